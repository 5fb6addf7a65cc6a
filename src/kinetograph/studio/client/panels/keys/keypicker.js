// Where poses come from: a take of the library and a second in it.
import { button, element, field, slider } from "../../dom.js";

/** @typedef {import("../../messages.js").TakeRow} TakeRow */

const FRAME = 1 / 30;
const MOST = 500; // takes

/** Chooses a take and a second; K or Enter takes the pose. */
export class KeyPicker {
  /** @type {TakeRow[]} */
  #takes = [];
  #library = "";
  #second = 0;

  /**
   * @param {import("../../studio.js").App} app
   * @param {{scrub: () => void, add: () => void, library: (name: string) => void}} events
   */
  constructor(app, events) {
    this.app = app;
    this.events = events;
    this.libraries = element("select", { onchange: () => events.library(this.libraries.value) });
    this.libraryField = field("Library", this.libraries);
    this.take = element("select", { onchange: () => this.#choose(0) });
    this.second = slider("Second", { min: 0, max: 1, step: FRAME, value: 0, unit: "s" }, (value) => this.#scrub(value));
    this.addButton = button("Add key", () => events.add(), { class: "primary", title: "Add a key of this pose (K)" });
    this.element = element(
      "section",
      { "aria-label": "A pose from the library" },
      element("h2", {}, "Pose"),
      this.libraryField,
      field("Take", this.take),
      this.second,
      element("div", { class: "buttons" }, this.addButton, element("span", { class: "note" }, "K")),
    );
    this.second.addEventListener("keydown", (event) => event.key === "Enter" && events.add());
    this.take.addEventListener("keydown", (event) => event.key === "Enter" && (event.preventDefault(), events.add()));
  }

  /** The pose, as documents name it; null without takes. */
  get pose() {
    return this.take.value ? `take:${this.take.value}@${Number(this.#second.toFixed(3))}` : null;
  }

  /**
   * A second of a take: a clip that loops is played on past its end.
   *
   * @param {string} name
   * @param {number} second
   */
  within(name, second) {
    const seconds = this.#takes.find((take) => take.name === name)?.seconds ?? Infinity;
    return second <= seconds ? second : second % seconds;
  }

  /** Asks for the takes again when they are shown next. */
  forget() {
    this.#library = "";
  }

  /**
   * Offers the takes of a library.
   *
   * @param {string} name
   */
  async show(name) {
    const libraries = this.app.store.welcome?.libraries ?? [];
    this.libraryField.hidden = libraries.length < 2;
    this.libraries.replaceChildren(...libraries.map((each) => element("option", { value: each.name }, each.name)));
    const chosen = name || libraries[0]?.name || "";
    this.libraries.value = chosen;
    if (!chosen || chosen === this.#library) return;
    this.#library = chosen;
    try {
      const answer = await this.app.connection.ask({ kind: "ask_takes", library: chosen, count: MOST });
      if (this.#library !== chosen) return;
      this.#takes = answer.rows;
      const before = this.take.value;
      this.take.replaceChildren(...this.#takes.map((take) => element("option", { value: take.name }, take.name)));
      if (this.#takes.some(({ name: known }) => known === before)) this.take.value = before;
      else this.#choose(0, false);
    } catch (error) {
      this.#library = "";
      this.app.say(/** @type {Error} */ (error).message, "error");
    }
  }

  /**
   * @param {number} second
   * @param {boolean} [scrubbed]
   */
  #choose(second, scrubbed = true) {
    const input = /** @type {HTMLInputElement} */ (this.second.querySelector("input"));
    input.max = String(Math.max(this.#takes.find((take) => take.name === this.take.value)?.seconds ?? 0, FRAME));
    this.second.set(second);
    this.#second = second;
    if (scrubbed) this.events.scrub();
  }

  /** @param {number} second */
  #scrub(second) {
    this.#second = second;
    this.events.scrub();
  }
}
