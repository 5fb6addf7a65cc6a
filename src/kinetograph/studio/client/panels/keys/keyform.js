// What is asked of one key: its time, its place and heading, the parts that count, and where hands and feet are.
import { button, element, field } from "../../dom.js";
import { check, checkbox, number, words } from "./keyfields.js";
import { KeyParts } from "./keyparts.js";
import { nameOf, timeFrom, windowOf } from "./keyrows.js";

/**
 * @typedef {import("../../messages.js").KeyRow} KeyRow
 * @typedef {import("../../messages.js").EndPlaces} EndPlaces
 * @typedef {import("./keyrows.js").Change} Change
 *
 * @typedef {object} Shown
 * @property {KeyRow} row
 * @property {number} index
 * @property {number} time seconds at which it is met or asked for
 * @property {{position: [number, number], heading: number}} place where it is shown
 * @property {EndPlaces | null} ends
 */

const AXES = ["sideways", "up", "forward"];

/** The fields of the key that is selected. */
export class KeyForm {
  /** @type {Shown | null} */
  #shown = null;
  #role = "left_hand";

  /**
   * @param {(change: Change, label: string) => void} change
   * @param {() => void} remove
   */
  constructor(change, remove) {
    this.change = change;
    this.title = element("h2", {}, "Key");
    this.name = element("input", { type: "text", maxlength: 60, onchange: () => change({ name: this.name.value.trim() }, "name a key") });
    this.when = select({ free: "free", at: "at", between: "within" }, () => this.#changeTime());
    this.from = number("from, seconds", 1 / 30, () => this.#changeTime());
    this.to = number("to, seconds", 1 / 30, () => this.#changeTime());
    this.placed = checkbox(() => this.#changePlace());
    this.x = number("x, metres", 0.05, () => this.#changePlace());
    this.z = number("z, metres", 0.05, () => this.#changePlace());
    this.headed = checkbox(() => this.#changeHeading());
    this.heading = number("heading, degrees", 5, () => this.#changeHeading());
    this.whole = checkbox(() => this.#changeRoles(null));
    this.roles = element("div", { class: "toggles", role: "group", "aria-label": "Parts that count" });
    this.end = select({}, () => ((this.#role = this.end.value), this.#showEnd()));
    this.place = AXES.map((axis) => number(`${axis}, metres`, 0.01, () => this.#changeEnd()));
    this.reset = button("As recorded", () => this.#resetEnd());
    this.said = element("p", { class: "warn" });
    this.parts = new KeyParts((parts, label) => change({ parts }, label));
    const trash = button("Delete key", remove);
    this.element = element("section", { "aria-label": "The selected key" }, this.title, field("Name", this.name), this.#times(), this.#places(), this.#parts(), this.#ends(), this.parts.element, element("div", { class: "buttons" }, trash));
  }

  /** @param {Shown | null} shown */
  show(shown) {
    this.#shown = shown;
    this.element.hidden = shown === null;
    if (!shown) return;
    const { row, index, time, place } = shown;
    this.title.textContent = nameOf(row, index);
    put(this.name, row.name ?? "");
    const window = windowOf(row, index);
    put(this.when, !window ? "free" : window[0] === window[1] ? "at" : "between");
    this.when.disabled = this.from.disabled = index === 0;
    put(this.from, (window?.[0] ?? time).toFixed(2));
    put(this.to, (window?.[1] ?? time).toFixed(2));
    this.from.hidden = this.when.value === "free";
    this.to.hidden = this.when.value !== "between";
    this.placed.checked = Boolean(row.position);
    this.headed.checked = typeof row.heading === "number";
    put(this.x, place.position[0].toFixed(2));
    put(this.z, place.position[1].toFixed(2));
    put(this.heading, place.heading.toFixed(0));
    this.#showRoles();
    this.#showEnds();
    this.parts.show({ parts: row.parts ?? [], ends: this.#shown?.ends ?? null, place });
  }

  #times() {
    return element("div", { class: "field" }, label("Time", this.when), element("div", { class: "row" }, this.when, this.from, this.to));
  }

  #places() {
    const place = element("div", { class: "field" }, check(this.placed, "Place"), element("div", { class: "row" }, this.x, this.z));
    const heading = element("div", { class: "field" }, check(this.headed, "Heading"), element("div", { class: "row" }, this.heading));
    return element("div", { class: "rows" }, place, heading);
  }

  #parts() {
    return element("details", {}, element("summary", {}, "Parts that count"), check(this.whole, "The whole body"), this.roles);
  }

  #ends() {
    const places = element("div", { class: "row" }, this.place);
    return element(
      "details",
      { open: true },
      element("summary", {}, "Hands and feet"),
      element("p", { class: "note" }, "Drag the dots on the stage, or set metres from the root: sideways, up, forward."),
      element("div", { class: "field" }, label("Part", this.end), this.end),
      places,
      this.said,
      element("div", { class: "buttons" }, this.reset),
    );
  }

  #changeTime() {
    const from = Number(this.from.value);
    const to = this.when.value === "between" ? Math.max(Number(this.to.value), from) : from;
    if (this.when.value === "free") return this.change({ time: null }, "free a key's time");
    const wide = this.when.value === "between" && to - from < 0.05 ? 0.25 : 0; // just opened
    this.change({ time: timeFrom(from - wide, to + wide) }, "time a key");
  }

  #changePlace() {
    this.change({ position: this.placed.checked ? [Number(this.x.value), Number(this.z.value)] : null }, "place a key");
  }

  #changeHeading() {
    this.change({ heading: this.headed.checked ? Number(this.heading.value) : null }, "turn a key");
  }

  /** @param {string | null} role */
  #changeRoles(role) {
    const all = this.#shown?.ends?.roles ?? [];
    if (role === null) return this.change({ roles: this.whole.checked ? null : all }, "choose parts");
    const now = new Set(this.#shown?.row.roles ?? all);
    if (!now.delete(role)) now.add(role);
    this.change({ roles: now.size ? all.filter((each) => now.has(each)) : null }, "choose parts");
  }

  #showRoles() {
    const { row, ends } = /** @type {Shown} */ (this.#shown);
    const now = row.roles ?? ends?.roles ?? [];
    this.whole.checked = !row.roles;
    this.roles.hidden = !row.roles;
    const focused = document.activeElement?.textContent;
    const inside = this.roles.contains(document.activeElement);
    this.roles.replaceChildren(...(ends?.roles ?? []).map((role) => button(words(role), () => this.#changeRoles(role), { pressed: now.includes(role), class: "small" })));
    if (inside) for (const each of this.roles.children) if (each.textContent === focused) /** @type {HTMLElement} */ (each).focus();
  }

  #showEnds() {
    const { ends } = /** @type {Shown} */ (this.#shown);
    const roles = Object.keys(ends?.ends ?? {});
    if (document.activeElement !== this.end) {
      this.end.replaceChildren(...roles.map((role) => element("option", { value: role }, words(role))));
      this.end.value = roles.includes(this.#role) ? this.#role : roles[0] ?? "";
    }
    this.said.textContent = ends?.said?.join(" ") ?? "";
    this.#showEnd();
  }

  #showEnd() {
    const place = this.#shown?.ends?.ends[this.end.value];
    this.reset.disabled = !this.#shown?.row.moved?.[this.end.value];
    this.place.forEach((input, axis) => put(input, place ? place[axis].toFixed(2) : ""));
  }

  #changeEnd() {
    const at = /** @type {[number, number, number]} */ (this.place.map((input) => Number(input.value)));
    this.change({ moved: { ...this.#shown?.row.moved, [this.end.value]: at } }, `move ${words(this.end.value)}`);
  }

  #resetEnd() {
    const { [this.end.value]: _, ...rest } = this.#shown?.row.moved ?? {};
    this.change({ moved: rest }, `leave ${words(this.end.value)}`);
  }
}

/**
 * Shows a value in a field, unless a person is in it.
 *
 * @param {HTMLInputElement | HTMLSelectElement} input
 * @param {string} value
 */
function put(input, value) {
  if (document.activeElement !== input || input.tagName === "SELECT") input.value = value;
}

/**
 * @param {Record<string, string>} options
 * @param {() => void} onchange
 */
function select(options, onchange) {
  return element("select", { onchange }, Object.entries(options).map(([value, text]) => element("option", { value }, text)));
}

let ids = 0;

/**
 * @param {string} name
 * @param {HTMLElement} control
 */
function label(name, control) {
  control.id ||= `key-field-${(ids += 1)}`;
  return element("label", { for: control.id }, name);
}
