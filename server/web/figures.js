// The figures of a result: what is drawn from the report and what from the series along the ride.

import { drawInside } from './inside.js';
import { rough } from './number.js';
import { Figure, Timeline } from './plot.js';

const AXLES = ['front', 'rear'];
const POINTS = 2000;
const mm = (values) => values.map((value) => (value === null ? null : 1e3 * value));
const minus = (a, b) => a.map((value, i) => (value === null || b[i] === null ? null : value - b[i]));

const INKS = {
  measured: 'series-measured', plain: 'series-plain', residual: 'series-plain', logged: 'series-other', swarm: 'series-swarm',
  least_squares: 'series-least-squares', observer: 'series-extended',
};
const NAMES = { plain: 'output error', least_squares: 'least squares', logged: 'accelerometer' };

/** What a model predicts, and the unit that it is drawn in. */
export const PREDICTED = {
  displacement: { name: 'z', unit: 'mm', scale: 1e3 },
  force: { name: 'force', unit: 'N', scale: 1 },
  acceleration: { name: "z''", unit: 'm/s²', scale: 1 },
};

/** Draws every figure that the page has a place for. */
export async function drawAll(job) {
  const report = await (await fetch(`${job}/report`)).json();
  const place = (id, draw, options) => {
    const host = document.getElementById(id);
    if (!host) return;
    host.hidden = false;
    new Figure(host, async (range) => draw(range), options);
  };
  const present = AXLES.filter((axle) => report.output_error[axle]);
  const evidence = report.diagnosis?.evidence;
  // No curve shows what the result withholds.
  const stated = (axle) => ['k', 'B'].every((name) => report.result[axle]?.[name]?.value !== null);
  for (const axle of AXLES) {
    const found = evidence?.[axle];
    // Without a road one axle's acceleration shows what acts on both.
    const shows = (effect) => found?.predicted === 'acceleration' || effect.axle === axle || effect.axle === 'both';
    const named = report.diagnosis?.effects.some(shows);
    if (found) {
      const predicted = PREDICTED[found.predicted];
      place(`worst-${axle}`, () => worst(found.worst, named, predicted), { eager: true });
      place(`spectrum-${axle}`, () => spectrum(found.spectrum, named, predicted), { eager: true });
      if (found.surface.lacking_n.length) place(`surface-${axle}`, () => heat(found.surface.deflection_m, found.surface.rate_m_s, found.surface.lacking_n), { eager: true });
    }
    const free = report.diagnosis?.free_form[axle];
    if (free?.force_n.length) place(`free-form-${axle}`, () => heat(free.deflection_m, free.rate_m_s, free.force_n));
    drawInside(report, axle, place, stated(axle));
    if (present.includes(axle) && stated(axle)) place(`scatter-${axle}`, () => scatter(report, axle));
  }
  if (report.latent_road?.road) withoutRoad(report.latent_road, place);
  // A ride without a road has no axle to draw and nothing was searched.
  if (present.length) {
    place('cost', () => cost(report.swarm.trials));
    if (present.every(stated)) place('position', () => position(report));
  }
  alongTheRide(job, report, present, place, stated);
}

/** The spectra that identified a ride without a road: of each axle's sensors, and of the road that explains them. */
function withoutRoad({ sensors, road }, place) {
  const inks = { a_f: 'series-extended', a_r: 'series-plain', d_f: 'series-measured', d_r: 'series-least-squares' };
  const names = { a_f: 'front accelerometer', a_r: 'rear accelerometer', d_f: 'front laser', d_r: 'rear laser' };
  const root = (values) => values.map(Math.sqrt);
  const panel = (unit, label) => ({ label, log: true, traces: sensors
    .filter((sensor) => sensor.unit === unit && sensor.frequency_hz?.length)
    .map((sensor) => ({
      name: names[sensor.channel] ?? sensor.channel, x: sensor.frequency_hz, y: root(sensor.density), ink: inks[sensor.channel],
    })) });
  const panels = [panel('m/s^2', 'm/s²/√Hz'), panel('m', 'm/√Hz')].filter((one) => one.traces.length);
  if (panels.length) place('sensors', () => ({ x: { label: 'frequency (Hz)', log: true }, panels }), { eager: true });
  place('road-spectrum', () => {
    const x = road.cycles_per_m;
    // Classes of ISO 8608 end at twice their mean: a straight line of slope -2, 0.1 cycles/m being where classes are named.
    const line = (share) => x.map((n) => share * road.psd_m3 * (n / 0.1) ** -2);
    return {
      x: { label: 'cycles per metre', log: true },
      panels: [{ label: 'm³', log: true, traces: [
        { name: 'estimated road', x, y: road.density_m3, ink: 'series-measured' },
        { name: `straight line of this roughness (class ${road.class})`, x, y: line(1), ink: 'series-plain', dash: 'dash' },
      ] }],
    };
  }, { eager: true });
}

function worst({ t_s: t, measured_m: measured, plain_m: plain, extended_m: extended }, named, { name, unit, scale }) {
  const line = (label, y, ink, dash) => ({ name: label, x: t, y: y.map((value) => (value === null ? null : scale * value)), ink, dash });
  return {
    x: { label: 'time from the first sample (s)' },
    panels: [
      { label: `${name} (${unit})`, weight: 1.2, traces: [
        line('measured', measured, 'series-measured'),
        line('plain model', plain, 'series-plain', 'dash'),
        ...(named ? [line('with the effects', extended, 'series-extended')] : []),
      ] },
      { label: `left (${unit})`, traces: [
        { ...line('plain model leaves', minus(measured, plain), 'series-plain'), legend: false },
        ...(named ? [{ ...line('with the effects', minus(measured, extended), 'series-extended'), legend: false }] : []),
      ] },
    ],
  };
}

function spectrum({ frequency_hz: x, plain_m2_hz: plain, extended_m2_hz: extended }, named, { unit, scale }) {
  const density = (values) => values.map((value) => (value === null ? null : scale * Math.sqrt(value)));
  return {
    x: { label: 'frequency (Hz)', log: true },
    panels: [{ label: `${unit}/√Hz`, log: true, traces: [
      { name: 'plain model', x, y: density(plain), ink: 'series-plain' },
      ...(named ? [{ name: 'with the effects', x, y: density(extended), ink: 'series-extended' }] : []),
    ] }],
  };
}

function heat(deflection, rate, z) {
  return {
    hover: 'closest',
    x: { label: 'deflection (mm)' },
    panels: [{ label: 'rate (m/s)', traces: [{ kind: 'heat', name: 'force', unit: 'N', label: 'rate (m/s)', x: mm(deflection), y: rate, z }] }],
  };
}

function cost(trials) {
  const length = Math.max(...trials.map((trial) => trial.best_cost.length));
  if (!(length > 0)) return null;
  const x = Array.from({ length }, (_, i) => i + 1);
  const at = (i) => trials.map((trial) => trial.best_cost[i] ?? trial.best_cost.at(-1));
  const best = (list) => list.reduce((a, b, i) => (b.best_cost.at(-1) < list[a].best_cost.at(-1) ? i : a), 0);
  const winner = best(trials);
  return {
    x: { label: 'iteration' },
    panels: [{ label: 'best cost', log: true, traces: [
      { name: 'lowest', x, y: x.map((_, i) => Math.min(...at(i))), ink: 'series-swarm', width: 0, legend: false },
      { name: 'range', x, y: x.map((_, i) => Math.max(...at(i))), ink: 'series-swarm', width: 0, band: true },
      ...trials.map((trial, i) => ({
        name: `trial ${i + 1}, seed ${trial.seed}`, x, y: trial.best_cost, legend: i === winner,
        ink: i === winner ? 'series-extended' : 'series-swarm', width: i === winner ? 2.4 : 0.9,
      })),
    ] }],
    hover: 'closest',
  };
}

function position(report) {
  const trial = report.swarm.trials[report.swarm.best_trial];
  if (!trial?.best_position.length) return null;
  const count = trial.best_position[0].length;
  const x = trial.best_position.map((_, i) => i + 1);
  const of = (q) => trial.best_position.map((position) => position[q]);
  const axles = count === 4 ? AXLES : [AXLES.find((axle) => report.output_error[axle])];
  const equal = count === 2 && report.bike.equal_axles;
  const trace = (axle, i, q) => ({
    name: equal ? 'both axles' : axle, x, y: of(2 * i + q), ink: i ? 'series-plain' : 'series-extended', legend: q === 0,
  });
  return {
    x: { label: 'iteration' },
    panels: [
      { label: equal ? 'k (N/m)' : 'k/m (1/s²)', traces: axles.map((axle, i) => trace(axle, i, 0)) },
      { label: equal ? 'B (N s/m)' : 'B/m (1/s)', traces: axles.map((axle, i) => trace(axle, i, 1)) },
    ],
  };
}

function scatter(report, axle) {
  const point = (name, all, ink, symbol, size) => {
    const list = all.filter(Boolean);
    return { name, x: list.map((p) => p.k_n_m), y: list.map((p) => p.b_n_s_m), ink, dots: true, symbol, size,
    text: list.map((p, i) => `${name}${list.length > 1 ? ` ${i + 1}` : ''}: k ${rough(p.k_n_m, 6)} N/m, B ${rough(p.b_n_s_m)} N s/m`) };
  };
  const trials = report.swarm.trials.map((trial) => trial[axle]).filter(Boolean);
  return {
    hover: 'closest',
    x: { label: 'k (N/m)' },
    panels: [{ label: 'B (N s/m)', traces: [
      point('trial', trials, 'series-swarm', 'circle', 8),
      point('mean of the trials', [report.swarm.mean[axle]], 'series-swarm', 'cross', 11),
      point('output error', [report.output_error[axle]], 'series-plain', 'diamond', 11),
      point('instrumental', [report.instrumental[axle]], 'series-measured', 'square', 9),
      { ...point('least squares', [report.least_squares[axle]], 'series-least-squares', 'triangle-up', 11), shown: false },
    ] }],
  };
}

function alongTheRide(job, report, present, place, stated) {
  const timeline = new Timeline();
  const answers = new Map();
  const series = (quantity, range) => {
    const query = new URLSearchParams({ quantity, points: POINTS });
    if (range) { query.set('t0', range[0]); query.set('t1', range[1]); }
    const address = `${job}/series?${query}`;
    if (!answers.has(address)) {
      if (answers.size > 12) answers.delete(answers.keys().next().value);
      answers.set(address, fetch(address).then((response) => response.json()));
    }
    return answers.get(address);
  };
  const scale = { displacement: 1e3, velocity: 1, acceleration: 1, load: 1, force: 1 };
  const unit = { displacement: 'mm', velocity: 'm/s', acceleration: 'm/s²', load: 'N', force: 'N' };
  const answersInForce = (axle) => report.output_error[axle]?.mass_kg === 0;
  const trace = (t, curves, quantity, name, extra) => curves[name] && {
    name: NAMES[name] ?? name, x: t, ink: INKS[name], ...extra,
    y: curves[name].map((value) => (value === null ? null : scale[quantity] * value)),
  };
  for (const quantity of Object.keys(scale)) {
    for (const axle of present) {
      if (answersInForce(axle) !== (quantity === 'force')) continue;
      place(`${quantity}-${axle}`, async (range) => {
        const { t_s: t, axles } = await series(quantity, range);
        const curves = axles[axle];
        const of = (name, extra) => trace(t, curves, quantity, name, extra);
        if (!curves.plain && !curves.measured) return null;
        const models = [of('measured'), of('least_squares', { dash: 'dot' }), of('swarm', { dash: 'dash' }), of('plain', { width: 1 }), of('logged', { width: 1 })];
        const letter = { displacement: 'z', velocity: "z'", acceleration: "z''", load: 'load', force: 'force' }[quantity];
        return {
          x: { label: 'time (s)' },
          panels: [
            { label: `${letter} (${unit[quantity]})`, weight: 1.6, traces: models.filter(Boolean) },
            { label: `left (${unit[quantity]})`, traces: [of('residual', { name: 'residual of output error', legend: false })].filter(Boolean) },
          ].filter((panel) => panel.traces.length),
        };
      }, { timeline });
    }
  }
  for (const axle of present.filter((axle) => !answersInForce(axle))) {
    place(`observer-${axle}`, async (range) => {
      const [z, v] = await Promise.all([series('displacement', range), series('velocity', range)]);
      const both = (answer, quantity, legend) => ['measured', 'observer'].map((name) =>
        trace(answer.t_s, answer.axles[axle], quantity, name, { legend, dash: name === 'observer' ? 'dash' : undefined })).filter(Boolean);
      if (!z.axles[axle].observer) return null;
      const error = (answer, quantity) => ({
        name: 'observer error', x: answer.t_s, ink: 'series-extended', legend: false,
        y: minus(answer.axles[axle].observer, answer.axles[axle].measured).map((value) => (value === null ? null : scale[quantity] * value)),
      });
      return {
        x: { label: 'time (s)' },
        panels: [
          { label: 'z (mm)', weight: 1.3, traces: both(z, 'displacement', true) },
          { label: 'error (mm)', traces: [error(z, 'displacement')] },
          { label: "z' (m/s)", weight: 1.3, traces: both(v, 'velocity', false) },
          { label: 'error (m/s)', traces: [error(v, 'velocity')] },
        ],
      };
    }, { timeline });
    if (stated(axle)) place(`recursive-${axle}`, () => {
      const path = report.recursive[axle];
      const reference = report.output_error[axle];
      if (!path?.t_s.length) return null;
      // The first estimates, from a handful of samples, would hide all others.
      const settled = (key) => {
        const late = path[key].filter((_, i) => path.t_s[i] > path.t_s[0] + 0.08 * (path.t_s.at(-1) - path.t_s[0]));
        const [low, high] = [Math.min(...late, reference[key]), Math.max(...late, reference[key])];
        const spare = 0.3 * (high - low || Math.abs(high));
        return [low - spare, high + spare];
      };
      const panel = (key, label, legend) => ({ label, range: settled(key), traces: [
        { name: 'recursive least squares', x: path.t_s, y: path[key], ink: 'series-least-squares', legend },
        { name: 'output error', x: path.t_s, y: path.t_s.map(() => reference[key]), ink: 'series-plain', dash: 'dash', legend },
      ] });
      return { x: { label: 'time (s)' }, panels: [panel('k_n_m', 'k (N/m)', true), panel('b_n_s_m', 'B (N s/m)', false)] };
    });
  }
  const roll = report.roll;
  if (!roll) return;
  place('roll', () => {
    const degrees = (values) => values.map((value) => (value * 180) / Math.PI);
    const angles = [{ name: 'steady cornering', x: roll.t_s, y: degrees(roll.steady_roll_rad), ink: 'series-plain' }];
    if (roll.measured_roll_rad) angles.push({ name: 'measured', x: roll.t_s, y: degrees(roll.measured_roll_rad), ink: 'series-measured' });
    const panels = [{ label: 'roll (°)', traces: angles }];
    if (roll.roll_acceleration_rad_s2) {
      const observed = roll.observed_roll_acceleration_rad_s2;
      panels.push({ label: 'roll acceleration (rad/s²)', traces: [
        ...(observed ? [{ name: 'observed', x: roll.t_s, y: observed, ink: 'series-measured' }] : []),
        { name: 'computed', x: roll.t_s, y: roll.roll_acceleration_rad_s2, ink: 'series-extended' },
      ] });
    }
    return { x: { label: 'time (s)' }, panels };
  });
}
