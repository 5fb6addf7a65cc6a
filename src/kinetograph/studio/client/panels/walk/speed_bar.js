// The speed of a path over time, and the speeds that a library has.
import { element, onTheme } from "../../dom.js";
import { faults, speeds, strange } from "./path.js";

/** @typedef {import("./path.js").Row} Row */
/** @typedef {import("../../messages.js").Pace} Pace */

const HEIGHT = 84;
const [LEFT, BOTTOM, TOP] = [26, 14, 4];

export class SpeedBar {
  /** @type {Row[]} */
  #path = [];
  /** @type {Pace | null} */
  #pace = null;
  #time = 0;

  constructor() {
    this.canvas = element("canvas", { class: "speed-bar", role: "img", height: HEIGHT });
    this.words = element("p", { class: "note", "aria-live": "polite" });
    this.element = element("div", { class: "speed" }, this.canvas, this.words);
    onTheme(() => this.#draw());
    new ResizeObserver(() => this.#draw()).observe(this.canvas);
  }

  /**
   * @param {Row[]} path
   * @param {Pace | null} pace
   */
  show(path, pace) {
    this.#path = path;
    this.#pace = pace;
    this.#say();
    this.#draw();
  }

  /** @param {number} time seconds of the path */
  seek(time) {
    this.#time = time;
    this.#draw();
  }

  #say() {
    const found = faults(this.#path, this.#pace);
    const pace = this.#pace;
    const range = pace ? `The library has ${pace.slowest.toFixed(2)} to ${pace.fastest.toFixed(2)} m/s.` : "";
    const first = found[0];
    const more = found.length > 1 ? `, and at ${found.length - 1} more` : "";
    const wrong = first && pace ? `Too ${first.fast ? "fast" : "slow"} at ${first.start.toFixed(1)} to ${first.stop.toFixed(1)} s${more}: ${first.speed.toFixed(2)} m/s. ` : "";
    this.words.textContent = wrong + range;
    this.words.classList.toggle("bad", Boolean(wrong));
    this.canvas.setAttribute("aria-label", `Speed of the path over time. ${wrong}${range}`);
  }

  #draw() {
    const width = this.canvas.clientWidth;
    if (!width) return;
    const scale = devicePixelRatio;
    this.canvas.width = width * scale;
    this.canvas.height = HEIGHT * scale;
    const context = this.canvas.getContext("2d");
    if (!context) return;
    context.scale(scale, scale);
    const style = getComputedStyle(this.canvas);
    const colour = (/** @type {string} */ name) => style.getPropertyValue(name).trim();
    const rows = speeds(this.#path, 0.1);
    const most = 1.15 * Math.max(1, this.#pace?.fastest ?? 0, ...rows.map((each) => each.speed));
    const lasts = Math.max(rows[rows.length - 1]?.time ?? 0, 1);
    const x = (/** @type {number} */ time) => LEFT + (time / lasts) * (width - LEFT - 4);
    const y = (/** @type {number} */ speed) => TOP + (1 - speed / most) * (HEIGHT - TOP - BOTTOM);
    this.#drawBands(context, colour, x(lasts), y);
    this.#drawScale(context, colour, lasts, most, x, y);
    context.lineWidth = 1.75;
    rows.forEach((each, i) => {
      if (!i) return;
      const before = rows[i - 1];
      const wrong = strange(each.speed, this.#pace);
      context.strokeStyle = colour(wrong ? "--bad" : "--accent");
      context.setLineDash(wrong ? [3, 2] : []);
      context.beginPath();
      context.moveTo(x(before.time), y(before.speed));
      context.lineTo(x(each.time), y(each.speed));
      context.stroke();
    });
    if (!rows.length) return;
    context.setLineDash([]);
    context.strokeStyle = colour("--playhead");
    context.beginPath();
    context.moveTo(x(Math.min(this.#time, lasts)), TOP);
    context.lineTo(x(Math.min(this.#time, lasts)), HEIGHT - BOTTOM);
    context.stroke();
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {(name: string) => string} colour
   * @param {number} right
   * @param {(speed: number) => number} y
   */
  #drawBands(context, colour, right, y) {
    const pace = this.#pace;
    if (!pace) return;
    const [low, , high] = pace.usual;
    for (const [slowest, fastest, alpha] of [[pace.slowest, pace.fastest, 0.12], [low, high, 0.16]]) {
      context.globalAlpha = alpha;
      context.fillStyle = colour("--good");
      context.fillRect(LEFT, y(fastest), right - LEFT, y(slowest) - y(fastest));
    }
    context.globalAlpha = 1;
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {(name: string) => string} colour
   * @param {number} lasts
   * @param {number} most
   * @param {(time: number) => number} x
   * @param {(speed: number) => number} y
   */
  #drawScale(context, colour, lasts, most, x, y) {
    context.fillStyle = colour("--quiet");
    context.strokeStyle = colour("--line");
    context.font = `10px ${getComputedStyle(this.canvas).fontFamily}`;
    context.lineWidth = 1;
    const step = most > 4 ? 2 : most > 1.6 ? 1 : 0.5;
    context.textAlign = "right";
    for (let speed = 0; speed < most; speed += step) {
      if (y(speed) > TOP + 14) context.fillText(String(speed), LEFT - 5, y(speed) + 3); // the unit is at the top
      context.beginPath();
      context.moveTo(LEFT, y(speed) + 0.5);
      context.lineTo(x(lasts), y(speed) + 0.5);
      context.stroke();
    }
    context.textAlign = "left";
    context.fillText("m/s", 0, TOP + 8);
    context.textAlign = "right";
    context.fillText(`${lasts.toFixed(1)} s`, x(lasts), HEIGHT - 2);
    context.textAlign = "left";
    context.fillText("0 s", LEFT, HEIGHT - 2);
  }
}
