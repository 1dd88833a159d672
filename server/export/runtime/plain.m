
function predicted = predict(ride, axles, starts, samples)
  predicted = cell(1, numel(axles));
  for a = 1:numel(axles), predicted{a} = answer(ride, axles{a}, starts(:, a), samples); end
end

function y = answer(ride, axle, start, samples)
  % Displacement (m) by m z'' = k (u - z) + B (u' - z') + F + c, exact for cubic splines u and F; without a mass the force (N) on u.
  m = axle.plain(1); k = axle.plain(2); B = axle.plain(3);
  h = ride.step;
  % Each with its derivatives at the samples.
  u = axle.road_cubics .* [1, 1 / h, 2 / h ^ 2, 6 / h ^ 3];
  F = axle.push_cubics .* [1, 1 / h, 2 / h ^ 2, 6 / h ^ 3];
  force = k * u + B * [u(:, 2:4), zeros(size(u, 1), 1)] + F;
  force(:, 1) = force(:, 1) + start(3);
  y = force(1:samples, 1);
  if m == 0, return; end
  system = diag(ones(5, 1), 1);
  system(2, 1:3) = [-k / m, -B / m, 1 / m];
  whole = expm(h * system);
  pushed = whole(1:2, 3:6) * force'; free = whole(1:2, 1:2);
  x = start(1:2);
  for i = 1:samples
    y(i) = x(1);
    x = free * x + pushed(:, i);
  end
end
