// Files dropped onto the page: what they are to be follows from their kind and from the section that is shown.

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
    app.say(/** @type {Error} */ (error).message, "error");
  }
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
