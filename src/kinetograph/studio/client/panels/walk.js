// The panel of walk.
import { element } from "../dom.js";

/**
 * @param {import("../studio.js").App} app
 * @returns {import("../studio.js").Panel}
 */
export function createWalk(app) {
  void app;
  return { element: element("div", { class: "walk" }), enter() {}, leave() {}, shown() {} };
}
