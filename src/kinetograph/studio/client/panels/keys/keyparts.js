// Parts of a key's body that are to be elsewhere than in its pose: a place, a rotation or both, from the root or in the world.
import { button, element, iconButton } from "../../dom.js";
import { check, checkbox, number, words } from "./keyfields.js";

/**
 * @typedef {import("../../messages.js").PartRow} PartRow
 * @typedef {import("../../messages.js").EndPlaces} EndPlaces
 * @typedef {[number, number, number]} Three
 * @typedef {[number, number, number, number]} Four
 *
 * @typedef {object} PartsShown
 * @property {PartRow[]} parts
 * @property {EndPlaces | null} ends where parts are in the pose
 * @property {{position: [number, number], heading: number}} place of the key, metres x and z, and degrees
 */

const DEGREES = 180 / Math.PI;
const AXES = { root: ["sideways", "up", "forward"], world: ["x", "up", "z"] };
const TURNS = ["nod", "turn", "roll"]; // about x, y and z

/** The list of parts, with a field that adds one. */
export class KeyParts {
  /** @type {PartsShown} */
  #shown = { parts: [], ends: null, place: { position: [0, 0], heading: 0 } };

  /** @param {(parts: PartRow[], label: string) => void} change */
  constructor(change) {
    this.change = change;
    this.role = element("select", { "aria-label": "Part to put elsewhere" });
    this.add = button("Add part", () => this.#add(), { title: "Ask for a place of this part, met within 1 mm" });
    this.list = element("ul", { class: "list", "aria-label": "Parts elsewhere" });
    this.element = element(
      "details",
      {},
      element("summary", {}, "Parts elsewhere"),
      element("p", { class: "note" }, "A place in metres, a rotation in degrees, or both; met within 1 mm and half a degree, or refused."),
      element("div", { class: "row" }, this.role, this.add),
      this.list,
    );
  }

  /** @param {PartsShown} shown */
  show(shown) {
    this.#shown = shown;
    const { parts, ends } = shown;
    const free = Object.keys(ends?.positions ?? {}).filter((role) => !parts.some((part) => part.role === role));
    if (document.activeElement !== this.role) {
      const before = this.role.value;
      this.role.replaceChildren(...free.map((role) => element("option", { value: role }, words(role))));
      if (free.includes(before)) this.role.value = before;
    }
    this.add.disabled = free.length === 0;
    if (parts.length) this.element.open = true;
    if (this.#typing && this.list.childElementCount === parts.length) return;
    this.list.replaceChildren(...parts.map((part, i) => this.#row(part, i)));
  }

  /** Whether a person is in a number, which is left as it is typed. */
  get #typing() {
    const inside = document.activeElement;
    return this.list.contains(inside) && inside instanceof HTMLInputElement && inside.type === "number";
  }

  #add() {
    const role = this.role.value;
    const position = this.#shown.ends?.positions?.[role];
    if (!position) return;
    this.change([...this.#shown.parts, { role, in: "root", position: rounded(position) }], `put ${words(role)} elsewhere`);
  }

  /**
   * @param {PartRow} part
   * @param {number} index
   */
  #row(part, index) {
    const name = words(part.role);
    const now = () => this.#shown.parts[index] ?? part; // rows are not made anew while a person types
    const replace = (/** @type {Partial<PartRow>} */ change) => this.#replace(index, change);
    const seen = element("select", { "aria-label": `${name}: seen from`, onchange: () => replace(this.#seenFrom(now(), /** @type {"root" | "world"} */ (seen.value))) });
    seen.append(element("option", { value: "root" }, "from the root"), element("option", { value: "world" }, "in the world"));
    seen.value = part.in;
    const placed = checkbox(() => replace({ position: placed.checked ? this.#usual(now()).position : null }));
    const rotated = checkbox(() => replace({ orientation: rotated.checked ? this.#usual(now()).orientation : null }));
    [placed.checked, rotated.checked] = [Boolean(part.position), Boolean(part.orientation)];
    placed.disabled = !part.orientation; // one of both is asked for
    rotated.disabled = !part.position;
    const metres = AXES[part.in].map((axis, i) => this.#number(`${name}: ${axis}, metres`, 0.01, part.position?.[i], (value) => replace({ position: with_(now().position ?? [0, 0, 0], i, value) })));
    const angles = part.orientation ? degreesOf(part.orientation) : null;
    const degrees = TURNS.map((turn, i) => this.#number(`${name}: ${turn}, degrees`, 5, angles?.[i], (value) => replace({ orientation: quaternionOf(with_(degreesOf(now().orientation ?? [1, 0, 0, 0]), i, value)) })));
    return element(
      "li",
      { class: "part-row" },
      element("div", { class: "row" }, element("strong", {}, name), seen, iconButton("close", `Remove: ${name}`, () => this.#remove(index), { class: "quiet" })),
      element("div", { class: "field" }, check(placed, "Place"), element("div", { class: "row", hidden: !part.position }, metres)),
      element("div", { class: "field" }, check(rotated, "Rotation"), element("div", { class: "row", hidden: !part.orientation }, degrees)),
    );
  }

  /**
   * @param {string} name
   * @param {number} step
   * @param {number | undefined} value
   * @param {(value: number) => void} change
   */
  #number(name, step, value, change) {
    const input = number(name, step, () => change(Number(input.value)));
    input.value = value === undefined ? "" : value.toFixed(step < 1 ? 3 : 1);
    return input;
  }

  /**
   * Where a part is in the pose, in the frame that its row has.
   *
   * @param {PartRow} part
   * @returns {{position: Three, orientation: Four}}
   */
  #usual(part) {
    const { ends, place } = this.#shown;
    const position = /** @type {Three} */ (ends?.positions?.[part.role] ?? [0, 1, 0]);
    const orientation = /** @type {Four} */ (ends?.orientations?.[part.role] ?? [1, 0, 0, 0]);
    return part.in === "root" ? { position, orientation } : moved({ position, orientation }, place, 1);
  }

  /**
   * The same place and rotation, seen from elsewhere.
   *
   * @param {PartRow} part
   * @param {"root" | "world"} seen
   * @returns {Partial<PartRow>}
   */
  #seenFrom(part, seen) {
    const there = { position: /** @type {Three} */ (part.position ?? [0, 0, 0]), orientation: /** @type {Four} */ (part.orientation ?? [1, 0, 0, 0]) };
    const { position, orientation } = moved(there, this.#shown.place, seen === "world" ? 1 : -1);
    return { in: seen, position: part.position && rounded(position), orientation: part.orientation && orientation };
  }

  /**
   * @param {number} index
   * @param {Partial<PartRow>} change
   */
  #replace(index, change) {
    const parts = this.#shown.parts.map((part, i) => (i === index ? clean({ ...part, ...change }) : part));
    this.change(parts, `put ${words(parts[index].role)} elsewhere`);
  }

  /** @param {number} index */
  #remove(index) {
    this.change(this.#shown.parts.filter((_, i) => i !== index), `leave ${words(this.#shown.parts[index].role)}`);
  }
}

/**
 * A place and a rotation brought from the root's frame into the world's, or back.
 *
 * @param {{position: Three, orientation: Four}} there
 * @param {{position: [number, number], heading: number}} place
 * @param {1 | -1} way
 * @returns {{position: Three, orientation: Four}}
 */
function moved({ position, orientation }, place, way) {
  const angle = (way * place.heading) / DEGREES;
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const [dx, dz] = place.position;
  const from = way === 1 ? position : [position[0] - dx, position[1], position[2] - dz];
  const turned = [c * from[0] + s * from[2], from[1], -s * from[0] + c * from[2]];
  const at = /** @type {Three} */ (way === 1 ? [turned[0] + dx, turned[1], turned[2] + dz] : turned);
  return { position: at, orientation: multiply([Math.cos(angle / 2), 0, Math.sin(angle / 2), 0], orientation) };
}

/**
 * @param {Four} a
 * @param {Four} b
 * @returns {Four}
 */
function multiply([aw, ax, ay, az], [bw, bx, by, bz]) {
  return [aw * bw - ax * bx - ay * by - az * bz, aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw];
}

/**
 * Angles about x, y and z of a rotation, degrees: first about z, then about x, then about y.
 *
 * @param {number[]} quaternion w, x, y, z
 * @returns {Three}
 */
export function degreesOf([w, x, y, z]) {
  const nod = Math.asin(Math.min(Math.max(2 * (w * x - y * z), -1), 1));
  const turn = Math.atan2(2 * (w * y + x * z), 1 - 2 * (x * x + y * y));
  const roll = Math.atan2(2 * (w * z + x * y), 1 - 2 * (x * x + z * z));
  return [nod * DEGREES, turn * DEGREES, roll * DEGREES];
}

/**
 * @param {number[]} angles as `degreesOf` gives them
 * @returns {Four}
 */
export function quaternionOf(angles) {
  const [x, y, z] = angles.map((angle) => angle / DEGREES / 2);
  const about = (/** @type {number} */ half, /** @type {number} */ axis) => /** @type {Four} */ ([Math.cos(half), ...[0, 1, 2].map((i) => (i === axis ? Math.sin(half) : 0))]);
  return multiply(about(y, 1), multiply(about(x, 0), about(z, 2)));
}

/**
 * @param {number[]} values
 * @param {number} index
 * @param {number} value
 * @returns {Three}
 */
function with_(values, index, value) {
  return /** @type {Three} */ (values.map((each, i) => (i === index ? value : each)));
}

/**
 * @param {number[]} position
 * @returns {Three}
 */
function rounded(position) {
  return /** @type {Three} */ (position.map((value) => Math.round(1e4 * value) / 1e4));
}

/**
 * A part without what is not asked for.
 *
 * @param {PartRow} part
 * @returns {PartRow}
 */
function clean(part) {
  return /** @type {PartRow} */ (Object.fromEntries(Object.entries(part).filter(([, value]) => value !== null && value !== undefined)));
}
