
function table = read_table(file)
  % Numbers of a table and its headers: separator , ; or tab; lines with # do not count.
  lines = regexp(fileread(file), '\r?\n', 'split');
  lines = lines(~cellfun(@(line) isempty(strtrim(line)) || line(1) == '#', lines));
  if isempty(lines), error('%s: no table', file); end
  separators = {',', ';', '\t'};
  [~, most] = max([sum(lines{1} == ','), sum(lines{1} == ';'), sum(lines{1} == 9)]);
  cells = regexp(lines, separators{most}, 'split');
  cells = vertcat(cells{cellfun(@numel, cells) == numel(cells{1})});
  headers = cellfun(@(header) header(double(header) ~= 65279), cells(1, :), 'UniformOutput', false);
  table.headers = strtrim(strrep(strrep(headers, char([239 187 191]), ''), '"', ''));
  table.data = str2double(strrep(cells(2:end, :), ',', '.'));
end

function ride = read_ride(model, file, own)
  % A ride on even samples; its own rows, or those of the part that the model is from where they are as many.
  ride = read_table(file);
  ride.model = model;
  ride.as_read = any(strcmp(ride.headers, 'veloid_sample'));
  ride.rows = true(size(ride.data, 1), 1);
  t = column(ride, 't');
  ride.rows = isfinite(t);
  if own && ~isempty(model.part) && ~ride.as_read
    within = ride.rows & t > model.part(1) - 1e-9 & t < model.part(2) + 1e-9;
    if sum(within) == model.samples, ride.rows = within; end
  end
  t = t(ride.rows); ride.recorded = t;
  n = numel(t); steps = diff(t);
  if n < 10 || min(steps) <= 0 || t(end) - t(1) > 10 * n * median(steps)
    error('A ride needs 10 samples or more whose times increase, most of them without a gap');
  end
  ride.t = t; ride.step = (t(end) - t(1)) / (n - 1);
  % Even stamps are off by what printing them rounds.
  d = 0;
  while d < 9 && any(abs(t * 10 ^ d - round(t * 10 ^ d)) >= 1e-3), d = d + 1; end
  off = max(abs(t - linspace(t(1), t(end), n)'));
  ride.is_even = off < max(1e-4 * ride.step, min(4 / 3 * 10 ^ -d, 0.4 * ride.step));
  if ~ride.is_even
    ride.step = median(steps);
    ride.t = t(1) + ride.step * (0:floor((t(end) - t(1)) / ride.step + 1e-6))';
  end
  ride.samples = numel(ride.t);
  ride = moved(ride);
end

function ride = moved(ride)
  % Speed (m/s), its rate (m/s^2), angle of the crank (rad) and distance (m) at the samples.
  needed = @(name) any(strcmp(ride.model.needed, name));
  none = zeros(ride.samples, 1);
  speed = none; rate = none; cadence = none;
  if needed('v'), speed = channel(ride, 'v'); end
  if needed('cadence'), cadence = channel(ride, 'cadence'); end
  if needed('speed_rate') && ride.as_read
    rate = channel(ride, 'speed_rate');
  elseif needed('speed_rate')
    % Over half a second: a speed is noisy, and riders brake for longer.
    v = channel(ride, 'v');
    at = @(t) interp1(ride.t, v, min(max(t, ride.t(1)), ride.t(end)));
    rate = (at(ride.t + 0.25) - at(ride.t - 0.25)) / 0.5;
  end
  ride.bicycle = [speed, rate, pi / 30 * ride.step * cumtrapz(cadence), ride.step * cumtrapz(speed)];
end

function [header, scale] = header_of(ride, name)
  % Header of a channel's column, and the factor that makes it SI.
  header = name; scale = 1;
  known = strcmp(ride.model.channels(:, 1), name);
  if any(known) && ~ride.as_read, [header, scale] = ride.model.channels{known, 2:3}; end
end

function x = column(ride, name)
  [header, scale] = header_of(ride, name);
  place = find(strcmp(ride.headers, header), 1);
  if isempty(place)
    error('There is no column for %s: expected the header "%s". This takes %s.', name, header, ride.model.takes);
  end
  x = scale * ride.data(:, place);
end

function [x, known] = channel(ride, name)
  % A channel on even samples in SI units, blanks filled along straight lines, and where it was recorded.
  at = ride.recorded;
  x = column(ride, name); x = x(ride.rows);
  known = isfinite(x); k = find(known);
  if isempty(k), error('The column for %s has no numbers', name); end
  x = interp1([at(1) - 1; at(k); at(end) + 1], [x(k(1)); x(k); x(k(end))], at);
  if ~ride.is_even
    place = interp1(at, (1:numel(at))', min(ride.t, at(end)));
    row = min(floor(place + 1e-9), numel(at) - 1);
    steps = diff(at);
    % As veloid does, longer gaps are bridged straight.
    gap = steps(row) > 4 * ride.step;
    straight = interp1(at, x, min(ride.t, at(end)));
    x = spline(at, x, ride.t);
    x(gap) = straight(gap);
    nearest = floor(place + 0.5);
    known = known(nearest) & abs(ride.t - at(nearest)) < 2 / 3 * ride.step;
  end
  if any(strcmp(ride.model.centred, name)) && ~ride.as_read, x = x - mean(x); end
end
