// The columns of a ride that is about to be sent: a table for each file, in which each column is given a channel and a unit.

import { element, foldOf } from './layout.js';
import { channelOf, hasLaser, logOf, relay, signOf, turn, unlearn } from './logs.js';
import { rough } from './number.js';

const channels = document.querySelector('#channels').content.querySelector('select');
const option = (channel) => [...channels.options].find(({ value }) => value === channel);
const HEAD = ['Column', 'First values', 'Channel', 'Unit'];
const SIGNS = [['1', 'deflection u − z'], ['-1', 'distance to the road']];

/** Shows a table for each file; `changed` is called after each choice. */
export function offer(ride, answer, changed) {
  // Another layout makes other columns.
  const shape = JSON.stringify(answer.tables.map(({ columns, layout }) => [columns.map(({ header }) => header), layout]));
  if (ride.shape !== shape) {
    const made = build(ride, changed);
    made.open = ride.columns?.open || ride.files.length > 1 || ride.files.some((file) => logOf(file).choices.size > 0) || Boolean(answer.problem);
    const key = ride.columns?.contains(document.activeElement) && document.activeElement.dataset.key;
    if (ride.columns) ride.columns.replaceWith(made);
    else ride.item.append(made);
    if (key) made.querySelector(`[data-key="${key}"]`)?.focus();
    Object.assign(ride, { columns: made, shape });
  }
  ride.files.forEach((file, index) => update(logOf(file), ride.columns.querySelectorAll('.log')[index]));
  const sign = ride.columns.querySelector('.sign');
  sign.hidden = !hasLaser(ride);
  sign.querySelector('select').value = signOf(ride);
}

function build(ride, changed) {
  const details = element('details', 'columns', element('summary', '', 'Columns'));
  for (const file of ride.files) details.append(tableOf(logOf(file), changed));
  const select = element('select', '', ...SIGNS.map(([value, text]) => new Option(text, value)));
  select.addEventListener('change', (event) => {
    event.stopPropagation();
    turn(ride, Number(select.value));
    changed();
  });
  details.append(element('p', 'sign', element('label', '', 'Laser columns (d_f, d_r) hold the ', select)));
  details.append(element('p', 'hint', 'After the upload, this browser remembers the channels and rows you choose for files with the same header.'));
  return details;
}

function tableOf(log, changed) {
  const { name, format, rows, columns } = log.table;
  const head = element('tr', '', ...HEAD.map((text) => element('th', '', text)));
  head.querySelectorAll('th').forEach((cell) => { cell.scope = 'col'; });
  const body = element('tbody', '', ...columns.map((column) => rowOf(log, column, changed)));
  const caption = element('caption', '', name, element('span', 'quiet small', ` ${format}, ${rough(rows, 9)} rows`));
  const table = element('table', 'cards', caption, element('thead', '', head), body);
  const button = element('button', 'plain', 'Forget');
  button.type = 'button';
  button.setAttribute('aria-label', `Forget the channels kept for ${name}`);
  button.addEventListener('click', () => { unlearn(log); changed(); });
  const note = element('p', 'hint kept', 'Channels from your last upload with this header. ', button);
  const layout = foldOf(log, log.isLaidOut, () => { relay(log); changed(); });
  return element('div', 'log', element('div', 'scroll', table), note, ...layout ? [layout] : []);
}

/** The first values of a column, none of them broken across lines. */
function valuesOf({ first }) {
  if (!first.length) return ['blank'];
  return first.flatMap((value, index) => [index ? ' · ' : '', element('span', 'value', value)]);
}

function rowOf(log, column, changed) {
  const title = column.header || `column ${column.number}`;
  const channel = element('select', 'channel');
  channel.append(new Option('not used', ''), ...[...channels.options].map((known) => known.cloneNode(true)));
  channel.setAttribute('aria-label', `Channel of ${title}`);
  const unit = element('select', 'unit');
  unit.setAttribute('aria-label', `Unit of ${title}`);
  const choose = (event) => {
    event.stopPropagation();
    const named = channel.value || (event.target === unit && log.names.get(column.number));
    // While another layout is read, what was chosen before it is forgotten.
    log.choices ??= new Map();
    const isSame = event.target === unit || channel.value === channelOf(log, column.number);
    if (named) log.choices.set(column.number, { channel: named, unit: isSame ? unit.value : '' });
    else log.choices.delete(column.number);
    log.from = 'user';
    changed();
  };
  channel.addEventListener('change', choose);
  unit.addEventListener('change', choose);
  const cells = [element('th', '', title), element('td', 'quiet small', element('div', '', ...valuesOf(column))),
    element('td', '', element('div', '', channel, element('p', 'hint'))), element('td', '', unit)];
  cells[0].scope = 'row';
  cells.forEach((cell, index) => { cell.dataset.label = HEAD[index]; });
  const row = element('tr', 'column', ...cells);
  row.dataset.header = column.header;
  return row;
}

/** Brings the drop-downs of a file to what is chosen and read. */
function update(log, section) {
  section.querySelector('.kept').hidden = log.from !== 'kept';
  const rows = section.querySelectorAll('.column');
  log.table.columns.forEach((column, index) => {
    const [channel, unit] = rows[index].querySelectorAll('select');
    const choice = log.choices.get(column.number);
    const named = log.names.get(column.number);
    channel.options[0].text = named ? `${named} (by name)` : 'not used';
    channel.value = choice?.channel ?? '';
    rows[index].querySelector('.hint').textContent = choice?.isGuess ? 'Guessed from the header' : '';
    const read = choice?.unit ? '' : column.unit;
    const known = option(channelOf(log, column.number))?.dataset.units.split(',') ?? [];
    const others = new Set([...known, ...choice?.unit ? [choice.unit] : []]);
    others.delete(read);
    unit.disabled = known.length === 0;
    unit.replaceChildren(new Option(read || (choice?.unit ? 'as in the file' : '–'), ''), ...[...others].map((text) => new Option(text)));
    unit.value = choice?.unit ?? '';
  });
}
