// What the page knows: the project as it is edited, what was made of it, and what is being done.
import { Emitter } from "./dom.js";

/**
 * @typedef {import("./messages.js").Project} Project
 * @typedef {import("./messages.js").MadeHeader} MadeHeader
 * @typedef {import("./messages.js").Welcome} Welcome
 * @typedef {"idle" | "drawing" | "solving" | "ready" | "error"} PageState
 *
 * @typedef {object} StoreEvents
 * @property {Project} project whenever it changes, by this page or by another
 * @property {{header: MadeHeader, payload: ArrayBuffer} | null} made what is shown; null where there is nothing yet
 * @property {Welcome} welcome
 * @property {PageState} state
 */

/** @extends {Emitter<StoreEvents>} */
export class Store extends Emitter {
  #drawing = false;
  /** @type {PageState} */
  #work = "idle";
  #unacknowledged = false; // an edit of this page is on its way
  #stale = false; // what arrives was made of an edit before the last one

  /** @param {import("./connection.js").Connection} connection */
  constructor(connection) {
    super();
    this.connection = connection;
    /** @type {Project} */
    this.project = {};
    /** @type {Welcome | null} */
    this.welcome = null;
    /** @type {MadeHeader | null} */
    this.made = null;
    /** @type {string | null} */
    this.undo = null;
    /** @type {string | null} */
    this.redo = null;
    this.#listen();
  }

  /** Which section is shown. */
  get mode() {
    return this.project.mode ?? "walk";
  }

  /** What the page is doing; `body[data-state]` says it too. */
  get state() {
    return this.#drawing ? "drawing" : this.#work;
  }

  /** Whether a person is drawing. */
  set drawing(/** @type {boolean} */ drawing) {
    this.#drawing = drawing;
    this.#show();
  }

  /** What was made is on the stage. */
  shown() {
    if (!this.#stale) this.#become(this.made ? "ready" : "idle");
  }

  #listen() {
    const { connection } = this;
    connection.on("welcome", (message) => {
      this.welcome = message;
      this.emit("welcome", message);
    });
    connection.on("edited", (message) => {
      if (message.kind === "edit") this.project = { ...this.project, [message.part]: message.value };
      this.#unacknowledged = true;
      if (message.solve) this.#wait();
      this.emit("project", this.project);
    });
    connection.on("state", (message) => this.#state(message));
    connection.on("working", (message) => message.section && !this.#stale && this.#become("solving"));
    connection.on("made", (blob) => this.#made(blob));
    connection.on("nothing", () => this.#made(null));
    connection.on("failed", (message) => message.section && this.#settled("error"));
  }

  /** @param {import("./messages.js").State} message */
  #state(message) {
    this.undo = message.undo ?? null;
    this.redo = message.redo ?? null;
    if (this.#unacknowledged && (message.number ?? 0) < this.connection.edits) return; // older than this page's own
    this.#unacknowledged = false;
    this.#stale = false;
    this.project = message.project;
    this.emit("project", this.project);
  }

  /** @param {{header: MadeHeader, payload: ArrayBuffer} | null} blob */
  #made(blob) {
    if (this.#stale || (blob && blob.header.section !== this.mode)) return; // of an edit before the last one
    this.made = blob?.header ?? null;
    this.emit("made", blob);
  }

  #wait() {
    this.#stale = true;
    this.#become("solving");
  }

  /** @param {PageState} state */
  #settled(state) {
    if (!this.#stale) this.#become(state);
  }

  /** @param {PageState} state */
  #become(state) {
    this.#work = state;
    this.#show();
  }

  #show() {
    document.body.dataset.state = this.state;
    this.emit("state", this.state);
  }
}
