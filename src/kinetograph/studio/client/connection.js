// The socket: messages, questions and their answers, binary frames, and coming back after the server was gone.
import { Emitter } from "./dom.js";

/**
 * @typedef {import("./messages.js").AnyMessage} AnyMessage
 * @typedef {{header: any, payload: ArrayBuffer}} Blob a binary frame with a header
 * @typedef {Record<string, any>} Events by the kind of a message or header; `pose` has a Float32Array; `open` and `closed`
 */

const BLOB = 1;
const POSE = 2;
const AGAIN = 700; // milliseconds before the next try to connect
const LONGEST = 5000;

/** Bytes of a file that the server takes. */
export const LARGEST = 60 * 2 ** 20;

/** @extends {Emitter<Events>} */
export class Connection extends Emitter {
  /** @type {WebSocket | null} */
  #socket = null;
  #number = 0;
  #wait = AGAIN;
  /** @type {Map<number, {resolve: (value: any) => void, reject: (reason: Error) => void}>} */
  #asked = new Map();
  /** @type {Map<string, any>} the latest edit of each part that could not be sent */
  #unsent = new Map();

  /** The number of the last edit that was sent; `State` has it again once it is made. */
  edits = 0;

  /** Connects, and again whenever the server is back. */
  open() {
    const socket = new WebSocket(`ws://${location.host}/socket${location.search}`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => this.#opened(socket);
    socket.onmessage = (event) => (typeof event.data === "string" ? this.#message(JSON.parse(event.data)) : this.#binary(event.data));
    socket.onclose = (event) => void this.#closed(event);
  }

  get connected() {
    return this.#socket !== null;
  }

  /** Lets the connection go; it comes back by itself. */
  drop() {
    this.#socket?.close();
    this.#socket = null;
  }

  /**
   * Sends a message; without a connection it is dropped.
   *
   * @param {any} message
   */
  send(message) {
    this.#socket?.send(JSON.stringify(message));
  }

  /**
   * Changes a part of the project. Without a connection it is kept, and sent when there is one.
   *
   * @param {string} part
   * @param {any} value the whole part
   * @param {{label?: string, merge?: boolean, solve?: boolean}} [how]
   */
  edit(part, value, { label = "edit", merge = false, solve = true } = {}) {
    this.edits += 1;
    const message = { kind: "edit", part, value, label, merge, solve, number: this.edits };
    if (this.connected) this.send(message);
    else this.#unsent.set(part, message);
    this.emit("edited", message);
  }

  /**
   * Takes the last edit back, or makes it again.
   *
   * @param {"undo" | "redo"} kind
   */
  step(kind) {
    if (!this.connected) return;
    this.edits += 1;
    this.send({ kind, number: this.edits });
    this.emit("edited", { kind, solve: true });
  }

  /**
   * Asks a question.
   *
   * @param {any} message without its `id`
   * @returns {Promise<any>} the message that answers it, or `{header, payload}`; rejected with the reason in words
   */
  ask(message) {
    return this.#question((id) => this.send({ ...message, id }));
  }

  /**
   * Sends a file.
   *
   * @param {File} file
   * @param {string} role what it is to be: `character`, `leader`, `readings`, `layout` or `recording`
   * @returns {Promise<{name: string, files: string[]}>}
   */
  async upload(file, role) {
    if (file.size > LARGEST)
      throw new Error(`${file.name}: ${Math.round(file.size / 2 ** 20)} MB are too many; ${LARGEST / 2 ** 20} MB at most`);
    const payload = new Uint8Array(await file.arrayBuffer());
    return this.#question((id) => this.#socket?.send(packed({ kind: "file", id, name: file.name, role }, payload)));
  }

  /**
   * @param {(id: number) => void} send
   * @returns {Promise<any>}
   */
  #question(send) {
    if (!this.connected) return Promise.reject(new Error("the studio's server is not running"));
    const id = (this.#number += 1);
    return new Promise((resolve, reject) => {
      this.#asked.set(id, { resolve, reject });
      send(id);
    });
  }

  /** @param {WebSocket} socket */
  #opened(socket) {
    this.#socket = socket;
    this.#wait = AGAIN;
    this.emit("open", null);
    for (const message of this.#unsent.values()) this.send(message);
    this.#unsent.clear();
  }

  /** @param {CloseEvent} event */
  async #closed(event) {
    this.#socket = null;
    for (const { reject } of this.#asked.values()) reject(new Error(event.reason || "the studio's server is gone"));
    this.#asked.clear();
    this.emit("closed", event.reason || (await reason()));
    setTimeout(() => this.open(), this.#wait);
    this.#wait = Math.min(1.5 * this.#wait, LONGEST);
  }

  /** @param {any} message */
  #message(message) {
    if (!this.#answered(message.id, message)) this.emit(message.kind, message);
  }

  /** @param {ArrayBuffer} frame */
  #binary(frame) {
    const view = new DataView(frame);
    const kind = view.getUint32(0, true);
    if (kind === POSE) this.emit("pose", new Float32Array(frame, 4));
    if (kind !== BLOB) return;
    const length = view.getUint32(4, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(frame, 8, length)));
    const blob = { header, payload: frame.slice(8 + length) };
    if (!this.#answered(header.id, blob)) this.emit(header.kind, blob);
  }

  /**
   * Whether something answers a question of this page.
   *
   * @param {number | null | undefined} id
   * @param {any} answer
   */
  #answered(id, answer) {
    const asked = this.#asked.get(id ?? 0);
    if (!asked) return false;
    this.#asked.delete(id ?? 0);
    if (answer.kind === "failed") asked.reject(new Error(answer.message));
    else asked.resolve(answer);
    return true;
  }
}

/**
 * A binary frame with a header.
 *
 * @param {any} header
 * @param {Uint8Array} payload
 * @returns {Uint8Array<ArrayBuffer>}
 */
function packed(header, payload) {
  const text = new TextEncoder().encode(JSON.stringify(header));
  const padding = -text.length & 3;
  const frame = new Uint8Array(8 + text.length + padding + payload.length).fill(32);
  const view = new DataView(frame.buffer);
  view.setUint32(0, BLOB, true);
  view.setUint32(4, text.length + padding, true);
  frame.set(text, 8);
  frame.set(payload, 8 + text.length + padding);
  return frame;
}

/** Why there is no connection. */
async function reason() {
  try {
    const answer = await fetch(location.href);
    return answer.ok ? "the connection was lost" : "the studio was started again: open the address that it printed";
  } catch {
    return "the studio's server is not running";
  }
}
