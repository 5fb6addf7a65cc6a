// The library browser: takes with moving thumbnails, found by words, tags and example, put on the stage and keyed; and
// the character that is worn.
import { loadClip } from "../../stage/body.js";
import { Cards } from "../walk/cards.js";
import { button, element, field, isTyping, press } from "../../dom.js";
import { dropFile } from "../../dropping.js";
import { Thumbnails } from "./thumbnails.js";

/** @typedef {import("../walk/cards.js").Card} Card */

const PAUSE = 150; // milliseconds after typing before the search
const EXAMPLE = 2; // seconds of an example
const TAGS = 40; // shown at most
const MOTIONS = ".bvh,.fbx,.glb,.gltf,.amc,.c3d,.npz,.usd,.usda,.usdc,.txt,.json,.csv";

/**
 * @param {import("../../studio.js").App} app
 * @returns {import("../../studio.js").Panel}
 */
export function createLibrary(app) {
  const browser = new Browser(app);
  return { element: browser.element, enter: () => browser.enter(), leave: () => browser.leave(), shown() {} };
}

class Browser {
  #open = false;
  #search = 0; // these two count, so that an answer that comes late is left
  #showing = 0;
  #timer = 0;
  /** @type {Map<string, number>} takes of each library, when they were last counted */
  #counts = new Map();
  /** @type {Set<string>} */
  #tags = new Set();
  /** @type {string} the take on the stage */
  #take = "";
  /** Whether cards are those of a search by example. */
  #alike = false;

  /** @param {import("../../studio.js").App} app */
  constructor(app) {
    this.app = app;
    this.libraries = element("select", { onchange: () => this.#another() });
    this.words = element("input", { type: "search", placeholder: "Name or tag, walk* for a pattern", "aria-label": "Search", oninput: () => this.#later() });
    this.tags = element("div", { class: "tags", role: "group", "aria-label": "Tags" });
    this.found = element("p", { class: "note", role: "status" });
    this.back = button("All takes", () => this.#find(), { class: "small" });
    this.thumbnails = new Thumbnails((takes) => app.connection.ask({ kind: "ask_thumbnails", takes, library: this.library }));
    this.cards = new Cards(this.thumbnails);
    this.keyButton = button("Set key", () => this.#key(), { title: "A key of the pose that is shown (K)", "aria-keyshortcuts": "K" });
    this.alikeButton = button("More like this", () => void this.#findAlike(), { title: "Takes with something like the two seconds around the time that is shown" });
    this.file = element("input", { type: "file", accept: MOTIONS, multiple: true, hidden: true, "aria-label": "Recordings from files", onchange: () => this.#drop(this.file, "recording") });
    this.character = element("select", { onchange: () => this.#wear(this.character.value) });
    this.body = element("input", { type: "file", accept: ".glb,.gltf", hidden: true, "aria-label": "Character from a file", onchange: () => this.#drop(this.body, "character") });
    this.element = element(
      "div",
      { class: "library" },
      element("h2", {}, "Library"),
      field("Library", this.libraries),
      this.words,
      this.tags,
      element("div", { class: "found" }, this.found, this.back),
      this.cards.element,
      element("div", { class: "buttons" }, this.keyButton, this.alikeButton, button("Add…", () => this.file.click(), { title: "Add recordings from files" }), this.file),
      field("Character", this.character, button("File…", () => this.body.click(), { title: "A .glb file with a skin" }), this.body),
    );
    this.#listen();
  }

  get library() {
    return this.libraries.value;
  }

  enter() {
    this.#open = true;
    this.#fill();
    void this.#find();
  }

  leave() {
    this.#open = false;
    this.#take = "";
    this.app.endPreview();
  }

  #listen() {
    const { app } = this;
    this.cards.on("choose", (card) => void this.#show(card));
    this.cards.on("need", ({ first, count }) => void this.#page(first, count));
    app.store.on("welcome", () => this.#welcomed());
    app.store.on("project", ({ character = "" }) => (this.character.value = character));
    app.store.on("made", () => this.#buttons());
    document.addEventListener("keydown", (event) => this.#pressed(event), true); // before the section's own keys
    this.#buttons();
  }

  /** Shows the library that has more takes than before, such as that of a recording that was dropped. */
  #welcomed() {
    const rows = this.app.store.welcome?.libraries ?? [];
    const grown = rows.find((row) => row.takes > (this.#counts.get(row.name) ?? 0));
    const known = this.#counts.size > 0;
    this.#counts = new Map(rows.map((row) => [row.name, row.takes]));
    const { value } = this.libraries;
    this.#fill();
    if (grown && known && this.#open) this.libraries.value = grown.name;
    if (this.#open && ((grown && known) || value !== this.libraries.value)) this.#another();
  }

  /** Lists the libraries and the characters. */
  #fill() {
    const { welcome, project } = this.app.store;
    const { value } = this.libraries;
    const rows = welcome?.libraries ?? [];
    this.libraries.replaceChildren(...rows.map((row) => element("option", { value: row.name }, `${row.name}, ${row.takes} takes`)));
    if (rows.some((row) => row.name === value)) this.libraries.value = value;
    const bodies = (welcome?.files ?? []).filter((name) => /\.gl(b|tf)$/i.test(name));
    const names = [["", "Capsules"], ["human", "Human"], ...bodies.map((name) => [name, name])];
    this.character.replaceChildren(...names.map(([value, name]) => element("option", { value }, name)));
    this.character.value = project.character ?? "";
  }

  #another() {
    this.#tags.clear();
    this.thumbnails.clear();
    void this.#find();
  }

  #later() {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => void this.#find(), PAUSE);
  }

  /** Lists what has the words and tags. */
  async #find() {
    const search = (this.#search += 1);
    this.#alike = false;
    this.back.hidden = true;
    const answer = await this.#ask(0, 200);
    if (!answer || search !== this.#search) return;
    const { found, all, rows, tags } = answer;
    this.found.textContent = found === all ? `${all} takes` : `${found} of ${all} takes`;
    this.#showTags(tags);
    this.cards.setCount(found, this.#take);
    this.cards.set(0, rows.map(cardOf));
  }

  /**
   * @param {number} first
   * @param {number} count
   */
  async #page(first, count) {
    if (this.#alike) return;
    const search = this.#search;
    const answer = await this.#ask(first, count);
    if (answer && search === this.#search) this.cards.set(first, answer.rows.map(cardOf));
  }

  /**
   * @param {number} first
   * @param {number} count
   * @returns {Promise<import("../../messages.js").Takes | null>}
   */
  async #ask(first, count) {
    try {
      const { library, words } = this;
      return await this.app.connection.ask({ kind: "ask_takes", library, words: words.value, tags: [...this.#tags], first, count });
    } catch (error) {
      this.#fail(error);
      return null;
    }
  }

  /** @param {[string, number][]} tags */
  #showTags(tags) {
    const often = [...tags].sort((a, b) => b[1] - a[1]).slice(0, TAGS);
    const focused = document.activeElement?.getAttribute("data-tag");
    this.tags.hidden = often.length === 0;
    this.tags.replaceChildren(
      ...often.map(([tag, count]) => {
        const made = button(tag, () => this.#toggle(tag), { class: "tag", pressed: this.#tags.has(tag), "data-tag": tag, title: `${count} takes` });
        return made;
      }),
    );
    if (focused) /** @type {HTMLElement | null} */ (this.tags.querySelector(`[data-tag="${CSS.escape(focused)}"]`))?.focus();
  }

  /** @param {string} tag */
  #toggle(tag) {
    if (!this.#tags.delete(tag)) this.#tags.add(tag);
    for (const each of this.tags.children) press(/** @type {HTMLElement} */ (each), this.#tags.has(each.getAttribute("data-tag") ?? ""));
    void this.#find();
  }

  /**
   * Puts a take on the stage.
   *
   * @param {Card} card
   */
  async #show(card) {
    const { app, library } = this;
    const showing = (this.#showing += 1);
    try {
      if (this.#take !== card.take) {
        const { header, payload } = await app.connection.ask({ kind: "ask_clip", take: card.take, library });
        const clip = await loadClip(payload);
        if (!this.#open || showing !== this.#showing) return clip.dispose();
        this.#take = card.take;
        app.preview(clip, header.floor ?? 0, []);
        app.stage.frame(clip.box());
        app.transport.seek(0);
      }
      const { span } = card;
      app.timeline.setLanes(span ? [{ name: "alike", kind: "moves", spans: [{ ...span, label: card.detail }] }] : []);
      if (span) app.transport.seek(span.start);
      app.say(`${card.take}: scrub it on the timeline, K sets a key`);
    } catch (error) {
      this.#fail(error);
    }
    this.#buttons();
  }

  /** Lists what is like the seconds around the time that is shown. */
  async #findAlike() {
    const { app, library } = this;
    const { time, duration } = app.transport;
    const start = Math.max(Math.min(time - EXAMPLE / 2, duration - EXAMPLE), 0);
    const stop = Math.min(start + EXAMPLE, duration);
    const search = (this.#search += 1);
    this.#alike = true;
    this.found.textContent = "comparing";
    try {
      const { rows } = await app.connection.ask({ kind: "ask_alike", take: this.#take, start, stop, library });
      if (search !== this.#search) return;
      const of = this.#take || "what is shown";
      this.found.textContent = `like ${of}, ${start.toFixed(1)} to ${stop.toFixed(1)} s`;
      this.back.hidden = false;
      this.cards.setCount(rows.length, this.#take);
      this.cards.set(0, rows.map(foundCard));
    } catch (error) {
      this.#fail(error);
    }
  }

  /** @param {KeyboardEvent} event */
  #pressed(event) {
    if (!this.#open || isTyping(event) || event.ctrlKey || event.metaKey || event.altKey || event.key.toLowerCase() !== "k") return;
    event.preventDefault();
    event.stopPropagation();
    this.#key();
  }

  #key() {
    const { app } = this;
    if (!this.#take) return app.say("put a take on the stage first: choose it in the library");
    if (!app.keys?.add) return app.say("keys cannot be set here", "error");
    app.keys.add(this.#take, app.transport.time, this.library);
    app.say(`a key of ${this.#take} at ${app.transport.time.toFixed(2)} s`);
  }

  /**
   * @param {HTMLInputElement} input
   * @param {string} role
   */
  #drop(input, role) {
    const host = /** @type {import("../../dropping.js").Host} */ (/** @type {unknown} */ (this.app));
    for (const file of input.files ?? []) void dropFile(host, file, role);
    input.value = "";
  }

  /** @param {string} name */
  #wear(name) {
    this.app.connection.edit("character", name, { label: `wear ${name || "capsules"}` });
  }

  #buttons() {
    this.keyButton.disabled = !this.#take;
    this.alikeButton.disabled = !this.#take && !this.app.store.made;
  }

  /** @param {unknown} error */
  #fail(error) {
    this.found.textContent = "";
    this.app.say(/** @type {Error} */ (error).message, "error");
  }
}

/**
 * @param {import("../../messages.js").TakeRow} row
 * @returns {Card}
 */
function cardOf({ name, seconds, tracks, tags }) {
  const title = [name, ...(tracks.length > 1 ? [tracks.join(", ")] : []), ...tags].join("\n");
  return { take: name, detail: `${seconds.toFixed(1)} s${tags.length ? `, ${tags.join(", ")}` : ""}`, title };
}

/**
 * @param {import("../../messages.js").FoundRow} row
 * @returns {Card}
 */
function foundCard({ take, track, start, stop, distance }) {
  const detail = `${start.toFixed(1)} to ${stop.toFixed(1)} s, ${(100 * distance).toFixed(0)} cm`;
  return { take, detail, title: `${take}, ${track}\n${detail} away`, span: { start, stop } };
}
