// The upload form with JavaScript: several rides at once, a preview of what was understood of each,
// progress and outcome per ride, to the end of its job. Without it the plain form sends one ride.

import { blame, isOfBicycle, isTold } from './bicycle.js';
import { guessed, mapped, offer } from './columns.js';
import { running, watch } from './live.js';
import { rough } from './number.js';

const STAGES = { observe: 'observer and least squares', trial: 'particle swarm', conclude: 'output error', diagnose: 'diagnosis' };
const form = document.querySelector('#upload');
const input = document.querySelector('#file');
const list = document.querySelector('#rides');
const drop = document.querySelector('.drop');
const rides = new Map();
/** What it depends on how a file is read, and whether it can be identified. */
const READING = ['rate_hz', 'rows', 'map', 'deflection_sign', 'band_hz'];
const isRead = (name) => READING.includes(name) || isOfBicycle(name);

const together = document.querySelector('#together');
const one = document.querySelector('#one');

input.required = false;
document.querySelector('#many').hidden = false;
document.querySelector('#several').hidden = true;
together.addEventListener('change', () => {
  const files = [];
  for (const ride of rides.values()) if (!ride.sent) { files.push(...ride.files); remove(ride); }
  add(files);
});

drop.addEventListener('dragover', (event) => { event.preventDefault(); drop.classList.add('over'); });
drop.addEventListener('dragleave', () => drop.classList.remove('over'));
drop.addEventListener('drop', (event) => {
  event.preventDefault();
  drop.classList.remove('over');
  add(event.dataTransfer.files);
});
input.addEventListener('change', () => { add(input.files); input.value = ''; });
form.addEventListener('change', ({ target }) => {
  if (isRead(target.name)) for (const ride of rides.values()) if (!ride.sent) preview(ride);
});

const another = document.querySelector('#another');
another.hidden = false;
another.addEventListener('click', () => {
  const rows = form.querySelectorAll('.map');
  const row = rows[rows.length - 1].cloneNode(true);
  const [label, field, hint] = ['label', 'input', '.hint'].map((part) => row.querySelector(part));
  field.id = label.htmlFor = `map${rows.length + 1}`;
  hint.id = `${field.id}-hint`;
  field.setAttribute('aria-describedby', hint.id);
  field.value = '';
  rows[rows.length - 1].after(row);
  field.focus();
});

/** Each file is a ride, or all that are not sent yet are one. */
function add(files) {
  const fresh = [...files].filter((file) => ![...rides.values()].some((ride) => ride.files.some((other) => same(file, other))));
  if (together.checked && fresh.length) {
    const waiting = [...rides.values()].filter((ride) => !ride.sent);
    waiting.forEach(remove);
    begin([...waiting.flatMap((ride) => ride.files), ...fresh]);
  } else for (const file of fresh) begin([file]);
  offerOne();
}

function same(a, b) {
  return a.name === b.name && a.size === b.size && a.lastModified === b.lastModified;
}

function begin(files) {
  const ride = { files, name: files.map((file) => file.name).join(', '), item: document.createElement('li') };
  ride.item.innerHTML = '<div class="top"><strong></strong><button type="button">Remove</button></div><p class="quiet small"></p>';
  ride.item.querySelector('strong').textContent = ride.name;
  ride.said = ride.item.querySelector('p');
  const button = ride.item.querySelector('button');
  button.setAttribute('aria-label', `Remove ${ride.name}`);
  button.addEventListener('click', () => { remove(ride); offerOne(); input.focus(); });
  rides.set(ride, ride);
  list.append(ride.item);
  list.hidden = false;
  preview(ride);
}

function remove(ride) {
  ride.request?.abort();
  rides.delete(ride);
  ride.item.remove();
}

/** Whether several files are one ride is asked where there are several. */
function offerOne() {
  const waiting = [...rides.values()].filter((ride) => !ride.sent).flatMap((ride) => ride.files);
  one.hidden = waiting.length < 2;
}

/** A form with the columns that were chosen for the ride, and its files at its end. */
function withFiles(ride, body) {
  for (const map of mapped(ride)) body.append('map', map);
  for (const file of ride.files) body.append('file', file);
  return body;
}

/** What is filled in of the form's fields, or of those whose names are wanted; several may have one name. */
function filled(isWanted = () => true) {
  const data = new FormData();
  for (const [name, value] of new FormData(form)) {
    if (typeof value === 'string' && value.trim() && isWanted(name)) data.append(name, value);
  }
  return data;
}

async function preview(ride) {
  say(ride, 'reading …');
  const body = withFiles(ride, filled(isRead));
  try {
    const response = await fetch('/v1/rides/preview', { method: 'POST', body });
    const answer = await response.json();
    if (ride.sent || !rides.has(ride)) return;
    if (!response.ok) { say(ride, answer.detail, true); return; }
    if (guessed(ride, answer.guesses)) { await preview(ride); return; }
    offer(ride, answer, () => preview(ride));
    const columns = answer.columns.map((c) => (c.header === c.channel ? `${c.channel} (${c.unit})` : `${c.channel} from ${c.header} (${c.unit})`));
    const parts = [answer.format];
    if (answer.rate_hz) parts.push(`${answer.duration_s.toFixed(1)} s at ${rough(answer.rate_hz)} Hz`);
    parts.push(columns.join(', '));
    if (answer.ignored.length) parts.push(`not used: ${answer.ignored.join(', ')}`);
    if (answer.gaps.length) parts.push(`${answer.gaps.length === 1 ? 'a gap' : `${answer.gaps.length} gaps, the first`} from ${answer.gaps[0].from_s.toFixed(2)} to ${answer.gaps[0].to_s.toFixed(2)} s`);
    say(ride, parts.join(' · '));
    for (const warning of answer.warnings) note(ride, warning);
    if (answer.problem) say(ride, answer.problem, true);
  } catch {
    say(ride, 'The preview could not be fetched.', true);
  }
}

function say(ride, text, fault = false) {
  ride.item.querySelectorAll('.note').forEach((element) => element.remove());
  ride.said.textContent = text;
  ride.said.className = fault ? 'fault' : 'quiet small';
}

function note(ride, text) {
  const line = document.createElement('p');
  line.className = 'note small';
  line.textContent = `Note: ${text}`;
  ride.item.append(line);
}

form.addEventListener('submit', async (event) => {
  event.preventDefault();
  blame('');
  if (rides.size === 0) { input.required = true; input.reportValidity(); input.required = false; return; }
  if (!isTold()) { blame('Which bicycle was it?'); return; }
  const button = form.querySelector('button.primary');
  button.disabled = true;
  const jobs = [];
  for (const ride of rides.values()) {
    if (ride.job) continue;
    const job = await send(ride);
    if (job) jobs.push(job);
  }
  button.disabled = false;
  const [ride] = rides.values();
  if (rides.size === 1 && jobs.length === 1 && !ride.known) location.assign(jobs[0].links.page);
});

/** Sends one ride and shows how far it is; its job, or nothing where it was refused. */
function send(ride) {
  ride.sent = true;
  const bar = document.createElement('progress');
  bar.max = ride.files.reduce((sum, file) => sum + file.size, 0);
  bar.value = 0;
  bar.setAttribute('aria-label', `Upload of ${ride.name}`);
  ride.item.append(bar);
  say(ride, 'sending …');
  return new Promise((resolve) => {
    const body = withFiles(ride, filled());
    const request = new XMLHttpRequest();
    ride.request = request;
    request.upload.addEventListener('progress', (event) => { bar.value = event.loaded; });
    request.addEventListener('loadend', () => {
      bar.remove();
      const answer = parse(request.responseText);
      if (request.status === 202) {
        ride.job = answer;
        ride.known = request.getResponseHeader('Veloid-Known') === 'true';
        ride.item.querySelector('button').remove();
        ride.columns?.remove();
        ride.said.className = '';
        show(ride, answer);
        watch(answer.links.job, (job) => show(ride, job));
        resolve(answer);
        return;
      }
      ride.sent = false;
      const detail = answer?.detail ?? 'The upload did not reach the server.';
      say(ride, detail, true);
      if (answer?.type === 'urn:veloid:problem:bad-bike') blame(detail);
      resolve(null);
    });
    request.open('POST', '/v1/rides');
    request.send(body);
  });
}

/** Where the job of a ride stands. */
function show(ride, job) {
  const said = {
    queued: 'queued', running: STAGES[job.stage], failed: `failed: ${job.failure?.detail}`, cancelled: 'cancelled',
    succeeded: job.verdict?.replaceAll('_', ' ') ?? 'done',
  }[job.state];
  const text = `${job.state} ${said}`;
  if (ride.shown !== text) {
    ride.shown = text;
    const state = document.createElement('span');
    state.className = `state ${job.state}`;
    state.textContent = said;
    const link = document.createElement('a');
    link.href = job.links.page;
    link.textContent = job.state === 'succeeded' ? 'see the result' : running(job) ? 'follow the identification' : 'see the job';
    link.setAttribute('aria-label', `${ride.name}: ${link.textContent}`);
    const known = !ride.known ? [] : [job.state === 'succeeded' ? ' · this ride was identified before' : ' · this ride was sent before'];
    ride.said.replaceChildren(state, ...known, ' · ', link);
  }
  let bar = ride.item.querySelector('progress');
  if (!running(job)) { bar?.remove(); return; }
  if (!bar) {
    bar = document.createElement('progress');
    bar.setAttribute('aria-label', `Identification of ${ride.name}`);
    ride.item.append(bar);
  }
  bar.value = job.progress;
}

function parse(text) {
  try { return JSON.parse(text); } catch { return null; }
}
