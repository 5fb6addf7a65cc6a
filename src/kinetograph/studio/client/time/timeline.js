// The timeline: a ruler and lanes of spans, to scrub, zoom, hover, pick, drag and remove in.
import { Emitter, button, element, iconButton } from "../dom.js";

/**
 * An interval on a lane; an instant where `start` is `stop`.
 *
 * @typedef {object} Span
 * @property {number} start seconds
 * @property {number} stop seconds
 * @property {string} label what is written in it, and its accessible name
 * @property {string} [title] more, shown while the pointer is over it
 * @property {string} [colour] any colour of CSS; that of the lane's kind where there is none
 * @property {boolean} [marked] drawn with a frame, such as what is pinned or chosen
 * @property {any} [data] for whoever listens
 *
 * @typedef {object} Lane
 * @property {string} name
 * @property {"pieces" | "contacts" | "keys" | "moves" | "signal"} kind
 * @property {Span[]} spans
 * @property {boolean} [draggable] spans can be moved and removed; those of `keys` can, unless this is false
 * @property {number[] | number[][]} [values] of a signal: one curve or several, evenly from the start to the duration
 * @property {[number, number]} [range] of the signal's values; their own where there is none
 *
 * @typedef {{lane: Lane, span: Span}} Where
 * @typedef {Where & {start: number, stop: number, done: boolean}} Move
 *   where a span is dragged to; `done` once it is let go. The timeline keeps the old place until lanes are set again.
 *
 * @typedef {object} TimelineEvents
 * @property {number} seek seconds, when the timeline is scrubbed
 * @property {Where | null} hover the span under the pointer or with the keyboard's focus
 * @property {Where & {event: Event}} pick clicked, or Enter pressed
 * @property {Move} drag moved in time, by the pointer or by the arrow keys
 * @property {Move} dragwindow Ctrl-dragged to a free window, or Ctrl and arrow keys
 * @property {Where} remove Delete or Backspace pressed
 */

const MOST_ZOOM = 400; // pixels a second and more show nothing new
const STEPS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600];
const TICK = 70; // least pixels between labels of the ruler
const MOST_POINTS = 1500; // of a curve
const LABEL = 26; // pixels of a label of the ruler
const CLICK = 3; // pixels that a pointer may move in a click

/** @extends {Emitter<TimelineEvents>} */
export class Timeline extends Emitter {
  #time = 0;
  #zoom = 1;
  // sizes in pixels, measured where they change: asking for them at every frame would lay out the page
  #width = 0;
  #room = 0;
  #x = 0;
  /** @type {Map<HTMLElement, Where>} */
  #places = new Map();
  #dragging = false;

  constructor() {
    super();
    /** Seconds. */
    this.duration = 1;
    this.clip = 1;
    /** Frames per second that dragged spans are rounded to. */
    this.fps = 30;
    /** @type {Lane[]} */
    this.lanes = [];
    this.ruler = element("div", { class: "ruler", "aria-hidden": "true" });
    this.head = element("div", { class: "playhead", "aria-hidden": "true" });
    this.rows = element("div", { class: "lanes" });
    this.content = element("div", { class: "timeline-content" }, this.ruler, this.rows, this.head);
    this.scroller = element("div", { class: "timeline-scroller", tabindex: "0", role: "group", "aria-label": "Timeline" }, this.content);
    this.zoomButtons = element(
      "div",
      { class: "zoom", role: "group", "aria-label": "Zoom of the timeline" },
      iconButton("minus", "Zoom out", () => this.zoom(this.#zoom / 1.5)),
      button("Fit", () => this.zoom(1), { title: "Show the whole clip" }),
      iconButton("plus", "Zoom in", () => this.zoom(this.#zoom * 1.5)),
    );
    /** The lanes; the buttons for zooming are {@link Timeline.zoomButtons}. */
    this.element = element("div", { class: "timeline-lanes" }, this.scroller);
    this.#listen();
    new ResizeObserver(() => this.#drawRuler()).observe(this.scroller);
  }

  /**
   * @param {number} seconds
   * @param {number} [fps] frames per second that dragged spans are rounded to
   * @param {number} [clip] seconds at which signals end, where there is room after them
   */
  setDuration(seconds, fps = this.fps, clip = seconds) {
    this.duration = Math.max(seconds, 1e-3);
    this.clip = Math.min(clip, this.duration);
    this.fps = fps;
    this.setLanes(this.lanes);
    this.zoom(this.#zoom);
  }

  /**
   * Moves the playhead.
   *
   * @param {number} seconds
   */
  setTime(seconds) {
    this.#time = seconds;
    this.#placeHead();
    this.#keepInView();
  }

  /**
   * Shows other lanes. The focus stays on the span at its place in its lane.
   *
   * @param {Lane[]} lanes
   */
  setLanes(lanes) {
    const focused = this.#focused();
    this.lanes = lanes;
    this.#places.clear();
    this.rows.replaceChildren(...lanes.map((lane) => this.#row(lane)));
    if (focused) this.#spansOf(focused.lane)[focused.span]?.focus();
  }

  /**
   * Shows the whole clip, or a part of it around the playhead.
   *
   * @param {number} zoom 1 shows all
   */
  zoom(zoom) {
    const most = Math.max((this.duration * MOST_ZOOM) / Math.max(this.scroller.clientWidth, 1), 1);
    this.#zoom = Math.min(Math.max(zoom, 1), most);
    this.content.style.setProperty("--zoom", String(this.#zoom));
    this.#drawRuler();
    this.#keepInView(true);
  }

  /**
   * Seconds at the pointer.
   *
   * @param {{clientX: number}} event
   * @returns {number}
   */
  timeAt(event) {
    const box = this.ruler.getBoundingClientRect();
    const share = (event.clientX - box.left) / Math.max(box.width, 1);
    return Math.min(Math.max(share, 0), 1) * this.duration;
  }

  #listen() {
    this.content.addEventListener("pointerdown", (event) => this.#press(event));
    this.scroller.addEventListener("keydown", (event) => this.#key(event));
    this.scroller.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    this.content.addEventListener("pointerover", (event) => !this.#dragging && this.emit("hover", this.#where(event)));
    this.content.addEventListener("pointerleave", () => !this.#dragging && this.emit("hover", null));
    this.content.addEventListener("focusin", (event) => this.emit("hover", this.#where(event)));
    this.content.addEventListener("focusout", () => this.emit("hover", null));
  }

  /** @param {WheelEvent} event */
  #wheel(event) {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    this.zoom(this.#zoom * Math.exp(-event.deltaY / 300));
  }

  /** @param {PointerEvent} event */
  #press(event) {
    if (event.button !== 0) return;
    const at = this.#elementOf(event);
    const where = at && this.#places.get(at);
    if (at && where) {
      this.#focus(at);
      this.#dragSpan(event, at, where);
    } else this.#scrub(event);
    event.preventDefault();
  }

  /** @param {PointerEvent} event */
  #scrub(event) {
    this.emit("seek", this.timeAt(event));
    this.#pointer(event, (moved) => this.emit("seek", this.timeAt(moved)));
  }

  /**
   * @param {PointerEvent} pressed
   * @param {HTMLElement} at
   * @param {Where} where
   */
  #dragSpan(pressed, at, where) {
    const from = this.timeAt(pressed);
    const kind = pressed.ctrlKey || pressed.metaKey ? "dragwindow" : "drag";
    let far = false;
    const move = (/** @type {PointerEvent} */ event, /** @type {boolean} */ done) => {
      far ||= Math.abs(event.clientX - pressed.clientX) > CLICK;
      if (!far || !isDraggable(where.lane)) return;
      const by = this.timeAt(event) - from;
      this.#move(kind, where, at, by, done);
    };
    this.#pointer(pressed, (event) => move(event, false), (event) => {
      move(event, true);
      if (!far) this.emit("pick", { ...where, event });
    });
  }

  /**
   * @param {"drag" | "dragwindow"} kind
   * @param {Where} where
   * @param {HTMLElement} at
   * @param {number} by seconds
   * @param {boolean} done
   */
  #move(kind, where, at, by, done) {
    const { start, stop } = where.span;
    const frames = Math.round(by * this.fps) / this.fps;
    const [first, last] = kind === "drag" ? [start + frames, stop + frames] : [start - Math.abs(frames), stop + Math.abs(frames)];
    const move = { ...where, start: Math.max(first, 0), stop: Math.max(last, 0), done };
    this.#place(at, move.start, move.stop);
    this.emit(kind, move);
  }

  /**
   * Follows the pointer until it is let go.
   *
   * @param {PointerEvent} pressed
   * @param {(event: PointerEvent) => void} moved
   * @param {(event: PointerEvent) => void} [released]
   */
  #pointer(pressed, moved, released) {
    this.#dragging = true;
    const stop = (/** @type {PointerEvent} */ event) => {
      this.#dragging = false;
      removeEventListener("pointermove", moved);
      removeEventListener("pointerup", stop);
      removeEventListener("pointercancel", stop);
      released?.(event);
    };
    addEventListener("pointermove", moved);
    addEventListener("pointerup", stop);
    addEventListener("pointercancel", stop);
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const at = this.#elementOf(event);
    const where = at && this.#places.get(at);
    if (!at || !where) {
      this.#enter(event);
      return;
    }
    const sideways = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const along = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (along) this.#walk(at, where.lane, along);
    else if (event.key === "Enter") this.emit("pick", { ...where, event });
    else if (sideways && isDraggable(where.lane)) this.#nudge(event, at, where, sideways);
    else if ((event.key === "Delete" || event.key === "Backspace") && isDraggable(where.lane)) this.emit("remove", where);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** @param {KeyboardEvent} event */
  #enter(event) {
    if (event.key !== "ArrowDown") return;
    const first = this.lanes.find((lane) => lane.spans.length);
    if (first) this.#spansOf(this.lanes.indexOf(first))[0].focus();
    event.preventDefault();
  }

  /**
   * @param {KeyboardEvent} event
   * @param {HTMLElement} at
   * @param {Where} where
   * @param {number} sign
   */
  #nudge(event, at, where, sign) {
    const frames = (event.shiftKey ? Math.round(this.fps) : 1) * sign;
    if (!event.ctrlKey) {
      this.#move("drag", where, at, frames / this.fps, true);
      return;
    }
    const { start, stop } = where.span;
    const middle = (start + stop) / 2;
    const half = Math.max((stop - start) / 2 + frames / this.fps, 0);
    const move = { ...where, start: Math.max(middle - half, 0), stop: middle + half, done: true };
    this.#place(at, move.start, move.stop);
    this.emit("dragwindow", move);
  }

  /**
   * @param {HTMLElement} at
   * @param {Lane} lane
   * @param {number} by
   */
  #walk(at, lane, by) {
    const all = [...this.#places].filter(([, where]) => where.lane === lane).map(([made]) => made);
    const next = all[all.indexOf(at) + by];
    if (next) this.#focus(next);
    else this.#focus(this.#beyond(lane, by) ?? at);
  }

  /**
   * The span of the next lane that is nearest to the playhead.
   *
   * @param {Lane} lane
   * @param {number} by
   * @returns {HTMLElement | null}
   */
  #beyond(lane, by) {
    for (let i = this.lanes.indexOf(lane) + by; i >= 0 && i < this.lanes.length; i += by) {
      const spans = this.#spansOf(i);
      if (spans.length) return by > 0 ? spans[0] : spans[spans.length - 1];
    }
    return null;
  }

  /** @param {HTMLElement} at */
  #focus(at) {
    const lane = this.#places.get(at)?.lane;
    for (const [made, where] of this.#places) if (where.lane === lane) made.tabIndex = made === at ? 0 : -1;
    at.focus();
  }

  #focused() {
    const where = document.activeElement instanceof HTMLElement && this.#places.get(document.activeElement);
    return where ? { lane: this.lanes.indexOf(where.lane), span: where.lane.spans.indexOf(where.span) } : null;
  }

  /** @param {number} lane */
  #spansOf(lane) {
    return [...this.#places].filter(([, where]) => where.lane === this.lanes[lane]).map(([made]) => made);
  }

  /** @param {Event} event */
  #elementOf(event) {
    return event.target instanceof Element ? /** @type {HTMLElement | null} */ (event.target.closest(".span")) : null;
  }

  /** @param {Event} event */
  #where(event) {
    const at = this.#elementOf(event);
    return (at && this.#places.get(at)) ?? null;
  }

  /** @param {Lane} lane */
  #row(lane) {
    const spans = lane.spans.map((span, i) => this.#span(lane, span, i));
    const list = { role: spans.length ? "listbox" : null, "aria-label": spans.length ? lane.name : null };
    const track = element("div", { class: "track", ...list }, spans);
    if (lane.values?.length) {
      const drawn = curves(lane);
      drawn[0].style.width = `${(100 * this.clip) / this.duration}%`;
      track.prepend(...drawn);
    }
    return element("div", { class: `lane ${lane.kind}` }, element("div", { class: "lane-name", title: lane.name }, lane.name), track);
  }

  /**
   * @param {Lane} lane
   * @param {Span} span
   * @param {number} index
   */
  #span(lane, span, index) {
    const instant = span.stop <= span.start;
    const name = `${span.label}, ${span.start.toFixed(2)}${instant ? "" : ` to ${span.stop.toFixed(2)}`} s`;
    const made = element(
      "div",
      {
        class: `span${span.marked ? " marked" : ""}${instant ? " instant" : ""}`,
        role: "option", "aria-label": name, "aria-selected": String(Boolean(span.marked)), title: span.title ?? name,
        tabindex: index === 0 ? "0" : "-1",
      },
      element("span", { class: "span-label" }, span.label),
    );
    if (span.colour) made.style.setProperty("--colour", span.colour);
    this.#place(made, span.start, span.stop);
    this.#places.set(made, { lane, span });
    return made;
  }

  /**
   * @param {HTMLElement} at
   * @param {number} start
   * @param {number} stop
   */
  #place(at, start, stop) {
    const [first, last] = [start, stop].map((time) => Math.min(Math.max(time, 0), this.duration));
    at.style.left = `${(100 * first) / this.duration}%`;
    at.style.width = `${(100 * Math.max(last - first, 0)) / this.duration}%`;
  }

  #drawRuler() {
    const width = this.ruler.clientWidth;
    if (!width) return;
    this.#width = width;
    this.#room = this.scroller.clientWidth - (this.content.clientWidth - width);
    this.#placeHead();
    const least = (TICK * this.duration) / width;
    const step = STEPS.find((candidate) => candidate >= least) ?? STEPS[STEPS.length - 1];
    const fits = (/** @type {number} */ time) => (1 - time / this.duration) * width > LABEL;
    const ticks = [];
    for (let i = 0; i * step <= this.duration + 1e-9; i++) {
      const tick = element("span", { class: "tick" }, fits(i * step) && label(i * step, step));
      tick.style.left = `${(100 * i * step) / this.duration}%`;
      ticks.push(tick);
    }
    this.ruler.replaceChildren(...ticks);
    this.content.style.setProperty("--tick", `${(100 * step) / this.duration}%`);
  }

  /** By a transform, which moves the playhead without laying out or painting the lanes again. */
  #placeHead() {
    const x = Math.round((this.#time / this.duration) * this.#width);
    if (x !== this.#x) this.head.style.transform = `translateX(${x}px)`;
    this.#x = x;
  }

  /** @param {boolean} [centred] */
  #keepInView(centred = false) {
    if (this.#zoom <= 1 || this.#dragging) return;
    const x = (this.#time / this.duration) * this.#width;
    const room = this.#room;
    const left = this.scroller.scrollLeft;
    if (centred || x < left || x > left + room - 20) this.scroller.scrollLeft = Math.max(x - (centred ? 0.5 : 0.1) * room, 0);
  }
}

/** @param {Lane} lane */
function isDraggable(lane) {
  return lane.draggable ?? lane.kind === "keys";
}

/**
 * @param {number} seconds
 * @param {number} step
 */
function label(seconds, step) {
  if (seconds < 60) return `${seconds.toFixed(step < 0.1 ? 2 : step < 1 ? 1 : 0)} s`;
  const whole = Math.floor(seconds / 60);
  return `${whole}:${(seconds - 60 * whole).toFixed(step < 1 ? 1 : 0).padStart(step < 1 ? 4 : 2, "0")}`;
}

/**
 * The curves of a signal, stretched over its lane, and the values at its top and bottom.
 *
 * @param {Lane} lane
 */
function curves(lane) {
  const all = /** @type {number[][]} */ (Array.isArray(lane.values?.[0]) ? lane.values : [lane.values ?? []]);
  const [low, high] = lane.range ?? limits(all);
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  for (const [key, value] of Object.entries({ class: "curves", viewBox: "0 0 1 1", preserveAspectRatio: "none", "aria-hidden": "true" }))
    svg.setAttribute(key, value);
  all.forEach((values, i) => {
    const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
    const points = thinned(values).map((value, k) => `${(k / Math.max(Math.min(values.length, MOST_POINTS) - 1, 1)).toFixed(5)} ${(1 - (value - low) / (high - low || 1)).toFixed(4)}`);
    path.setAttribute("d", `M${points.join("L")}`);
    path.setAttribute("class", `curve curve-${i % 3}`);
    svg.append(path);
  });
  const [bottom, top] = [low, high].map((value) => String(Number(value.toPrecision(3))));
  return [svg, element("span", { class: "range" }, top), element("span", { class: "range low" }, bottom)];
}

/** @param {number[]} values */
function thinned(values) {
  if (values.length <= MOST_POINTS) return values;
  return Array.from({ length: MOST_POINTS }, (_, k) => values[Math.round((k * (values.length - 1)) / (MOST_POINTS - 1))]);
}

/**
 * @param {number[][]} all
 * @returns {[number, number]}
 */
function limits(all) {
  let [low, high] = [Infinity, -Infinity];
  for (const values of all) for (const value of values) [low, high] = [Math.min(low, value), Math.max(high, value)];
  return low <= high ? [low, high] : [0, 1];
}
