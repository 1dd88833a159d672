// Several jobs over each other. What is seen, the zoom included, stands in the page's address.

import { Figure, Timeline } from './plot.js';

const jobs = [...document.querySelectorAll('#jobs li')].map((item, i) => ({
  address: item.dataset.job, name: `${i + 1}: ${item.querySelector('a').textContent}`, ink: `job-${i + 1}`,
})).filter((job) => job.address);
const view = document.querySelector('#view');
const fields = { quantity: view.querySelector('#quantity'), curve: view.querySelector('#curve') };
const asked = new URLSearchParams(location.search);
const timeline = new Timeline();
const reports = Promise.all(jobs.map((job) => fetch(`${job.address}/report`).then((answer) => answer.json())));

view.hidden = false;
for (const [name, field] of Object.entries(fields)) {
  if ([...field.options].some((option) => option.value === asked.get(name))) field.value = asked.get(name);
  field.addEventListener('change', () => { remember(); figures.forEach((figure) => figure.refresh()); });
}
if (asked.has('t0') && asked.has('t1')) timeline.range = [Number(asked.get('t0')), Number(asked.get('t1'))];

/** Writes the view into the address. */
function remember() {
  const address = new URL(location.href);
  const set = (name, value) => (value === null ? address.searchParams.delete(name) : address.searchParams.set(name, value));
  for (const [name, field] of Object.entries(fields)) set(name, field.selectedIndex ? field.value : null);
  const [from, to] = timeline.range ?? [null, null];
  set('t0', from === null ? null : Number(from).toPrecision(7));
  set('t1', to === null ? null : Number(to).toPrecision(7));
  history.replaceState(null, '', address);
}

const answers = new Map();
function series(job, range) {
  const query = new URLSearchParams({ quantity: fields.quantity.value, points: 2000 });
  if (range) { query.set('t0', range[0]); query.set('t1', range[1]); }
  const address = `${job.address}/series?${query}`;
  if (!answers.has(address)) {
    if (answers.size > 64) answers.clear();
    answers.set(address, fetch(address).then((answer) => answer.json()));
  }
  return answers.get(address);
}

const figures = [];
for (const axle of ['front', 'rear']) {
  const place = document.querySelector(`#compare-${axle}`);
  place.hidden = false;
  figures.push(new Figure(place, async (range) => {
    const found = await Promise.all(jobs.map((job) => series(job, range)));
    const millimetres = fields.quantity.value === 'displacement';
    const unit = millimetres ? 'mm' : { velocity: 'm/s', acceleration: 'm/s²' }[fields.quantity.value];
    const traces = found.flatMap(({ t_s: t, axles }, i) => {
      const values = axles[axle]?.[fields.curve.value];
      if (!values) return [];
      const y = values.map((value) => (value === null ? null : (millimetres ? 1e3 : 1) * value));
      return [{ name: jobs[i].name, x: t, y, ink: jobs[i].ink, width: 1.1 }];
    });
    if (!traces.length) return null;
    return { x: { label: 'time (s)' }, panels: [{ label: unit, traces }] };
  }, { timeline }));

  const spectra = document.querySelector(`#spectra-${axle}`);
  spectra.hidden = false;
  new Figure(spectra, async () => {
    const traces = (await reports).flatMap((report, i) => {
      const spectrum = report.diagnosis?.evidence[axle]?.spectrum;
      if (!spectrum) return [];
      const y = spectrum.extended_m2_hz.map((power) => (power === null ? null : 1e3 * Math.sqrt(power)));
      return [{ name: jobs[i].name, x: spectrum.frequency_hz, y, ink: jobs[i].ink }];
    });
    if (!traces.length) return null;
    return { x: { label: 'frequency (Hz)', log: true }, panels: [{ label: 'mm/√Hz', log: true, traces }] };
  });
}
timeline.join({ refresh: remember });
