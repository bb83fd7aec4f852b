// Numbers as people read, type and drag them.

/** At most this many significant digits, without zeros at the end. */
export function tidy(x, digits = 5) {
  return Number(x.toPrecision(digits));
}

export function format(x) {
  return typeof x === "number" ? String(tidy(x, 5)) : "";
}

/** A typed number, also with a comma; undefined if it is none. */
export function parse(text) {
  const value = Number(text.trim().replace(",", "."));
  return text.trim() === "" || !Number.isFinite(value) ? undefined : value;
}

/**
 * @param range {minimum, maximum, integer, unit}; each may be left out
 */
export function limit(x, { minimum = -Infinity, maximum = Infinity, integer }) {
  return Math.min(Math.max(integer ? Math.round(x) : x, minimum), maximum);
}

/** What a pixel of dragging adds to a value. */
export function stepOf(value, { minimum = -Infinity, maximum = Infinity, integer, unit }) {
  if (integer) return 0.1;
  if (unit === "degrees") return 0.5;
  const width = maximum - minimum;
  if (width <= 1000) return 10 ** Math.floor(Math.log10(width / 300));
  const size = Math.abs(value) || 1;
  return 10 ** Math.floor(Math.log10(size) - 1.5);
}

/** The value after dragging over some pixels. */
export function dragged(value, pixels, range) {
  const step = stepOf(value, range);
  const moved = Math.round((value + pixels * step) / step) * step;
  return limit(tidy(moved, 9), range);
}

/** The value after some presses of an arrow key. */
export function nudged(value, times, range) {
  const step = range.integer || range.unit === "degrees" ? 1 : stepOf(value, range) * 10;
  return limit(tidy(value + times * step, 9), range);
}
