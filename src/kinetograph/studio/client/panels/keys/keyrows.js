// Rows of the document's keys: when they are, in which order, and rows that are changed.

/**
 * @typedef {import("../../messages.js").KeyRow} KeyRow
 * @typedef {import("../../messages.js").MetRow} MetRow
 * @typedef {Partial<KeyRow>} Change
 */

const FRAME = 1 / 30; // seconds: what times are rounded to

/**
 * What a key is called.
 *
 * @param {KeyRow} row
 * @param {number} index
 */
export function nameOf(row, index) {
  return row.name || `key ${index + 1}`;
}

/**
 * The recording and second of a pose.
 *
 * @param {KeyRow} row
 */
export function poseOf(row) {
  const at = row.pose.lastIndexOf("@");
  return { source: row.pose.slice(0, at).replace(/^take:/, ""), second: Number(row.pose.slice(at + 1)) };
}

/**
 * The window in which a key is asked for; null where its time is free. The first key is where time begins.
 *
 * @param {KeyRow} row
 * @param {number} index
 * @returns {[number, number] | null}
 */
export function windowOf(row, index) {
  if (index === 0) return [0, 0];
  if (row.time === null || row.time === undefined) return null;
  return typeof row.time === "number" ? [row.time, row.time] : row.time;
}

/**
 * Where keys are on the timeline: where they are asked for, where they were met, or after the one before.
 *
 * @param {KeyRow[]} rows
 * @param {MetRow[] | null} met of these rows
 * @returns {[number, number][]}
 */
export function spansOf(rows, met) {
  /** @type {[number, number][]} */
  const spans = [];
  rows.forEach((row, i) => {
    const before = i ? spans[i - 1][1] : 0;
    const at = met?.[i]?.time ?? before + (i ? 1 : 0);
    spans.push(windowOf(row, i) ?? [at, at]);
  });
  return spans;
}

/**
 * A time of the document: a second, a window, or null for free.
 *
 * @param {number} start
 * @param {number} stop
 * @returns {number | [number, number]}
 */
export function timeFrom(start, stop) {
  const [first, last] = [round(Math.max(start, FRAME)), round(Math.max(stop, FRAME))];
  return last - first < FRAME / 2 ? first : [first, last];
}

/** @param {number} seconds */
function round(seconds) {
  return Number((Math.round(seconds / FRAME) * FRAME).toFixed(4));
}

/**
 * Rows with one changed, in order of time, and where that one is now. The first key stays the first.
 *
 * @param {KeyRow[]} rows
 * @param {number} index
 * @param {Change} change what is undefined or null in it is left out of the row
 * @param {MetRow[] | null} met
 * @returns {{rows: KeyRow[], index: number}}
 */
export function changed(rows, index, change, met) {
  const row = clean({ ...rows[index], ...change });
  const next = rows.map((other, i) => (i === index ? row : other));
  if (!("time" in change) || index === 0) return { rows: next, index };
  const middle = spansOf(next, met).map(([start, stop]) => (start + stop) / 2);
  const order = next.map((_, i) => i).sort((a, b) => (a && b ? middle[a] - middle[b] || a - b : a - b));
  return { rows: order.map((i) => next[i]), index: order.indexOf(index) };
}

/**
 * Rows with one more: at its time among the others, or last.
 *
 * @param {KeyRow[]} rows
 * @param {KeyRow} row
 * @param {MetRow[] | null} met
 * @returns {{rows: KeyRow[], index: number}}
 */
export function added(rows, row, met) {
  if (typeof row.time !== "number" || !rows.length) return { rows: [...rows, row], index: rows.length };
  const spans = spansOf(rows, met);
  const later = spans.findIndex(([start, stop], i) => i > 0 && (start + stop) / 2 > /** @type {number} */ (row.time));
  const index = later < 0 ? rows.length : later;
  return { rows: [...rows.slice(0, index), row, ...rows.slice(index)], index };
}

/**
 * Rows of which one and all later ones are asked for later.
 *
 * @param {KeyRow[]} rows
 * @param {number} index
 * @param {number} seconds
 * @returns {KeyRow[]}
 */
export function putOff(rows, index, seconds) {
  const by = Math.ceil(seconds / FRAME - 1e-6) * FRAME;
  return rows.map((row, i) => {
    const window = i >= index ? windowOf(row, i) : null;
    if (!window || i === 0) return row;
    const first = window[0] === window[1] || i > index ? window[0] + by : window[0];
    return { ...row, time: timeFrom(first, window[1] + by) };
  });
}

/**
 * A row without what is not set.
 *
 * @param {Record<string, any>} row
 * @returns {KeyRow}
 */
function clean(row) {
  const kept = Object.entries(row).filter(([name, value]) => value !== null && value !== undefined && value !== "" && !((name === "moved" || name === "parts") && !Object.keys(value).length));
  return /** @type {KeyRow} */ (Object.fromEntries(kept));
}
