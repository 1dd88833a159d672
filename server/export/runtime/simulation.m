
function predicted = predict(ride, axles, starts, samples)
  % What is measured at the first samples of axles that move together, by Runge-Kutta's method; without starts from the report's.
  count = numel(axles);
  steps = max(cellfun(@(axle) axle.steps, axles));
  steps = ceil(ride.step * steps / ride.model.step - 1e-3);
  h = ride.step / steps;
  from = cell(1, count);
  for a = 1:count
    axle = axles{a}; from{a} = axle.start;
    if isempty(starts), continue; end
    known = [0; starts(1:2, a)]; from{a} = known(axle.follows + 1);
    % A constant force moves the place where an axle rests, from which laws may count.
    if axle.rests_on ~= 0
      axle.road_cubics(:, 1) = axle.road_cubics(:, 1) + starts(3, a) / axle.rests_on;
    else
      axle.push_cubics(:, 1) = axle.push_cubics(:, 1) + starts(3, a);
    end
    axles{a} = axle;
  end
  x = vertcat(from{:});
  mass = cumsum([1, cellfun(@numel, from(1:end - 1))]);
  f = axles{1}.rates;
  if count == 2, f = @(dt, in, x) coupled(ride.model.pitch, axles, mass(2), dt, in, x); end
  motion = zeros(3 * count, samples);
  block = 500;
  for first = 1:block:samples
    intervals = first:min(first + block - 1, samples);
    in = cellfun(@(axle) inputs(ride, axle, intervals, steps), axles, 'UniformOutput', false);
    in = vertcat(in{:});
    place = 1;
    for i = intervals
      for sub = 1:steps
        [acceleration, a] = f(h, in(:, place), x);
        if sub == 1, motion(:, i) = [x(mass); x(mass + 1); acceleration]; end
        if i == samples, break; end
        middle = in(:, place + 1);
        [~, b] = f(h, middle, x + 0.5 * h * a);
        [~, c] = f(h, middle, x + 0.5 * h * b);
        [~, d] = f(h, in(:, place + 2), x + h * c);
        x = x + h / 6 * (a + 2 * b + 2 * c + d);
        place = place + 2;
      end
    end
  end
  predicted = cell(1, count);
  for a = 1:count, predicted{a} = sensed(ride, axles{a}, motion([a, count + a, 2 * count + a], :)); end
end

function in = inputs(ride, axle, intervals, steps)
  % Time, road, slope, push, speed and its rate, crank and distance at the ends and middles of all steps of these intervals.
  s = (0:2 * steps - 1)' / (2 * steps);
  i = [reshape(repmat(intervals, 2 * steps, 1), [], 1); intervals(end)];
  s = [repmat(s, numel(intervals), 1); 1];
  u = axle.road_cubics(i, :); f = axle.push_cubics(i, :);
  x = ride.bicycle(i, :);
  lines = x + s .* (ride.bicycle(min(i + 1, ride.samples), :) - x);
  in = [ride.step * (i - 1 + s), u(:, 1) + s .* (u(:, 2) + s .* (u(:, 3) + s .* u(:, 4))), ...
    (u(:, 2) + s .* (2 * u(:, 3) + s .* (3 * u(:, 4)))) / ride.step, ...
    f(:, 1) + s .* (f(:, 2) + s .* (f(:, 3) + s .* f(:, 4))), lines]';
end

function [acceleration, r] = coupled(pitch, axles, second, dt, in, x)
  % Two axles that push each other.
  [front, a] = axles{1}.rates(dt, in(1:8), x(1:second - 1));
  [rear, b] = axles{2}.rates(dt, in(9:16), x(second:end));
  coupling = pitch(1); l_f = pitch(2); l_r = pitch(3);
  total = pitch(4) + pitch(5);
  front = pitch(4) * front; rear = pitch(5) * rear;
  acceleration = [front * ((1 + coupling) * l_f / l_r / total + 1 / total) - rear * coupling / total; ...
    rear * ((1 + coupling) * l_r / l_f / total + 1 / total) - front * coupling / total];
  a(2) = acceleration(1); b(2) = acceleration(2);
  r = [a; b];
end

function y = sensed(ride, axle, motion)
  % What the sensor reads of displacement, velocity and acceleration at the samples.
  y = motion(1, :)';
  if axle.prescribed, y = motion(3, :)'; end
  if isempty(axle.sensor), return; end
  sharp = y; before = [];
  for i = 1:numel(y)
    [delay, gain, offset, lag] = axle.sensor((i - 1) * ride.step);
    reading = sharp(i);
    if delay ~= 0, reading = earlier(motion, ride.step, i - 1 - delay / ride.step); end
    prompt = gain * reading + offset;
    y(i) = prompt;
    if ~isempty(before) && lag > 0
      kept = exp(-ride.step / lag); behind = (prompt - before(1)) * lag / ride.step;
      y(i) = prompt - behind + (before(2) - before(1) + behind) * kept;
    end
    before = [prompt, y(i)];
  end
end

function z = earlier(motion, h, position)
  % The displacement between samples, from displacement, velocity and acceleration at them.
  last = size(motion, 2) - 1;
  if position < 0 || position > last
    edge = min(max(position, 0), last);
    m = motion(:, edge + 1); beyond = h * (position - edge);
    z = m(1) + beyond * (m(2) + 0.5 * beyond * m(3));
    return;
  end
  i = min(floor(position), last - 1); s = position - i;
  m = motion(:, i + 1:i + 2) .* [1; h; h ^ 2];
  d = m(1, 2) - m(1, 1) - m(2, 1) - 0.5 * m(3, 1); e = m(2, 2) - m(2, 1) - m(3, 1); f = m(3, 2) - m(3, 1);
  z = m(1, 1) + s * (m(2, 1) + s * (0.5 * m(3, 1) + s * (10 * d - 4 * e + 0.5 * f + s * (-15 * d + 7 * e - f + s * (6 * d - 3 * e + 0.5 * f)))));
end

function y = above_zero(x)
  y = double(x > 0);
end
