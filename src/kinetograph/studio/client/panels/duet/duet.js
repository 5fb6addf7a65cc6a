// The panel of a duet: a leader is chosen, and what answers him is looked at.
import { Between } from "../../stage/between.js";
import { loadClip } from "../../stage/body.js";
import { button, element, field, slider } from "../../dom.js";
import { LEADER, Rehearsal } from "./rehearsal.js";
import { Pieces } from "../walk/pieces.js";

/**
 * @typedef {import("../../studio.js").Panel} Panel
 * @typedef {import("../../messages.js").Duet} Duet
 * @typedef {import("../../messages.js").MadeHeader} MadeHeader
 * @typedef {import("../../messages.js").LeaderTakes} LeaderTakes
 * @typedef {import("../../messages.js").LeaderFacts} LeaderFacts
 * @typedef {import("../../messages.js").MoveRow} MoveRow
 * @typedef {import("../../stage/body.js").Clip} Clip
 */

const TAKE = "take:";
const TRUTH = "#2f9e6e";
const GHOST = 0.4;
const PATIENCE = 4000; // milliseconds after which it is said what takes so long
const UNITS = ["metre", "centimetre", "millimetre", "inch", "foot", "cmu"];
const MOTIONS = ".amc,.bvh,.c3d,.fbx,.glb,.gltf,.json,.npz,.txt,.usd,.usda,.usdc";
const SLOW = "still searching; the first dance after an installation also compiles the search, which takes some seconds more";

/**
 * @param {import("../../studio.js").App} app
 * @returns {Panel}
 */
export function createDuet(app) {
  return new DuetPanel(app);
}

/** @implements {Panel} */
class DuetPanel {
  /** @type {LeaderTakes | null} */
  #takes = null;
  /** @type {LeaderFacts | null} */
  #facts = null;
  /** @type {MadeHeader | null} */
  #made = null;
  /** @type {Clip | null} */
  #clip = null;
  /** @type {MoveRow[]} */
  #moves = [];
  #movesOf = "";
  #entered = false;
  #askedOf = "";
  #factsOf = "";
  #framed = "";
  #began = 0;
  #previewing = false;

  /** @param {import("../../studio.js").App} app */
  constructor(app) {
    this.app = app;
    this.between = new Between(app.stage);
    this.rehearsal = new Rehearsal(app, (state) => this.#rehearsed(state));
    this.pieces = new Pieces(app, (change, label) => this.#edit(change, label), "duet");
    this.element = element("div", { class: "duet" }, this.#leaderSection(), this.#followerSection(), this.#shownSection(), this.pieces.element, this.#moveSection(), this.#liveSection());
    app.store.on("project", () => this.#entered && this.#showProject());
    app.store.on("welcome", () => this.#entered && void this.#ask(true));
    app.store.on("state", () => this.#entered && this.#showWork());
    app.connection.on("working", (message) => this.#entered && message.section === "duet" && this.#progress(message));
    app.transport.on("time", (time) => this.#entered && this.#seek(time));
    app.timeline.on("hover", (where) => this.#entered && void this.pieces.hover(where?.lane.kind === "pieces" ? where.span.data : null));
    app.timeline.on("pick", (where) => this.#entered && this.#pick(where));
  }

  /** @returns {Duet} */
  get duet() {
    return this.app.store.project.duet ?? {};
  }

  enter() {
    this.#entered = true;
    this.app.stage.add(this.between.object);
    void this.#ask(true);
    this.#showProject();
    this.#showWork();
  }

  leave() {
    this.rehearsal.stop();
    this.pieces.close();
    this.#endPreview();
    this.#entered = false;
    this.app.stage.remove(this.between.object);
  }

  /**
   * @param {MadeHeader | null} made
   * @param {Clip | null} clip
   */
  shown(made, clip) {
    this.#endPreview();
    this.pieces.close();
    if (made?.key !== this.#movesOf) this.#moves = [];
    this.#made = made;
    this.#clip = clip;
    const who = (/** @type {string} */ name) => clip?.characters.indexOf(name) ?? -1;
    this.between.show(clip, { follower: 0, leader: who("leader"), truth: who("truth") });
    if (clip && this.#framed !== this.duet.leader) {
      this.#framed = this.duet.leader ?? "";
      this.app.stage.frame(clip.box());
    }
    this.#showBodies();
    this.#showMoves();
    if (made) void this.#askAbout(made);
  }

  /**
   * @param {string} name
   * @param {string} role
   */
  dropped(name, role) {
    if (role === "leader") this.#lead(name);
  }

  /**
   * @param {MadeHeader} made
   * @returns {import("../../time/timeline.js").Lane[]}
   */
  lanes(made) {
    const spans = (made.key === this.#movesOf ? this.#moves : [])
      .filter(({ move }) => move)
      .map(({ move, start, stop, margin, notation }) => ({ start, stop, label: notation || move, title: `${move}, ${marginOf(margin)}` }));
    return [...this.pieces.lanes, ...(spans.length ? [{ name: "moves", kind: /** @type {const} */ ("moves"), spans }] : [])];
  }

  // ---- sections ----

  #leaderSection() {
    this.library = element("select", { onchange: () => this.#edit({ library: this.library?.value, ...NOBODY, target: "" }, "choose a library") });
    this.leader = element("select", { onchange: () => this.#lead(this.leader?.value ?? "") });
    this.person = element("select", { onchange: () => this.#edit({ person: this.person?.value }, "choose who leads") });
    this.units = element("select", { onchange: () => this.#edit({ units: this.units?.value }, "set units") }, options(["", ...UNITS], "", "guess"));
    this.up = element("select", { onchange: () => this.#edit({ up: this.up?.value }, "set the upward axis") }, options(["", "y", "z", "x"], "", "guess"));
    const file = element("input", { type: "file", accept: MOTIONS, hidden: true, "aria-label": "A motion file to lead", onchange: () => this.#open(file) });
    this.advice = element("div", { class: "advice warn", role: "note", hidden: true });
    this.notes = element("ul", { class: "notes", "aria-label": "What was guessed of the leader" });
    this.personField = field("Person", this.person);
    this.unitsField = field("Units", this.units);
    this.upField = field("Upward axis", this.up);
    return element(
      "section",
      { "aria-label": "Leader" },
      element("h2", {}, "Leader"),
      this.advice,
      field("Library", this.library),
      field("Leader", this.leader),
      this.personField, this.unitsField, this.upField,
      element("div", { class: "buttons" }, button("Open a file", () => file.click()), file),
      element("p", { class: "note" }, "or drop a motion file here: any format, one person or several"),
      this.notes,
    );
  }

  #followerSection() {
    this.target = element("select", { onchange: () => this.#edit({ target: this.target?.value, ...NOBODY }, "choose who follows") });
    this.mirror = check("Mirrored recordings too", (on) => this.#edit({ mirror: on }, "mirror recordings"));
    this.work = element("p", { class: "note", role: "status" });
    this.bar = element("progress", { max: 1, value: 0, "aria-label": "How far the search is", hidden: true });
    this.workButton = button("Answer the leader", () => this.#solve());
    return element(
      "section",
      { "aria-label": "Follower" },
      element("h2", {}, "Follower"),
      field("Makes", this.target),
      this.mirror.element,
      element("div", { class: "buttons" }, this.workButton),
      this.bar,
      this.work,
    );
  }

  #shownSection() {
    this.truth = check("Recorded follower, as a ghost", () => this.#showBodies(), true);
    this.distances = check("Lines to where it was recorded", () => this.#showBodies());
    this.hands = check("Lines between hands held", () => this.#showBodies(), true);
    this.now = element("p", { class: "note" });
    return element(
      "section",
      { "aria-label": "Shown" },
      element("h2", {}, "Shown"),
      element("p", { class: "note" }, "The leader is grey, and the recorded follower a green ghost."),
      this.truth.element, this.distances.element, this.hands.element, this.now,
    );
  }

  #moveSection() {
    this.moves = element("ul", { class: "list moves-list", "aria-label": "Transcript" });
    this.movesNote = element("p", { class: "note", role: "status" });
    return element("section", { "aria-label": "Moves" }, element("h2", {}, "Transcript"), this.movesNote, this.moves);
  }

  #liveSection() {
    this.lag = slider("Decide after", { min: 0.2, max: 1.5, step: 0.1, value: 0.5, unit: "s" }, (value) => (this.#lag = value));
    this.liveButton = button("Rehearse live", () => this.#rehearse());
    this.live = element("p", { class: "note", role: "status" });
    return element(
      "section",
      { "aria-label": "Live" },
      element("h2", {}, "Live"),
      element("p", { class: "note" }, "The leader dances now; the follower is decided by what it has seen of him."),
      this.lag,
      element("div", { class: "buttons" }, this.liveButton),
      this.live,
    );
  }

  #lag = 0.5;

  // ---- the project ----

  /**
   * @param {Partial<Duet>} change
   * @param {string} label
   */
  #edit(change, label) {
    this.rehearsal.stop();
    if (this.live) this.live.textContent = "";
    this.app.connection.edit("duet", { ...this.duet, ...change }, { label });
  }

  /** @param {string} leader */
  #lead(leader) {
    this.#edit({ ...NOBODY, leader }, leader ? `follow ${leader.replace(TAKE, "")}` : "follow nobody");
  }

  /** @param {HTMLInputElement} input */
  async #open(input) {
    const [file] = input.files ?? [];
    input.value = "";
    if (!file) return;
    this.app.say(`taking ${file.name}`);
    try {
      const { name } = await this.app.connection.upload(file, "leader");
      this.app.say(`${name} is in the project`);
      this.#lead(name);
    } catch (error) {
      this.app.say(/** @type {Error} */ (error).message, "error");
    }
  }

  #solve() {
    if (this.app.store.state === "solving") this.app.connection.send({ kind: "cancel" });
    else this.app.connection.send({ kind: "solve" });
  }

  #showProject() {
    const { duet } = this;
    const isFile = Boolean(duet.leader) && !duet.leader?.startsWith(TAKE);
    this.#showChoices();
    this.pieces.show();
    this.mirror?.set(duet.mirror ?? false);
    if (this.unitsField && this.upField && this.units && this.up) {
      this.unitsField.hidden = this.upField.hidden = !isFile;
      this.units.value = duet.units ?? "";
      this.up.value = duet.up ?? "";
    }
    if (duet.library !== undefined && duet.library !== this.#askedOf) void this.#ask(false);
    const leader = JSON.stringify([duet.library, duet.leader, duet.target, duet.person, duet.units, duet.up]);
    if (leader !== this.#factsOf) void this.#askLeader(leader);
  }

  #showChoices() {
    const { library, leader, target, person, duet } = this;
    const { store } = this.app;
    if (!library || !leader || !target || !person) return;
    const libraries = store.welcome?.libraries ?? [];
    library.replaceChildren(...libraries.map(({ name, partners }) => element("option", { value: name, selected: name === (this.#takes?.library || duet.library) }, partners ? name : `${name} (no partners)`)));
    library.disabled = libraries.length < 2;
    const takes = (this.#takes?.takes ?? []).map(({ take, seconds }) => choice(`${TAKE}${take}`, `${take} (${seconds.toFixed(0)} s)`, duet.leader));
    const files = [...new Set([...(store.welcome?.files ?? []).filter(isMotion), ...(duet.leader && !duet.leader.startsWith(TAKE) ? [duet.leader] : [])])];
    leader.replaceChildren(
      choice("", "choose", duet.leader ?? ""),
      ...(takes.length ? [element("optgroup", { label: "Takes" }, takes)] : []),
      ...(files.length ? [element("optgroup", { label: "Files" }, files.map((name) => choice(name, name, duet.leader)))] : []),
    );
    target.replaceChildren(...(this.#takes?.targets ?? []).map((name) => choice(name, name, duet.target || this.#takes?.target)));
    const persons = this.#facts?.persons ?? [];
    person.replaceChildren(...persons.map((name) => choice(name, name, this.#facts?.person)));
    if (this.personField) this.personField.hidden = persons.length < 2;
    this.#showNotes();
  }

  #showNotes() {
    const advice = this.#takes?.advice ?? "";
    const [said, ...commands] = advice.split(/; (?=kinetograph)|: (?=kinetograph)/);
    if (this.advice) this.advice.hidden = !advice;
    this.advice?.replaceChildren(element("p", {}, said), ...commands.map((command) => element("code", {}, command)));
    this.notes?.replaceChildren(...(this.#facts?.notes ?? []).map((note) => element("li", { class: "note" }, note)));
  }

  /** @param {boolean} anew */
  async #ask(anew) {
    const library = this.duet.library ?? "";
    if (!anew && library === this.#askedOf) return;
    this.#askedOf = library;
    try {
      this.#takes = await this.app.connection.ask({ kind: "ask_leaders" });
    } catch (error) {
      return this.app.say(/** @type {Error} */ (error).message, "error");
    }
    if (this.#entered) this.#showChoices();
  }

  /** @param {string} of */
  async #askLeader(of) {
    this.#factsOf = of;
    this.#facts = null;
    if (!this.duet.leader) return this.#showChoices();
    try {
      const facts = await this.app.connection.ask({ kind: "ask_leader" });
      if (of !== this.#factsOf) return;
      this.#facts = facts;
      this.#showChoices();
      await this.#preview(of);
    } catch {
      // the section says what is wrong with its leader
    }
  }

  /**
   * Shows the leader alone until the follower is there.
   *
   * @param {string} of
   */
  async #preview(of) {
    if (this.app.store.state !== "solving" || this.rehearsal.running) return;
    const { header, payload } = await this.app.connection.ask({ kind: "show_leader" });
    const clip = await loadClip(payload);
    if (of !== this.#factsOf || this.app.store.state !== "solving" || !this.#entered || this.rehearsal.running) return clip.dispose();
    clip.setGhost(1, LEADER);
    this.#previewing = true;
    this.app.preview(clip, header.floor ?? 0, []);
    this.app.stage.frame(clip.box());
  }

  #endPreview() {
    if (!this.#previewing) return;
    this.#previewing = false;
    this.app.endPreview();
  }

  // ---- the work ----

  /** @param {import("../../messages.js").Working} message */
  #progress({ done, total }) {
    if (this.bar) this.bar.value = total > 0 ? done / total : 0;
  }

  #showWork() {
    const { state } = this.app.store;
    const solving = state === "solving";
    if (!this.workButton || !this.work || !this.bar) return;
    this.workButton.textContent = solving ? "Stop" : "Answer the leader";
    this.workButton.disabled = !this.duet.leader;
    if (this.liveButton) this.liveButton.disabled = !this.duet.leader;
    this.bar.hidden = !solving;
    if (!solving) {
      this.#began = 0;
      this.work.textContent = this.duet.leader ? "" : "Choose who leads, and somebody made of the other takes follows.";
      if (state !== "ready") this.#endPreview();
    } else if (!this.#began) {
      this.#began = performance.now();
      this.#wait(this.#began);
    }
  }

  /** @param {number} began */
  #wait(began) {
    if (began !== this.#began || !this.work) return;
    const passed = performance.now() - began;
    this.work.textContent = passed < PATIENCE ? "searching" : `${SLOW} (${(passed / 1000).toFixed(0)} s)`;
    setTimeout(() => this.#wait(began), 500);
  }

  // ---- what was made ----

  #showBodies() {
    const clip = this.#clip;
    if (!clip) return this.#seek(this.app.transport.time);
    const has = clip.characters.includes("truth");
    clip.characters.forEach((name, i) => {
      const figure = clip.figures[i];
      if (name === "leader") figure.setGhost(1, LEADER);
      if (name === "truth") figure.setGhost(GHOST, TRUTH);
      figure.object.visible = name !== "truth" || Boolean(this.truth?.on);
    });
    this.truth?.enable(has);
    this.distances?.enable(has);
    this.between.distances = Boolean(this.distances?.on);
    this.between.hands = Boolean(this.hands?.on);
    this.#seek(this.app.transport.time);
  }

  /** @param {number} time */
  #seek(time) {
    this.between.object.visible = !this.#previewing && !this.rehearsal.running;
    this.between.seek(time);
    const lane = this.#made?.lanes?.find(({ role }) => role === "error");
    const values = lane?.values ?? [];
    const at = Math.round((time / Math.max(this.#made?.seconds ?? 1, 1e-9)) * (values.length - 1));
    if (this.now) this.now.textContent = values.length ? `Now ${values[Math.min(at, values.length - 1)].toFixed(1)} cm from the recording` : "";
    for (const row of this.moves?.children ?? []) {
      const { start, stop } = /** @type {HTMLElement} */ (row).dataset;
      const here = Number(start) <= time && time < Number(stop);
      row.firstElementChild?.setAttribute("aria-current", String(here));
    }
    this.app.stage.render();
  }

  /** @param {MadeHeader} made */
  async #askAbout(made) {
    const { connection } = this.app;
    try {
      const { holds } = await connection.ask({ kind: "ask_hands" });
      if (made !== this.#made) return;
      this.between.setHolds(holds ?? []);
      this.#seek(this.app.transport.time);
    } catch {
      // another follower is being shown
    }
    await this.#transcribe(made);
  }

  /** @param {MadeHeader} made */
  async #transcribe(made) {
    if (this.#moves.length || !this.movesNote) return;
    this.movesNote.textContent = "reading the moves, and how sure each is";
    try {
      const { moves, advice } = await this.app.connection.ask({ kind: "transcribe" });
      if (made !== this.#made) return;
      this.#moves = moves ?? [];
      this.#movesOf = made.key;
      this.movesNote.textContent = advice ?? "";
      this.#showMoves();
      this.app.showLanes();
    } catch (error) {
      if (made === this.#made) this.movesNote.textContent = /** @type {Error} */ (error).message;
    }
  }

  #showMoves() {
    if (this.movesNote && !this.#moves.length) this.movesNote.textContent = "";
    const rows = this.#moves.map(({ move, start, stop, margin }) =>
      element(
        "li",
        { "data-start": start, "data-stop": stop },
        button("", () => this.app.transport.seek(start), { class: "move-row", title: `${move || "no name"}: ${marginOf(margin)}`, "aria-label": `${start.toFixed(1)} s, ${move || "no name"}, ${marginOf(margin)}` }),
      ),
    );
    this.#moves.forEach(({ move, start, margin, notation }, i) =>
      rows[i].firstElementChild?.append(
        element("span", { class: "move-time" }, `${start.toFixed(1)} s`),
        element("span", { class: "move-notation", "aria-hidden": "true" }, notation ?? ""),
        element("span", { class: "move-margin" }, move ? percent(margin) : ""),
        element("span", { class: "move-name" }, move || "(no name)"),
      ),
    );
    this.moves?.replaceChildren(...rows);
  }

  /** @param {import("../../time/timeline.js").Where} where */
  #pick(where) {
    if (where.lane.kind === "pieces") void this.pieces.open(where.span.data);
    else this.app.transport.seek(where.span.start);
  }

  // ---- live ----

  #rehearse() {
    if (this.rehearsal.running) return this.rehearsal.stop();
    this.#endPreview();
    if (this.liveButton) this.liveButton.textContent = "Stop rehearsing";
    if (this.live) this.live.textContent = "getting ready";
    void this.rehearsal.start(this.#lag);
  }

  /** @param {import("../../messages.js").Rehearsed | null} state */
  #rehearsed(state) {
    if (!this.live || !this.liveButton) return;
    if (!state) {
      this.liveButton.textContent = "Rehearse live";
      this.#seek(this.app.transport.time);
      return;
    }
    const load = state.load ?? 0;
    const parts = [`${state.lag.toFixed(2)} s behind the leader`];
    if (load > 1) parts.push(`the leader waits: this machine needs ${load.toFixed(1)} s of work for a second`);
    else if (load) parts.push(`${Math.round(100 * load)} % of the time is needed`);
    if (state.error !== null && state.error !== undefined) parts.push(`${state.error.toFixed(1)} cm from the recording in the mean`);
    this.live.textContent = parts.join("; ");
  }
}

const NOBODY = { leader: "", person: "", units: "", up: "", rules: [] };

/**
 * @param {string} value
 * @param {string} name
 * @param {string | undefined} chosen
 */
function choice(value, name, chosen) {
  return element("option", { value, selected: value === chosen }, name);
}

/**
 * @param {string[]} values
 * @param {string} chosen
 * @param {string} none what the empty one is called
 */
function options(values, chosen, none) {
  return values.map((value) => choice(value, value || none, chosen));
}

/** @param {string} name */
function isMotion(name) {
  return MOTIONS.split(",").some((suffix) => name.toLowerCase().endsWith(suffix));
}

/** @param {number | null | undefined} margin */
function percent(margin) {
  return margin === null || margin === undefined ? "only one" : `+${(100 * margin).toFixed(margin < 0.1 ? 1 : 0)} %`;
}

/** @param {number | null | undefined} margin */
function marginOf(margin) {
  return margin === null || margin === undefined ? "nothing else fits" : `anything else costs ${(100 * margin).toFixed(margin < 0.1 ? 1 : 0)} % more`;
}

/**
 * @param {string} name
 * @param {(on: boolean) => void} changed
 * @param {boolean} [on]
 */
function check(name, changed, on = false) {
  const box = element("input", { type: "checkbox", checked: on, onchange: () => changed(box.checked) });
  const label = element("label", { class: "check" }, box, name);
  return {
    element: label,
    get on() {
      return box.checked && !box.disabled;
    },
    set: (/** @type {boolean} */ to) => void (box.checked = to),
    enable: (/** @type {boolean} */ to) => void (box.disabled = !to),
  };
}
