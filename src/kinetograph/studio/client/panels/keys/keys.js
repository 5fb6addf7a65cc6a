// The panel of keys: poses that a motion goes through, where and when, and what goes on between them.
import { loadClip } from "../../stage/body.js";
import { button, element, isTyping, remember, remembered } from "../../dom.js";
import { check, checkbox } from "./keyfields.js";
import { KeyForm } from "./keyform.js";
import { KeyList } from "./keylist.js";
import { KeyOptions } from "./keyoptions.js";
import { KeyPicker } from "./keypicker.js";
import { added, changed, nameOf, poseOf, putOff, spansOf, timeFrom, windowOf } from "./keyrows.js";
import { KeyStage } from "./keystage.js";

/**
 * @typedef {import("../../messages.js").Keys} Keys
 * @typedef {import("../../messages.js").KeyRow} KeyRow
 * @typedef {import("../../messages.js").MadeHeader} MadeHeader
 * @typedef {import("../../messages.js").MetRow} MetRow
 * @typedef {import("../../messages.js").Trouble} Trouble
 * @typedef {import("../../messages.js").EndPlaces} EndPlaces
 * @typedef {import("../../time/timeline.js").Lane} Lane
 * @typedef {import("../../time/timeline.js").Move} Move
 * @typedef {import("./keyrows.js").Change} Change
 * @typedef {import("./keystage.js").Place} Place
 */

const LANE = "keys";
const ROOM = 1.5; // seconds of timeline after what there is, to drag keys to

/**
 * @param {import("../../studio.js").App} app
 * @returns {import("../../studio.js").Panel}
 */
export function createKeys(app) {
  const panel = new KeysPanel(app);
  app.keys = { add: (/** @type {string} */ take, /** @type {number} */ second, /** @type {string} */ library = "") => panel.addPose(take, second, library) };
  return panel;
}

class KeysPanel {
  #selected = 0;
  /** @type {MetRow[] | null} */
  #met = null;
  /** @type {Trouble | null} */
  #trouble = null;
  /** @type {EndPlaces | null} */
  #ends = null;
  #endsOf = "";
  #active = false;
  #scrubbed = false; // the picker was used after the timeline
  #asked = 0;
  /** @type {KeyRow | null} while a hand is dragged */
  #draft = null;

  /** @param {import("../../studio.js").App} app */
  constructor(app) {
    this.app = app;
    this.list = new KeyList({ select: (i) => this.#select(i), remove: (i) => this.#remove(i), putOff: (i, seconds) => this.#putOff(i, seconds), force: () => this.#edit({ force: true }, "force timings") });
    this.form = new KeyForm((change, label) => this.#change(change, label), () => this.#remove(this.#selected));
    this.picker = new KeyPicker(app, { scrub: () => this.#scrub(), add: () => this.#addPicked(), library: (library) => this.#edit({ library, rows: [], lock: null }, "choose a library") });
    this.options = new KeyOptions({
      change: (change, label) => this.#edit(change, label),
      lock: (span) => this.#lock(span),
      ghosts: () => void this.#showAlternatives(),
      time: () => app.transport.time,
    });
    this.stage = new KeyStage(app, {
      select: (i) => this.#select(i),
      place: (place, done, part) => done && this.#change(part === "heading" ? { heading: Number(place.heading.toFixed(1)) } : { position: /** @type {[number, number]} */ (place.position.map((v) => Number(v.toFixed(3)))) }, part === "heading" ? "turn a key" : "place a key"),
      end: (role, at, done) => this.#moveEnd(role, at, done),
      choose: (chosen) => this.#edit({ chosen }, "choose an alternative"),
    });
    this.auto = checkbox(() => remember("keys.auto", String(this.auto.checked)));
    this.auto.checked = remembered("keys.auto") !== "false";
    this.solveButton = button("Solve", () => this.#solve(), { class: "primary", title: "Make the motion (Enter)" });
    this.element = element(
      "div",
      { class: "keys-panel" },
      this.picker.element,
      element("section", { "aria-label": "Keys" }, element("h2", {}, "Keys"), this.list.element, element("div", { class: "buttons" }, this.solveButton, check(this.auto, "after each edit"))),
      this.form.element,
      this.options.element,
    );
    this.#listen();
  }

  enter() {
    this.#active = true;
    this.stage.enter();
    this.#show();
  }

  leave() {
    this.#active = false;
    this.stage.leave();
  }

  /** @param {MadeHeader | null} made */
  shown(made) {
    if (!this.#active) return;
    this.#trouble = null;
    this.#show();
    void this.#askMet(made);
    void this.#showAlternatives();
  }

  /**
   * @param {MadeHeader} made
   * @returns {Lane[]}
   */
  lanes(made) {
    void made;
    const { lock } = this.keys;
    const kept = lock ? [{ name: "kept", kind: /** @type {const} */ ("moves"), spans: [{ start: lock.span[0], stop: lock.span[1], label: "kept as it was" }], draggable: false }] : [];
    return [this.#lane(), ...kept];
  }

  /**
   * Adds a key of a pose of a take.
   *
   * @param {string} take
   * @param {number} second
   * @param {string} library
   */
  addPose(take, second, library) {
    const keys = this.keys;
    if (library && !this.rows.length && library !== (keys.library ?? "")) this.app.connection.edit("keys", { ...keys, library }, { label: "choose a library", solve: false });
    this.#add({ pose: `take:${take}@${Number(second.toFixed(3))}` });
  }

  /** @returns {Keys} */
  get keys() {
    return this.app.store.project.keys ?? {};
  }

  /** @returns {KeyRow[]} */
  get rows() {
    return this.keys.rows ?? [];
  }

  #listen() {
    const { store, connection, timeline, transport } = this.app;
    store.on("project", () => this.#active && this.#show());
    store.on("welcome", () => {
      this.picker.forget(); // a recording may have been dropped
      if (this.#active) void this.picker.show(this.keys.library ?? "");
    });
    connection.on("failed", (message) => this.#active && message.section === "keys" && void this.#askTrouble());
    transport.on("time", (time) => {
      if (!this.#active) return;
      this.#scrubbed = false;
      this.stage.seek(time);
    });
    timeline.on("hover", (where) => this.#active && where?.lane.name === LANE && document.activeElement?.classList.contains("span") && this.#select(where.span.data));
    timeline.on("pick", ({ lane, span, event }) => {
      if (!this.#active || lane.name !== LANE) return;
      this.#select(span.data);
      if (event instanceof KeyboardEvent) this.#solve();
      else transport.seek(span.start);
    });
    timeline.on("drag", (move) => this.#retime(move));
    timeline.on("dragwindow", (move) => this.#retime(move));
    timeline.on("remove", ({ lane, span }) => this.#active && lane.name === LANE && this.#remove(span.data));
    document.addEventListener("keydown", (event) => this.#key(event));
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (!this.#active || !this.element.isConnected || event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    const key = event.key.toLowerCase();
    const scrubbing = event.target instanceof HTMLInputElement && event.target.type === "range";
    if (isTyping(event) && !(scrubbing && key === "k")) return;
    const onButton = event.target instanceof HTMLElement && event.target.closest("button, a, summary") !== null;
    if (key === "k") this.#addHere();
    else if (key === "w") this.#window();
    else if (key === "enter" && !onButton) this.#solve();
    else return;
    event.preventDefault();
  }

  #show() {
    const { rows } = this;
    if (this.#selected >= rows.length) this.#selected = Math.max(rows.length - 1, 0);
    if (this.#met && this.#met.length !== rows.length) this.#met = null;
    if (this.#trouble && typeof this.#trouble.row === "number" && this.#trouble.row >= rows.length) this.#trouble = null;
    void this.picker.show(this.keys.library ?? "");
    this.list.show(rows, this.#selected, this.#met, this.#trouble);
    this.#showForm();
    this.options.show(this.keys, this.app.store.made);
    this.#showStage();
    this.#showTimeline();
  }

  #showForm() {
    const index = this.#selected;
    const row = this.#draft ?? this.rows[index];
    if (!row) return this.form.show(null);
    this.form.show({ row, index, time: spansOf(this.rows, this.#met)[index][0], place: this.#places()[index], ends: this.#ends });
    const name = JSON.stringify([row.pose, row.moved ?? {}]);
    if (name !== this.#endsOf) void this.#askEnds(row, name);
  }

  #showStage() {
    const rows = this.rows.map((row, i) => (i === this.#selected && this.#draft ? this.#draft : row));
    this.stage.show(rows, this.#places(), rows.length ? this.#selected : -1, this.#ends);
  }

  /**
   * Where keys are shown: where they are asked for, where they were met, or else one after another.
   *
   * @returns {Place[]}
   */
  #places() {
    /** @type {Place[]} */
    const places = [];
    this.rows.forEach((row, i) => {
      const met = this.#met?.[i];
      const before = places[i - 1];
      const position = row.position ?? met?.position ?? (before ? [before.position[0] + 0.9, before.position[1]] : [0, 0]);
      places.push({ position: /** @type {[number, number]} */ (position), heading: row.heading ?? met?.heading ?? 0 });
    });
    return places;
  }

  /** @returns {Lane} */
  #lane() {
    const spans = spansOf(this.rows, this.#met).map(([start, stop], i) => {
      const free = windowOf(this.rows[i], i) === null;
      const title = `${nameOf(this.rows[i], i)}: ${poseOf(this.rows[i]).source}${free ? ", its time is free" : ""}. Drag to retime, Ctrl-drag for a window, Delete removes.`;
      return { start, stop, label: nameOf(this.rows[i], i), title, marked: i === this.#selected, data: i, colour: this.#trouble?.row === i ? "var(--bad)" : undefined };
    });
    return { name: LANE, kind: "keys", spans, draggable: true };
  }

  #showTimeline() {
    const { timeline, clip, store } = this.app;
    const inside = timeline.element.contains(document.activeElement) && document.activeElement?.classList.contains("span");
    const last = Math.max(0, ...spansOf(this.rows, this.#met).map(([, stop]) => stop));
    const length = Math.max(clip?.duration ?? 0, last);
    timeline.setDuration(length + ROOM, clip?.fps ?? 30, store.made ? clip?.duration : undefined);
    if (store.made) this.app.showLanes();
    else timeline.setLanes(this.rows.length ? [this.#lane()] : []);
    if (inside) this.#focusSpan(this.#selected);
  }

  /** @param {number} index */
  #focusSpan(index) {
    const lane = [...this.app.timeline.rows.querySelectorAll(".lane.keys")][0];
    /** @type {HTMLElement | undefined} */ (lane?.querySelectorAll(".span")[index])?.focus();
  }

  // ---- edits ----

  /**
   * @param {Partial<Keys>} change
   * @param {string} label
   * @param {boolean} [merge]
   */
  #edit(change, label, merge = false) {
    const fresh = change.rows || change.moves || change.without || change.library !== undefined ? { chosen: 0 } : {};
    this.app.connection.edit("keys", { ...this.keys, ...fresh, ...change }, { label, merge, solve: this.auto.checked || change.chosen !== undefined });
  }

  /**
   * @param {Change} change
   * @param {string} label
   * @param {boolean} [merge]
   */
  #change(change, label, merge = false) {
    if (!this.rows[this.#selected]) return;
    const { rows, index } = changed(this.rows, this.#selected, change, this.#met);
    if (this.#met) this.#met = sorted(this.#met, this.rows, rows);
    this.#selected = index;
    this.#draft = null;
    this.#edit({ rows }, label, merge);
  }

  /** @param {number} index */
  #remove(index) {
    const rows = this.rows.filter((_, i) => i !== index);
    if (rows.length === this.rows.length) return;
    if (index === 0 && rows.length) rows[0] = { ...rows[0], time: undefined };
    this.#met = this.#met?.filter((_, i) => i !== index) ?? null;
    this.#selected = Math.min(index, Math.max(rows.length - 1, 0));
    this.#edit({ rows }, "remove a key");
  }

  /** @param {KeyRow} row */
  #add(row) {
    const { rows, index } = added(this.rows, row, this.#met);
    this.#met = null;
    this.#selected = index;
    this.#edit({ rows }, "add a key");
    this.app.say(`${nameOf(row, index)} added${rows.length < 2 ? "; add another" : ""}`);
  }

  /** A key of what is scrubbed: of the recording that is looked through, or of the result. */
  #addHere() {
    const { store, transport } = this.app;
    if (this.#scrubbed || !store.made) return this.#addPicked();
    const time = transport.time;
    const piece = [...(store.made.pieces ?? [])].reverse().find((each) => each.start <= time + 1e-6);
    if (!piece) return this.#addPicked();
    if (piece.mirrored) return this.app.say("this part is mirrored; choose its pose from the recording", "error");
    const share = (time - piece.start) / Math.max(piece.stop - piece.start, 1e-6);
    const second = this.picker.within(piece.take, piece.source_start + share * (piece.source_stop - piece.source_start));
    this.#add({ pose: `take:${piece.take}@${Number(second.toFixed(3))}`, time: this.rows.length ? timeFrom(time, time) : undefined });
  }

  #addPicked() {
    const { pose } = this.picker;
    if (!pose) return this.app.say("there is no take to choose a pose from", "error");
    this.stage.showPreview(null, { position: [0, 0], heading: 0 });
    this.#scrubbed = false;
    this.#add({ pose });
  }

  #scrub() {
    this.#scrubbed = true;
    const { pose } = this.picker;
    const last = this.#places()[this.rows.length - 1];
    const position = /** @type {[number, number]} */ (last ? [last.position[0] + 0.9, last.position[1]] : [0, 0]);
    this.stage.showPreview(pose ? { pose } : null, { position, heading: last?.heading ?? 0 });
  }

  /** @param {Move} move */
  #retime({ lane, span, start, stop, done }) {
    if (!this.#active || lane.name !== LANE) return;
    this.#selected = span.data;
    if (!done) return;
    if (span.data === 0) {
      this.app.say("time begins with the first key; move the others");
      return this.#show();
    }
    this.#change({ time: timeFrom(start, stop) }, `retime ${nameOf(this.rows[span.data], span.data)}`, true);
  }

  /** Opens a window of time around the selected key, or closes it. */
  #window() {
    const row = this.rows[this.#selected];
    if (!row) return;
    if (this.#selected === 0) return this.app.say("time begins with the first key; open windows for the others");
    const [start, stop] = spansOf(this.rows, this.#met)[this.#selected];
    const middle = (start + stop) / 2;
    this.#change({ time: stop > start ? timeFrom(middle, middle) : timeFrom(start - 0.25, stop + 0.25) }, "open a window");
  }

  /**
   * @param {number} index
   * @param {number} seconds
   */
  #putOff(index, seconds) {
    this.#edit({ rows: putOff(this.rows, index, seconds) }, "give a key more time");
  }

  /** @param {[number, number]} span */
  #lock(span) {
    const { keys } = this;
    this.#edit({ lock: { span, of: keys }, chosen: 0 }, "lock a part");
  }

  /**
   * @param {string} role
   * @param {[number, number, number]} at
   * @param {boolean} done
   */
  #moveEnd(role, at, done) {
    const row = this.rows[this.#selected];
    const moved = { ...row.moved, [role]: at };
    if (done) return this.#change({ moved }, `move ${role.replace("_", " ")}`);
    this.#draft = { ...row, moved };
    if (this.#asked === 0) this.#showStage();
    this.#showForm();
  }

  #solve() {
    this.app.connection.send({ kind: "solve" });
  }

  /** @param {number} index */
  #select(index) {
    if (index === this.#selected || !this.rows[index]) return;
    this.#selected = index;
    this.#draft = null;
    this.#ends = null;
    this.#show();
  }

  // ---- questions ----

  /**
   * @param {KeyRow} row
   * @param {string} name
   */
  async #askEnds(row, name) {
    if (this.#asked) return; // one at a time; the last one is asked for after it
    this.#endsOf = name;
    this.#asked += 1;
    try {
      this.#ends = await this.app.connection.ask({ kind: "key_ends", row: { pose: row.pose, moved: row.moved ?? {} } });
    } catch {
      this.#ends = null;
    } finally {
      this.#asked -= 1;
    }
    if (!this.#active) return;
    this.#showForm();
    this.#showStage();
  }

  /** @param {MadeHeader | null} made */
  async #askMet(made) {
    if (!made) return;
    try {
      const { rows } = await this.app.connection.ask({ kind: "keys_met" });
      if (this.app.store.made !== made || rows.length !== this.rows.length) return;
      this.#met = rows;
      this.#show();
    } catch {
      // the keys have changed since; what is made next says where they are
    }
  }

  async #askTrouble() {
    try {
      const trouble = await this.app.connection.ask({ kind: "key_trouble" });
      this.#trouble = trouble.message ? trouble : null;
      this.#show();
    } catch {
      // the status line has the reason
    }
  }

  async #showAlternatives() {
    const { connection, store } = this.app;
    const made = store.made;
    const chosen = made?.chosen ?? 0;
    const numbers = this.options.ghosts.value !== "none" ? (made?.costs ?? []).map((_, i) => i).filter((i) => i !== chosen) : [];
    try {
      const others = await Promise.all(numbers.map(async (number) => ({ number, clip: await loadClip((await connection.ask({ kind: "alternative", number })).payload) })));
      if (store.made !== made || !this.#active) for (const { clip } of others) clip.dispose();
      else this.stage.showAlternatives(others, this.options.ghosts.value === "beside");
    } catch {
      this.stage.showAlternatives([]);
    }
  }
}

/**
 * Where rows were met, in another order of them.
 *
 * @param {MetRow[]} met
 * @param {KeyRow[]} before
 * @param {KeyRow[]} after
 * @returns {MetRow[] | null}
 */
function sorted(met, before, after) {
  const left = before.map((row, i) => ({ row, met: met[i] }));
  const found = after.map((row) => {
    const at = left.findIndex((each) => each.row === row);
    return at < 0 ? null : left.splice(at, 1)[0].met;
  });
  return found.map((each) => each ?? left[0].met);
}
