// What is known of each file that is about to be sent: its columns, and the channel and unit chosen for each of them. The server's
// guesses are chosen at first, or what was kept for the same header.

import { forget, keep, kept } from './kept.js';

const logs = new WeakMap();

/**
 * `from` says where the choices come from: 'guess', 'kept' or 'user'; `sign` is the laser's, where it was chosen; `layout` is what the
 * user says of the rows, and `seen` the headers before that.
 */
export function logOf(file) {
  if (!logs.has(file)) logs.set(file, { name: file.name, table: null, choices: null, guesses: new Map(), sign: null, from: 'guess', layout: {}, seen: null });
  return logs.get(file);
}

/** Forgets what was guessed, as another set of files or another layout may leave other guesses. */
export function rethink(log) {
  if (log.from !== 'user') log.choices = null;
}

/** Forgets the columns of a file whose layout was chosen. */
export function relay(log) {
  Object.assign(log, { isLaidOut: true, from: 'guess', choices: null });
}

const headersOf = (log) => log.table.columns.map(({ header }) => header);

/** Takes in what the server made of the files; whether that chose channels, so that it would now read them otherwise. */
export function learn(ride, { tables, guesses }) {
  let isNew = false;
  ride.files.forEach((file, index) => {
    const log = logOf(file);
    log.table = tables[index];
    log.name = log.table.name;
    log.seen ??= headersOf(log);
    if (log.choices) return;
    log.names = new Map(log.table.columns.map(({ number, channel }) => [number, channel]));
    log.guesses = new Map();
    for (const guess of guesses) {
      if ((guess.file ?? log.name) !== log.name) continue;
      const column = log.table.columns.find(({ header, channel }) => header === guess.header && !channel);
      if (column) log.guesses.set(column.number, guess);
    }
    recall(log);
    isNew ||= log.choices === null || log.choices.size > 0;
  });
  settle(ride);
  return isNew;
}

/** Drops guesses of channels that were chosen in another file; each file has a time of its own. */
function settle(ride) {
  const all = ride.files.map(logOf).filter(({ choices }) => choices);
  const chosen = all.flatMap(({ choices }) => [...choices.values()]).filter(({ isGuess }) => !isGuess).map(({ channel }) => channel);
  for (const { choices } of all) {
    for (const [number, { channel, isGuess }] of choices) {
      if (isGuess && channel !== 't' && chosen.includes(channel)) choices.delete(number);
    }
  }
}

function recall(log) {
  const found = log.isLaidOut ? null : kept(log.seen);
  if (found && Object.keys(found.layout).length > 0 && !log.isRecalled) {
    // The columns are those of this layout: they are recalled from the next preview.
    Object.assign(log, { layout: found.layout, isRecalled: true });
    return;
  }
  log.from = found ? 'kept' : 'guess';
  log.sign = found?.sign ?? null;
  log.choices = new Map(found
    ? found.columns.map(({ number, channel, unit }) => [number, { channel, unit }])
    : [...log.guesses].map(([number, { channel, unread_unit: unit }]) => [number, { channel, unit: unit ?? '', isGuess: true }]));
}

/** Drops what was kept for files like this one. */
export function unlearn(log) {
  forget(log.seen);
  Object.assign(log, { layout: {}, isLaidOut: false, choices: null });
}

/** Keeps what the user chose for the files of a ride. */
export function remember(ride) {
  for (const log of ride.files.map(logOf)) {
    if (log.from !== 'user' && !log.isLaidOut) continue;
    const columns = [...log.choices].map(([number, { channel, unit }]) => ({ number, channel, unit }));
    keep(log.seen, columns, signOf(ride), log.layout);
  }
}

/** The channel of a column, chosen or by its name. */
export const channelOf = (log, number) => log.choices?.get(number)?.channel ?? log.names?.get(number) ?? null;

const lasersOf = (log) => (log.table?.columns ?? []).filter(({ number }) => channelOf(log, number)?.startsWith('d_'));
export const hasLaser = (ride) => ride.files.some((file) => lasersOf(logOf(file)).length > 0);

/** -1 where a laser's column holds its distance to the road. */
export function signOf(ride) {
  const isDistance = (log) => lasersOf(log).some(({ number }) => (log.sign ?? log.guesses.get(number)?.deflection_sign) === -1);
  return ride.files.some((file) => isDistance(logOf(file))) ? -1 : 1;
}

export function turn(ride, sign) {
  for (const log of ride.files.map(logOf)) if (lasersOf(log).length) Object.assign(log, { sign, from: 'user' });
}

/** A column as the mapping names it: by its header, or by its number if the header is not unique. */
function columnOf(log, number, unit) {
  const headers = headersOf(log);
  const header = headers[number - 1];
  const named = unit ? `${header} [${unit}]` : header;
  const isOwn = header && headers.indexOf(header) === headers.lastIndexOf(header) && !(unit && headers.includes(named));
  return isOwn ? named : unit ? `${number} [${unit}]` : `${number}`;
}

/** In front of a channel a file's name ends at the first equals sign. */
const plain = (name) => name.replaceAll('=', '_');

/** Adds the chosen columns, the layouts, the laser's sign and the files of a ride to a form. */
export function fill(body, ride) {
  const several = ride.files.length > 1;
  for (const file of ride.files) {
    const log = logOf(file);
    for (const [number, { channel, unit }] of log.choices ?? []) {
      body.append('map', `${several ? `${plain(log.name)}:` : ''}${channel}=${columnOf(log, number, unit)}`);
    }
    for (const [key, value] of Object.entries(log.layout)) body.append('layout', `${several ? `${plain(log.name)}:` : ''}${key}=${value}`);
    if (several) body.append('file', file, plain(file.name));
    else body.append('file', file);
  }
  if (hasLaser(ride) && signOf(ride) === -1) body.set('deflection_sign', '-1');
  return body;
}
