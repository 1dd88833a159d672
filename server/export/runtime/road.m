
function [y, m] = read_road(ride, axle, y, m)
  % Heights and slopes (for each sample) as the effects have them.
  c = cubics(y, m);
  area = [0; cumsum(c(:, 1) + c(:, 2) / 2 + c(:, 3) / 3 + c(:, 4) / 4)];
  last = ride.samples - 1;
  for i = 0:last
    [shift, half_window, more, more_rate] = axle.read_road(ride.bicycle(i + 1, 1), ride.bicycle(i + 1, 4));
    if shift ~= 0 || half_window ~= 0
      centre = i - shift / ride.step;
      inside = min(max(centre, 0), last);
      half = min([half_window / ride.step, inside, last - inside]);
      if half < 1e-6
        [y(i + 1), m(i + 1)] = at(c, area, centre);
      else
        [above, ~, to] = at(c, area, centre + half);
        [below, ~, from] = at(c, area, centre - half);
        y(i + 1) = (to - from) / (2 * half);
        m(i + 1) = (above - below) / (2 * half);
      end
    end
    y(i + 1) = y(i + 1) + more;
    m(i + 1) = m(i + 1) + more_rate * ride.step;
  end
end

function [y, m, sum] = at(c, area, position)
  % Height, slope and integral of the road at a place in samples.
  last = size(c, 1) - 1;
  position = min(max(position, 0), last);
  i = min(floor(position), last - 1);
  s = position - i; c = c(i + 1, :);
  y = c(1) + s * (c(2) + s * (c(3) + s * c(4)));
  m = c(2) + s * (2 * c(3) + s * 3 * c(4));
  sum = area(i + 1) + s * (c(1) + s * (c(2) / 2 + s * (c(3) / 3 + s * c(4) / 4)));
end
