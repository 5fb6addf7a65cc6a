// Calibration in three steps: stand still, move as in the library, and how each sensor is worn.
import { button, element, field } from "../../dom.js";
import { plain } from "./listening.js";

const STEPS = /** @type {const} */ ({ still: "Stand still, arms hanging", moving: "Move as in the library", result: "Result" });
const SAY = { ready: "Get ready", still: "Stand still", moving: "Move", solving: "Working it out" };
const CLASSES = /** @type {Record<string, string>} */ ({ good: "good", fair: "warn", "put it on again": "bad", "not heard": "note" });

export class Calibration {
  #running = false;

  /**
   * @param {import("../../studio.js").App} app
   * @param {import("./listening.js").Listening} listening
   * @param {(layout: string) => void} use takes the layout that was written
   */
  constructor(app, listening, use) {
    this.app = app;
    this.listening = listening;
    this.use = use;
    this.from = element("select", {}, element("option", { value: "live" }, "Live, as above"), element("option", { value: "file" }, "The readings file"));
    this.from.addEventListener("change", () => this.#write());
    const number = (/** @type {number} */ value) => element("input", { type: "number", min: "0", max: "120", step: "0.5", value });
    this.ready = number(3);
    this.standing = number(4);
    this.moving = number(20);
    this.first = number(0);
    this.last = number(3);
    this.liveFields = element("div", { class: "group" }, field("Get ready", this.ready, "s"), field("Stand still", this.standing, "s"), field("Move", this.moving, "s"));
    this.fileFields = element("div", { class: "group" }, field("Stands still from", this.first, "s"), field("until", this.last, "s"));
    this.button = button("Calibrate", () => (this.#running ? this.#stop() : this.#start()));
    this.steps = element("ol", { class: "steps" }, Object.entries(STEPS).map(([step, text]) => element("li", { "data-step": step }, text)));
    this.count = element("p", { class: "countdown", role: "timer", "aria-live": "off", hidden: true });
    this.result = element("div", { class: "calibrated", role: "status" });
    this.element = element(
      "section",
      { "aria-label": "Calibration" },
      element("h2", {}, "Calibration"),
      this.steps,
      field("From", this.from),
      this.liveFields,
      this.fileFields,
      element("div", { class: "buttons" }, this.button),
      this.count,
      this.result,
    );
    app.connection.on("calibration_step", (message) => this.#step(message));
    app.connection.on("calibrated", (message) => this.#done(message));
    app.connection.on("failed", (message) => message.section === "sensors" && this.#running && this.#end());
    this.#write();
  }

  #write() {
    this.liveFields.hidden = this.from.value !== "live";
    this.fileFields.hidden = this.from.value === "live";
  }

  #start() {
    const live = this.from.value === "live";
    const source = live ? this.listening.source : (this.app.store.project.sensors?.readings ?? "");
    if (!source || source.startsWith("take:")) return this.app.say("choose a readings file to calibrate on", "error");
    const [ready, standing, moving, first, last] = [this.ready, this.standing, this.moving, this.first, this.last].map((input) => Number(input.value));
    const how = live ? { ready, standing, moving } : last > first ? { still: [first, last] } : {};
    this.listening.ended(); // one thing runs at a time
    this.listening.clear();
    this.app.connection.send({ kind: "calibrate", source, ...how });
    this.#running = true;
    this.button.textContent = "Stop calibrating";
    this.result.replaceChildren();
    this.app.say("");
  }

  /** Stops, as where the section is left. */
  stop() {
    if (this.#running) this.#stop();
  }

  #stop() {
    this.app.connection.send({ kind: "stop_run" });
    this.#end();
  }

  #end() {
    this.#running = false;
    this.button.textContent = "Calibrate";
    this.count.hidden = true;
    this.#mark("");
  }

  /** @param {import("../../messages.js").CalibrationStep} message */
  #step({ step, left }) {
    this.count.hidden = false;
    const seconds = step === "solving" ? [] : [element("span", { class: "seconds" }, Math.ceil(left)), " s"];
    this.count.replaceChildren(element("span", {}, SAY[step]), element("span", {}, ...seconds));
    this.#mark({ ready: "still", still: "still", moving: "moving", solving: "result" }[step]);
  }

  /** @param {string} current */
  #mark(current) {
    for (const item of this.steps.children) {
      const at = /** @type {HTMLElement} */ (item);
      if (at.dataset.step === current) at.setAttribute("aria-current", "step");
      else at.removeAttribute("aria-current");
    }
  }

  /** @param {import("../../messages.js").Calibrated} message */
  #done({ layout, rows }) {
    this.#end();
    this.#mark("result");
    const cells = rows.map((row) =>
      element(
        "tr",
        { title: details(row) },
        element("th", { scope: "row" }, plain(row.sensor)),
        element("td", { class: CLASSES[row.verdict] ?? "" }, row.verdict),
      ),
    );
    const again = rows.filter((row) => row.verdict === "put it on again");
    this.result.replaceChildren(
      element("table", {}, element("caption", { class: "hidden-text" }, "How each sensor is worn"), element("tbody", {}, cells)),
      ...again.map((row) => element("p", {}, `The ${plain(row.sensor)} reads like the ${plain(row.other ?? "")}: is it on the right limb?`)),
      element("p", { class: "note" }, outcome(layout, again.length > 0)),
      ...(layout && again.length ? [element("div", { class: "buttons" }, button("Use it all the same", () => this.use(layout)))] : []),
    );
    if (layout && !again.length) this.use(layout);
  }
}

/** @param {import("../../messages.js").CalibratedRow} row */
function details(row) {
  if (row.verdict === "not heard") return "no readings";
  return `residual ${row.residual?.toFixed(1)} m/s², ${row.before?.toFixed(1)} before; rotated ${row.rotated?.toFixed(0)}°; halves ${row.apart?.toFixed(0)}° apart`;
}

/**
 * @param {string} layout
 * @param {boolean} again whether a sensor is to be put on again
 */
function outcome(layout, again) {
  if (!layout) return "The sensors are worn as the layout says, or the movement was another: nothing was saved.";
  return again ? `Saved as ${layout}. Put the sensor right and calibrate again.` : `Saved as ${layout}, which is used from now on.`;
}
