
function x = channel(ride, name)
  % A channel in SI units; the table is the ride's file, or the ride as veloid read it.
  header = name; scale = 1; centred = false;
  if ~any(strcmp(ride.headers, 'veloid_sample'))
    known = strcmp(ride.channels(:, 1), name);
    if ~any(known), error('There is no column for %s: this needs %s', name, ride.as_read); end
    header = ride.channels{known, 2}; scale = ride.channels{known, 3}; centred = any(strcmp(ride.centred, name));
  end
  column = find(strcmp(ride.headers, header), 1);
  if isempty(column), error('There is no column for %s: this needs %s', name, ride.as_read); end
  x = scale * ride.data(:, column);
  if centred, x = x - mean(x); end
end

function ride = completed(ride, needed)
  % The ride with its time and what its laws ask of the bicycle.
  if ~isempty(ride.part) && ~any(strcmp(ride.headers, 'veloid_sample'))
    t = channel(ride, 't');
    ride.data = ride.data(t > ride.part(1) - 1e-9 & t < ride.part(2) + 1e-9, :);
  end
  ride.t = channel(ride, 't');
  n = numel(ride.t);
  if n ~= ride.samples || abs((ride.t(end) - ride.t(1)) / (n - 1) / ride.step - 1) >= 1e-6
    error('This is not the ride on the samples that the model was fitted on: this needs %s', ride.as_read);
  end
  none = zeros(n, 1);
  ride.speed = none; ride.speed_rate = none; ride.crank = none;
  if any(strcmp(needed, 'v')), ride.speed = channel(ride, 'v'); end
  if any(strcmp(needed, 'speed_rate')), ride.speed_rate = channel(ride, 'speed_rate'); end
  if any(strcmp(needed, 'cadence')), ride.crank = pi / 30 * ride.step * cumtrapz(channel(ride, 'cadence')); end
  ride.distance = ride.step * cumtrapz(ride.speed);
end

function axle = with_inputs(ride, axle)
  % The axle's inputs as cubics, and its measurement.
  letter = axle.name(1);
  none = zeros(ride.samples, 1);
  road = none; push = none;
  axle.measured = channel(ride, ['z_', letter]);
  if axle.road, road = channel(ride, ['u_', letter]); end
  if axle.force, push = channel(ride, ['force_', letter]); end
  if axle.prescribed
    road = axle.measured; push = none;
    axle.measured = channel(ride, ['force_', letter]);
    % Whether the force was logged as a reaction.
    if sum(diff(road) .* (axle.measured(1:end - 1) + axle.measured(2:end))) < 0, axle.measured = -axle.measured; end
  end
  if ~axle.prescribed, road = lifted(road); push = lifted(push); end
  [road, slopes] = read_road(ride, axle, road, spline_slopes(ride, road));
  axle.road_cubics = cubics(ride, road, slopes);
  axle.push_cubics = cubics(ride, push, spline_slopes(ride, push));
  axle.counts = false(ride.samples, 1);
  axle.counts(ride.held_out(1) + 1:ride.held_out(2)) = true;
  for i = 1:size(axle.left_out, 1), axle.counts(axle.left_out(i, 1) + 1:axle.left_out(i, 2)) = false; end
  found = sqrt(mean(axle.measured(axle.counts) .^ 2));
  if ~(abs(found - axle.measured_rms) <= 1e-6 * axle.measured_rms)
    error('The %s axle was not measured so where the model is from: this needs %s', axle.name, ride.as_read);
  end
end

function m = spline_slopes(ride, y)
  h = ride.step;
  [~, c] = unmkpp(spline(h * (0:numel(y) - 1)', y));
  m = [c(:, 3); 3 * c(end, 1) * h ^ 2 + 2 * c(end, 2) * h + c(end, 3)];
end

function c = cubics(ride, y, m)
  % For each sample interval the coefficients of the cubic with these ends, its place in it from 0 to 1.
  d = diff(y); a = ride.step * m(1:end - 1); b = ride.step * m(2:end);
  c = [y(1:end - 1), a, 3 * d - 2 * a - b, a + b - 2 * d];
end

function [y, m] = read_road(ride, axle, y, m)
  % Heights and slopes as the effects have them.
  if isempty(axle.read_road), return; end
  c = cubics(ride, y, m);
  area = [0; cumsum(ride.step * (c(:, 1) + c(:, 2) / 2 + c(:, 3) / 3 + c(:, 4) / 4))];
  last = ride.samples - 1;
  for i = 0:last
    [shift, half_window, more, more_rate] = axle.read_road(ride.speed(i + 1), ride.distance(i + 1));
    if shift ~= 0 || half_window ~= 0
      centre = i - shift / ride.step;
      inside = min(max(centre, 0), last);
      half = min([half_window / ride.step, inside, last - inside]);
      if half < 1e-6
        [y(i + 1), m(i + 1)] = at(ride, c, area, centre);
      else
        [above, ~, to] = at(ride, c, area, centre + half);
        [below, ~, from] = at(ride, c, area, centre - half);
        width = 2 * half * ride.step;
        y(i + 1) = (to - from) / width;
        m(i + 1) = (above - below) / width;
      end
    end
    y(i + 1) = y(i + 1) + more;
    m(i + 1) = m(i + 1) + more_rate;
  end
end

function [y, m, sum] = at(ride, c, area, position)
  % Height, slope and integral of the road at a place in samples.
  position = min(max(position, 0), ride.samples - 1);
  i = min(floor(position), ride.samples - 2);
  s = position - i; c = c(i + 1, :);
  y = c(1) + s * (c(2) + s * (c(3) + s * c(4)));
  m = (c(2) + s * (2 * c(3) + s * 3 * c(4))) / ride.step;
  sum = area(i + 1) + ride.step * s * (c(1) + s * (c(2) / 2 + s * (c(3) / 3 + s * c(4) / 4)));
end
