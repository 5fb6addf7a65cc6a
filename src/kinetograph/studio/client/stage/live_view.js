// A body that poses drive as they come: the newest is drawn, those before it are dropped.
import { loadLiveBody } from "./body.js";

const RECOLOUR = 100; // milliseconds between two colourings

/**
 * @typedef {{pose: number, drawn: number}} Drawn seconds of a pose in its run, and milliseconds of the clock when it was drawn
 */

export class LiveView {
  /** @type {import("./body.js").LiveBody | null} */
  body = null;
  /** @type {Float32Array | null} */
  #newest = null;
  #recoloured = 0;
  /** How many poses came, and how many of them were drawn. */
  came = 0;
  /** @type {Drawn[]} the last poses that were drawn */
  drawn = [];

  /**
   * @param {import("../studio.js").App} app
   * @param {(deviations: Float32Array, joints: string[]) => Float32Array | null} colours from the joints' standard deviations
   */
  constructor(app, colours) {
    this.app = app;
    this.colours = colours;
    app.stage.onFrame(() => this.#draw());
  }

  /**
   * Shows a body in place of what was made.
   *
   * @param {{header: any, payload: ArrayBuffer}} blob
   */
  async show({ header, payload }) {
    this.clear();
    const body = await loadLiveBody(payload);
    this.body = body;
    this.came = 0;
    this.drawn = [];
    this.app.stage.floor = header.floor ?? 0;
    this.app.stage.add(body.object);
    this.hideClip();
  }

  /** While a body is live, what was made is not shown. */
  hideClip() {
    if (this.body && this.app.clip) this.app.clip.object.visible = false;
  }

  /** @param {Float32Array} values the time, the root's place, rotations, and deviations */
  move(values) {
    if (!this.body) return;
    this.came += 1;
    this.#newest = values;
    this.app.stage.render();
  }

  /** Takes the body away, and shows what was made again. */
  clear() {
    this.#newest = null;
    if (!this.body) return;
    this.body.dispose();
    this.body = null;
    if (this.app.clip) this.app.clip.object.visible = true;
    this.app.stage.floor = this.app.store.made?.floor ?? 0;
  }

  /** @param {number} pose */
  #note(pose) {
    this.drawn.push({ pose, drawn: performance.timeOrigin + performance.now() });
    if (this.drawn.length > 3000) this.drawn.shift();
  }

  #draw() {
    const { body } = this;
    const values = this.#newest;
    if (!body || !values) return;
    this.#newest = null;
    body.apply(values.subarray(1));
    const deviations = values.subarray(4 + 4 * body.joints.length);
    const now = performance.now();
    if (deviations.length && now - this.#recoloured > RECOLOUR) {
      this.#recoloured = now;
      body.setJointColours(this.colours(deviations, body.joints));
    }
    queueMicrotask(() => this.#note(values[0])); // once the frame has been drawn
  }
}
