// The panel of export.
import { element } from "../dom.js";

/**
 * @param {import("../studio.js").App} app
 * @returns {import("../studio.js").Panel}
 */
export function createExport(app) {
  void app;
  return { element: element("div", { class: "export" }), enter() {}, leave() {}, shown() {} };
}
