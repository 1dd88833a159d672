// The upload form with JavaScript: several rides at once, a preview and a table of columns for each, progress and outcome to the
// end of its job. Without it the plain form sends one ride.

import { blame, isGiven, isOfBicycle } from './bicycle.js';
import { logOf, rethink } from './logs.js';
import { clear, lead } from './outcome.js';
import { look } from './preview.js';
import { send } from './send.js';

const form = document.querySelector('#upload');
const input = document.querySelector('#file');
const list = document.querySelector('#rides');
const drop = document.querySelector('.drop');
const together = document.querySelector('#together');
const one = document.querySelector('#one');
const reason = document.querySelector('#one-reason');
const button = form.querySelector('button.primary');
const rides = new Set();
/** Options that change how a file is read. */
const READING = ['rate_hz', 'rows', 'map', 'deflection_sign', 'band_hz'];
const isRead = (name) => READING.includes(name) || isOfBicycle(name);
/** Whether the page has proposed that the files are one ride, and whether the user has decided. */
let isProposed = false;
let isDecided = false;

input.required = false;
for (const part of document.querySelectorAll('.unscripted')) part.hidden = true;
for (const part of document.querySelectorAll('.scripted')) part.hidden = false;
// Each ride has a choice of its own beside its columns.
const sign = form.querySelector('#deflection_sign');
sign.disabled = true;
sign.closest('.field').hidden = true;

together.addEventListener('change', () => {
  isDecided = true;
  isProposed = false;
  reason.textContent = '';
  group(takeBack());
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
  clear();
  if (isRead(target.name)) waiting().forEach(preview);
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

function waiting() {
  return [...rides].filter((ride) => !ride.sent);
}

const same = (a, b) => a.name === b.name && a.size === b.size && a.lastModified === b.lastModified;

function add(files) {
  clear();
  const fresh = [...files].filter((file) => ![...rides].some((ride) => ride.files.some((other) => same(file, other))));
  if (!fresh.length) return;
  // With another file what was proposed may no longer hold.
  const isOne = together.checked;
  if (isProposed) { together.checked = isProposed = false; reason.textContent = ''; }
  group([...isOne ? takeBack() : [], ...fresh]);
}

/** Files that are not sent yet, out of the list. */
function takeBack() {
  const back = waiting();
  back.forEach(remove);
  return back.flatMap((ride) => ride.files);
}

/** Each file is a ride, or all of them are one. */
function group(files) {
  files.map(logOf).forEach(rethink);
  if (together.checked && files.length) begin(files);
  else for (const file of files) begin([file]);
  offerOne();
}

function begin(files) {
  const ride = { files, name: files.map((file) => file.name).join(', '), item: document.createElement('li'), round: 0 };
  ride.item.innerHTML = '<div class="top"><strong></strong><button type="button">Remove</button></div><p class="quiet small" role="status"></p>';
  ride.item.querySelector('strong').textContent = ride.name;
  ride.said = ride.item.querySelector('p');
  const off = ride.item.querySelector('button');
  off.setAttribute('aria-label', `Remove ${ride.name}`);
  off.addEventListener('click', () => { clear(); remove(ride); offerOne(); propose(); input.focus(); });
  rides.add(ride);
  list.append(ride.item);
  list.hidden = false;
  preview(ride);
}

function remove(ride) {
  ride.request?.abort();
  rides.delete(ride);
  ride.item.remove();
}

/** Several files may be one ride. */
function offerOne() {
  one.hidden = waiting().flatMap((ride) => ride.files).length < 2;
  if (rides.size === 0) together.checked = isProposed = isDecided = false;
  if (one.hidden) reason.textContent = '';
}

/** Proposes one ride where every file was read and none is a ride by itself. */
function propose() {
  const alone = waiting();
  if (isDecided || together.checked || alone.length < 2 || alone.some(({ isRide }) => isRide !== false)) return;
  isProposed = together.checked = true;
  reason.textContent = 'Checked because no file is a complete ride by itself. Uncheck it if they are separate rides.';
  group(takeBack());
}

/** What is filled in of the form's fields, or of those whose names are wanted; several may have one name. */
function filled(isWanted = () => true) {
  const data = new FormData();
  for (const [name, value] of new FormData(form)) {
    if (typeof value === 'string' && value.trim() && isWanted(name)) data.append(name, value);
  }
  return data;
}

function preview(ride) {
  const round = ++ride.round;
  const isLast = () => round === ride.round && !ride.sent && rides.has(ride);
  const reading = look(ride, () => filled(isRead), isLast, () => preview(ride)).then(() => {
    if (!isLast()) return;
    ride.reading = null;
    propose();
  });
  ride.reading = reading;
}

/** Waits for the previews: they choose the channels, and whether the files are one ride. */
async function settled() {
  for (let open = waiting(); open.some(({ reading }) => reading); open = waiting()) {
    await Promise.all(open.map(({ reading }) => reading));
  }
}

form.addEventListener('submit', async (event) => {
  event.preventDefault();
  clear();
  blame('');
  if (rides.size === 0) { input.required = true; input.reportValidity(); input.required = false; return; }
  if (!isGiven()) { fail('Choose a bicycle or enter its values.'); return; }
  button.disabled = true;
  lead(null, false, 'Reading the files …');
  await settled();
  clear();
  const jobs = [];
  const refused = [];
  for (const ride of rides) {
    if (ride.job) continue;
    const { job, problem } = await send(ride, filled());
    if (job) jobs.push(job);
    else refused.push({ ride, problem });
  }
  button.disabled = false;
  offerOne();
  const [ride] = rides;
  if (refused.length) {
    const [first] = refused;
    if (first.problem.type === 'urn:veloid:problem:bad-bike') fail(first.problem.detail);
    else lead(first.ride.said, true, rides.size > 1 ? `${first.ride.name}: ${first.problem.detail}` : first.problem.detail);
    return;
  }
  if (rides.size === 1 && jobs.length === 1 && !ride.known) { location.assign(jobs[0].links.page); return; }
  const known = [...rides].find((other) => other.known && jobs.includes(other.job));
  if (known) lead(known.said, false, ...known.said.cloneNode(true).childNodes);
});

/** Says what is wrong with the bicycle, in its place and beside the button. */
function fail(detail) {
  lead(blame(detail), true, detail);
}
