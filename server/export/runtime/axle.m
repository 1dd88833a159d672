
function axle = with_inputs(ride, axle, own)
  % The axle's inputs as cubics, its measurement, and the samples that count; `own` where the ride is to be the model's.
  letter = axle.name(1);
  none = zeros(ride.samples, 1);
  road = none; push = none; known = none > 0;
  axle.unit = 'm'; axle.measured = [];
  if axle.road, road = channel(ride, ['u_', letter]); end
  if axle.force, push = channel(ride, ['force_', letter]); end
  if axle.prescribed
    axle.unit = 'N';
    road = channel(ride, ['z_', letter]); push = none;
    [axle.measured, known] = channel(ride, ['force_', letter]);
    % Whether the force was logged as a reaction.
    if sum(diff(road) .* (axle.measured(1:end - 1) + axle.measured(2:end))) < 0, axle.measured = -axle.measured; end
  else
    if ~ride.model.needs_road || any(strcmp(ride.headers, header_of(ride, ['z_', letter])))
      [axle.measured, known] = channel(ride, ['z_', letter]);
    end
    road = lifted(road); push = lifted(push);
  end
  slopes = spline_slopes(road);
  if isfield(axle, 'read_road') && ~isempty(axle.read_road), [road, slopes] = read_road(ride, axle, road, slopes); end
  axle.road_cubics = cubics(road, slopes);
  axle.push_cubics = cubics(push, spline_slopes(push));
  i = (0:ride.samples - 1)';
  if own
    axle.counts = known & i >= ride.model.held_out(1) & i < ride.model.held_out(2);
    for k = 1:size(axle.left_out, 1), axle.counts(axle.left_out(k, 1) + 1:axle.left_out(k, 2)) = false; end
    axle.fitted_to = axle.counts;
  else
    first = i < find([known; true], 1) - 1 + min([axle.start_s / ride.step, ride.samples / 4]);
    if isempty(axle.start_s), axle.fitted_to = known; axle.counts = known;
    else, axle.fitted_to = known & first; axle.counts = known & ~first; end
  end
end

function yes = is_measured_so(axle)
  % Whether the measurement is the one that the model was fitted to, as far as that is known.
  yes = ~isfield(axle, 'measured_rms') || ...
    abs(sqrt(mean(axle.measured(axle.counts) .^ 2)) - axle.measured_rms) <= 1e-6 * axle.measured_rms;
end

function e = rms_error(axle, predicted)
  e = sqrt(mean((axle.measured(axle.counts) - predicted(axle.counts)) .^ 2));
end

function m = spline_slopes(y)
  [~, c] = unmkpp(spline((0:numel(y) - 1)', y));
  m = [c(:, 3); 3 * c(end, 1) + 2 * c(end, 2) + c(end, 3)];
end

function c = cubics(y, m)
  % For each sample the coefficients of the cubic to the next, with these slopes for each sample, its place in it from 0 to 1.
  d = diff(y); a = m(1:end - 1); b = m(2:end);
  c = [y, m, [3 * d - 2 * a - b; 0], [a + b - 2 * d; 0]];
end
