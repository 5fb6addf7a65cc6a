// The stand-alone player: clips in a page of their own, which asks nothing of any network.
import { Vector3 } from "three";
import { loadClip } from "./stage/body.js";
import { button, element, iconButton, press, themeButton } from "./dom.js";
import { lanesOf } from "./time/lanes.js";
import { Stage } from "./stage/stage.js";
import { Timeline } from "./time/timeline.js";
import { Transport } from "./time/transport.js";

/**
 * A clip of the page; see `kinetograph.studio.sharing`.
 *
 * @typedef {object} SharedClip
 * @property {string} name
 * @property {string} glb in base64
 * @property {number} floor height of the ground, metres
 * @property {import("./messages.js").PieceRow[]} [pieces]
 * @property {import("./messages.js").Lane[]} [lanes]
 * @property {import("./messages.js").Figure[]} [figures]
 * @property {string[]} [warnings]
 *
 * @typedef {{title: string, clips: SharedClip[]}} SharedPage
 */

const FAR = 4; // metres that a body goes from which on the camera goes along

/** Plays the clips of a page. */
class Player {
  /** @type {import("./stage/body.js").Clip | null} */
  clip = null;
  #following = false;
  #told = 0;
  /** @type {import("./messages.js").PieceRow[]} */
  #pieces = [];
  source = element("dd");

  /** @param {SharedPage} page */
  constructor(page) {
    this.page = page;
    const main = element("main", { class: "stage", "aria-label": "Stage" });
    this.transport = new Transport();
    this.timeline = new Timeline();
    this.followButton = iconButton("follow", "Follow the body", () => this.follow(!this.#following), { pressed: false });
    this.views = this.#viewButtons();
    this.about = element("div", { class: "overlay about" });
    const bare = !page.title && page.clips.length < 2;
    document.body.append(
      ...(bare ? [] : [this.#bar()]),
      main,
      element("footer", { class: "timeline" }, element("div", { class: "controls" }, this.transport.element, this.timeline.zoomButtons), this.timeline.element),
    );
    this.stage = new Stage(main);
    if (bare) this.views.append(themeButton());
    main.append(this.views, this.about);
    this.transport.on("time", (time) => this.#seek(time));
    this.timeline.on("seek", (time) => this.transport.seek(time));
    this.timeline.on("pick", ({ span }) => this.transport.seek(span.start));
    this.stage.follow(() => (this.#following && this.clip ? middle(this.clip, this.transport.time) : null));
  }

  /**
   * Shows a clip of the page.
   *
   * @param {number} index
   */
  async show(index) {
    const shown = this.page.clips[index];
    document.body.dataset.state = "solving";
    const clip = await loadClip(bytes(shown.glb));
    this.clip?.dispose();
    this.clip = clip;
    this.#pieces = shown.pieces ?? [];
    this.stage.floor = shown.floor;
    this.stage.add(clip.object);
    this.stage.path(clip.figures.map((_, character) => clip.path(character)));
    this.#name(shown.name);
    this.timeline.setDuration(clip.duration, clip.fps);
    this.timeline.setLanes(lanesOf(shown));
    this.transport.setClip(clip.duration, clip.fps);
    this.transport.seek(0);
    this.#tell(shown);
    this.stage.frame(clip.box());
    this.follow(clip.box().getSize(new Vector3()).setY(0).length() > FAR);
    document.body.dataset.state = "ready";
  }

  /** @param {boolean} following */
  follow(following) {
    this.#following = following;
    press(this.followButton, following);
    if (following) this.stage.closeUp();
    else if (this.clip) this.stage.frame(this.clip.box());
    this.stage.render();
  }

  /** @param {number} time */
  #seek(time) {
    this.clip?.seek(time);
    this.timeline.setTime(time);
    this.#tellSource();
    this.stage.render();
  }

  /** @param {SharedClip} shown */
  #tell(shown) {
    const figures = (shown.figures ?? []).flatMap(({ name, value, title }) => [element("dt", { title }, name), element("dd", {}, value)]);
    const notes = shown.warnings ?? [];
    const lines = notes.map((note) => element("p", {}, note));
    this.about.replaceChildren(
      element("dl", { class: "figures" }, figures, shown.pieces && [element("dt", {}, "recording"), this.source]),
      notes.length > 1 ? element("details", { class: "notes" }, element("summary", {}, `${notes.length} notes`), lines) : "",
      ...(notes.length > 1 ? [] : lines),
    );
  }

  /** Says which recording the pose that is shown comes from; ten times a second, as drawing text takes its time. */
  #tellSource() {
    const now = performance.now();
    if (this.transport.playing && now - this.#told < 100) return;
    this.#told = now;
    const time = this.transport.time;
    const piece = this.#pieces.filter(({ start }) => start <= time + 1e-6).at(-1);
    if (!piece) return;
    const share = Math.min((time - piece.start) / (piece.stop - piece.start || 1), 1);
    const second = piece.source_start + share * (piece.source_stop - piece.source_start);
    this.source.textContent = `${piece.take}, ${second.toFixed(2)} s${piece.mirrored ? ", mirrored" : ""}`;
  }

  /** @param {string} name */
  #name(name) {
    this.stage.canvas.setAttribute("aria-label", `${name}. Control and arrow keys orbit, plus and minus come nearer and go away.`);
  }

  #bar() {
    const { title, clips } = this.page;
    const choice = element(
      "select",
      { "aria-label": "Clip", onchange: () => this.show(Number(choice.value)) },
      clips.map((clip, i) => element("option", { value: i }, clip.name)),
    );
    return element("header", { class: "bar" }, title && element("h1", { class: "title" }, title), clips.length > 1 && choice, element("span", { class: "spacer" }), themeButton());
  }

  #viewButtons() {
    const views = /** @type {const} */ ({ corner: "Corner", front: "Front", side: "Side", top: "Top" });
    const buttons = Object.entries(views).map(([from, name]) =>
      button(name, () => this.stage.view(/** @type {keyof typeof views} */ (from)), { title: `Look from the ${name.toLowerCase()}` }),
    );
    return element("div", { class: "views", role: "group", "aria-label": "Camera" }, buttons, this.followButton);
  }
}

/**
 * Where all characters are, on average.
 *
 * @param {import("./stage/body.js").Clip} clip
 * @param {number} time
 * @returns {[number, number, number]}
 */
function middle(clip, time) {
  const roots = clip.characters.map((_, character) => clip.root(time, character));
  const mean = (/** @type {0 | 1 | 2} */ axis) => roots.reduce((sum, root) => sum + root[axis], 0) / roots.length;
  return [mean(0), mean(1), mean(2)];
}

/**
 * @param {string} base64
 * @returns {ArrayBuffer}
 */
function bytes(base64) {
  return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0)).buffer;
}

const player = new Player(JSON.parse(document.getElementById("clips")?.textContent ?? '{"title": "", "clips": []}'));
Object.assign(window, {
  kinetograph: {
    pose: (/** @type {number} */ seconds) => player.clip?.pose(seconds) ?? {},
    clip: () => player.clip,
    drawn: () => player.stage.drawn,
    still: () => player.stage.isStill,
  },
});
await player.show(0);
