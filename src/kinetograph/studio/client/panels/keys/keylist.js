// The list of keys, with what stands in the way of one.
import { button, element } from "../../dom.js";
import { nameOf, poseOf, spansOf, windowOf } from "./keyrows.js";

/**
 * @typedef {import("../../messages.js").KeyRow} KeyRow
 * @typedef {import("../../messages.js").MetRow} MetRow
 * @typedef {import("../../messages.js").Trouble} Trouble
 *
 * @typedef {object} ListEvents
 * @property {(index: number) => void} select
 * @property {(index: number) => void} remove
 * @property {(index: number, seconds: number) => void} putOff
 * @property {() => void} force
 */

/** Keys in their order; arrow keys go from one to the next, Delete removes. */
export class KeyList {
  /** @param {ListEvents} events */
  constructor(events) {
    this.events = events;
    this.list = element("ol", { class: "list key-list", "aria-label": "Keys" });
    this.empty = element("p", { class: "note" }, "Choose a take, scrub to a pose and press K. Two keys make a motion.");
    this.element = element("div", {}, this.empty, this.list);
    this.list.addEventListener("keydown", (event) => this.#key(event));
  }

  /**
   * @param {KeyRow[]} rows
   * @param {number} selected
   * @param {MetRow[] | null} met
   * @param {Trouble | null} trouble
   */
  show(rows, selected, met, trouble) {
    const focused = [...this.list.querySelectorAll(".key-row")].indexOf(/** @type {Element} */ (document.activeElement));
    this.empty.hidden = rows.length > 1;
    const spans = spansOf(rows, met);
    this.list.replaceChildren(...rows.map((row, i) => this.#row(row, i, i === selected, spans[i], met?.[i] ?? null, trouble?.row === i ? trouble : null)));
    if (focused >= 0) this.#rows()[Math.min(selected, rows.length - 1)]?.focus();
  }

  /** @returns {HTMLButtonElement[]} */
  #rows() {
    return [...this.list.querySelectorAll("button")].filter((each) => each.classList.contains("key-row"));
  }

  /**
   * @param {KeyRow} row
   * @param {number} index
   * @param {boolean} selected
   * @param {[number, number]} span
   * @param {MetRow | null} met
   * @param {Trouble | null} trouble
   */
  #row(row, index, selected, span, met, trouble) {
    const { source, second } = poseOf(row);
    const made = button("", () => this.events.select(index), { class: "key-row", pressed: selected });
    made.append(
      element("span", { class: "key-name" }, nameOf(row, index)),
      element("span", { class: "key-time" }, timeText(row, index, span, met)),
      element("span", { class: "key-pose" }, `${source} @ ${second.toFixed(2)} s`),
      element("span", { class: "key-pose" }, placeText(row)),
    );
    return element("li", { class: selected ? "selected" : null }, made, trouble && this.#trouble(index, trouble));
  }

  /**
   * @param {number} index
   * @param {Trouble} trouble
   */
  #trouble(index, { message, seconds, force }) {
    const more = seconds ? Math.ceil(seconds * 30 - 1e-6) / 30 : 0;
    return element(
      "div",
      { class: "key-trouble", role: "alert" },
      element("p", {}, message ?? ""),
      more > 0 && button(`Give it ${more.toFixed(2)} s more`, () => this.events.putOff(index, more), { class: "primary", title: "The least duration that works" }),
      force && button("Make it all the same", () => this.events.force(), { title: "Force the timing: the motion is worse than the recordings" }),
    );
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const rows = this.#rows();
    const at = rows.indexOf(/** @type {HTMLButtonElement} */ (event.target));
    if (at < 0) return;
    const by = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (by) {
      const next = Math.min(Math.max(at + by, 0), rows.length - 1);
      rows[next].focus();
      this.events.select(next);
    } else if (event.key === "Delete" || event.key === "Backspace") this.events.remove(at);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }
}

/**
 * @param {KeyRow} row
 * @param {number} index
 * @param {[number, number]} span
 * @param {MetRow | null} met
 */
function timeText(row, index, span, met) {
  const window = windowOf(row, index);
  if (!window) return met ? `${met.time.toFixed(2)} s, free` : "free";
  if (window[0] === window[1]) return `${span[0].toFixed(2)} s`;
  return `${window[0].toFixed(2)} to ${window[1].toFixed(2)} s`;
}

/** @param {KeyRow} row */
function placeText(row) {
  const place = row.position ? `x ${row.position[0].toFixed(2)}, z ${row.position[1].toFixed(2)} m` : "any place";
  return typeof row.heading === "number" ? `${place}, ${row.heading.toFixed(0)}°` : place;
}
