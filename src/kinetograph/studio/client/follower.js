// The body that follows a path while it is drawn.
import { loadLiveBody } from "./body.js";

const OFTEN = 33; // milliseconds between messages

export class Follower {
  /** @type {import("./body.js").LiveBody | null} */
  #body = null;
  #running = false;
  #sent = 0;
  #timer = 0;
  /** @type {import("./path.js").Pen | import("./path.js").Timing | null} */
  #pen = null;

  /** @param {import("./studio.js").App} app */
  constructor(app) {
    this.app = app;
    app.connection.on("live", (blob) => void this.#begin(blob));
    app.connection.on("pose", (values) => this.#move(values));
  }

  /**
   * Follows from now on.
   *
   * @param {import("./path.js").Pen | import("./path.js").Timing} pen what is drawn with
   */
  start(pen) {
    this.clear();
    this.#running = true;
    this.#pen = pen;
    this.#sent = 0;
    this.app.connection.send({ kind: "walk_live" });
    this.#timer = window.setInterval(() => this.#send(), OFTEN);
  }

  /** No more is drawn; the body stays until {@link Follower.clear}. */
  stop() {
    if (!this.#running) return;
    this.#running = false;
    clearInterval(this.#timer);
    this.app.connection.send({ kind: "stop_run" });
  }

  /** Takes the body away. */
  clear() {
    this.stop();
    this.#body?.dispose();
    this.#body = null;
    this.app.stage.render();
  }

  #send() {
    if (!this.#pen) return;
    const { rows } = this.#pen;
    const points = rows.length > this.#sent ? rows.slice(this.#sent) : this.#pen.now;
    if (points.length) this.app.connection.send({ kind: "walk_drawn", points });
    this.#sent = rows.length;
  }

  /** @param {{header: any, payload: ArrayBuffer}} blob */
  async #begin({ header, payload }) {
    if (!this.#running || header.section !== "walk") return;
    const body = await loadLiveBody(payload);
    if (!this.#running) return void body.dispose();
    body.object.visible = false; // until its first pose
    this.#body = body;
    this.app.stage.add(body.object);
  }

  /** @param {Float32Array} values the time, the root's place, and rotations */
  #move(values) {
    if (!this.#running || !this.#body) return;
    this.#body.object.visible = true;
    this.#body.apply(values.subarray(1));
    if (this.app.clip) this.app.clip.object.visible = false;
    this.app.stage.render();
  }
}
