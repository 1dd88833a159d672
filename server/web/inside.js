// Figures of the report's `dynamics` and `validation`: drawn when their tab is opened.

const milli = (values) => values.map((value) => (value === null ? null : 1e3 * value));

/** Draws those of an axle that there are; no model's curve where the result withholds k or B. */
export function drawInside(report, axle, place, stated) {
  const { residual, response, restoring } = report.validation?.[axle] ?? {};
  const step = report.dynamics?.[axle]?.step_response;
  if (residual) place(`correlation-${axle}`, () => correlations(residual));
  if (!stated) return;
  if (response) place(`frequency-${axle}`, () => frequency(response));
  if (step) place(`step-${axle}`, () => stepResponse(step));
  if (!restoring) return;
  const { over_deflection: deflection, over_rate: rate } = restoring;
  place(`restoring-${axle}`, () => force(deflection, milli(deflection.at), 'deflection (mm)'));
  place(`damping-${axle}`, () => force(rate, rate.at, 'rate (m/s)'));
}

/** A shaded band between two curves. */
function band(name, x, low, high, ink, legend) {
  return [
    { name, x, y: low, ink, width: 0, legend: false },
    { name, x, y: high, ink, width: 0, band: true, legend },
  ];
}

function correlations({ lag_s: lags, autocorrelation, cross_correlation: cross }) {
  const x = milli(lags);
  const panel = (label, { values, bounds }, from, legend) => ({ label, traces: [
    ...band('99 % of white noise', x, bounds.map((bound) => -bound), bounds, 'series-other', legend),
    { name: label, x: x.slice(from), y: values.slice(from), ink: 'series-plain', dots: true, legend: false },
  ] });
  return {
    x: { label: 'lag (ms)' },
    panels: [
      // At lag 0 it is 1 whatever the residual.
      panel('with itself', autocorrelation, 1, true),
      ...(cross ? [panel('with the input', cross, 0, false)] : []),
    ],
  };
}

function frequency(response) {
  const { frequency_hz: x, plain, extended } = response;
  // Where input and output are not coherent, nothing was measured.
  const isKnown = (i) => response.coherence[i] >= response.coherent_above && response.magnitude_low[i] !== null;
  const known = (values) => values.map((value, i) => (isKnown(i) ? value : null));
  const within = (values) => values.filter((_, i) => isKnown(i));
  const models = (key, legend) => [
    { name: 'plain model', x, y: plain[key], ink: 'series-plain', dash: 'dash', legend },
    ...(extended ? [{ name: 'with the effects', x, y: known(extended[key]), ink: 'series-extended', legend }] : []),
  ];
  const unit = response.unit === '-' ? '' : ` (${response.unit})`;
  return {
    x: { label: 'frequency (Hz)', log: true },
    marks: response.coherent_hz.map(([from, to]) => ({ from, to })),
    panels: [
      { label: `|${response.of}|${unit}`, log: true, weight: 2, traces: [
        ...band('95 % interval', within(x), within(response.magnitude_low), within(response.magnitude_high), 'series-measured', false),
        { name: 'measured', x, y: known(response.magnitude), ink: 'series-measured' },
        ...(plain.magnitude_low.length ? band('95 % of the plain model', x, plain.magnitude_low, plain.magnitude_high, 'series-plain', false) : []),
        ...models('magnitude', true),
      ] },
      { label: 'phase (rad)', weight: 1.3, traces: [{ name: 'measured', x, y: known(response.phase_rad), ink: 'series-measured', legend: false }, ...models('phase_rad', false)] },
      { label: 'coherence', range: [0, 1.05], traces: [{ name: 'coherence', x, y: response.coherence, ink: 'series-measured', legend: false }] },
    ],
  };
}

function stepResponse({ input, t_s: t, displacement_m: z }) {
  const road = input === 'road';
  return {
    x: { label: 'time (s)' },
    panels: [{ label: road ? 'z per step of the road (m/m)' : 'z per force (mm/N)', traces: [
      { name: 'displacement', x: t, y: road ? z : milli(z), ink: 'series-plain', legend: false },
    ] }],
  };
}

function force(curve, x, label) {
  const margin = (sign) => curve.plain_n.map((force, i) => force + sign * curve.plain_margin_n[i]);
  return {
    hover: 'closest',
    x: { label },
    panels: [{ label: 'N', traces: [
      ...(curve.plain_margin_n.length ? band('95 % of the plain model', x, margin(-1), margin(1), 'series-plain', false) : []),
      { name: 'plain model', x, y: curve.plain_n, ink: 'series-plain', dash: 'dash' },
      ...(curve.extended_n.length ? [{ name: 'with the effects', x, y: curve.extended_n, ink: 'series-extended' }] : []),
      { name: 'measured', x, y: curve.measured_n, ink: 'series-measured', dots: true, error: curve.std_error_n.map((std) => 1.96 * std) },
    ] }],
  };
}
