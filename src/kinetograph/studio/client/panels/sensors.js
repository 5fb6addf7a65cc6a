// The panel of sensors.
import { element } from "../dom.js";

/**
 * @param {import("../studio.js").App} app
 * @returns {import("../studio.js").Panel}
 */
export function createSensors(app) {
  void app;
  return { element: element("div", { class: "sensors" }), enter() {}, leave() {}, shown() {} };
}
