// The studio's page: joins the socket, the stage, the timeline and the panels.
import { Box3, Vector3 } from "three";
import { loadClip } from "./stage/body.js";
import { Connection } from "./connection.js";
import { button, element, iconButton, isTyping, press, themeButton } from "./dom.js";
import { dropFiles } from "./dropping.js";
import { lanesOf } from "./time/lanes.js";
import { createDuet } from "./panels/duet/duet.js";
import { createExport } from "./panels/library/export.js";
import { createKeys } from "./panels/keys/keys.js";
import { createLibrary } from "./panels/library/library.js";
import { createSensors } from "./panels/sensors/sensors.js";
import { createWalk } from "./panels/walk/walk.js";
import { Stage } from "./stage/stage.js";
import { Store } from "./store.js";
import { Timeline } from "./time/timeline.js";
import { Transport } from "./time/transport.js";

/**
 * @typedef {import("./messages.js").MadeHeader} MadeHeader
 * @typedef {import("./messages.js").Mode} Mode
 * @typedef {import("./stage/body.js").Clip} Clip
 *
 * @typedef {object} Panel a section's controls
 * @property {HTMLElement} element
 * @property {() => void} enter the section is shown from now on
 * @property {() => void} leave
 * @property {(made: MadeHeader | null, clip: Clip | null) => void} shown what was made is on the stage
 * @property {() => void} [press] the section's button was pressed while the section is shown
 * @property {(made: MadeHeader) => import("./time/timeline.js").Lane[]} [lanes] lanes above the others
 * @property {() => import("./stage/body.js").Positions | null} [pose] joints of a body that is live, in place of what was made
 * @property {() => [number, number, number] | null} [root] its root, which the camera stays with
 * @property {(name: string, role: string) => void} [dropped] a file was taken into the project
 *
 * @typedef {object} App what panels work with
 * @property {Connection} connection
 * @property {Store} store
 * @property {Stage} stage
 * @property {Transport} transport
 * @property {Timeline} timeline
 * @property {Clip | null} clip what is on the stage
 * @property {(text: string, kind?: "note" | "error") => void} say
 * @property {() => void} showLanes shows the lanes of what was made again
 * @property {(clip: Clip, floor: number, lanes: import("./time/timeline.js").Lane[]) => void} preview shows another clip meanwhile
 * @property {() => void} endPreview shows what was made again
 * @property {any} [keys] what the panel of keys offers to others
 */

const PATIENCE = 400; // milliseconds that something may take without a word

const MODES = /** @type {const} */ ({ walk: "Draw", keys: "Keys", duet: "Duet", sensors: "Sensors" });

/** @implements {App} */
class Studio {
  connection = new Connection();
  store = new Store(this.connection);
  timeline = new Timeline();
  transport = new Transport();
  /** @type {Clip | null} */
  clip = null;
  /** @type {any} */
  keys = null;
  /** @type {Clip | null} */
  #previewed = null;
  #following = false;
  #soon = 0; // what will say that something is being made, if it is not made by then
  #walked = ""; // the path that was walked last
  /** @type {Mode | null} */
  #shownMode = null;

  status = element("p", { class: "status", role: "status" });
  aside = element("aside", { class: "panel", "aria-label": "Panel" });
  figures = element("section", { class: "figures", "aria-label": "Figures" });
  modes = element("div", { class: "modes", role: "group", "aria-label": "Control" });
  libraryButton = button("Library", () => this.#toggleLibrary(), { pressed: false });
  undoButton = iconButton("undo", "Undo", () => this.connection.step("undo"), { disabled: true });
  redoButton = iconButton("redo", "Redo", () => this.connection.step("redo"), { disabled: true });
  exportButton = button("Export", () => this.exporting.enter(), { disabled: true });
  followButton = iconButton("follow", "Follow the body", () => this.#follow(!this.#following), { pressed: false });

  constructor() {
    for (const mode of /** @type {Mode[]} */ (Object.keys(MODES)))
      this.modes.append(button(MODES[mode], () => this.#choose(mode), { pressed: false, "data-mode": mode }));
    const main = element("main", { class: "stage", "aria-label": "Stage" });
    document.body.append(this.#bar(), main, this.aside, this.#footer(), this.status);
    this.stage = new Stage(main);
    this.stage.frame(new Box3(new Vector3(-3.5, 0, -3.5), new Vector3(3.5, 1.8, 3.5)));
    main.append(this.#views());
    this.library = createLibrary(this);
    this.exporting = createExport(this);
    /** @type {Record<Mode, Panel>} */
    this.panels = { walk: createWalk(this), keys: createKeys(this), duet: createDuet(this), sensors: createSensors(this) };
    this.#listen();
    dropFiles(this);
    this.connection.open();
  }

  /** The panel of the section that is shown. */
  get panel() {
    return this.panels[this.store.mode];
  }

  /**
   * Says something in the status line.
   *
   * @param {string} text
   * @param {"note" | "error"} [kind]
   */
  say(text, kind = "note") {
    clearTimeout(this.#soon);
    this.status.textContent = text;
    this.status.dataset.kind = kind;
  }

  /**
   * Shows another clip in place of what was made.
   *
   * @param {Clip} clip
   * @param {number} floor
   * @param {import("./time/timeline.js").Lane[]} lanes
   */
  preview(clip, floor, lanes) {
    this.#takeOff();
    this.#previewed = clip;
    this.#putOn(clip, floor);
    this.timeline.setLanes(lanes);
    this.stage.render();
  }

  /** Shows what was made again. */
  endPreview() {
    if (!this.#previewed) return;
    this.#takeOff();
    this.#previewed = null;
    const { made } = this.store;
    if (made && this.clip) this.#onStage(made, this.clip, true);
    else this.timeline.setLanes([]);
    this.stage.render();
  }

  /** Shows the lanes of what was made. */
  showLanes() {
    if (this.#previewed) return;
    const { made } = this.store;
    const own = made ? (this.panel.lanes?.(made) ?? []) : [];
    const others = made ? lanesOf(made).filter((lane) => !own.some(({ name }) => name === lane.name)) : [];
    this.timeline.setLanes([...own, ...others]);
  }

  /**
   * Joint names and world positions, metres, of what is shown.
   *
   * @param {number} seconds
   */
  pose(seconds) {
    return this.panel.pose?.() ?? this.#onView?.pose(seconds) ?? {};
  }

  #bar() {
    return element(
      "header",
      { class: "bar" },
      element("h1", { class: "title" }, "Kinetograph"),
      this.modes,
      element("span", { class: "rule" }),
      this.libraryButton,
      element("span", { class: "spacer" }),
      this.undoButton,
      this.redoButton,
      element("span", { class: "rule" }),
      this.exportButton,
      themeButton(),
    );
  }

  #footer() {
    return element(
      "footer",
      { class: "timeline" },
      element("div", { class: "controls" }, this.transport.element, this.timeline.zoomButtons),
      this.timeline.element,
    );
  }

  #views() {
    const view = (/** @type {import("./stage/stage.js").View} */ from, /** @type {string} */ name) =>
      button(name, () => this.stage.view(from), { "aria-label": `View from the ${from}` });
    return element("div", { class: "views" }, view("corner", "Corner"), view("front", "Front"), view("side", "Side"), view("top", "Top"), this.followButton);
  }

  #listen() {
    const { connection, store, stage, timeline, transport } = this;
    store.on("project", () => this.#projectChanged());
    store.on("state", (state) => {
      stage.busy = state === "drawing" || state === "solving";
      if (state === "drawing") transport.pause();
    });
    store.on("made", (made) => void this.#show(made));
    connection.on("working", (message) => this.#working(message));
    connection.on("failed", (message) => this.say(message.message, "error"));
    connection.on("said", (message) => this.say(message.message));
    connection.on("nothing", () => this.say(""));
    connection.on("closed", (reason) => this.say(`${reason}; trying again`, "error"));
    connection.on("open", () => this.say("connected"));
    transport.on("time", (time) => this.#seek(time));
    timeline.on("seek", (time) => transport.seek(time));
    stage.follow(() => this.panel.root?.() ?? (this.#following && this.#onView ? this.#onView.root(transport.time) : null));
    document.addEventListener("keydown", (event) => this.#key(event));
  }

  /** @param {Mode} mode */
  #choose(mode) {
    this.#toggleLibrary(false);
    if (mode === this.store.mode) this.panel.press?.();
    else {
      this.connection.edit("mode", mode, { label: `show ${MODES[mode].toLowerCase()}` });
      this.panel.press?.();
    }
  }

  #projectChanged() {
    const { mode, undo, redo } = this.store;
    this.undoButton.disabled = undo === null;
    this.undoButton.title = undo === null ? "Undo" : `Undo: ${undo}`;
    this.redoButton.disabled = redo === null;
    this.redoButton.title = redo === null ? "Redo" : `Redo: ${redo}`;
    for (const each of this.modes.children) press(/** @type {HTMLElement} */ (each), /** @type {HTMLElement} */ (each).dataset.mode === mode);
    if (mode === this.#shownMode) return;
    if (this.#shownMode) this.panels[this.#shownMode].leave();
    this.#shownMode = mode;
    this.aside.replaceChildren(this.panel.element, this.figures);
    this.panel.enter();
  }

  /** @param {boolean} [open] */
  #toggleLibrary(open = this.libraryButton.getAttribute("aria-pressed") !== "true") {
    if (open === (this.libraryButton.getAttribute("aria-pressed") === "true")) return;
    press(this.libraryButton, open);
    this.aside.replaceChildren(...(open ? [this.library.element] : [this.panel.element, this.figures]));
    if (open) this.library.enter();
    else this.library.leave();
  }

  /** @param {{header: MadeHeader, payload: ArrayBuffer} | null} made */
  async #show(made) {
    const clip = made ? await loadClip(made.payload) : null;
    if (made && made.header !== this.store.made) return void clip?.dispose(); // something newer was made meanwhile
    const first = this.clip === null;
    this.clip?.dispose();
    this.clip = clip;
    this.exportButton.disabled = clip === null;
    if (made && clip && !this.#previewed) this.#onStage(made.header, clip, first);
    else if (!this.#previewed) this.timeline.setLanes([]);
    this.#showFigures(made?.header ?? null);
    this.panel.shown(made?.header ?? null, clip);
    this.stage.render();
    this.store.shown();
  }

  /**
   * @param {MadeHeader} header
   * @param {Clip} clip
   * @param {boolean} first
   */
  #onStage(header, clip, first) {
    this.#putOn(clip, header.floor ?? 0);
    this.showLanes();
    if (first) this.stage.frame(clip.box());
    if (header.section === "walk") this.#setOff();
  }

  /** What the stage shows. */
  get #onView() {
    return this.#previewed ?? this.clip;
  }

  /**
   * @param {Clip} clip
   * @param {number} floor
   */
  #putOn(clip, floor) {
    this.stage.floor = floor;
    this.stage.add(clip.object);
    this.transport.setClip(clip.duration, clip.fps);
    this.timeline.setDuration(clip.duration, clip.fps);
    clip.seek(this.transport.time);
  }

  #takeOff() {
    if (this.#onView) this.stage.remove(this.#onView.object);
    if (this.#previewed) this.#previewed.dispose();
  }

  /** Walks a path that is new, unless it was there when the page was opened, or this person wants nothing to move. */
  #setOff() {
    const path = JSON.stringify(this.store.project.walk?.path);
    const drawn = path !== this.#walked && this.connection.edits > 0;
    this.#walked = path;
    if (!drawn) return;
    this.transport.seek(0);
    if (!matchMedia("(prefers-reduced-motion: reduce)").matches) this.transport.play();
  }

  /** @param {MadeHeader | null} made */
  #showFigures(made) {
    const figures = (made?.figures ?? []).map(({ name, value, title }) => element("div", { title }, element("dt", {}, name), element("dd", {}, value)));
    const warnings = (made?.warnings ?? []).map((text) => element("li", {}, text));
    this.figures.replaceChildren(
      ...(figures.length ? [element("h2", {}, "Figures"), element("dl", { class: "figures" }, figures)] : []),
      ...(warnings.length ? [element("ul", { class: "warnings", "aria-label": "Warnings" }, warnings)] : []),
    );
  }

  /** @param {number} time */
  #seek(time) {
    this.#onView?.seek(time);
    this.timeline.setTime(time);
    this.stage.render();
  }

  /** @param {boolean} following */
  #follow(following) {
    this.#following = following;
    press(this.followButton, following);
    this.stage.render();
  }

  /** @param {import("./messages.js").Working} message */
  #working(message) {
    if (message.done >= message.total) return this.say("");
    clearTimeout(this.#soon);
    if (this.status.querySelector("progress")) this.#showProgress(message);
    else this.#soon = setTimeout(() => this.store.state !== "ready" && this.#showProgress(message), PATIENCE);
  }

  /** @param {import("./messages.js").Working} message */
  #showProgress({ label, done, total, section }) {
    this.say("");
    const share = total > 0 ? done / total : 0;
    this.status.append(
      `${label} `,
      element("progress", { value: share, max: 1, "aria-label": label }),
      section ? button("Stop", () => this.connection.send({ kind: "cancel" }), { class: "small" }) : "",
    );
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (isTyping(event) || !(event.ctrlKey || event.metaKey) || event.altKey) return;
    const key = event.key.toLowerCase();
    const kind = key === "y" || (key === "z" && event.shiftKey) ? "redo" : key === "z" ? "undo" : null;
    if (!kind) return;
    event.preventDefault();
    if (this.store[kind] !== null) this.connection.step(kind);
  }
}

const studio = new Studio();
/** @type {any} */ (window).kinetograph = { pose: (/** @type {number} */ seconds) => studio.pose(seconds), studio };
