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
    for (const file of event.dataTransfer?.files ?? []) void take(app, file);
  });
}

/**
 * Takes a file for what it is; where that can be several things, the person is asked.
 *
 * @param {Host} app
 * @param {File} file
 */
async function take(app, file) {
  const role = roleOf(file.name, app.store.mode);
  const { skins, animations } = role === "character" ? await contents(file) : { skins: 0, animations: 0 };
  if (animations) offer(app, file, skins ? "It holds a body and a motion." : "It holds a motion and no body.", skins > 0);
  else void dropFile(app, file, role);
}

/**
 * How many skins and animations a glTF file has; none where it cannot be read, which the server says.
 *
 * @param {File} file
 */
async function contents(file) {
  try {
    const start = new DataView(await file.slice(0, 20).arrayBuffer());
    const binary = start.getUint32(0, true) === 0x46546c67;
    const text = await (binary ? file.slice(20, 20 + start.getUint32(12, true)) : file).text();
    const { skins = [], animations = [] } = JSON.parse(text);
    return { skins: skins.length, animations: animations.length };
  } catch {
    return { skins: 0, animations: 0 };
  }
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
    app.say(/** @type {Error} */ (error).message, "error");
  }
}

/**
 * Asks what a file is to be.
 *
 * @param {Host} app
 * @param {File} file
 * @param {string} reason
 * @param {boolean} body whether it has one
 */
function offer(app, file, reason, body) {
  const as = (/** @type {string} */ role, /** @type {string} */ name) =>
    button(name, () => {
      dialog.close();
      void dropFile(app, file, role);
    });
  const dialog = element(
    "dialog",
    { "aria-labelledby": "offer-title", onclose: () => dialog.remove() },
    element("h2", { id: "offer-title" }, file.name),
    element("p", {}, reason),
    element(
      "div",
      { class: "buttons offer" },
      body && as("character", "Wear the body"),
      as("recording", "Add the motion to the library"),
      as("leader", "Use it as a leader"),
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
