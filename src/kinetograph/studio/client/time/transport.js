// Time: playing, looping, stepping, and the buttons and keys for them.
import { Emitter, element, icon, iconButton, isTyping, press } from "../dom.js";

/**
 * @typedef {object} TransportEvents
 * @property {number} time seconds, whenever the time changes
 * @property {boolean} playing whenever playing starts or stops
 * @property {number} duration seconds, whenever another clip is played
 */

const RATES = [0.1, 0.25, 0.5, 1, 1.5, 2];

/** @extends {Emitter<TransportEvents>} */
export class Transport extends Emitter {
  #time = 0;
  #playing = false;
  #looping = true;
  #last = 0;
  #frame = 0;
  #written = 0;

  /** @param {{keys?: boolean}} [options] `keys: false` where the page listens for keys itself, see {@link Transport.key} */
  constructor({ keys = true } = {}) {
    super();
    /** Seconds to the last frame. */
    this.duration = 0;
    /** Frames per second, for steps. */
    this.fps = 30;
    /** How fast the clock goes; 1 is real time. */
    this.rate = 1;
    this.playButton = iconButton("play", "Play", () => this.toggle(), { class: "primary", pressed: false });
    this.loopButton = iconButton("loop", "Loop", () => (this.looping = !this.looping), { pressed: true });
    this.readout = element("span", { class: "clock" }, `${clock(0)} / ${clock(0)}`);
    this.readout.addEventListener("pointerenter", () => (this.readout.title = this.#frames()));
    this.rates = element(
      "select",
      { "aria-label": "Speed", title: "Speed", onchange: () => (this.rate = Number(this.rates.value)) },
      RATES.map((rate) => element("option", { value: rate, selected: rate === 1 }, `${rate}×`)),
    );
    /** The buttons. */
    this.element = element(
      "div",
      { class: "transport", role: "group", "aria-label": "Time" },
      iconButton("first", "First frame", () => this.seek(0)),
      iconButton("back", "A frame back", () => this.step(-1)),
      this.playButton,
      iconButton("forward", "A frame on", () => this.step(1)),
      iconButton("last", "Last frame", () => this.seek(this.duration)),
      this.loopButton,
      this.readout,
      this.rates,
    );
    if (keys) document.addEventListener("keydown", (event) => this.key(event));
  }

  /** Seconds. */
  get time() {
    return this.#time;
  }

  get playing() {
    return this.#playing;
  }

  get looping() {
    return this.#looping;
  }

  set looping(looping) {
    this.#looping = looping;
    press(this.loopButton, looping);
  }

  /**
   * Takes another length and rate; the time is kept where it fits.
   *
   * @param {number} duration seconds
   * @param {number} fps frames per second
   */
  setClip(duration, fps) {
    this.duration = duration;
    this.fps = fps;
    this.emit("duration", duration);
    this.seek(this.#time);
  }

  /**
   * Goes to a time; times beyond the ends are held at them.
   *
   * @param {number} seconds
   */
  seek(seconds) {
    this.#time = Math.min(Math.max(seconds, 0), this.duration);
    this.#read();
    this.emit("time", this.#time);
  }

  /** Plays, from the start where the end is shown. */
  play() {
    if (this.#playing || this.duration <= 0) return;
    if (this.#time >= this.duration) this.seek(0);
    this.#setPlaying(true);
    this.#last = 0;
    this.#frame = requestAnimationFrame((now) => this.#tick(now));
  }

  pause() {
    if (!this.#playing) return;
    cancelAnimationFrame(this.#frame);
    this.#setPlaying(false);
    this.#read();
  }

  toggle() {
    if (this.#playing) this.pause();
    else this.play();
  }

  /**
   * Stops and goes on by frames.
   *
   * @param {number} frames negative goes back
   */
  step(frames) {
    this.pause();
    this.seek((Math.round(this.#time * this.fps) + frames) / this.fps);
  }

  /**
   * Does what a key asks for: Space, arrows, Shift and arrows, Home, End.
   *
   * @param {KeyboardEvent} event
   */
  key(event) {
    if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey || isTyping(event)) return;
    const onButton = event.target instanceof HTMLElement && event.target.closest("button, a, summary") !== null;
    if (event.key === " " && onButton) return; // presses the button
    const frames = event.shiftKey ? Math.round(this.fps) : 1;
    /** @type {Record<string, () => void>} */
    const actions = {
      " ": () => this.toggle(),
      ArrowLeft: () => this.step(-frames),
      ArrowRight: () => this.step(frames),
      Home: () => this.seek(0),
      End: () => this.seek(this.duration),
    };
    if (!(event.key in actions)) return;
    event.preventDefault();
    actions[event.key]();
  }

  /** While playing, ten times a second: nobody reads faster, and text takes as long to draw as a small stage. */
  #read() {
    const now = performance.now();
    if (this.#playing && now - this.#written < 100) return;
    this.#written = now;
    this.readout.textContent = `${clock(this.#time)} / ${clock(this.duration)}`;
  }

  #frames() {
    const [frame, last] = [this.#time, this.duration].map((seconds) => Math.round(seconds * this.fps));
    return `Frame ${frame} of ${last}, ${round(this.fps)} per second`;
  }

  /** @param {boolean} playing */
  #setPlaying(playing) {
    this.#playing = playing;
    press(this.playButton, playing);
    this.playButton.title = playing ? "Pause" : "Play";
    this.playButton.replaceChildren(icon(playing ? "pause" : "play"));
    this.emit("playing", playing);
  }

  /** @param {number} now milliseconds */
  #tick(now) {
    if (!this.#playing) return;
    const passed = this.#last ? ((now - this.#last) / 1000) * this.rate : 0;
    this.#last = now;
    const next = this.#time + passed;
    if (next < this.duration) this.seek(next);
    else if (this.#looping) this.seek(next % this.duration);
    else {
      this.seek(this.duration);
      this.pause();
      return;
    }
    this.#frame = requestAnimationFrame((later) => this.#tick(later));
  }
}

/**
 * Minutes, seconds and hundredths.
 *
 * @param {number} seconds
 * @returns {string}
 */
export function clock(seconds) {
  const hundredths = Math.round(seconds * 100);
  const minutes = Math.floor(hundredths / 6000);
  return `${minutes}:${((hundredths % 6000) / 100).toFixed(2).padStart(5, "0")}`;
}

/** @param {number} value */
function round(value) {
  return Number(value.toFixed(2));
}
