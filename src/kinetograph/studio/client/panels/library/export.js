// The export dialog: which files are written of what is shown, how far it is, and the files.
import { button, element, field } from "../../dom.js";

/** What people call the formats, by suffix, in groups. */
const GROUPS = /** @type {const} */ ({
  Motion: { ".bvh": "BVH", ".glb": "GLB", ".fbx": "FBX", ".usda": "USD, text", ".usdc": "USD, binary" },
  Numbers: { ".npz": "NumPy arrays", ".csv": "Table of positions" },
  Film: { ".gif": "GIF", ".mp4": "MP4" },
  Reports: { ".png": "Contact sheet, PNG", ".json": "Report, JSON" },
});
const SEVERAL = [".glb", ".fbx", ".usda", ".usdc", ".npz", ".gif", ".mp4"]; // hold several bodies
const NO_VIDEO = "MP4 needs ffmpeg: install it, or pip install imageio-ffmpeg";

/**
 * @param {import("../../studio.js").App} app
 * @returns {import("../../studio.js").Panel}
 */
export function createExport(app) {
  const made = new ExportDialog(app);
  return { element: made.dialog, enter: () => made.open(), leave: () => made.dialog.close(), shown() {} };
}

class ExportDialog {
  #writing = false;

  /** @param {import("../../studio.js").App} app */
  constructor(app) {
    this.app = app;
    this.name = element("input", { type: "text", autocomplete: "off", spellcheck: "false", required: true, maxlength: 80 });
    this.together = element("input", { type: "checkbox", id: "export-together" });
    this.togetherLine = element("div", { class: "check" }, this.together, element("label", { for: "export-together" }, "With the other bodies that are shown"));
    this.groups = element("div", { class: "export-groups" });
    this.progress = element("progress", { max: 1, value: 0, "aria-label": "Writing files" });
    this.outcome = element("div", { class: "export-outcome", role: "status" });
    this.write = button("Write files", undefined, { type: "submit", class: "primary" });
    this.stop = button("Stop", () => app.connection.send({ kind: "stop_run" }));
    this.form = element(
      "form",
      { method: "dialog", onsubmit: (/** @type {Event} */ event) => (event.preventDefault(), void this.#write()) },
      element("h2", { id: "export-title" }, "Export"),
      field("Name", this.name),
      this.groups,
      this.togetherLine,
      this.progress,
      this.outcome,
      element("div", { class: "buttons export-buttons" }, button("Close", () => this.dialog.close()), this.stop, this.write),
    );
    this.dialog = element("dialog", { class: "export", "aria-labelledby": "export-title" }, this.form);
    document.body.append(this.dialog);
    app.connection.on("working", (message) => this.#working(message));
    this.#show(false);
  }

  /** Opens the dialog; the browser keeps the focus in it, and gives it back when it is closed. */
  open() {
    if (this.dialog.open) return;
    if (!this.groups.childElementCount) this.#offer();
    if (!this.#writing) this.outcome.replaceChildren();
    this.name.value ||= this.app.store.mode;
    this.togetherLine.hidden = (this.app.store.made?.characters ?? []).length < 2;
    this.dialog.showModal();
    this.name.select();
  }

  /** Offers the formats that the server can write. */
  #offer() {
    const { welcome } = this.app.store;
    const known = new Set([...(welcome?.formats ?? []), ...(welcome?.films ?? []), ".png", ".json"]);
    this.groups.replaceChildren(
      ...Object.entries(GROUPS).map(([title, formats]) =>
        element(
          "fieldset",
          {},
          element("legend", {}, title),
          Object.entries(formats).filter(([suffix]) => known.has(suffix)).map(([suffix, name]) => check(suffix, name)),
          title === "Film" && !known.has(".mp4") && element("p", { class: "note" }, NO_VIDEO),
        ),
      ),
    );
  }

  #chosen() {
    return [...this.groups.querySelectorAll("input")].filter((input) => input.checked).map((input) => input.value);
  }

  async #write() {
    const formats = this.#chosen();
    if (!formats.length) return this.#say("Choose a format.", true);
    this.#show(true);
    this.#say("");
    const together = this.together.checked && !this.togetherLine.hidden && formats.some((suffix) => SEVERAL.includes(suffix));
    try {
      const answer = await this.app.connection.ask({ kind: "export", formats, name: this.name.value.trim(), together });
      this.#list(/** @type {import("../../messages.js").Exported} */ (answer));
    } catch (error) {
      this.#say(/** @type {Error} */ (error).message, true);
    }
    this.#show(false);
  }

  /** @param {import("../../messages.js").Exported} answer */
  #list({ files }) {
    const rows = files.map(([name, address]) => element("li", {}, element("a", { href: `${address}${location.search}`, download: name }, name)));
    this.outcome.replaceChildren(element("p", { class: "good" }, "Written to the project's folder exports:"), element("ul", { class: "files" }, rows));
    this.app.say(`wrote ${files.map(([name]) => name).join(", ")}`);
  }

  /** @param {import("../../messages.js").Working} message */
  #working({ done, total, section }) {
    if (this.#writing && !section && total > 1) this.progress.value = done / total;
  }

  /**
   * @param {string} text
   * @param {boolean} [wrong]
   */
  #say(text, wrong = false) {
    this.outcome.replaceChildren(...(text ? [element("p", { class: wrong ? "bad" : "note" }, text)] : []));
  }

  /** @param {boolean} writing */
  #show(writing) {
    this.#writing = writing;
    this.progress.value = 0;
    this.progress.style.visibility = writing ? "visible" : "hidden";
    if (!writing && document.activeElement === this.stop) this.write.focus();
    this.write.disabled = writing;
    this.stop.hidden = !writing;
    if (writing) this.stop.focus();
    else if (this.dialog.open && document.activeElement === document.body) this.write.focus();
  }
}

/**
 * @param {string} suffix
 * @param {string} name
 */
function check(suffix, name) {
  const id = `export-${suffix.slice(1)}`;
  const input = element("input", { type: "checkbox", id, value: suffix, checked: suffix === ".bvh" || suffix === ".glb" });
  return element("div", { class: "check" }, input, element("label", { for: id }, name));
}
