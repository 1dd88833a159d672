
function [t, z] = run_model(model, file)
  % Times (s), and a column for each axle of what the model predicts (m; N where a rig prescribes the motion).
  own = true;
  [ride, axles, z] = simulated(model, file, own);
  if isempty(z)
    own = false;
    [ride, axles, z] = simulated(model, file, own);
  end
  t = ride.t;
  for a = 1:numel(axles)
    axle = axles{a};
    if model.needs_road, fprintf('%s: displacement %.6g m RMS\n', axle.name, std(z(:, a), 1)); end
    if isempty(axle.measured), continue; end
    text = sprintf('error %.6g %s', rms_error(axle, z(:, a)), axle.unit);
    if own
      kind = '';
      if isfield(axle, 'start'), kind = 'held-out '; end
      fprintf('%s: %s%s, %s\n', axle.name, kind, text, axle.report);
    else
      measured = axle.measured(axle.counts);
      fit = 1 - norm(measured - z(axle.counts, a)) / norm(measured - mean(measured));
      start = sum(axle.fitted_to) * ride.step;
      fprintf('%s: %s, fit %.6g %%, from a start that is fitted to %.3g s\n', axle.name, text, 100 * fit, start);
    end
  end
end

function [ride, axles, z] = simulated(model, file, own)
  % Ride, axles and what the model predicts; nothing of that where the ride is to be the model's own and is another.
  ride = read_ride(model, file, own);
  axles = model.axles; z = [];
  is_own = ride.samples == model.samples && abs(ride.step / model.step - 1) < 1e-6;
  if own && ~(is_own && (ride.as_read || ~any(strcmp(model.needed, 'speed_rate')))), return; end
  for a = 1:numel(axles), axles{a} = with_inputs(ride, axles{a}, own); end
  if own && ~all(cellfun(@is_measured_so, axles)), return; end
  groups = num2cell(1:numel(axles));
  if ~isempty(model.pitch), groups = {1:numel(axles)}; end
  predicted = cell(1, numel(axles));
  for group = groups
    together = axles(group{1}); starts = [];
    if ~own || ~isfield(together{1}, 'start'), starts = fitted(ride, together); end
    predicted(group{1}) = predict(ride, together, starts, ride.samples);
  end
  for a = 1:numel(axles)
    known = isfield(axles{a}, 'error') && ~isempty(axles{a}.error);
    if own && known && ~(abs(rms_error(axles{a}, predicted{a}) / axles{a}.error - 1) < 1e-6), return; end
  end
  z = [predicted{:}];
end

function starts = fitted(ride, axles)
  % Height (m), velocity (m/s) and constant force (N) of each axle at the start that suit the measurement best (Gauss-Newton).
  starts = zeros(3, numel(axles)); free = zeros(2, 0); samples = 0;
  for a = 1:numel(axles)
    axle = axles{a}; starts(1, a) = axle.road_cubics(1, 1);
    if isempty(axle.measured), return; end
    used = find(axle.fitted_to);
    if isempty(used), error('%s: nothing was measured in the part that the start is fitted to', axle.name); end
    starts(1, a) = axle.measured(used(1)); samples = max(samples, used(end));
    free = [free, [axle.free; a + 0 * axle.free]];
  end
  % Changes that show what they do.
  steps = [1e-6, 1e-5, 1e-2];
  for pass = 1:ride.model.rounds
    now = left(ride, axles, starts, samples); slopes = zeros(numel(now), 0);
    for place = free
      other = starts; other(place(1), place(2)) = other(place(1), place(2)) + steps(place(1));
      slopes(:, end + 1) = (now - left(ride, axles, other, samples)) / steps(place(1));
    end
    change = slopes \ now;
    for p = 1:size(free, 2), starts(free(1, p), free(2, p)) = starts(free(1, p), free(2, p)) + change(p); end
  end
end

function rest = left(ride, axles, starts, samples)
  % What the model leaves of the samples that the start is fitted to.
  predicted = predict(ride, axles, starts, samples); rest = [];
  for a = 1:numel(axles)
    used = axles{a}.fitted_to(1:samples);
    rest = [rest; axles{a}.measured(used) - predicted{a}(used)];
  end
end
