// The panel of sensors: readings become a motion, live or from a file, and sensors are calibrated.
import { button, element, field } from "../../dom.js";
import { dropFile } from "../../dropping.js";
import { LiveView } from "../../stage/live_view.js";
import { Calibration } from "./calibration.js";
import { Listening } from "./listening.js";
import { Uncertainty } from "./uncertainty.js";

const LAYOUTS = ["wii", "phone", "imu", "ideal"];
const SYNTHESES = ["guided", "ridge", "continuity", "interpolation", "optimisation"];
const USES = { "": "all there is", force: "force", "force angular": "force, angular velocity", "force tilt": "force, tilt", "force angular tilt": "force, angular velocity, tilt" };

/**
 * @param {import("../../studio.js").App} app
 * @returns {import("../../studio.js").Panel}
 */
export function createSensors(app) {
  return new SensorPanel(app);
}

class SensorPanel {
  /** @type {string[]} */
  #takes = [];
  #library = "?";

  /** @param {import("../../studio.js").App} app */
  constructor(app) {
    this.app = app;
    this.uncertainty = new Uncertainty(app);
    this.listening = new Listening(app, (fields, label) => this.#edit(fields, label, false), () => this.live.clear());
    this.calibration = new Calibration(app, this.listening, (layout) => this.#edit({ layout }, `use ${layout}`));
    this.live = new LiveView(app, (deviations, joints) => this.uncertainty.colours(deviations, joints));
    this.readings = element("select", { onchange: () => this.#choose() });
    this.library = element("select", { onchange: () => this.#edit({ library: this.library.value, readings: "" }, `use ${this.library.value}`) });
    this.layout = element("select", { onchange: () => this.#edit({ layout: this.layout.value }, `wear ${this.layout.value}`) });
    this.use = element("select", { onchange: () => this.#edit({ use: this.use.value.split(" ").filter(Boolean) }, "use other channels") }, options(USES));
    this.synthesis = element("select", { onchange: () => this.#edit({ synthesis: /** @type {any} */ (this.synthesis.value) }, this.synthesis.value) }, SYNTHESES.map((name) => element("option", { value: name }, name)));
    this.picker = element("input", { type: "file", accept: ".csv,.tsv,.txt,.toml", hidden: true, "aria-label": "A readings file or a layout", onchange: () => this.#pick() });
    this.element = element("div", { class: "sensors group" }, this.#readings(), this.uncertainty.element, this.listening.element, this.calibration.element);
    this.#listen();
  }

  enter() {
    this.#show();
    void this.#findTakes();
  }

  leave() {
    this.listening.stop();
    this.calibration.stop();
    this.live.clear();
  }

  /**
   * @param {import("../../messages.js").MadeHeader | null} made
   * @param {import("../../stage/body.js").Clip | null} clip
   */
  shown(made, clip) {
    this.live.hideClip();
    void this.uncertainty.load(made ? clip : null);
  }

  /**
   * @param {string} name
   * @param {string} role
   */
  dropped(name, role) {
    if (role === "readings") this.#edit({ readings: name }, `read ${name}`);
    if (role === "layout") this.#edit({ layout: name }, `wear ${name}`);
  }

  /** The pose that is shown live, if any. */
  pose() {
    return this.live.body?.pose() ?? null;
  }

  /** Where the live body is, if there is one. */
  root() {
    return this.live.body?.root() ?? null;
  }

  #readings() {
    return element(
      "section",
      { "aria-label": "Readings" },
      element("h2", {}, "Readings"),
      field("Readings", this.readings),
      element("div", { class: "buttons" }, button("Open a file…", () => this.picker.click()), this.picker),
      field("Library", this.library),
      field("Layout", this.layout),
      field("Channels", this.use),
      field("Synthesis", this.synthesis),
    );
  }

  #listen() {
    const { connection, store } = this.app;
    const here = () => store.mode === "sensors";
    store.on("project", () => here() && this.#show());
    store.on("welcome", () => here() && (this.#show(), void this.#findTakes()));
    connection.on("live", (blob) => blob.header.section === "sensors" && void this.live.show(blob));
    connection.on("pose", (values) => this.live.move(values));
    connection.on("live_ended", (message) => message.section === "sensors" && this.listening.ended());
    connection.on("failed", (message) => message.section === "sensors" && this.listening.ended());
    connection.on("closed", () => this.listening.ended());
  }

  /**
   * @param {Partial<import("../../messages.js").Sensors>} fields
   * @param {string} label
   * @param {boolean} [solve]
   */
  #edit(fields, label, solve = true) {
    if (solve) this.live.clear();
    this.app.connection.edit("sensors", { ...this.app.store.project.sensors, ...fields }, { label, solve });
  }

  #choose() {
    this.#edit({ readings: this.readings.value }, this.readings.value ? `read ${this.readings.value.replace("take:", "")}` : "read nothing");
  }

  async #pick() {
    const file = this.picker.files?.[0];
    if (!file) return;
    const app = /** @type {any} */ ({ ...this.app, connection: this.app.connection, say: this.app.say.bind(this.app), panel: this });
    await dropFile(app, file, /\.toml$/i.test(file.name) ? "layout" : "readings");
    this.picker.value = "";
  }

  #show() {
    const { project, welcome } = this.app.store;
    const section = project.sensors ?? {};
    const files = welcome?.files ?? [];
    const readings = section.readings ?? "";
    const group = (/** @type {string} */ label, /** @type {[string, string][]} */ rows) =>
      rows.length ? element("optgroup", { label }, rows.map(([value, name]) => element("option", { value, selected: value === readings }, name))) : null;
    const known = /** @type {[string, string][]} */ (files.filter((name) => /\.(csv|tsv|txt)$/i.test(name)).map((name) => [name, name]));
    const takes = /** @type {[string, string][]} */ (this.#takes.map((name) => [`take:${name}`, name]));
    const other = [...known, ...takes].some(([value]) => value === readings) ? [] : [element("option", { value: readings, selected: true }, readings.replace("take:", "") || "none")];
    const none = readings ? [element("option", { value: "" }, "none")] : [];
    this.readings.replaceChildren(...none, ...other, ...[group("Files of the project", known), group("Simulated on a take, which is left out", takes)].filter((each) => each !== null));
    this.#fill(this.library, (welcome?.libraries ?? []).map(({ name }) => name), section.library || (welcome?.libraries[0]?.name ?? ""));
    this.#fill(this.layout, [...LAYOUTS, ...files.filter((name) => /\.toml$/i.test(name))], section.layout ?? "wii");
    this.use.value = (section.use ?? []).join(" ");
    this.synthesis.value = section.synthesis ?? "guided";
    this.listening.show();
  }

  /**
   * @param {HTMLSelectElement} select
   * @param {string[]} names
   * @param {string} chosen
   */
  #fill(select, names, chosen) {
    const all = names.includes(chosen) || !chosen ? names : [...names, chosen];
    select.replaceChildren(...all.map((name) => element("option", { value: name, selected: name === chosen }, name)));
  }

  async #findTakes() {
    const library = this.app.store.project.sensors?.library ?? "";
    if (library === this.#library || !this.app.store.welcome?.libraries.length) return;
    this.#library = library;
    try {
      const found = await this.app.connection.ask({ kind: "ask_takes", library, count: 200 });
      this.#takes = found.rows.map((/** @type {{name: string}} */ row) => row.name);
      this.#show();
    } catch (error) {
      this.#library = "?";
      this.app.say(/** @type {Error} */ (error).message, "error");
    }
  }
}

/** @param {Record<string, string>} names by value */
function options(names) {
  return Object.entries(names).map(([value, name]) => element("option", { value }, name));
}
