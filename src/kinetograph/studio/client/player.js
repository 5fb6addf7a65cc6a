// The stand-alone player: clips in a page of their own, which asks nothing of any network.
import { loadClip } from "./body.js";
import { button, element, iconButton, press, themeButton } from "./dom.js";
import { Stage } from "./stage.js";
import { Timeline } from "./timeline.js";
import { Transport } from "./transport.js";

/**
 * A clip of the page.
 *
 * @typedef {object} Shown
 * @property {string} name
 * @property {string} glb in base64
 * @property {number} floor height of the ground, metres
 * @property {import("./timeline.js").Lane[]} lanes
 * @property {[string, string][]} figures what is said about it: a name and a value
 * @property {string[]} notes what a person should know, a line each
 *
 * @typedef {{title: string, clips: Shown[]}} Page
 */

/** Plays the clips of a page. */
class Player {
  /** @type {import("./body.js").Clip | null} */
  clip = null;
  #following = false;

  /** @param {Page} page */
  constructor(page) {
    this.page = page;
    const main = element("main", { class: "stage", "aria-label": "Stage" });
    this.transport = new Transport();
    this.timeline = new Timeline();
    this.followButton = iconButton("follow", "Follow the body", () => this.follow(!this.#following), { pressed: false });
    this.views = this.#viewButtons();
    this.about = element("div", { class: "overlay about" });
    document.body.classList.add("player");
    document.body.append(
      this.#bar(),
      main,
      element("footer", { class: "timeline" }, element("div", { class: "controls" }, this.transport.element, this.timeline.zoomButtons), this.timeline.element),
    );
    this.stage = new Stage(main);
    main.append(this.views, this.about);
    this.transport.on("time", (time) => this.#seek(time));
    this.timeline.on("seek", (time) => this.transport.seek(time));
    this.timeline.on("pick", ({ span }) => this.transport.seek(span.start));
    this.stage.follow(() => (this.#following && this.clip ? this.clip.root(this.transport.time) : null));
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
    this.stage.floor = shown.floor;
    this.stage.add(clip.object);
    this.stage.frame(clip.box());
    this.timeline.lanes = shown.lanes;
    this.timeline.setDuration(clip.duration, clip.fps);
    this.transport.setClip(clip.duration, clip.fps);
    this.transport.seek(0);
    this.#tell(shown);
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
    this.stage.render();
  }

  /** @param {Shown} shown */
  #tell(shown) {
    const figures = shown.figures.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]);
    this.about.replaceChildren(
      figures.length ? element("dl", { class: "figures" }, figures) : "",
      ...shown.notes.map((note) => element("p", { class: "warn" }, note)),
    );
  }

  #bar() {
    const { title, clips } = this.page;
    const choice = element(
      "select",
      { "aria-label": "Clip", onchange: () => this.show(Number(choice.value)) },
      clips.map((clip, i) => element("option", { value: i }, clip.name)),
    );
    return element("header", { class: "bar" }, element("h1", { class: "title" }, title), clips.length > 1 && choice, element("span", { class: "spacer" }), themeButton());
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
 * @param {string} base64
 * @returns {ArrayBuffer}
 */
function bytes(base64) {
  return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0)).buffer;
}

const player = new Player(JSON.parse(document.getElementById("clips")?.textContent ?? '{"title": "", "clips": []}'));
Object.assign(window, { kinetograph: { pose: (/** @type {number} */ seconds) => player.clip?.pose(seconds) ?? {} } });
await player.show(0);
