// A model on another ride: where it is worst, and the spectrum of what it leaves.

import { PREDICTED } from './figures.js';
import { Figure } from './plot.js';

const { axles } = JSON.parse(document.querySelector('#validation').textContent);

for (const [axle, found] of Object.entries(axles)) {
  if (!found) continue;
  const { name, unit, scale } = PREDICTED[found.predicted];
  const scaled = (values, by = (value) => value) => values.map((value) => (value === null ? null : scale * by(value)));
  const place = (id, figure) => {
    const host = document.querySelector(`#${id}-${axle}`);
    host.hidden = false;
    new Figure(host, async () => figure, { eager: true });
  };
  const { t_s: t, measured, model, refitted } = found.worst;
  const left = (predicted) => measured.map((value, i) => (value === null || predicted[i] === null ? null : value - predicted[i]));
  place('worst', {
    x: { label: 'time (s)' },
    panels: [
      { label: `${name} (${unit})`, weight: 1.6, traces: [
        { name: 'measured', x: t, y: scaled(measured), ink: 'series-measured' },
        { name: 'model', x: t, y: scaled(model), ink: 'series-plain' },
        { name: 'fitted to this ride', x: t, y: scaled(refitted), ink: 'series-extended', dash: 'dash' },
      ] },
      { label: `left (${unit})`, traces: [
        { name: 'left by the model', x: t, y: scaled(left(model)), ink: 'series-plain', legend: false },
        { name: 'left by the fit', x: t, y: scaled(left(refitted)), ink: 'series-extended', dash: 'dash', legend: false },
      ] },
    ],
  });
  const { frequency_hz: hz, model: power, refitted: fitted } = found.spectrum;
  if (hz.length) place('spectrum', {
    x: { label: 'frequency (Hz)', log: true },
    panels: [{ label: `${unit}/√Hz`, log: true, traces: [
      { name: 'left by the model', x: hz, y: scaled(power, Math.sqrt), ink: 'series-plain' },
      { name: 'left by the fit', x: hz, y: scaled(fitted, Math.sqrt), ink: 'series-extended', dash: 'dash' },
    ] }],
  });
}
