// Numbers as people read them, by the rules of engine/number.rs; a test holds the two equal.

const THIN_SPACE = '\u202f';
const MINUS = '\u2212';
const MOST = 10;
const ALONE = 5;

/** The power of ten of a number rounded to so many digits. */
const power = (value, digits) => Number(value.toExponential(digits - 1).split('e')[1]);
const decimals = (value, digits) => (value === 0 ? 0 : digits - 1 - power(value, digits));
// toFixed knows a hundred places.
const fixed = (value, places) => value.toFixed(Math.min(Math.max(places, 0), 100));

function rounded(value, places) {
  if (places >= 0) return Number(fixed(value, places));
  const step = 10 ** -places;
  return Math.round(value / step) * step;
}

const exponent = (size) => (size === 0 || (size >= 1e-3 && size < 1e6) ? null : power(size, 15));

/** The number over a power of ten, with the decimals that it had before. */
function shifted(value, places, by) {
  const left = by < 0 ? value * 10 ** -by : value / 10 ** (by ?? 0);
  return grouped(fixed(rounded(left, places + (by ?? 0)), places + (by ?? 0)));
}

/** Thousands apart, from five digits on, and nothing has no sign. */
function grouped(text) {
  const [whole, fraction] = text.replace('-', '').split('.');
  const apart = whole.length > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, THIN_SPACE) : whole;
  return (text.startsWith('-') && /[1-9]/.test(text) ? MINUS : '') + apart + (fraction ? `.${fraction}` : '');
}

/** So many significant digits, less zeros at the end. */
export function rough(value, digits = ALONE) {
  if (!Number.isFinite(value)) return '–';
  const places = decimals(value, digits);
  const by = exponent(rounded(Math.abs(value), places));
  const text = shifted(value, places, by);
  return (text.includes('.') ? text.replace(/\.?0+$/, '') : text) + (by === null ? '' : `e${by}`);
}

/** A value with its 95 % interval, to two digits of that. */
export function measured(value, stdError) {
  const known = 1.96 * (stdError ?? NaN);
  if (!(known > 0 && Number.isFinite(known)) || !Number.isFinite(value)) return rough(value);
  const places = Math.min(decimals(known, 2), value === 0 ? Infinity : decimals(value, MOST));
  const margin = Math.max(known, 10 ** -places);
  const by = exponent(rounded(Math.max(Math.abs(value), margin), places));
  const text = `${shifted(value, places, by)} ± ${shifted(margin, places, by)}`;
  return by === null ? text : `(${text})e${by}`;
}
