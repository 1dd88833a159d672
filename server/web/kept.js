// The channels chosen for a logger's columns, kept in this browser under the header of its files.

const PLACE = 'columns';
/** Most headers that are kept. */
const MOST = 50;

function entries() {
  try {
    const found = JSON.parse(localStorage.getItem(PLACE));
    return Array.isArray(found) ? found.filter((entry) => Array.isArray(entry?.headers) && Array.isArray(entry.columns)) : [];
  } catch { return []; }
}

function write(kept) {
  try { localStorage.setItem(PLACE, JSON.stringify(kept.slice(-MOST))); } catch { /* storage may be off */ }
}

const is = (headers) => (entry) => JSON.stringify(entry.headers) === JSON.stringify(headers);
const isColumn = (column) => Number.isInteger(column?.number) && typeof column.channel === 'string' && typeof column.unit === 'string';

const KEYS = ['header_row', 'units_row', 'first_row', 'separator', 'decimal', 'time_format'];
const layoutOf = ({ layout }) => Object.fromEntries(KEYS.filter((key) => typeof layout?.[key] === 'string').map((key) => [key, layout[key]]));

/** What was kept for files with this header: columns with their channels and units, the laser's sign and the layout. */
export function kept(headers) {
  const found = entries().find(is(headers));
  return found ? { columns: found.columns.filter(isColumn), sign: found.sign === -1 ? -1 : 1, layout: layoutOf(found) } : null;
}

export function keep(headers, columns, sign, layout) {
  write([...entries().filter((entry) => !is(headers)(entry)), { headers, columns, sign, layout }]);
}

export function forget(headers) {
  write(entries().filter((entry) => !is(headers)(entry)));
}
