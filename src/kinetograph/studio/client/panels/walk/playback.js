// A take of the library on the ground at its own pace, to get a sense of speed before drawing.
import { loadClip } from "../../stage/body.js";
import { button, element, field, press } from "../../dom.js";

const GHOST = 0.5;

export class Playback {
  /** @type {import("../../stage/body.js").Clip | null} */
  #clip = null;
  #begun = 0;
  #wanted = 0;

  /**
   * @param {import("../../studio.js").App} app
   * @param {import("./path_view.js").PathView} view
   */
  constructor(app, view) {
    this.app = app;
    this.view = view;
    this.takes = element("select", { onchange: () => this.playing && void this.#play() });
    this.button = button("Show its pace", () => (this.playing ? this.stop() : void this.#play()), { pressed: false });
    this.element = element(
      "section",
      { "aria-label": "A sense of speed" },
      element("h2", {}, "A sense of speed"),
      field("Recording", this.takes, this.button),
    );
  }

  get playing() {
    return this.button.getAttribute("aria-pressed") === "true";
  }

  /** @param {import("../../messages.js").TakePace[]} takes */
  offer(takes) {
    const chosen = this.takes.value;
    this.takes.replaceChildren(...takes.map(({ name, speed }) => element("option", { value: name, selected: name === chosen }, `${name} (${speed.toFixed(2)} m/s)`)));
  }

  stop() {
    this.#wanted += 1;
    press(this.button, false);
    this.#clip?.dispose();
    this.#clip = null;
    this.view.showMover(null);
  }

  async #play() {
    const number = (this.#wanted += 1);
    press(this.button, true);
    try {
      const { payload } = await this.app.connection.ask({ kind: "play_take", take: this.takes.value });
      const clip = await loadClip(payload);
      if (number !== this.#wanted) return clip.dispose();
      this.#clip?.dispose();
      this.#clip = clip;
      clip.setGhost(GHOST, "#7d8794");
      this.app.stage.add(clip.object);
      this.#begun = performance.now();
      this.#step();
    } catch (error) {
      this.stop();
      this.app.say(/** @type {Error} */ (error).message, "error");
    }
  }

  #step() {
    const clip = this.#clip;
    if (!clip) return;
    const time = ((performance.now() - this.#begun) / 1000) % Math.max(clip.duration, 0.1);
    clip.seek(time);
    const [x, , z] = clip.root(time);
    this.view.showMover({ x, z });
    requestAnimationFrame(() => this.#step());
  }
}
