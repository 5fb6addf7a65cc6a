// The panel of duet.
import { element } from "../dom.js";

/**
 * @param {import("../studio.js").App} app
 * @returns {import("../studio.js").Panel}
 */
export function createDuet(app) {
  void app;
  return { element: element("div", { class: "duet" }), enter() {}, leave() {}, shown() {} };
}
