// How uncertain each joint is, as colour on the body and in words.
import { element } from "../../dom.js";

const DEGREES = 180 / Math.PI;
const MOST = 30; // degrees from which on the colour is full
const STEPS = [0, 10, 20, 30];

/** @typedef {import("../../stage/body.js").Clip} Clip */

export class Uncertainty {
  /** @type {Float32Array | null} */
  #values = null;
  /** @type {{fps: number, frames: number, joints: string[]} | null} */
  #header = null;
  /** @type {Clip | null} */
  #clip = null;
  #row = -1;

  /** @param {import("../../studio.js").App} app */
  constructor(app) {
    this.app = app;
    this.check = element("input", { type: "checkbox", id: "uncertainty-colour", checked: true, onchange: () => this.#again() });
    this.truth = element("input", { type: "checkbox", id: "recorded-body", checked: true, onchange: () => this.#showTruth() });
    this.recorded = element("div", { class: "check", hidden: true }, this.truth, element("label", { for: "recorded-body" }, "Show the recorded body, grey"));
    this.most = element("p", { class: "note" });
    this.element = element(
      "section",
      { "aria-label": "Body" },
      element("h2", {}, "Body"),
      element("div", { class: "check" }, this.check, element("label", { for: "uncertainty-colour" }, "Colour by uncertainty")),
      legend(),
      this.most,
      this.recorded,
    );
    app.transport.on("time", (time) => this.#apply(time));
  }

  /** Whether bodies are coloured. */
  get on() {
    return this.check.checked;
  }

  /**
   * Colours what was made.
   *
   * @param {Clip | null} clip
   */
  async load(clip) {
    this.#clip = clip;
    this.#values = null;
    this.most.textContent = "";
    this.recorded.hidden = !clip?.characters.includes("truth");
    this.#showTruth();
    if (!clip) return;
    try {
      const { header, payload } = await this.app.connection.ask({ kind: "joint_uncertainty" });
      if (clip !== this.#clip) return;
      this.#header = header;
      this.#values = new Float32Array(payload);
      this.#again();
    } catch (error) {
      this.app.say(/** @type {Error} */ (error).message, "error");
    }
  }

  /**
   * Colours from 0 to 1, and the most uncertain joint in words.
   *
   * @param {Float32Array} deviations radians
   * @param {string[]} joints
   * @returns {Float32Array | null} null where bodies keep their own colours
   */
  colours(deviations, joints) {
    let most = 0;
    for (let i = 1; i < deviations.length; i++) if (deviations[i] > deviations[most]) most = i;
    this.most.textContent = `Most uncertain: ${(joints[most] ?? "").replaceAll("_", " ")}, ${Math.round(deviations[most] * DEGREES)}°`;
    return this.on ? deviations.map((value) => Math.min((value * DEGREES) / MOST, 1)) : null;
  }

  #again() {
    this.#row = -1;
    this.#apply(this.app.transport.time);
    this.app.stage.render();
  }

  /** @param {number} time */
  #apply(time) {
    if (!this.#clip || !this.#values || !this.#header) return;
    const { fps, frames, joints } = this.#header;
    const row = Math.min(Math.max(Math.round(time * fps), 0), frames - 1);
    if (row === this.#row) return;
    this.#row = row;
    const own = this.colours(this.#values.subarray(row * joints.length, (row + 1) * joints.length), joints);
    const all = own && new Float32Array(this.#clip.joints.length);
    all?.set(own ?? []);
    this.#clip.setJointColours(all);
  }

  #showTruth() {
    const at = this.#clip?.characters.indexOf("truth") ?? -1;
    const figure = this.#clip?.figures[at];
    if (!figure) return;
    figure.setGhost(0.4, "#9aa1ad");
    figure.object.visible = this.truth.checked;
    this.app.stage.render();
  }
}

function legend() {
  const swatches = STEPS.map((degrees) => {
    const swatch = element("span", { class: "swatch" });
    swatch.style.setProperty("--share", `${(100 * degrees) / MOST}%`);
    return element("li", {}, swatch, `${degrees}°${degrees === MOST ? " and more" : ""}`);
  });
  return element("ul", { class: "legend", "aria-label": "Standard deviation of a joint" }, swatches);
}
