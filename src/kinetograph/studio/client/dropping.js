// Files dropped onto the page: what they are to be follows from their kind and from the section that is shown.

import { button, element } from "./dom.js";

/** @typedef {import("./studio.js").App & {panel: import("./studio.js").Panel}} Host */

/**
 * Takes files that are dropped.
 *
 * @param {Host} app
 */
export function dropFiles(app) {
  addEventListener("dragover", (event) => {
    event.preventDefault();
    document.body.classList.add("dropping");
  });
  addEventListener("dragleave", (event) => event.relatedTarget === null && document.body.classList.remove("dropping"));
  addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("dropping");
    for (const file of event.dataTransfer?.files ?? []) void dropFile(app, file, roleOf(file.name, app.store.mode));
  });
}

/**
 * Takes a file into the project.
 *
 * @param {Host} app
 * @param {File} file
 * @param {string} role
 */
export async function dropFile(app, file, role) {
  app.say(`taking ${file.name}`);
  try {
    const { name } = await app.connection.upload(file, role);
    app.say(`${name} is in the project`);
    if (role === "character") app.connection.edit("character", name, { label: `wear ${name}` });
    else app.panel.dropped?.(name, role);
  } catch (error) {
    const { message } = /** @type {Error} */ (error);
    app.say(message, "error");
    if (role === "character") offer(app, file, message);
  }
}

/**
 * Offers what else a file may be that is no character.
 *
 * @param {Host} app
 * @param {File} file
 * @param {string} reason
 */
function offer(app, file, reason) {
  const as = (/** @type {string} */ role) => {
    dialog.close();
    void dropFile(app, file, role);
  };
  const dialog = element(
    "dialog",
    { "aria-labelledby": "offer-title", onclose: () => dialog.remove() },
    element("h2", { id: "offer-title" }, `${file.name} is no character`),
    element("p", { class: "note" }, reason),
    element("p", {}, "If it holds a motion, it can be:"),
    element(
      "div",
      { class: "buttons offer" },
      button("A recording of the library", () => as("recording")),
      button("A leader to dance with", () => as("leader")),
      button("Leave it", () => dialog.close()),
    ),
  );
  document.body.append(dialog);
  dialog.showModal();
}

/**
 * What a file is to be.
 *
 * @param {string} name
 * @param {string} mode
 * @returns {string}
 */
export function roleOf(name, mode) {
  const suffix = name.slice(name.lastIndexOf(".")).toLowerCase();
  if (suffix === ".toml") return "layout";
  if (mode === "sensors" && suffix === ".csv") return "readings";
  if (mode === "duet") return "leader";
  return suffix === ".glb" || suffix === ".gltf" ? "character" : "recording";
}
