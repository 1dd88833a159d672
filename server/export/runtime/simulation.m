
function in = inputs(ride, axle, intervals, steps)
  % Time, road, slope, push, speed and its rate, crank and distance at the ends and middles of all steps of these intervals.
  s = (0:2 * steps - 1)' / (2 * steps);
  last = intervals(end);
  i = [reshape(repmat(intervals, 2 * steps, 1), [], 1); last];
  s = [repmat(s, numel(intervals), 1); 1];
  u = axle.road_cubics(i, :); f = axle.push_cubics(i, :);
  line = @(y) y(i) + s .* (y(i + 1) - y(i));
  in = [ride.step * (i - 1 + s), u(:, 1) + s .* (u(:, 2) + s .* (u(:, 3) + s .* u(:, 4))), ...
    (u(:, 2) + s .* (2 * u(:, 3) + s .* (3 * u(:, 4)))) / ride.step, ...
    f(:, 1) + s .* (f(:, 2) + s .* (f(:, 3) + s .* f(:, 4))), ...
    line(ride.speed), line(ride.speed_rate), line(ride.crank), line(ride.distance)]';
end

function motions = simulate(ride, axles)
  % Displacement, velocity and acceleration at every sample of axles that move together (Runge-Kutta).
  count = numel(axles);
  steps = max(cellfun(@(axle) axle.steps, axles));
  h = ride.step / steps;
  starts = cellfun(@(axle) axle.start, axles, 'UniformOutput', false);
  x = vertcat(starts{:});
  mass = cumsum([1, cellfun(@numel, starts(1:end - 1))]);
  f = axles{1}.rates;
  if count == 2, f = @(dt, in, x) coupled(ride.pitch, axles, mass(2), dt, in, x); end
  motion = zeros(3 * count, ride.samples);
  block = 500;
  for first = 1:block:ride.samples - 1
    intervals = first:min(first + block, ride.samples) - 1;
    in = cellfun(@(axle) inputs(ride, axle, intervals, steps), axles, 'UniformOutput', false);
    in = vertcat(in{:});
    place = 1;
    for i = intervals
      for sub = 1:steps
        [acceleration, a] = f(h, in(:, place), x);
        if sub == 1, motion(:, i) = [x(mass); x(mass + 1); acceleration]; end
        middle = in(:, place + 1);
        [~, b] = f(h, middle, x + 0.5 * h * a);
        [~, c] = f(h, middle, x + 0.5 * h * b);
        place = place + 2;
        [~, d] = f(h, in(:, place), x + h * c);
        x = x + h / 6 * (a + 2 * b + 2 * c + d);
      end
    end
  end
  acceleration = f(h, in(:, place), x);
  motion(:, end) = [x(mass); x(mass + 1); acceleration];
  motions = arrayfun(@(q) motion([q, count + q, 2 * count + q], :), 1:count, 'UniformOutput', false);
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
  for i = 1:ride.samples
    [delay, gain, offset, lag] = axle.sensor((i - 1) * ride.step);
    reading = sharp(i);
    if delay ~= 0, reading = earlier(ride, motion, i - 1 - delay / ride.step); end
    prompt = gain * reading + offset;
    y(i) = prompt;
    if ~isempty(before) && lag > 0
      kept = exp(-ride.step / lag); behind = (prompt - before(1)) * lag / ride.step;
      y(i) = prompt - behind + (before(2) - before(1) + behind) * kept;
    end
    before = [prompt, y(i)];
  end
end

function z = earlier(ride, motion, position)
  % The displacement between samples, from displacement, velocity and acceleration at them.
  last = size(motion, 2) - 1; h = ride.step;
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
