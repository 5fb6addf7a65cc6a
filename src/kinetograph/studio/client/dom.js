// Making elements, and what several parts of the page share: icons, themes, events.

const SVG = "http://www.w3.org/2000/svg";

/**
 * @typedef {Node | string | number | null | undefined | false} Child
 * @typedef {Record<string, any>} Attributes
 *   `class`, `style` and any attribute by its own name; `onclick`, `oninput`, ... are listeners; `true` sets an attribute
 *   without a value, `false`, `null` and `undefined` leave it out; `value`, `checked`, `disabled` and `selected` are set as
 *   properties too.
 */

/**
 * Makes an element.
 *
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag
 * @param {Attributes} [attributes]
 * @param {...(Child | Child[])} children text or nodes; what is null, undefined or false is left out
 * @returns {HTMLElementTagNameMap[T]}
 */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) setAttribute(made, name, value);
  made.append(...present(children));
  return made;
}

/**
 * @param {HTMLElement} made
 * @param {string} name
 * @param {any} value
 */
function setAttribute(made, name, value) {
  if (name.startsWith("on") && typeof value === "function") made.addEventListener(name.slice(2), value);
  else if (value === false || value === null || value === undefined) return;
  else {
    made.setAttribute(name, value === true ? "" : String(value));
    if (["value", "checked", "disabled", "selected"].includes(name)) /** @type {any} */ (made)[name] = value;
  }
}

/**
 * @param {(Child | Child[])[]} children
 * @returns {(Node | string)[]}
 */
function present(children) {
  const kept = children.flat().filter((child) => child !== null && child !== undefined && child !== false);
  return /** @type {(Node | string | number)[]} */ (kept).map((child) => (child instanceof Node ? child : String(child)));
}

/** What icons are drawn with, as paths in a box of 16 by 16. */
const ICONS = {
  play: "M4 2.5v11l9-5.5z",
  pause: "M4 2.5h3v11H4zM9 2.5h3v11H9z",
  first: "M3 2.5h1.8v11H3zM13 2.5v11L5.5 8z",
  last: "M11.2 2.5H13v11h-1.8zM3 2.5v11L10.5 8z",
  back: "M7.6 3v10L2 8zM9 3h1.6v10H9z",
  forward: "M8.4 3v10L14 8zM5.4 3H7v10H5.4z",
  loop: "M4 5h6V3l4 3-4 3V7H5.5v2.5h-2V5.5zM12 11H6v2l-4-3 4-3v2h4.5V6.5h2v4z",
  follow: "M8 1.5a3 3 0 1 1 0 6 3 3 0 0 1 0-6zM2.5 14.5c0-4 2.5-6 5.5-6s5.5 2 5.5 6z",
  camera: "M1.5 4h9v8h-9zM11.5 7l3-2.5v7l-3-2.5z",
  theme: "M8 1.5a6.5 6.5 0 1 0 0 13zM8 1.5a6.5 6.5 0 0 1 0 13v-1.2a5.3 5.3 0 0 0 0-10.6z",
  plus: "M7.2 3h1.6v4.2H13v1.6H8.8V13H7.2V8.8H3V7.2h4.2z",
  minus: "M3 7.2h10v1.6H3z",
  close: "M4 3l4 4 4-4 1 1-4 4 4 4-1 1-4-4-4 4-1-1 4-4-4-4z",
  undo: "M6 2v3h4a4 4 0 0 1 0 8H5v-1.6h5a2.4 2.4 0 0 0 0-4.8H6v3L1.5 5.8z",
  redo: "M10 2v3H6a4 4 0 0 0 0 8h5v-1.6H6a2.4 2.4 0 0 1 0-4.8h4v3l4.5-3.8z",
  pin: "M5 1.5h6l-.8 1.2v3.6L12.5 9H8.8v5.5H7.2V9H3.5l2.3-2.7V2.7z",
  lock: "M4 7V5a4 4 0 0 1 8 0v2h1v7.5H3V7zm1.6 0h4.8V5a2.4 2.4 0 0 0-4.8 0z",
};

/** @typedef {keyof typeof ICONS} IconName */

/**
 * Makes an icon, which assistive technology does not see.
 *
 * @param {IconName} name
 * @returns {SVGSVGElement}
 */
export function icon(name) {
  const svg = document.createElementNS(SVG, "svg");
  const path = document.createElementNS(SVG, "path");
  for (const [key, value] of Object.entries({ viewBox: "0 0 16 16", width: "16", height: "16", class: "icon", "aria-hidden": "true" }))
    svg.setAttribute(key, value);
  path.setAttribute("d", ICONS[name]);
  path.setAttribute("fill", "currentColor");
  svg.append(path);
  return svg;
}

/**
 * Makes a button with text.
 *
 * @param {string} name its text, which is its accessible name
 * @param {(event: MouseEvent) => void} [onclick]
 * @param {Attributes} [attributes] `pressed` makes it one of two states
 * @returns {HTMLButtonElement}
 */
export function button(name, onclick, attributes = {}) {
  const { pressed, ...rest } = attributes;
  return element("button", { type: "button", onclick, "aria-pressed": pressed === undefined ? null : String(pressed), ...rest }, name);
}

/**
 * Makes a button that shows an icon.
 *
 * @param {IconName} shown
 * @param {string} name accessible name and tooltip
 * @param {(event: MouseEvent) => void} [onclick]
 * @param {Attributes} [attributes] as for {@link button}
 * @returns {HTMLButtonElement}
 */
export function iconButton(shown, name, onclick, attributes = {}) {
  const made = button("", onclick, { "aria-label": name, title: name, ...attributes, class: `icon-button ${attributes.class ?? ""}` });
  made.replaceChildren(icon(shown));
  return made;
}

/**
 * Sets the state of a button of two states.
 *
 * @param {HTMLElement} of
 * @param {boolean} pressed
 */
export function press(of, pressed) {
  of.setAttribute("aria-pressed", String(pressed));
}

let ids = 0;

/**
 * A label with the field that it names.
 *
 * @param {string} name
 * @param {HTMLElement} control an input, select or textarea
 * @param {...Child} after such as a unit or a readout
 * @returns {HTMLDivElement}
 */
export function field(name, control, ...after) {
  control.id ||= `field-${(ids += 1)}`;
  return element("div", { class: "field" }, element("label", { for: control.id }, name), control, ...after);
}

/**
 * A slider with its value next to it.
 *
 * @param {string} name
 * @param {{min: number, max: number, step: number, value: number, unit?: string}} range
 * @param {(value: number, done: boolean) => void} change `done` once the slider is let go
 * @returns {HTMLDivElement & {set(value: number): void}} the field, with a method to show another value
 */
export function slider(name, range, change) {
  const shown = element("output", { class: "readout" });
  const { min, max, step, value, unit } = range;
  const write = () => (shown.value = `${Number(input.value).toFixed(decimals(step))}${unit ? ` ${unit}` : ""}`);
  const input = element("input", {
    type: "range", min, max, step, value,
    oninput: () => (write(), change(Number(input.value), false)),
    onchange: () => (write(), change(Number(input.value), true)),
  });
  const made = field(name, input, shown);
  made.classList.add("slider");
  write();
  return Object.assign(made, { set: (/** @type {number} */ to) => ((input.value = String(to)), write()) });
}

/** @param {number} step */
function decimals(step) {
  return Math.max(0, Math.min(4, -Math.floor(Math.log10(step) + 1e-9)));
}

/**
 * Whether an event comes from something that one types or picks in, which needs the keys itself.
 *
 * @param {Event} event
 * @returns {boolean}
 */
export function isTyping(event) {
  const at = event.target instanceof HTMLElement ? event.target : null;
  if (at === null) return false;
  return at.isContentEditable || at.closest("input, textarea, select, dialog[open]") !== null;
}

/**
 * Listeners by name of an event.
 *
 * @template {Record<string, any>} Events
 */
export class Emitter {
  /** @type {Map<keyof Events, Set<(value: any) => void>>} */
  #listeners = new Map();

  /**
   * Listens; the function returned stops listening.
   *
   * @template {keyof Events} K
   * @param {K} name
   * @param {(value: Events[K]) => void} listener
   * @returns {() => void}
   */
  on(name, listener) {
    const known = this.#listeners.get(name) ?? new Set();
    this.#listeners.set(name, known.add(listener));
    return () => void known.delete(listener);
  }

  /**
   * @template {keyof Events} K
   * @param {K} name
   * @param {Events[K]} value
   */
  emit(name, value) {
    for (const listener of [...(this.#listeners.get(name) ?? [])]) listener(value);
  }
}

/**
 * The theme that is shown.
 *
 * @returns {"dark" | "light"}
 */
export function theme() {
  const chosen = document.documentElement.dataset.theme;
  if (chosen === "dark" || chosen === "light") return chosen;
  return matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
}

/**
 * A button that goes from dark to light and back; the choice is kept where the browser keeps anything.
 *
 * @returns {HTMLButtonElement}
 */
export function themeButton() {
  const stored = remembered("theme");
  if (stored === "dark" || stored === "light") document.documentElement.dataset.theme = stored;
  return iconButton("theme", "Dark or light", () => {
    const next = theme() === "dark" ? "light" : "dark";
    document.documentElement.dataset.theme = next;
    remember("theme", next);
  });
}

/**
 * Calls back whenever the theme changes, by the button or by the system.
 *
 * @param {() => void} changed
 */
export function onTheme(changed) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", changed);
  new MutationObserver(changed).observe(document.documentElement, { attributeFilter: ["data-theme"] });
}

/**
 * A small text kept in this browser; null where there is none, or where storing is not allowed.
 *
 * @param {string} name
 * @returns {string | null}
 */
export function remembered(name) {
  try {
    return localStorage.getItem(`kinetograph.${name}`);
  } catch {
    return null; // a sandboxed frame, or a file: page of some browsers
  }
}

/**
 * @param {string} name
 * @param {string} value
 */
export function remember(name, value) {
  try {
    localStorage.setItem(`kinetograph.${name}`, value);
  } catch {
    // see `remembered`
  }
}
