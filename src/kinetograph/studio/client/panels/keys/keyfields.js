// Fields that the panel of keys is made of.
import { element } from "../../dom.js";

/** @param {string} role */
export function words(role) {
  return role.replaceAll("_", " ");
}

/**
 * @param {string | null} name null where a label names it
 * @param {number} step
 * @param {() => void} onchange
 */
export function number(name, step, onchange) {
  return element("input", { type: "number", "aria-label": name, title: name, step: "any", "data-step": step, onchange, onkeydown: (/** @type {KeyboardEvent} */ event) => nudge(event, step) });
}

/**
 * Arrow keys go by steps that suit the quantity, from wherever the value is.
 *
 * @param {KeyboardEvent} event
 * @param {number} step
 */
function nudge(event, step) {
  const by = { ArrowUp: 1, ArrowDown: -1 }[event.key];
  const input = /** @type {HTMLInputElement} */ (event.target);
  if (!by) return;
  event.preventDefault();
  input.value = (Number(input.value) + by * step * (event.shiftKey ? 10 : 1)).toFixed(step < 0.05 ? 3 : 2);
  input.dispatchEvent(new Event("change"));
}

/** @param {() => void} onchange */
export function checkbox(onchange) {
  return element("input", { type: "checkbox", onchange });
}

/**
 * @param {HTMLInputElement} box
 * @param {string} name
 */
export function check(box, name) {
  return element("label", { class: "check" }, box, name);
}
