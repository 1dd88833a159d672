// The history of one bicycle.

import { Figure } from './plot.js';
import { measured } from './number.js';

const host = document.querySelector('#history');
if (host) draw(host.dataset.address);

async function draw(address) {
  const { courses, events } = await (await fetch(address)).json();
  for (const axle of ['front', 'rear', 'both']) {
    const own = courses.filter((course) => course.axle === axle);
    if (!own.length) continue;
    const figure = document.querySelector(`#history-${axle}`);
    figure.hidden = false;
    new Figure(figure, () => ({
      hover: 'closest',
      x: { label: 'ridden', type: 'date' },
      panels: own.map(panel),
      events: events.map(({ date, text }) => ({ at: date, label: text })),
    }), { eager: true });
  }
}

function panel({ name, unit, points, development }) {
  const x = points.map((point) => point.dated_at);
  const letter = { k_n_m: 'k', b_n_s_m: 'B' }[name] ?? name.split('.').at(-1).replaceAll('_', ' ');
  const traces = [{
    name: letter, x, y: points.map((point) => point.value), error: points.map((point) => 1.96 * point.std_error),
    dots: true, ink: 'series-extended', legend: false, size: 7,
    text: points.map((point) => `${measured(point.value, point.std_error)} ${unit}, ${(point.verdict ?? 'no diagnosis').replaceAll('_', ' ')}`),
  }];
  if (development && development.kind !== 'none') {
    traces.push({ name: 'level', ...level(x, development), ink: 'series-plain', legend: false, dash: 'dash' });
  }
  return { label: `${letter} (${unit.replace('N s', 'N·s')})`, traces };
}

// The level over the rides, from today's back, with a corner where a drift begins or ends and a jump at each step.
function level(dates, { now, steps, drifts }) {
  const day = (time) => Date.parse(time) / 864e5;
  const last = day(dates.at(-1));
  const passed = (drift, at) => drift.per_day * Math.max(0, Math.min(at, drift.until ? day(drift.until) : last) - day(drift.since));
  const at = (time, before) => {
    const steppedSince = steps.filter((step) => day(step.at) > time || (before && day(step.at) === time));
    const driftedSince = drifts.map((drift) => passed(drift, last) - passed(drift, time));
    return now - steppedSince.reduce((sum, step) => sum + step.size, 0) - driftedSince.reduce((sum, change) => sum + change, 0);
  };
  const places = [[dates[0], false], [dates.at(-1), false]];
  for (const { since, until } of drifts) places.push([since, false], ...(until ? [[until, false]] : []));
  for (const step of steps) places.push([step.at, true], [step.at, false]);
  places.sort(([a, first], [b, second]) => day(a) - day(b) || second - first);
  return { x: places.map(([time]) => time), y: places.map(([time, before]) => at(day(time), before)) };
}
