// A duet live: the leader plays as a clip, and the follower is posed as its poses arrive.
import { loadClip, loadLiveBody } from "../../stage/body.js";

export const LEADER = "#8b94a3";
/** The colour of a leader, and of nobody else. */

/** The leader and the follower of a rehearsal. */
export class Rehearsal {
  /** @type {import("../../stage/body.js").LiveBody | null} */
  #body = null;
  #lag = 0;
  #number = 0;
  #running = false;

  /**
   * @param {import("../../studio.js").App} app
   * @param {(state: import("../../messages.js").Rehearsed | null) => void} told how it goes; null once it is over
   */
  constructor(app, told) {
    this.app = app;
    this.told = told;
    app.connection.on("live", (blob) => void this.#begin(blob));
    app.connection.on("pose", (values) => this.#move(values));
    app.connection.on("rehearsed", (message) => this.#state(message));
    app.connection.on("failed", (message) => message.section === "duet" && this.stop());
    app.connection.on("closed", () => this.stop());
  }

  get running() {
    return this.#running;
  }

  /** @param {number} lag seconds after which motion is decided */
  async start(lag) {
    this.stop();
    const number = (this.#number += 1);
    this.#running = true;
    try {
      const { header, payload } = await this.app.connection.ask({ kind: "show_leader" });
      const clip = await loadClip(payload);
      if (number !== this.#number) return clip.dispose();
      clip.setGhost(1, LEADER);
      this.app.transport.pause();
      this.app.preview(clip, header.floor ?? 0, []);
      this.app.transport.seek(0);
      this.app.connection.send({ kind: "rehearse", lag });
    } catch (error) {
      this.stop();
      this.app.say(/** @type {Error} */ (error).message, "error");
    }
  }

  stop() {
    if (!this.#running) return;
    this.#number += 1;
    this.#running = false;
    this.app.connection.send({ kind: "stop_run" });
    this.#body?.dispose();
    this.#body = null;
    this.app.endPreview();
    this.told(null);
  }

  /** @param {{header: any, payload: ArrayBuffer}} blob */
  async #begin({ header, payload }) {
    if (!this.#running || header.section !== "duet") return;
    const number = this.#number;
    const body = await loadLiveBody(payload);
    if (number !== this.#number) return void body.dispose();
    body.object.visible = false; // until its first pose
    this.#body = body;
    this.app.stage.add(body.object);
  }

  /** @param {Float32Array} values the time, the root's place, and rotations */
  #move(values) {
    if (!this.#running || !this.#body) return;
    this.#body.object.visible = true;
    this.#body.apply(values.subarray(1));
    this.app.transport.seek(values[0] + this.#lag);
  }

  /** @param {import("../../messages.js").Rehearsed} state */
  #state(state) {
    if (!this.#running) return;
    this.#lag = state.lag;
    this.told(state);
    if (!this.#body?.object.visible) this.app.transport.seek(state.second);
    if (state.running === false) this.stop();
  }
}
