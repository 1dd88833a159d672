// The bicycle of the upload form: one way to enter it at a time, checked by the server while it is typed.

import { rough } from './number.js';

/** Pause in typing before the server is asked (ms). */
const PAUSE = 350;
const part = document.querySelector('#bicycle');
const panels = [...part.querySelectorAll('.way')];
const names = new Set([...part.querySelectorAll('[name]')].map(({ name }) => name));
const whole = part.querySelector('#bike-fault');
const understood = part.querySelector('#bike-understood');
let timer = null;
let asked = 0;

/** Whether a part of the form describes the bicycle. */
export function isOfBicycle(name) {
  return names.has(name);
}

/** Whether something is entered in the chosen way. */
export function isGiven() {
  return [...given().keys()].some((name) => name !== 'bicycle');
}

/** Shows what is wrong with the bicycle as a whole; returns the field to correct first. */
export function blame(text) {
  whole.textContent = text;
  return part.querySelector('[aria-invalid=true]') ?? panel()?.querySelector('input, select, textarea');
}

function panel() {
  return panels.find(({ disabled }) => !disabled);
}

/** Fields of the other ways are neither sent nor checked. */
function choose() {
  const way = part.querySelector('[name=bicycle]:checked')?.value;
  for (const panel of panels) panel.disabled = panel.dataset.way !== way;
}

function given() {
  const parts = new URLSearchParams();
  for (const [name, value] of new FormData(part.form)) {
    if (names.has(name) && value.trim()) parts.append(name, value);
  }
  return parts;
}

async function check() {
  const round = ++asked;
  if (!isGiven()) { show([]); return; }
  try {
    const response = await fetch('/v1/rides/preview/bike', { method: 'POST', body: given() });
    const answer = await response.json();
    if (round !== asked) return;
    if (response.ok) show(answer.faults, answer.bike);
    else show([{ part: 'bike', detail: answer.detail }]);
  } catch {
    if (round === asked) show([]);
  }
}

function show(faults, bike = null) {
  for (const field of part.querySelectorAll('[name]')) {
    const place = part.querySelector(`#${field.name}-fault`);
    if (!place || field.type === 'radio') continue;
    const detail = faults.find((fault) => fault.part === field.name)?.detail ?? '';
    if (place.textContent !== detail) place.textContent = detail;
    if (detail) field.setAttribute('aria-invalid', 'true');
    else field.removeAttribute('aria-invalid');
  }
  understood.textContent = bike ? summary(bike) : '';
}

/** The bicycle as it was read, in short. */
function summary(bike) {
  const pair = (what, front, rear, unit) => (front === null && rear === null ? []
    : [`${what} ${[front, rear].map((x) => (x === null ? 'unknown' : `${rough(x)} ${unit}`)).join(' front, ')} rear`]);
  const parts = [
    ...pair('masses', bike.mass_front_kg, bike.mass_rear_kg, 'kg'),
    ...pair('from the centre of gravity', bike.l_front_m, bike.l_rear_m, 'm'),
  ];
  return parts.length ? `Understood: ${parts.join('; ')}.` : '';
}

function later() {
  clearTimeout(timer);
  timer = setTimeout(check, PAUSE);
}

for (const event of ['input', 'change']) part.addEventListener(event, () => { whole.textContent = ''; choose(); later(); });
addEventListener('pageshow', () => { choose(); check(); });
choose();
