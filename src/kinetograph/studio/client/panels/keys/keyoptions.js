// What the motion between keys is made of, the alternatives, and a span that is kept.
import { button, element, field } from "../../dom.js";
import { check, checkbox, number } from "./keyfields.js";

/**
 * @typedef {import("../../messages.js").Keys} Keys
 * @typedef {import("../../messages.js").MadeHeader} MadeHeader
 *
 * @typedef {object} OptionEvents
 * @property {(change: Partial<Keys>, label: string) => void} change
 * @property {(span: [number, number]) => void} lock
 * @property {() => void} ghosts the others are to be shown otherwise
 * @property {() => number} time seconds that are shown
 */

export const COLOURS = ["#3b82d6", "#d1742f", "#2f9e62", "#9a5fc9"];
const MOST = 4;

/** Names that are typed, each shown with a button that takes it out. */
class Tags {
  /** @type {string[]} */
  #tags = [];

  /**
   * @param {string} name
   * @param {string} hint
   * @param {(tags: string[]) => void} change
   */
  constructor(name, hint, change) {
    this.change = change;
    this.name = name;
    this.input = element("input", { type: "text", placeholder: hint, onchange: () => this.#add(), onkeydown: (/** @type {KeyboardEvent} */ event) => event.key === "Enter" && this.#add() });
    this.chips = element("div", { class: "chips" });
    this.element = element("div", {}, field(name, this.input), this.chips);
  }

  /** @param {string[]} tags */
  show(tags) {
    this.#tags = tags;
    this.chips.hidden = !tags.length;
    this.chips.replaceChildren(
      ...tags.map((tag) => button(`${tag} ×`, () => this.change(tags.filter((other) => other !== tag)), { class: "small", "aria-label": `${this.name}: remove ${tag}` })),
    );
  }

  #add() {
    const tags = this.input.value.split(",").map((tag) => tag.trim()).filter((tag) => tag && !this.#tags.includes(tag));
    this.input.value = "";
    if (tags.length) this.change([...this.#tags, ...tags]);
  }
}

/** The fields of the motion as a whole. */
export class KeyOptions {
  /** @param {OptionEvents} events */
  constructor(events) {
    this.events = events;
    this.moves = new Tags("Go by way of", "walk, turn*", (moves) => events.change({ moves }, "choose moves"));
    this.without = new Tags("Leave out", "punch", (without) => events.change({ without }, "leave moves out"));
    this.filler = checkbox(() => events.change({ filler: this.filler.checked }, "let anything fill in"));
    this.force = checkbox(() => events.change({ force: this.force.checked }, this.force.checked ? "force timings" : "force no timings"));
    this.mirror = checkbox(() => events.change({ mirror: this.mirror.checked }, "mirror"));
    const counts = Array.from({ length: MOST }, (_, i) => element("option", { value: i + 1 }, String(i + 1)));
    this.count = element("select", { onchange: () => events.change({ alternatives: Number(this.count.value), chosen: 0 }, "alternatives") }, counts);
    this.choices = element("div", { class: "choices", role: "radiogroup", "aria-label": "Alternatives" });
    const views = Object.entries({ beside: "next to it", place: "in place", none: "not shown" });
    this.ghosts = element("select", { onchange: () => events.ghosts() }, views.map(([value, text]) => element("option", { value }, text)));
    this.ghostsField = field("The others", this.ghosts);
    this.from = number(null, 0.1, () => {});
    this.to = number(null, 0.1, () => {});
    this.lockButton = button("Lock", () => this.#lock());
    this.unlockButton = button("Unlock", () => events.change({ lock: null }, "unlock"));
    this.locked = element("p", { class: "note" });
    this.element = element("div", { class: "rows" }, this.#motion(), this.#alternatives(), this.#span());
  }

  /**
   * @param {Keys} keys
   * @param {MadeHeader | null} made
   */
  show(keys, made) {
    this.moves.show(keys.moves ?? []);
    this.without.show(keys.without ?? []);
    this.filler.checked = keys.filler ?? false;
    this.mirror.checked = keys.mirror ?? false;
    this.force.checked = keys.force ?? false;
    this.count.value = String(keys.alternatives ?? 1);
    this.#showChoices(keys, made?.costs ?? []);
    this.lockButton.disabled = !made;
    this.unlockButton.hidden = !keys.lock;
    this.locked.hidden = !keys.lock;
    if (keys.lock) this.locked.textContent = `${keys.lock.span[0].toFixed(2)} to ${keys.lock.span[1].toFixed(2)} s stays as it is; the rest is made anew.`;
    if (made && !this.to.value) [this.from.value, this.to.value] = ["0.00", made.seconds.toFixed(2)];
  }

  #motion() {
    const boxes = element("div", { class: "rows" }, check(this.mirror, "Mirrored recordings too"), check(this.filler, "Let any recording fill in"), check(this.force, "Force timings that are too quick"));
    return element("section", { "aria-label": "Motion" }, element("h2", {}, "Motion"), this.moves.element, this.without.element, boxes);
  }

  #alternatives() {
    return element("section", { "aria-label": "Alternatives" }, element("h2", {}, "Alternatives"), field("How many", this.count), this.choices, this.ghostsField);
  }

  #span() {
    const here = (/** @type {HTMLInputElement} */ input, /** @type {string} */ name) =>
      button("Here", () => (input.value = this.events.time().toFixed(2)), { class: "small", "aria-label": `Here: ${name}` });
    const buttons = element("div", { class: "buttons" }, this.lockButton, this.unlockButton);
    return element(
      "section",
      { "aria-label": "Keep a part" },
      element("h2", {}, "Keep a part"),
      field("Keep from, s", this.from, here(this.from, "From")),
      field("Keep to, s", this.to, here(this.to, "To")),
      buttons,
      this.locked,
    );
  }

  #lock() {
    const [from, to] = [Number(this.from.value), Number(this.to.value)].sort((a, b) => a - b);
    this.events.lock([from, to]);
  }

  /**
   * @param {Keys} keys
   * @param {number[]} costs
   */
  #showChoices(keys, costs) {
    const chosen = Math.min(keys.chosen ?? 0, Math.max(costs.length - 1, 0));
    this.choices.hidden = this.ghostsField.hidden = costs.length < 2;
    const focused = this.choices.contains(document.activeElement);
    this.choices.replaceChildren(
      ...costs.map((cost, i) => {
        const box = element("input", { type: "radio", name: "alternative", value: i, checked: i === chosen, onchange: () => this.events.change({ chosen: i }, "choose an alternative") });
        const dot = element("span", { class: "dot", style: `background: ${COLOURS[i]}`, "aria-hidden": "true" });
        return element("label", { class: "check" }, box, dot, `${i + 1}`, element("span", { class: "note" }, `cost ${cost.toFixed(1)}`));
      }),
    );
    if (focused) this.choices.querySelectorAll("input")[chosen]?.focus();
  }
}
