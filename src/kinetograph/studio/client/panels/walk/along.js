// What a walk meets along its path: poses, and moves that are asked for or ruled out.
import { button, element, field, iconButton } from "../../dom.js";

/**
 * @typedef {import("../../messages.js").RequestOnPathRow} KeyRow
 * @typedef {import("../../messages.js").RequestMoveRow} MoveRow
 * @typedef {import("../../messages.js").Walk} Walk
 */

const MOST = 500; // takes that are offered

/** What a person sees of keys and moves on a path and does to them. */
export class Along {
  #offered = "";

  /**
   * @param {import("../../studio.js").App} app
   * @param {(change: Partial<Walk>, label: string) => void} edit
   * @param {() => {second: number, place: [number, number]}} where the second of the path and the place on it that are shown
   * @param {(place: [number, number]) => number} passed the second at which the path passes a place
   */
  constructor(app, edit, where, passed) {
    this.app = app;
    this.edit = edit;
    this.where = where;
    this.passed = passed;
    const number = (/** @type {number} */ value) => element("input", { type: "number", value, step: 0.1, min: 0 });
    this.take = element("select", {});
    this.second = number(0);
    this.hereButton = button("Add pose here", () => this.#addKey(({ place }) => ({ near: place })), { title: "At this place of the path, which waits while a recording that has the pose plays" });
    this.keyButton = button("Add pose now", () => this.#addKey(({ second }) => ({ time: rounded(second) })), { title: "At this time, whatever plays then" });
    this.keys = element("ul", { class: "list layers", "aria-label": "Poses on the path" });
    this.fill = element("input", { type: "checkbox", onchange: () => this.edit({ fill: this.fill.checked || null }, "play the recordings of poses") });
    this.move = element("input", { type: "text", placeholder: "run, turn left, ..." });
    this.from = number(0);
    this.to = number(2);
    this.moves = element("ul", { class: "list layers", "aria-label": "Moves on the path" });
    this.element = element(
      "section",
      { "aria-label": "Along the path" },
      element("h2", {}, "Along the path"),
      element("p", { class: "note" }, "Poses that the walk meets to a millimetre, and moves by their names, tags or labels."),
      field("Pose of", this.take),
      field("at its second", this.second),
      element("div", { class: "buttons" }, this.hereButton, this.keyButton),
      this.keys,
      element("label", { class: "check", title: "For poses at times too: the walk leaves the path for some seconds around one that no piece is like" }, this.fill, "Play the recordings of poses"),
      field("Move", this.move),
      field("Begins at, s", this.from),
      field("Ends at, s", this.to),
      element("div", { class: "buttons" }, button("Ask for it", () => this.#addMove(false)), button("Rule it out", () => this.#addMove(true))),
      this.moves,
    );
  }

  /** @returns {Walk} */
  get walk() {
    return this.app.store.project.walk ?? {};
  }

  /** Shows what is asked for. */
  show() {
    void this.#offer();
    const { keys = [], moves = [] } = this.walk;
    this.fill.checked = this.walk.fill ?? false;
    const inside = document.activeElement;
    if (!this.keys.contains(inside) || inside?.tagName !== "INPUT" || this.keys.childElementCount !== keys.length) this.keys.replaceChildren(...keys.map((row, i) => this.#key(row, i)));
    this.moves.replaceChildren(...moves.map((row, i) => this.#moveRow(row, i)));
  }

  /** Offers the takes of the walk's library. */
  async #offer() {
    const { welcome } = this.app.store;
    const library = this.walk.library || welcome?.libraries[0]?.name;
    const key = JSON.stringify([welcome?.libraries, library]);
    if (!library || key === this.#offered) return;
    this.#offered = key;
    const before = this.take.value;
    try {
      const { rows } = await this.app.connection.ask({ kind: "ask_takes", library, count: MOST });
      this.take.replaceChildren(...rows.map((/** @type {{name: string}} */ row) => element("option", { value: row.name }, row.name)));
    } catch (error) {
      this.#offered = "";
      return this.app.say(/** @type {Error} */ (error).message, "error");
    }
    if ([...this.take.options].some(({ value }) => value === before)) this.take.value = before;
    this.keyButton.disabled = this.hereButton.disabled = this.take.options.length === 0;
  }

  /** @param {(where: {second: number, place: [number, number]}) => Partial<KeyRow>} when */
  #addKey(when) {
    const second = this.second.valueAsNumber;
    if (!this.take.value || !(second >= 0)) return this.app.say("a pose has a take and a second of it", "error");
    const row = { pose: `take:${this.take.value}@${second}`, ...when(this.where()) };
    this.#setKeys([...(this.walk.keys ?? []), row], "meet a pose");
  }

  /**
   * @param {KeyRow[]} keys
   * @param {string} label
   */
  #setKeys(keys, label) {
    const when = (/** @type {KeyRow} */ row) => (row.near ? this.passed(row.near) : Array.isArray(row.time) ? row.time[0] : row.time);
    const timed = keys.every((row) => typeof when(row) === "number");
    this.edit({ keys: timed ? [...keys].sort((a, b) => Number(when(a)) - Number(when(b))) : keys }, label);
  }

  /**
   * @param {KeyRow} row
   * @param {number} index
   */
  #key(row, index) {
    const name = row.name ?? row.pose.replace(/^take:/, "");
    const keys = this.walk.keys ?? [];
    const where = typeof row.time === "number" ? this.#time(row, index, name) : element("span", { class: "note" }, place(row));
    const remove = iconButton("close", `Remove: ${name}`, () => this.edit({ keys: keys.filter((_, i) => i !== index) }, "take a pose away"), { class: "quiet" });
    return element("li", { class: "layer-row" }, element("div", { class: "row" }, element("strong", {}, name), remove), where);
  }

  /**
   * @param {KeyRow} row
   * @param {number} index
   * @param {string} name
   */
  #time(row, index, name) {
    const input = element("input", { type: "number", min: 0, step: 0.1, value: Number(row.time), "aria-label": `${name}: met at, seconds` });
    input.addEventListener("change", () => {
      if (!(input.valueAsNumber >= 0)) return;
      this.#setKeys((this.walk.keys ?? []).map((each, i) => (i === index ? { ...each, time: rounded(input.valueAsNumber) } : each)), "move a pose");
    });
    return field("met at, s", input);
  }

  /** @param {boolean} forbid */
  #addMove(forbid) {
    const [name, start, stop] = [this.move.value.trim(), this.from.valueAsNumber, this.to.valueAsNumber];
    if (!name || !(start >= 0 && start < stop)) return this.app.say("a move has a name, and runs from a second to a later one", "error");
    const row = { name, start: rounded(start), stop: rounded(stop), ...(forbid ? { forbid } : {}) };
    this.edit({ moves: [...(this.walk.moves ?? []), row] }, forbid ? "rule a move out" : "ask for a move");
  }

  /**
   * @param {MoveRow} row
   * @param {number} index
   */
  #moveRow(row, index) {
    const feet = [row.first && `${row.first} foot first`, row.last && `${row.last} foot last`].filter(Boolean).join(", ");
    const name = `${row.forbid ? "no " : ""}${row.name || "any move"}${feet ? `, ${feet}` : ""}, ${row.start} to ${row.stop} s`;
    const moves = this.walk.moves ?? [];
    const remove = iconButton("close", `Remove: ${name}`, () => this.edit({ moves: moves.filter((_, i) => i !== index) }, "take a move away"), { class: "quiet" });
    return element("li", { class: "layer-row" }, element("div", { class: "row" }, element("strong", {}, name), remove));
  }
}

/** @param {number} seconds */
function rounded(seconds) {
  return Math.round(seconds * 1e4) / 1e4;
}

/** @param {KeyRow} row */
function place(row) {
  if (Array.isArray(row.time)) return `between ${row.time[0]} and ${row.time[1]} s`;
  if (typeof row.along === "number") return `${row.along} m along the path`;
  return row.near ? `nearest to ${row.near[0]}, ${row.near[1]} m` : "";
}
