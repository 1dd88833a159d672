// The history of one bicycle.

import { Figure } from './plot.js';
import { measured } from './number.js';

const host = document.querySelector('#history');
if (host) draw(host.dataset.address);

async function draw(address) {
  const { courses, events } = await (await fetch(address)).json();
  for (const axle of ['front', 'rear']) {
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

function panel({ name, unit, points, pooled, trend, development }) {
  const x = points.map((point) => point.dated_at);
  const letter = name === 'k_n_m' ? 'k' : 'B';
  const traces = [{
    name: letter, x, y: points.map((point) => point.value), error: points.map((point) => 1.96 * point.std_error),
    dots: true, ink: 'series-extended', legend: false, size: 7,
    text: points.map((point) => `${measured(point.value, point.std_error)} ${unit}, ${(point.verdict ?? 'no diagnosis').replaceAll('_', ' ')}`),
  }];
  // A step makes a trend significant too; the development is one choice between them.
  const drifts = !development || ['drift', 'both'].includes(development.kind);
  if (drifts && trend && trend.p_value < 0.05) {
    const day = (time) => Date.parse(time) / 864e5;
    const weights = points.map((point) => 1 / (point.std_error ** 2 + pooled.between_rides ** 2));
    const total = weights.reduce((sum, weight) => sum + weight, 0);
    const middle = points.reduce((sum, point, i) => sum + weights[i] * day(point.dated_at), 0) / total;
    const mean = points.reduce((sum, point, i) => sum + weights[i] * point.value, 0) / total;
    traces.push({
      name: 'trend', x: [x[0], x.at(-1)], ink: 'series-plain', legend: false, dash: 'dash',
      y: [x[0], x.at(-1)].map((time) => mean + trend.per_day * (day(time) - middle)),
    });
  }
  return { label: `${letter} (${unit.replace('N s', 'N·s')})`, traces };
}
