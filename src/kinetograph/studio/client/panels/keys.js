// The panel of keys.
import { element } from "../dom.js";

/**
 * @param {import("../studio.js").App} app
 * @returns {import("../studio.js").Panel}
 */
export function createKeys(app) {
  void app;
  return { element: element("div", { class: "keys" }), enter() {}, leave() {}, shown() {} };
}
