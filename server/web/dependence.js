// Partial plots: one for each fact that was fitted.

import { measured } from './number.js';
import { Figure } from './plot.js';

const host = document.querySelector('#dependence');
if (host) draw(await (await fetch(host.dataset.address)).json());

function draw({ name, unit, facts, points, level }) {
  const fitted = facts.filter((fact) => fact.slope);
  const letter = { k_n_m: 'k', b_n_s_m: 'B' }[name] ?? name;
  facts.forEach((fact, i) => {
    if (!fact.slope) return;
    const figure = document.querySelector(`#on-${i}`);
    const column = fitted.indexOf(fact);
    const dated = fact.name === 'date';
    const at = (x) => (dated ? new Date(x * 864e5).toISOString() : x);
    const own = new Map(fact.own.map((own) => [own.bike, own]));
    // A bicycle that differs is shown with its own slope.
    const apart = (point) => {
      const its = own.get(point.bike);
      return its ? (its.slope.value - fact.slope.value) * (point.facts[column] - its.mean) : 0;
    };
    const partial = (point) => level.value + fact.slope.value * (point.facts[column] - fact.mean) + apart(point) + point.residual;
    const dots = (name, points, ink) => ({
      name, x: points.map((point) => at(point.facts[column])), y: points.map(partial), dots: true, ink, size: 5, legend: own.size > 0,
      text: points.map((point) => `${point.bike}, ${point.dated_at.slice(0, 10)}: ${measured(point.value, point.std_error)} ${unit}`),
    });
    const line = fact.line.map((place) => at(place.x));
    figure.hidden = false;
    new Figure(figure, () => ({
      hover: 'closest',
      x: { label: dated ? 'ridden' : `${figure.querySelector('h3').textContent}${fact.unit && ` (${fact.unit})`}`, type: dated ? 'date' : undefined },
      panels: [{
        label: `${letter} (${unit.replace('N s', 'N·s')})`,
        traces: [
          { name: 'lower end', x: line, y: fact.line.map((place) => place.low), ink: 'series-plain', width: 0, legend: false },
          { name: '95 % interval', x: line, y: fact.line.map((place) => place.high), ink: 'series-plain', width: 0, band: true, legend: false },
          { name: 'fitted', x: line, y: fact.line.map((place) => place.value), ink: 'series-plain', legend: false },
          dots(own.size ? 'other bicycles' : letter, points.filter(({ bike }) => !own.has(bike)), 'series-extended'),
          ...[...own.keys()].map((bike, i) => dots(bike, points.filter((point) => point.bike === bike), `job-${2 + 2 * (i % 4)}`)),
        ],
      }],
    }));
  });
}
