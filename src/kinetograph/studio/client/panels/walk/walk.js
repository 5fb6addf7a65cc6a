// The panel of a walk: a path is drawn, smoothed, dragged, timed again; a character walks it.
import { MOUSE, TOUCH } from "three";
import { button, element, field, press, slider } from "../../dom.js";
import { Along } from "./along.js";
import { Follower } from "./follower.js";
import { Layers } from "./layers.js";
import { listenOnGround } from "../../stage/ground_pointer.js";
import { Pen, Timing, at, dragged, nearest, paced, waiting } from "./path.js";
import { PathView } from "./path_view.js";
import { SpeedBar } from "./speed_bar.js";
import { Pieces } from "./pieces.js";
import { Playback } from "./playback.js";

/**
 * @typedef {import("../../studio.js").Panel} Panel
 * @typedef {import("./path.js").Row} Row
 * @typedef {import("../../messages.js").Walk} Walk
 * @typedef {import("../../messages.js").MadeHeader} MadeHeader
 * @typedef {import("../../messages.js").Pace} Pace
 * @typedef {"draw" | "timing" | null} Tool
 */

const GRIP = 12; // pixels from the path within which it is gripped
const SMOOTH = { smooth_time: 0.2, smooth_space: 0.15 }; // of the first path: hands tremble
const UNASKED = { rules: [], keys: [], moves: [], contacts: [] }; // what is at seconds of another path
const CLICK = 4; // pixels that a pointer may move in a click
const HINTS = {
  draw: "Drag on the ground to draw a path at the pace of the walk. Hold still to wait. Esc ends it.",
  timing: "Drag along the path at the pace that is wanted. Esc ends it.",
};

/**
 * @param {import("../../studio.js").App} app
 * @returns {import("../../studio.js").Panel}
 */
export function createWalk(app) {
  return new WalkPanel(app);
}

/** @implements {Panel} */
class WalkPanel {
  /** @type {Tool} */
  #tool = null;
  /** @type {Pace | null} */
  #pace = null;
  #paceOf = "";
  /** @type {MadeHeader | null} */
  #made = null;
  /** @type {ReturnType<typeof listenOnGround> | null} */
  #listening = null;
  #reach = 1;
  #entered = false;
  #soon = 0;

  /** @param {import("../../studio.js").App} app */
  constructor(app) {
    this.app = app;
    this.view = new PathView(app.stage);
    this.speeds = new SpeedBar();
    this.follower = new Follower(app);
    this.pieces = new Pieces(app, (change, label) => this.#edit(change, label), "walk", (time) => this.#pathSecond(time));
    this.along = new Along(app, (change, label) => this.#edit(change, label), () => this.#where(), ([x, z]) => nearest(this.path, { x, z })?.time ?? 0);
    this.layers = new Layers(app, (change, label, merge) => this.#edit(change, label, merge));
    this.playback = new Playback(app, this.view);
    this.hint = element("p", { class: "hint", role: "status", hidden: true });
    app.stage.parent.append(this.hint);
    this.element = element("div", { class: "walk" }, this.#pathSection(), this.#shapeSection(), this.#changeSection(), this.along.element, this.layers.element, this.playback.element, this.pieces.element);
    app.store.on("project", () => this.#entered && this.#showProject());
    app.store.on("welcome", () => {
      if (!this.#entered) return;
      this.along.show();
      this.layers.show();
      void this.#askPace();
    });
    app.transport.on("time", (time) => this.speeds.seek(this.#drawnTime(time)));
    app.timeline.on("hover", (where) => this.#entered && void this.pieces.hover(where?.lane.kind === "pieces" ? where.span.data : null));
    app.timeline.on("pick", (where) => this.#entered && where.lane.kind === "pieces" && void this.pieces.open(where.span.data));
    document.addEventListener("keydown", (event) => event.key === "Escape" && this.#entered && this.#use(null));
  }

  /** @returns {Walk} */
  get walk() {
    return this.app.store.project.walk ?? {};
  }

  /** @returns {Row[]} */
  get path() {
    return this.walk.path ?? [];
  }

  enter() {
    this.#entered = true;
    this.app.stage.add(this.view.object);
    this.#listening = listenOnGround(this.app.stage, { press: (event, point) => this.#press(event, point), hover: (event, point) => this.#hover(event, point) });
    this.#showProject();
    void this.#askPace();
  }

  leave() {
    this.#use(null);
    this.#entered = false;
    this.#listening?.stop();
    this.#listening = null;
    this.follower.clear();
    this.playback.stop();
    this.pieces.close();
    this.app.stage.remove(this.view.object);
  }

  /** @param {MadeHeader | null} made */
  shown(made) {
    this.#made = made;
    if (this.app.store.state !== "drawing") this.follower.clear();
    this.pieces.close();
  }

  /** The bar's button: drawing starts or ends. */
  press() {
    this.#use(this.#tool === "draw" ? null : "draw");
  }

  /** @returns {import("../../time/timeline.js").Lane[]} */
  lanes() {
    return this.pieces.lanes;
  }

  #pathSection() {
    this.timingButton = button("Time it again", () => this.#use(this.#tool === "timing" ? null : "timing"), { pressed: false, title: "Go along the path again, at another pace" });
    this.clearButton = button("Clear", () => this.#edit({ path: [], ...UNASKED }, "clear the path"), { title: "Take the path away" });
    return element("section", { "aria-label": "Path" }, element("h2", {}, "Path"), element("div", { class: "buttons" }, this.timingButton, this.clearButton), this.speeds.element);
  }

  #shapeSection() {
    const smooth = (/** @type {"smooth_time" | "smooth_space"} */ name) => (/** @type {number} */ value) => this.#edit({ [name]: value }, "smooth the path", true);
    this.smoothTime = slider("Smooth in time", { min: 0, max: 1, step: 0.05, value: 0, unit: "s" }, smooth("smooth_time"));
    this.smoothSpace = slider("Smooth in space", { min: 0, max: 1, step: 0.05, value: 0, unit: "m" }, smooth("smooth_space"));
    this.mirror = check("Mirrored recordings too", (on) => this.#edit({ mirror: on }, "mirror recordings"));
    this.keepTime = check("Keep the path's times", (on) => this.#edit({ keep_time: on }, "keep times"));
    this.faces = check("Start facing", (on) => this.#edit({ facing: on ? this.#firstHeading() : null }, "start facing"));
    this.facing = slider("Facing", { min: -180, max: 180, step: 5, value: 0, unit: "°" }, (value) => this.#edit({ facing: value }, "start facing", true));
    return element(
      "section",
      { "aria-label": "How it is walked" },
      element("h2", {}, "How it is walked"),
      this.smoothTime, this.smoothSpace, this.mirror.element, this.keepTime.element, this.faces.element, this.facing,
    );
  }

  #changeSection() {
    const number = (/** @type {number} */ value, step = 0.1, least = -100) => element("input", { type: "number", value, step, min: least });
    const [wait, x, z, after, dx, dz, from, to, speed] = [number(1, 0.5, 0.1), number(0), number(2), number(2, 0.1, 0.1), number(0.5), number(0), number(0, 0.1, 0), number(2, 0.1, 0), number(0.8, 0.1, 0.1)];
    const value = (/** @type {HTMLInputElement} */ input) => input.valueAsNumber;
    return element(
      "section",
      { "aria-label": "Change the path" },
      element("h2", {}, "Change the path"),
      element("p", { class: "note" }, "Drag the path on the ground to bend it; click it to go there."),
      slider("Reach of a bend", { min: 0.25, max: 4, step: 0.25, value: this.#reach, unit: "m" }, (reach) => (this.#reach = reach)),
      field("Stop here for, s", wait, button("Wait", () => this.#wait(value(wait)), { title: "At the time that is shown" })),
      element(
        "details",
        {},
        element("summary", {}, "By numbers"),
        element("fieldset", {}, element("legend", {}, "Next point"), field("x, m", x), field("z, m", z), field("seconds later", after), button("Add point", () => this.#addPoint(value(x), value(z), value(after)))),
        element("fieldset", {}, element("legend", {}, "Bend at the time that is shown"), field("by x, m", dx), field("by z, m", dz), button("Bend", () => this.#bend(value(dx), value(dz)))),
        element("fieldset", {}, element("legend", {}, "Pace"), field("from, s", from), field("to, s", to), field("speed, m/s", speed), button("Set the pace", () => this.#setPace(value(from), value(to), value(speed)))),
      ),
    );
  }

  /**
   * @param {Partial<Walk>} change
   * @param {string} label
   * @param {boolean} [merge]
   */
  #edit(change, label, merge = false) {
    this.app.connection.edit("walk", { ...this.walk, ...change }, { label, merge });
  }

  #showProject() {
    if (this.#soon) cancelAnimationFrame(this.#soon);
    this.#soon = 0;
    const { walk, path } = this;
    this.smoothTime?.set(walk.smooth_time ?? 0);
    this.smoothSpace?.set(walk.smooth_space ?? 0);
    this.mirror?.set(walk.mirror ?? true);
    this.keepTime?.set(walk.keep_time ?? false);
    const facing = walk.facing ?? null;
    this.faces?.set(facing !== null);
    this.facing?.set(facing ?? 0);
    if (this.facing) this.facing.hidden = facing === null;
    for (const each of [this.timingButton, this.clearButton]) if (each) each.disabled = path.length < 2;
    if (this.app.store.state !== "drawing") this.view.show(path, this.#pace);
    this.view.showFacing(facing);
    this.speeds.show(path, this.#pace);
    this.pieces.show();
    this.along.show();
    this.layers.show();
    this.app.showLanes();
    if (`${walk.library ?? ""}${walk.mirror ?? true}` !== this.#paceOf) void this.#askPace();
  }

  async #askPace() {
    this.#paceOf = `${this.walk.library ?? ""}${this.walk.mirror ?? true}`;
    if (!Object.keys(this.app.store.project.libraries ?? {}).length) return;
    try {
      this.#pace = await this.app.connection.ask({ kind: "ask_pace" });
    } catch (error) {
      return this.app.say(/** @type {Error} */ (error).message, "error");
    }
    this.playback.offer(this.#pace?.takes ?? []);
    if (this.#entered) this.#showProject();
  }

  /**
   * Takes a tool into the hand, or lays it down.
   *
   * @param {Tool} tool
   */
  #use(tool) {
    this.#listening?.cancel();
    this.#tool = tool;
    const { controls, canvas } = this.app.stage;
    controls.mouseButtons.LEFT = /** @type {any} */ (tool ? null : MOUSE.ROTATE);
    controls.touches.ONE = /** @type {any} */ (tool ? null : TOUCH.ROTATE);
    canvas.classList.toggle("drawing", tool !== null);
    if (this.timingButton) press(this.timingButton, tool === "timing");
    document.querySelector('[data-mode="walk"]')?.toggleAttribute("data-active", tool === "draw");
    this.hint.hidden = tool === null;
    this.hint.textContent = tool ? HINTS[tool] : "";
    if (tool) this.pieces.close();
  }

  /**
   * @param {PointerEvent} event
   * @param {{x: number, z: number}} point
   */
  #press(event, point) {
    if (this.#tool === "draw") return this.#draw(new Pen(), (pen) => this.#finishPath(pen.rows));
    if (this.#tool === "timing") return this.#draw(new Timing(this.path), (timing) => this.#finishTiming(timing.whole));
    const grip = this.#grip(event, point);
    return grip && this.#drag(event, point, grip.along, grip.time);
  }

  /**
   * A stroke that draws.
   *
   * @template {Pen | Timing} T
   * @param {T} pen
   * @param {(pen: T) => void} finish
   * @returns {import("../../stage/ground_pointer.js").Stroke}
   */
  #draw(pen, finish) {
    const { store } = this.app;
    this.app.transport.pause();
    store.drawing = true;
    this.follower.start(pen);
    const end = () => {
      this.follower.stop();
      store.drawing = false;
    };
    return {
      move: (milliseconds, point) => {
        pen.move(milliseconds, point);
        this.#showSoon(pen.rows, pen instanceof Pen);
      },
      done: (milliseconds) => {
        pen.end(milliseconds);
        end();
        this.#use(null);
        finish(pen);
      },
      cancelled: () => {
        end();
        this.follower.clear();
        if (this.app.clip) this.app.clip.object.visible = true;
        this.#showProject();
      },
    };
  }

  /**
   * Shows rows with the next frame.
   *
   * @param {Row[]} rows
   * @param {boolean} [onGround]
   */
  #showSoon(rows, onGround = true) {
    if (this.#soon) cancelAnimationFrame(this.#soon);
    this.#soon = requestAnimationFrame(() => {
      this.#soon = 0;
      if (onGround) this.view.show(rows, this.#pace);
      this.speeds.show(rows, this.#pace);
    });
  }

  /** @param {Row[]} rows */
  #finishPath(rows) {
    const length = rows.length ? rows[rows.length - 1][0] : 0;
    if (rows.length < 2 || length < 0.3) {
      if (this.app.clip) this.app.clip.object.visible = true;
      this.follower.clear();
      this.app.say("the path is too short: drag further");
      return this.#showProject();
    }
    const first = this.path.length ? {} : SMOOTH;
    this.#edit({ ...first, path: rows, ...UNASKED }, "draw a path");
  }

  /** @param {Row[]} rows */
  #finishTiming(rows) {
    this.#edit({ path: rows, ...UNASKED }, "draw the timing");
  }

  /**
   * A stroke that bends the path; one that does not move goes there.
   *
   * @param {PointerEvent} event
   * @param {{x: number, z: number}} from
   * @param {number} along
   * @param {number} time
   * @returns {import("../../stage/ground_pointer.js").Stroke}
   */
  #drag(event, from, along, time) {
    const { path } = this;
    let bent = path;
    const pressed = this.app.stage.screenPoint(from.x, this.app.stage.floor, from.z);
    return {
      move: (_, point) => {
        const now = this.app.stage.screenPoint(point.x, this.app.stage.floor, point.z);
        if (bent === path && Math.hypot(now.clientX - pressed.clientX, now.clientY - pressed.clientY) < CLICK) return;
        bent = dragged(path, along, { x: point.x - from.x, z: point.z - from.z }, this.#reach);
        this.#showSoon(bent);
        this.view.showHandle(point);
      },
      done: () => {
        this.view.showHandle(null);
        if (bent === path) this.app.transport.seek(this.#shownTime(time));
        else this.#edit({ path: bent }, "bend the path");
      },
      cancelled: () => this.#showProject(),
    };
  }

  /**
   * @param {PointerEvent} event
   * @param {{x: number, z: number} | null} point
   */
  #hover(event, point) {
    const grip = point && !this.#tool ? this.#grip(event, point) : null;
    this.view.showHandle(grip);
    this.app.stage.canvas.classList.toggle("grip", grip !== null);
  }

  /**
   * The place of the path under the pointer.
   *
   * @param {PointerEvent} event
   * @param {{x: number, z: number}} point
   */
  #grip(event, point) {
    if (this.path.length < 2) return null;
    const found = nearest(this.path, point);
    if (!found) return null;
    const there = this.app.stage.screenPoint(found.x, this.app.stage.floor, found.z);
    const limit = event.pointerType === "touch" ? 2 * GRIP : GRIP;
    return Math.hypot(there.clientX - event.clientX, there.clientY - event.clientY) < limit ? found : null;
  }

  /**
   * The second of the drawn path for a second of the walk, which is later where a path was too fast.
   *
   * @param {number} time
   */
  #drawnTime(time) {
    const walked = this.#made?.path ?? [];
    const last = this.path[this.path.length - 1]?.[0] ?? 0;
    const lasts = walked[walked.length - 1]?.[0] ?? 0;
    if (lasts < last + 0.15 || walked.length < 2) return time;
    const [x, z] = at(walked, time);
    const found = nearest(this.path, { x, z }, this.#around(time / lasts));
    return found?.time ?? time;
  }

  /**
   * The second of the walk for a second of the drawn path.
   *
   * @param {number} time
   */
  #shownTime(time) {
    const walked = this.#made?.path ?? [];
    const [x, z] = at(this.path, time);
    const lasts = walked[walked.length - 1]?.[0] ?? 0;
    const last = this.path[this.path.length - 1]?.[0] ?? 0;
    if (walked.length < 2 || lasts < last + 0.15) return time;
    return nearest(walked, { x, z })?.time ?? time;
  }

  /**
   * Metres along the path that a share of its time is near to.
   *
   * @param {number} share
   * @returns {[number, number]}
   */
  #around(share) {
    const length = nearest(this.path, { x: this.path[this.path.length - 1][1], z: this.path[this.path.length - 1][2] })?.along ?? 0;
    return [Math.max((share - 0.3) * length, 0), (share + 0.3) * length];
  }

  /** Where the path sets out to, in degrees. */
  #firstHeading() {
    const [first] = this.path;
    const next = this.path.find((each) => first && Math.hypot(each[1] - first[1], each[2] - first[2]) > 0.3);
    return next ? Math.round((Math.atan2(next[1] - first[1], next[2] - first[2]) * 36) / Math.PI) * 5 : 0;
  }

  /** @param {number} seconds */
  #wait(seconds) {
    if (this.path.length < 2 || !(seconds > 0)) return;
    const time = this.#drawnTime(this.app.transport.time);
    const [rules, moves, contacts] = [this.walk.rules, this.walk.moves, this.walk.contacts].map((rows) => later(rows ?? [], time, seconds));
    const keys = (this.walk.keys ?? []).map((row) => (typeof row.time === "number" && row.time > time ? { ...row, time: row.time + seconds } : row));
    this.#edit({ path: waiting(this.path, time, seconds), rules, moves, contacts, keys }, "wait");
  }

  /**
   * @param {number} x
   * @param {number} z
   * @param {number} seconds
   */
  #addPoint(x, z, seconds) {
    if (![x, z, seconds].every(Number.isFinite) || !(seconds > 0)) return this.app.say("a point has a place x, z and a time after the one before", "error");
    const last = this.path[this.path.length - 1];
    /** @type {Row[]} */
    const path = last ? [...this.path, [Math.round(1e4 * (last[0] + seconds)) / 1e4, x, z]] : [[0, x, z]];
    this.#edit({ path }, "add a point");
    this.app.say(path.length < 2 ? "the path begins there; add another point" : "");
  }

  /**
   * The second of the path for a second of the walk, where the path waits.
   *
   * @param {number} time
   */
  #pathSecond(time) {
    const clock = this.#made?.clock ?? [];
    const after = clock.findIndex(([second]) => second >= time);
    if (after < 1) return clock[after === 0 ? 0 : clock.length - 1]?.[1] ?? time;
    const [[from, begin], [to, end]] = [clock[after - 1], clock[after]];
    return begin + ((end - begin) * (time - from)) / Math.max(to - from, 1e-9);
  }

  /** The second of the path, and the place on it, that are shown: the path may wait, or be slower than it was drawn. */
  #where() {
    const time = this.app.transport.time;
    const walked = this.#made?.path?.length ? this.#made.path : this.path;
    const [x, z] = walked.length ? at(walked, time) : [0, 0];
    return { second: this.#pathSecond(time), place: /** @type {[number, number]} */ ([+x.toFixed(3), +z.toFixed(3)]) };
  }

  /**
   * @param {number} x
   * @param {number} z
   */
  #bend(x, z) {
    const place = at(this.path.length ? this.path : [[0, 0, 0]], this.#drawnTime(this.app.transport.time));
    const found = nearest(this.path, { x: place[0], z: place[1] });
    if (found && Number.isFinite(x + z)) this.#edit({ path: dragged(this.path, found.along, { x, z }, this.#reach) }, "bend the path");
  }

  /**
   * @param {number} from
   * @param {number} to
   * @param {number} speed
   */
  #setPace(from, to, speed) {
    if (this.path.length < 2 || !(from < to) || !(speed > 0)) return this.app.say("a pace is a speed from a second to a later one", "error");
    const last = this.path[this.path.length - 1][0];
    this.#edit({ path: paced(this.path, Math.max(from, 0), Math.min(to, last), speed), ...UNASKED }, "set the pace");
  }
}

/**
 * Spans, those after a time later by some seconds.
 *
 * @template {{start: number, stop: number}} T
 * @param {T[]} rows
 * @param {number} time
 * @param {number} seconds
 * @returns {any[]}
 */
function later(rows, time, seconds) {
  return rows.map((row) => (row.start > time ? { ...row, start: row.start + seconds, stop: row.stop + seconds } : row));
}

/**
 * A checkbox with its label.
 *
 * @param {string} name
 * @param {(on: boolean) => void} change
 */
function check(name, change) {
  const input = element("input", { type: "checkbox", onchange: () => change(input.checked) });
  return { element: element("label", { class: "check" }, input, name), set: (/** @type {boolean} */ on) => (input.checked = on) };
}
