// A drawn path: rows of seconds and metres x and z, in order of time, and what a person does to it.

/** @typedef {[number, number, number]} Row seconds, metres x and z */
/** @typedef {{start: number, stop: number, speed: number, fast: boolean}} Fault where a path is faster or slower than people */

const PACE = 0.5; // seconds over which speeds are taken, as the method compares them
const APART = 0.01; // least seconds between two rows
const HELD = 0.15; // seconds without a move after which the pen was held still
const NEAR = 1.5; // metres of path ahead in which a pointer that draws the timing is looked for

/** Rows as they are drawn, by a pointer's own times. */
export class Pen {
  /** @type {Row[]} */
  rows = [];
  #begun = 0;
  #late = 0;

  /**
   * @param {number} milliseconds
   * @param {{x: number, z: number}} point
   */
  move(milliseconds, { x, z }) {
    this.#late = performance.now() - milliseconds;
    if (!this.rows.length) this.#begun = milliseconds;
    const time = (milliseconds - this.#begun) / 1000;
    const last = this.rows[this.rows.length - 1];
    if (last && time - last[0] < APART) return;
    if (last && time - last[0] > HELD) this.rows.push(row(time - APART / 2, last[1], last[2]));
    this.rows.push(row(time, x, z));
  }

  /**
   * The row of a pen that has been where it is for a while.
   *
   * @param {number} milliseconds
   * @returns {Row[]} one or none
   */
  held(milliseconds) {
    const last = this.rows[this.rows.length - 1];
    const time = (milliseconds - this.#begun) / 1000;
    return last && time - last[0] > HELD ? [row(time, last[1], last[2])] : [];
  }

  /**
   * The row of a pen that is held now; the time by which events are handled late does not count.
   *
   * @returns {Row[]} one or none
   */
  get now() {
    return this.held(performance.now() - this.#late);
  }

  /** @param {number} milliseconds */
  end(milliseconds) {
    this.rows.push(...this.held(milliseconds));
  }
}

/**
 * @param {number} time
 * @param {number} x
 * @param {number} z
 * @returns {Row}
 */
function row(time, x, z) {
  const rounded = (/** @type {number} */ value) => Math.round(1e4 * value) / 1e4;
  return [rounded(time), rounded(x), rounded(z)];
}

/**
 * Metres along a path at each of its rows.
 *
 * @param {Row[]} path
 * @returns {number[]}
 */
export function lengths(path) {
  let length = 0;
  return path.map(([, x, z], i) => (length += i ? Math.hypot(x - path[i - 1][1], z - path[i - 1][2]) : 0));
}

/**
 * Where a path is at a time; held beyond its ends.
 *
 * @param {Row[]} path
 * @param {number} time
 * @returns {[number, number]} metres x and z
 */
export function at(path, time) {
  return /** @type {[number, number]} */ (between(path.map((each) => each[0]), path, time).slice(1));
}

/**
 * The row between others, by a number that grows along them.
 *
 * @param {number[]} along
 * @param {Row[]} path
 * @param {number} wanted
 * @returns {Row}
 */
function between(along, path, wanted) {
  const after = along.findIndex((each) => each >= wanted);
  if (after < 0) return path[path.length - 1];
  if (after === 0) return path[0];
  const share = (wanted - along[after - 1]) / Math.max(along[after] - along[after - 1], 1e-12);
  const [a, b] = [path[after - 1], path[after]];
  return [a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])];
}

/**
 * Rows at even times, from the first to the last.
 *
 * @param {Row[]} path
 * @param {number} step seconds
 * @returns {Row[]}
 */
export function evenly(path, step) {
  /** @type {Row[]} */
  const rows = [];
  let i = 0;
  for (let time = path[0][0]; time <= path[path.length - 1][0] + 1e-9; time += step) {
    while (i < path.length - 2 && path[i + 1][0] < time) i++;
    const [a, b] = [path[i], path[i + 1] ?? path[i]];
    const share = Math.min(Math.max((time - a[0]) / Math.max(b[0] - a[0], 1e-12), 0), 1);
    rows.push([time, a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])]);
  }
  return rows;
}

/**
 * Speeds at even times, over half a second each.
 *
 * @param {Row[]} path
 * @param {number} step seconds
 * @returns {{time: number, speed: number, x: number, z: number}[]}
 */
export function speeds(path, step) {
  if (path.length < 2) return [];
  const fine = evenly(path, 1 / 30);
  const length = lengths(fine);
  const reach = Math.round((PACE / 2) * 30);
  const every = Math.max(Math.round(step * 30), 1);
  return fine.flatMap(([time, x, z], i) => {
    if (i % every) return [];
    const [low, high] = [Math.max(i - reach, 0), Math.min(i + reach, fine.length - 1)];
    return [{ time, x, z, speed: (length[high] - length[low]) / Math.max(fine[high][0] - fine[low][0], 1e-9) }];
  });
}

/**
 * Whether people of a library walk at a speed.
 *
 * @param {number} speed metres a second
 * @param {{slowest: number, fastest: number, stands: boolean} | null} pace
 * @returns {"" | "fast" | "slow"}
 */
export function strange(speed, pace) {
  if (!pace) return "";
  if (speed > 1.02 * pace.fastest) return "fast";
  const still = pace.stands && speed < 0.05;
  return speed < 0.95 * pace.slowest && !still ? "slow" : "";
}

/**
 * The spans in which a path is faster or slower than people of the library.
 *
 * @param {Row[]} path
 * @param {{slowest: number, fastest: number, stands: boolean} | null} pace
 * @returns {Fault[]}
 */
export function faults(path, pace) {
  /** @type {Fault[]} */
  const found = [];
  let before = "";
  for (const { time, speed } of speeds(path, 0.1)) {
    const now = strange(speed, pace);
    const last = found[found.length - 1];
    if (now && now === before) {
      last.stop = time;
      last.speed = now === "fast" ? Math.max(last.speed, speed) : Math.min(last.speed, speed);
    } else if (now) found.push({ start: time, stop: time + 0.1, speed, fast: now === "fast" });
    before = now;
  }
  return found;
}

/**
 * The place of a path that is nearest to a point.
 *
 * @param {Row[]} path
 * @param {{x: number, z: number}} point
 * @param {[number, number]} [within] metres along the path
 * @returns {{along: number, time: number, x: number, z: number, distance: number} | null}
 */
export function nearest(path, point, within = [0, Infinity]) {
  const length = lengths(path);
  let best = null;
  for (let i = 1; i < path.length; i++) {
    if (length[i] < within[0] || length[i - 1] > within[1]) continue;
    const [a, b] = [path[i - 1], path[i]];
    const [dx, dz, step] = [b[1] - a[1], b[2] - a[2], length[i] - length[i - 1]];
    let share = step > 0 ? ((point.x - a[1]) * dx + (point.z - a[2]) * dz) / (step * step) : 0;
    const [least, most] = step > 0 ? within.map((limit) => (limit - length[i - 1]) / step) : [0, 1];
    share = Math.min(Math.max(share, least, 0), most, 1);
    const [x, z] = [a[1] + share * dx, a[2] + share * dz];
    const distance = Math.hypot(point.x - x, point.z - z);
    if (!best || distance < best.distance - 1e-12) best = { along: length[i - 1] + share * step, time: a[0] + share * (b[0] - a[0]), x, z, distance };
  }
  return best;
}

/**
 * A path of which a part was moved: all of the shift at a place, less of it further along, none beyond the reach.
 *
 * @param {Row[]} path
 * @param {number} along metres along the path
 * @param {{x: number, z: number}} shift metres
 * @param {number} reach metres along the path
 * @returns {Row[]}
 */
export function dragged(path, along, shift, reach) {
  const length = lengths(path);
  return path.map(([time, x, z], i) => {
    const off = Math.abs(length[i] - along) / reach;
    const share = off < 1 ? Math.cos((Math.PI / 2) * off) ** 2 : 0;
    return row(time, x + share * shift.x, z + share * shift.z);
  });
}

/**
 * A path that stops at a time, and goes on later.
 *
 * @param {Row[]} path
 * @param {number} time seconds
 * @param {number} seconds how long it stops
 * @returns {Row[]}
 */
export function waiting(path, time, seconds) {
  const [x, z] = at(path, time);
  const before = path.filter((each) => each[0] < time - 1e-3);
  const after = path.filter((each) => each[0] > time + 1e-3);
  const stop = [row(time, x, z), row(time + seconds, x, z)];
  return [...before, ...stop, ...after.map(([t, ...place]) => row(t + seconds, ...place))];
}

/**
 * A path whose part between two times is walked at a speed; what comes after is as fast as before.
 *
 * @param {Row[]} path
 * @param {number} start seconds
 * @param {number} stop seconds
 * @param {number} speed metres a second
 * @returns {Row[]}
 */
export function paced(path, start, stop, speed) {
  const inside = [row(start, ...at(path, start)), ...path.filter((each) => each[0] > start && each[0] < stop), row(stop, ...at(path, stop))];
  const length = lengths(inside);
  const lasts = length[length.length - 1] / speed;
  const rows = inside.map(([, x, z], i) => row(start + length[i] / speed, x, z));
  const later = path.filter((each) => each[0] > stop).map(([t, ...place]) => row(t - stop + start + lasts, ...place));
  return increasing([...path.filter((each) => each[0] < start), ...rows, ...later]);
}

/**
 * Rows of which none is at the time of the one before.
 *
 * @param {Row[]} rows
 */
function increasing(rows) {
  /** @type {Row[]} */
  const kept = [];
  for (const each of rows) if (!kept.length || each[0] > kept[kept.length - 1][0] + 1e-3) kept.push(each);
  return kept;
}

/** The timing of a path, drawn again: a pointer goes along it at the pace that is wanted. */
export class Timing {
  /** @type {Row[]} the part that was drawn, at its new times from 0 */
  rows = [];
  #begun = 0;
  #late = 0;
  #first = 0;
  #along = 0;

  /** @param {Row[]} path */
  constructor(path) {
    this.path = path;
    this.lengths = lengths(path);
  }

  /**
   * @param {number} milliseconds
   * @param {{x: number, z: number}} point
   */
  move(milliseconds, point) {
    this.#late = performance.now() - milliseconds;
    const last = this.rows[this.rows.length - 1];
    const found = nearest(this.path, point, last ? [this.#along, this.#along + NEAR] : undefined);
    if (!found) return;
    if (!last) [this.#begun, this.#first, this.#along] = [milliseconds, found.along, found.along];
    const time = (milliseconds - this.#begun) / 1000;
    if (last && time - last[0] < APART) return;
    if (last && time - last[0] > HELD) this.rows.push(row(time - APART / 2, last[1], last[2]));
    if (last) this.#passCorners(time, found.along);
    this.#along = Math.max(found.along, this.#along);
    this.rows.push(row(time, found.x, found.z));
  }

  /**
   * The row of a pointer that has been where it is for a while.
   *
   * @param {number} milliseconds
   * @returns {Row[]} one or none
   */
  held(milliseconds) {
    const last = this.rows[this.rows.length - 1];
    const time = (milliseconds - this.#begun) / 1000;
    return last && time - last[0] > HELD ? [row(time, last[1], last[2])] : [];
  }

  /**
   * The row of a pen that is held now; the time by which events are handled late does not count.
   *
   * @returns {Row[]} one or none
   */
  get now() {
    return this.held(performance.now() - this.#late);
  }

  /** @param {number} milliseconds */
  end(milliseconds) {
    this.rows.push(...this.held(milliseconds));
  }

  /**
   * The whole path: what was before and after the part that was drawn is as fast as it was.
   *
   * @returns {Row[]}
   */
  get whole() {
    const last = this.rows[this.rows.length - 1];
    if (!last || this.#along - this.#first < 0.05) return this.path;
    const [start, stop] = [this.#first, this.#along].map((along) => between(this.lengths, this.path, along)[0]);
    const drawn = this.rows.map(([t, x, z]) => row(t + start, x, z));
    const later = this.path.filter((each) => each[0] > stop + 1e-3).map(([t, x, z]) => row(t - stop + start + last[0], x, z));
    return increasing([...this.path.filter((each) => each[0] < start), ...drawn, ...later]);
  }

  /**
   * Rows of the path's own corners between the last row and a place.
   *
   * @param {number} time
   * @param {number} along
   */
  #passCorners(time, along) {
    const before = this.rows[this.rows.length - 1];
    const way = along - this.#along;
    const from = this.lengths.findIndex((each) => each > this.#along + 1e-3);
    for (let k = from; k >= 0 && k < this.path.length && this.lengths[k] < along - 1e-3; k++) {
      const share = (this.lengths[k] - this.#along) / way;
      this.rows.push(row(before[0] + share * (time - before[0]), this.path[k][1], this.path[k][2]));
    }
  }
}
