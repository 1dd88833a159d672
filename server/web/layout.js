// How the table of a file is laid out: its first lines, and fields for what was found wrong.

const ROWS = [['header_row', 'Column names in line', 0], ['units_row', 'Units in line', 0], ['first_row', 'Numbers from line', 1]];
const SEPARATORS = [[',', 'comma'], [';', 'semicolon'], ['tab', 'tab'], ['|', 'bar'], ['blanks', 'blanks']];
const DECIMALS = [['.', 'point'], [',', 'comma']];
const NAMES = new Map([['header_row', 'names'], ['units_row', 'units'], ['first_row', 'numbers']]);

/** An element with its class and what it holds. */
export function element(name, className, ...nodes) {
  const made = document.createElement(name);
  if (className) made.className = className;
  made.append(...nodes);
  return made;
}

function labelled(text, field) {
  return element('label', '', text, field);
}

/** The first lines of a file, each with what it was taken for. */
function linesOf({ lines, layout }) {
  const body = lines.map(({ number, cells }) => {
    const role = [...NAMES].find(([key]) => layout[key] === number)?.[1] ?? '';
    const head = element('th', '', `${number}`);
    head.scope = 'row';
    const row = element('tr', '', head, element('td', 'quiet small', role), ...cells.map((cell) => element('td', '', cell)));
    row.dataset.role = role;
    return row;
  });
  return element('div', 'scroll', element('table', 'lines', element('tbody', '', ...body)));
}

/** A fold with the layout of `log`, a text file; `changed` is called after a choice. Null for other files. */
export function foldOf(log, isOpen, changed) {
  const { table, layout } = log;
  if (!table.lines?.length) return null;
  const say = (key, value) => {
    if (value === '') delete layout[key];
    else layout[key] = value;
    changed();
  };
  const listen = (field, key) => {
    field.dataset.key = key;
    field.addEventListener('change', (event) => { event.stopPropagation(); if (field.validity.valid) say(key, field.value.trim()); });
    return field;
  };
  const numbers = ROWS.map(([key, text, least]) => {
    const field = Object.assign(element('input'), { type: 'number', min: least, max: 100000, step: 1, value: layout[key] ?? '' });
    field.placeholder = table.layout[key] || 'none';
    return labelled(text, listen(field, key));
  });
  const selects = [['separator', 'Cells end with', SEPARATORS], ['decimal', 'Decimal mark', DECIMALS]].map(([key, text, known]) => {
    const found = known.find(([value]) => value === table.layout[key])?.[1] ?? table.layout[key];
    const select = element('select', '', new Option(`${found} (found)`, ''), ...known.map(([value, name]) => new Option(name, value)));
    select.value = layout[key] ?? '';
    return labelled(text, listen(select, key));
  });
  const format = Object.assign(element('input'), { type: 'text', maxLength: 64, value: layout.time_format ?? '', placeholder: 'as found, or %d/%m/%Y %H:%M:%S%.f' });
  const fields = element('div', 'options', ...numbers, ...selects, labelled('Format of times', listen(format, 'time_format')));
  const fold = element('details', 'layout', element('summary', '', 'Rows and marks'), linesOf(table), fields);
  fold.open = isOpen;
  return fold;
}
