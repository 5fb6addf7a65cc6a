// Layers of a walk: parts of the body that takes, or files of the project, drive.
import { button, element, field, iconButton } from "../../dom.js";

/** @typedef {import("../../messages.js").LayerRow} LayerRow */

const PARTS = ["arms", "left arm", "right arm", "head", "upper body"];
const MOST = 500; // takes of a library that are offered
const DRIVES = /\.(bvh|fbx|glb|gltf|amc|npz|usd[ac]?|csv)$/i;

/** What a person sees of layers and does to them. */
export class Layers {
  #offered = "";

  /**
   * @param {import("../../studio.js").App} app
   * @param {(change: {layers: LayerRow[]}, label: string, merge?: boolean) => void} edit
   */
  constructor(app, edit) {
    this.app = app;
    this.edit = edit;
    this.list = element("ul", { class: "list layers", "aria-label": "Layers" });
    this.parts = element("select", {}, PARTS.map((part) => element("option", { value: part }, part)));
    this.source = element("select", {});
    this.addButton = button("Add layer", () => this.#add(), { title: "From the time that is shown on" });
    this.element = element(
      "section",
      { "aria-label": "Layers of the body" },
      element("h2", {}, "Layers"),
      element("p", { class: "note" }, "A take or a file drives a part of the body, while the legs follow the path."),
      field("Part", this.parts),
      field("Driven by", this.source),
      element("div", { class: "buttons" }, this.addButton),
      this.list,
    );
  }

  /** @returns {LayerRow[]} */
  get layers() {
    return this.app.store.project.walk?.layers ?? [];
  }

  /** Shows the layers. */
  show() {
    void this.#offer();
    const inside = document.activeElement;
    if (this.list.contains(inside) && inside?.tagName === "INPUT" && this.list.childElementCount === this.layers.length) return;
    this.list.replaceChildren(...this.layers.map((row, i) => this.#row(row, i)));
  }

  /** Offers the takes of all libraries, and the files that are there. */
  async #offer() {
    const { welcome } = this.app.store;
    const files = (welcome?.files ?? []).filter((name) => DRIVES.test(name));
    const key = JSON.stringify([welcome?.libraries, files]);
    if (!welcome || key === this.#offered) return;
    this.#offered = key;
    const before = this.source.value;
    const groups = [element("optgroup", { label: "files of the project" }, files.map((name) => option("", name, name)))];
    try {
      for (const { name } of welcome.libraries) {
        const { rows } = await this.app.connection.ask({ kind: "ask_takes", library: name, count: MOST });
        groups.push(element("optgroup", { label: name }, rows.map((/** @type {{name: string}} */ take) => option(name, `take:${take.name}`, take.name))));
      }
    } catch (error) {
      this.#offered = "";
      return this.app.say(/** @type {Error} */ (error).message, "error");
    }
    this.source.replaceChildren(...groups.filter((group) => group.childElementCount));
    if ([...this.source.options].some(({ value }) => value === before)) this.source.value = before;
    this.addButton.disabled = this.source.options.length === 0;
  }

  #add() {
    if (!this.source.value) return;
    const [library, source] = JSON.parse(this.source.value);
    const start = Math.round(30 * this.app.transport.time) / 30;
    const row = { parts: [this.parts.value], source, start: Number(start.toFixed(4)), ...(library ? { library } : {}) };
    this.edit({ layers: [...this.layers, row] }, `drive ${this.parts.value}`);
  }

  /**
   * @param {LayerRow} row
   * @param {number} index
   */
  #row(row, index) {
    const name = `${row.parts.join(" and ")} by ${row.source.replace(/^take:/, "")}`;
    const number = (/** @type {"start" | "second" | "seconds"} */ what, /** @type {string} */ label) => {
      const input = element("input", { type: "number", min: 0, step: 0.1, "aria-label": `${name}: ${label}, seconds`, placeholder: "all" });
      input.value = typeof row[what] === "number" ? String(row[what]) : what === "seconds" ? "" : "0";
      input.addEventListener("change", () => this.#change(index, { [what]: input.value === "" ? null : Math.max(input.valueAsNumber, 0) }));
      return field(label, input);
    };
    const hold = element("input", { type: "checkbox", checked: row.hold ?? false, onchange: () => this.#change(index, { hold: hold.checked }) });
    return element(
      "li",
      { class: "layer-row" },
      element("div", { class: "row" }, element("strong", {}, name), iconButton("close", `Remove: ${name}`, () => this.#remove(index), { class: "quiet" })),
      number("start", "from"),
      number("second", "its second"),
      number("seconds", "for"),
      element("label", { class: "check" }, hold, "Hold its ends"),
    );
  }

  /**
   * @param {number} index
   * @param {Record<string, any>} change what is null in it is left out
   */
  #change(index, change) {
    const layers = this.layers.map((row, i) => (i === index ? /** @type {any} */ (Object.fromEntries(Object.entries({ ...row, ...change }).filter(([, value]) => value !== null))) : row));
    this.edit({ layers }, "change a layer");
  }

  /** @param {number} index */
  #remove(index) {
    this.edit({ layers: this.layers.filter((_, i) => i !== index) }, "take a layer away");
  }
}

/**
 * @param {string} library
 * @param {string} source
 * @param {string} name
 */
function option(library, source, name) {
  return element("option", { value: JSON.stringify([library, source]) }, name);
}
