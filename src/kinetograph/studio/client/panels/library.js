// The panel of library.
import { element } from "../dom.js";

/**
 * @param {import("../studio.js").App} app
 * @returns {import("../studio.js").Panel}
 */
export function createLibrary(app) {
  void app;
  return { element: element("div", { class: "library" }), enter() {}, leave() {}, shown() {} };
}
