// Moving thumbnails of takes: bones on small canvases, drawn from whole millimetres that the server sends.

/** @typedef {import("../../messages.js").ThumbnailRow} ThumbnailRow */

const TALL = 2000; // millimetres that a canvas shows at least
const SIDES = ["--quiet", "--left", "--right"];

/** Keeps thumbnails, asks for those that are missing, and moves those that are looked at. */
export class Thumbnails {
  /** @type {Map<string, {row: ThumbnailRow, ends: Int16Array, box: [number, number, number, number]}>} */
  #known = new Map();
  /** @type {Set<string>} */
  #wanted = new Set();
  /** @type {Map<HTMLCanvasElement, {take: string, began: number}>} */
  #moving = new Map();
  #frame = 0;
  #asking = 0;

  /** @param {(takes: string[]) => Promise<{header: import("../../messages.js").ThumbnailsHeader, payload: ArrayBuffer}>} ask */
  constructor(ask) {
    this.ask = ask;
    /** Called when thumbnails have come. */
    this.came = () => {};
  }

  /** Forgets what another library had. */
  clear() {
    this.#known.clear();
    this.#wanted.clear();
    this.#moving.clear();
  }

  /**
   * Draws the still of a take, or asks for it.
   *
   * @param {HTMLCanvasElement} canvas
   * @param {string} take
   */
  show(canvas, take) {
    const known = this.#known.get(take);
    if (known) draw(canvas, known, (known.row.frames - 1) / 3);
    else {
      this.#wanted.add(take);
      if (!this.#asking) this.#asking = setTimeout(() => void this.#ask(), 30); // those of a page go together
    }
  }

  /**
   * Moves a thumbnail, or holds it still.
   *
   * @param {HTMLCanvasElement} canvas
   * @param {string} take
   * @param {boolean} moving
   */
  move(canvas, take, moving) {
    if (moving && !matchMedia("(prefers-reduced-motion: reduce)").matches) {
      if (!this.#moving.has(canvas)) this.#moving.set(canvas, { take, began: performance.now() });
      if (!this.#frame) this.#frame = requestAnimationFrame((now) => this.#step(now));
    } else if (this.#moving.delete(canvas)) this.show(canvas, take);
  }

  /** @param {number} now */
  #step(now) {
    for (const [canvas, { take, began }] of this.#moving) {
      const known = this.#known.get(take);
      if (!canvas.isConnected) this.#moving.delete(canvas);
      else if (known) draw(canvas, known, frameAt(known.row, (now - began) / 1000));
    }
    this.#frame = this.#moving.size ? requestAnimationFrame((next) => this.#step(next)) : 0;
  }

  async #ask() {
    const takes = [...this.#wanted].slice(0, 60);
    for (const take of takes) this.#wanted.delete(take);
    try {
      const { header, payload } = await this.ask(takes);
      let start = 0;
      for (const row of header.rows) {
        const count = 4 * row.frames * row.bones;
        const ends = new Int16Array(payload, 2 * start, count);
        this.#known.set(row.take, { row, ends, box: boxOf(ends) });
        start += count;
      }
      this.came();
    } catch {
      // the connection is gone: the cards stay empty until they are drawn again
    }
    this.#asking = this.#wanted.size ? setTimeout(() => void this.#ask(), 0) : 0;
  }
}

/**
 * @param {ThumbnailRow} row
 * @param {number} seconds
 */
function frameAt(row, seconds) {
  if (!row.seconds) return 0;
  return ((seconds % row.seconds) / row.seconds) * (row.frames - 1);
}

/**
 * @param {Int16Array} ends
 * @returns {[number, number, number, number]} left, right, bottom and top in millimetres
 */
function boxOf(ends) {
  let [left, right, bottom, top] = [0, 0, 0, 0];
  for (let i = 0; i < ends.length; i += 2) {
    left = Math.min(left, ends[i]);
    right = Math.max(right, ends[i]);
    bottom = Math.min(bottom, ends[i + 1]);
    top = Math.max(top, ends[i + 1]);
  }
  return [left, right, bottom, top];
}

/**
 * @param {HTMLCanvasElement} canvas
 * @param {{row: ThumbnailRow, ends: Int16Array, box: [number, number, number, number]}} thumbnail
 * @param {number} frame may lie between two
 */
function draw(canvas, { row, ends, box }, frame) {
  const context = canvas.getContext("2d", { willReadFrequently: true }); // small drawings do not need the graphics card
  if (!context) return;
  const ratio = devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth || 120, canvas.clientHeight || 96];
  if (canvas.width !== Math.round(width * ratio)) [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
  const [left, right, bottom, top] = box;
  const scale = Math.min((width - 8) / (right - left + 200), (height - 10) / Math.max(top - bottom + 120, TALL * 0.8));
  const style = getComputedStyle(canvas);
  const colours = SIDES.map((name) => style.getPropertyValue(name).trim());
  const first = Math.min(Math.floor(frame), row.frames - 1);
  const [a, b] = [4 * row.bones * first, 4 * row.bones * Math.min(first + 1, row.frames - 1)];
  const share = frame - first;
  const at = (/** @type {number} */ i) => ends[a + i] + share * (ends[b + i] - ends[a + i]);
  const x = (/** @type {number} */ i) => width / 2 + scale * (at(i) - (left + right) / 2);
  const y = (/** @type {number} */ i) => height - 6 - scale * (at(i) - bottom);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.lineCap = "round";
  context.strokeStyle = style.getPropertyValue("--line").trim();
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(8, height - 5);
  context.lineTo(width - 8, height - 5);
  context.stroke();
  for (const side of [2, 0, 1]) {
    context.strokeStyle = colours[side];
    for (let bone = 0; bone < row.bones; bone++) {
      if (row.sides[bone] !== side) continue;
      context.lineWidth = Math.max(scale * row.widths[bone] * 0.8, 1.5);
      context.beginPath();
      context.moveTo(x(4 * bone), y(4 * bone + 1));
      context.lineTo(x(4 * bone + 2), y(4 * bone + 3));
      context.stroke();
    }
  }
}
