// The pieces of a walk or a duet: where they come from, what is pinned and forbidden, and the next best ones side by side.
import { loadClip } from "../../stage/body.js";
import { button, element, iconButton } from "../../dom.js";

/**
 * @typedef {import("../../messages.js").PieceRow} PieceRow
 * @typedef {import("../../messages.js").RuleRow} RuleRow
 * @typedef {import("../../messages.js").CandidateRow} CandidateRow
 * @typedef {import("../../messages.js").WhyRow} WhyRow
 * @typedef {import("../../stage/body.js").Clip} Clip
 */

const TERMS = /** @type {const} */ (["interpretation", "continuity", "reuse"]);
const GHOST = 0.45;
const NAMES = /** @type {Record<string, string>} */ ({ before: "seam before", after: "seam after", change: "change of person", keys: "unlike keys", rules: "moves not asked for" });
const TINY = 1e-7; // what costs no more costs nothing

/** What a person sees of pieces and does to them. */
export class Pieces {
  /** @type {{clip: Clip, start: number} | null} */
  #ghost = null;
  #wanted = 0; // counts what was asked for, so that what comes too late is not shown

  /**
   * @param {import("../../studio.js").App} app
   * @param {(change: {rules: RuleRow[]}, label: string) => void} edit
   * @param {"walk" | "duet"} section whose pieces they are
   * @param {(time: number) => number} second the second of the control for one of the result
   */
  constructor(app, edit, section = "walk", second = (time) => time) {
    this.app = app;
    this.second = second;
    this.section = section;
    this.edit = edit;
    this.list = element("ul", { class: "list rules", "aria-label": "Pinned and forbidden pieces" });
    /** In the panel: what is pinned and forbidden. */
    this.element = element("section", { "aria-label": "Pieces", hidden: true }, element("h2", {}, "Pinned and forbidden"), this.list);
    /** On the stage: a piece and what could take its place. */
    this.card = element("section", { class: "candidates", "aria-label": "Piece", hidden: true });
    app.stage.parent.append(this.card);
    this.card.addEventListener("keydown", (event) => event.key === "Escape" && this.close());
    app.transport.on("time", () => this.#seek());
  }

  /** @returns {RuleRow[]} */
  get rules() {
    return this.app.store.project[this.section]?.rules ?? [];
  }

  /** Shows what is pinned and forbidden. */
  show() {
    const { rules } = this;
    this.element.hidden = rules.length === 0;
    this.list.replaceChildren(
      ...rules.map((rule, i) =>
        element(
          "li",
          { class: "rule-row" },
          element("span", {}, `${words(rule)}, ${rule.start.toFixed(1)} to ${rule.stop.toFixed(1)} s`),
          iconButton("close", `Remove: ${words(rule)}`, () => this.edit({ rules: rules.filter((_, k) => k !== i) }, "let a piece free"), { class: "quiet" }),
        ),
      ),
    );
  }

  /**
   * Lanes of what is pinned and forbidden.
   *
   * @returns {import("../../time/timeline.js").Lane[]}
   */
  get lanes() {
    const spans = this.rules.map((rule) => ({ start: rule.start, stop: rule.stop, label: words(rule), marked: !rule.forbid, colour: rule.forbid ? "var(--bad)" : undefined }));
    return spans.length ? [{ name: "rules", kind: "moves", spans }] : [];
  }

  /**
   * Shows the recording behind a piece as a ghost, and says where it comes from.
   *
   * @param {PieceRow | null} piece
   */
  async hover(piece) {
    const number = (this.#wanted += 1);
    if (!piece) return this.#showGhost(null);
    this.app.say(`${source(piece)}, ${piece.start.toFixed(2)} to ${piece.stop.toFixed(2)} s`);
    await new Promise((resolve) => setTimeout(resolve, 120)); // who passes over a piece does not ask for it
    if (number === this.#wanted) await this.#ask({ kind: "piece_source", time: Math.max((piece.start + piece.stop) / 2, 0) }, number);
  }

  /**
   * Opens a piece.
   *
   * @param {PieceRow} piece
   */
  async open(piece) {
    this.app.transport.pause();
    const time = Math.max((Math.max(piece.start, 0) + piece.stop) / 2, 0);
    const heading = element("h2", {}, source(piece));
    const close = iconButton("close", "Close", () => this.close(), { class: "quiet" });
    const found = element("div", {}, element("p", { class: "note" }, "searching for the next best ones"));
    const why = button("Why?", () => void this.#why(piece, time, found), { title: "Why this piece is here, and what else could be" });
    const bar = element("div", { class: "card-bar" }, heading, element("span", { class: "spacer" }), why, this.#pin(piece, this.second(time)), this.#forbid(piece, this.second(time)), close);
    this.card.replaceChildren(bar, found);
    this.card.hidden = false;
    close.focus();
    await this.#fill(found, async () => [this.#table(await this.app.connection.ask({ kind: "next_best", time: this.#within(time), count: 4 }))]);
  }

  /** @param {number} time */
  #within(time) {
    return Math.min(time, this.app.transport.duration - 1e-3);
  }

  /** @type {object | null} */
  #filling = null; // what the card waits for

  /**
   * Shows an answer in the card, unless another was asked for meanwhile.
   *
   * @param {HTMLElement} found
   * @param {() => Promise<HTMLElement[]>} ask
   */
  async #fill(found, ask) {
    const mine = (this.#filling = {});
    try {
      const parts = await ask();
      if (this.#filling === mine) found.replaceChildren(...parts);
    } catch (error) {
      if (this.#filling === mine) found.replaceChildren(element("p", { class: "bad" }, /** @type {Error} */ (error).message));
    }
    this.#makeRoom();
  }

  /**
   * Lists what could be at the time that is shown, where that is in the piece, and what would have to go for it.
   *
   * @param {PieceRow} piece
   * @param {number} time its middle
   * @param {HTMLElement} found
   */
  async #why(piece, time, found) {
    const now = this.app.transport.time;
    const asked = this.#within(piece.start <= now && now < piece.stop ? now : time);
    found.replaceChildren(element("p", { class: "note", role: "status" }, "comparing all pieces"));
    await this.#fill(found, async () => this.#reasons(await this.app.connection.ask({ kind: "ask_why", time: asked })));
  }

  /**
   * @param {import("../../messages.js").Why} why
   * @returns {HTMLElement[]}
   */
  #reasons({ rows, without, time, span, played = [], layers = [] }) {
    const drive = layers.length ? [element("ul", { class: "list", "aria-label": "Layers here" }, layers.map((line) => element("li", {}, line)))] : [];
    if (span) {
      const said = `From ${span[0].toFixed(2)} to ${span[1].toFixed(2)} s the walk leaves the path to meet a pose. There play:`;
      return [element("p", { class: "note" }, said), element("ul", { class: "list", "aria-label": "Recordings of the span" }, played.map((each) => element("li", {}, source(each)))), ...drive];
    }
    const terms = Object.keys(rows[0]?.terms ?? {}).filter((term) => rows.some((row) => Math.abs(row.terms[term]) > TINY));
    const heads = ["rank", "from", "margin", ...terms.map((term) => NAMES[term] ?? term), "choose"].map((name) => element("th", { scope: "col" }, name));
    const body = rows.map((row, i) => this.#reason(row, i, terms, time));
    const caption = element("caption", {}, `Pieces at ${time.toFixed(2)} s. Margin: what the best whole motion with a piece costs above the optimum, reuse being free.`);
    const table = element("table", { class: "candidate-table" }, caption, element("thead", {}, element("tr", {}, heads)), element("tbody", {}, body));
    const lines = without.map((row) => element("li", {}, `Without ${row.constraint}: ${source(row)}; the whole would cost ${figure(row.saved)} less.`));
    const none = element("p", { class: "note" }, "No single constraint or cost, taken away, would put another piece here.");
    return [table, lines.length ? element("ul", { class: "list", "aria-label": "What would have to go" }, lines) : none, ...drive];
  }

  /**
   * @param {WhyRow} row
   * @param {number} index
   * @param {string[]} terms
   * @param {number} time
   */
  #reason(row, index, terms, time) {
    const name = row.chosen ? "Shown" : String(index + 1);
    const pin = row.chosen ? null : button("Pin", () => this.#rule(row, this.second(time), false), { "aria-label": `Pin ${source(row)}`, class: "small" });
    const costs = terms.map((term) => element("td", {}, figure(row.terms[term])));
    return element("tr", { class: "candidate" }, element("th", { scope: "row" }, name), element("td", {}, source(row)), element("td", {}, figure(row.margin)), costs, element("td", {}, pin));
  }

  /** Looks at the ground above the card. */
  #makeRoom() {
    const { camera, canvas } = this.app.stage;
    const { clientWidth: width, clientHeight: height } = canvas;
    if (!this.card.hidden) camera.setViewOffset(width, height, 0, this.card.offsetHeight / 2, width, height);
    this.app.stage.render();
  }

  /** Closes the piece that is open. */
  close() {
    this.card.hidden = true;
    this.#wanted += 1;
    this.#filling = null;
    this.app.stage.camera.clearViewOffset();
    this.#showGhost(null);
  }

  /**
   * @param {PieceRow} piece
   * @param {number} time
   */
  #pin(piece, time) {
    return button("Pin", () => this.#rule(piece, time, false), { title: "Keep this piece here, whatever else changes" });
  }

  /**
   * @param {PieceRow} piece
   * @param {number} time
   */
  #forbid(piece, time) {
    return button("Forbid", () => this.#rule(piece, time, true), { title: "Use something else here" });
  }

  /**
   * @param {PieceRow | CandidateRow | WhyRow} piece
   * @param {number} time
   * @param {boolean} forbid
   */
  #rule(piece, time, forbid) {
    // a pin is of this piece alone; what is forbidden is whatever shows its middle
    /** @type {number | [number, number]} */
    const part = forbid ? round((piece.source_start + piece.source_stop) / 2) : [round(piece.source_start), round(piece.source_stop)];
    const there = { start: round(time - 0.02), stop: round(time + 0.02), take: piece.take, source: part, forbid };
    const others = this.rules.filter((rule) => rule.stop < there.start || rule.start > there.stop || (forbid && rule.forbid));
    this.close();
    this.edit({ rules: [...others, there] }, forbid ? "forbid a piece" : "pin a piece");
  }

  /** @param {import("../../messages.js").Candidates} found */
  #table({ rows, time }) {
    const most = Math.max(...rows.map((one) => one.cost), 1e-9);
    const heads = ["rank", "from", "cost", "more", ...TERMS, "choose"].map((name) => element("th", { scope: "col" }, name));
    const body = rows.map((each, i) => this.#candidate(each, i, most, time));
    return element("table", { class: "candidate-table" }, element("thead", {}, element("tr", {}, heads)), element("tbody", {}, body));
  }

  /**
   * @param {CandidateRow} each
   * @param {number} index
   * @param {number} most the greatest cost
   * @param {number} time
   */
  #candidate(each, index, most, time) {
    const name = index ? `Next best ${index}` : "Shown";
    const terms = TERMS.map((term) => element("td", {}, figure(each[term]), element("span", { class: "bar-of", style: `--share: ${Math.max(each[term], 0) / most}` })));
    const more = index ? `${each.more < 0 ? "−" : "+"}${figure(Math.abs(each.more))}` : "";
    const use = index ? button("Use", () => this.#rule(each, time, false), { "aria-label": `Use next best ${index}`, class: "small" }) : null;
    const line = element("tr", { class: "candidate" }, element("th", { scope: "row" }, name), element("td", {}, source(each)), element("td", {}, figure(each.cost)), element("td", {}, more), terms, element("td", {}, use));
    if (!index) return line;
    const look = () => void this.#look(each, (this.#wanted += 1));
    const away = () => ((this.#wanted += 1), this.#showGhost(null));
    line.addEventListener("pointerenter", look);
    line.addEventListener("pointerleave", away);
    line.addEventListener("focusin", look);
    line.addEventListener("focusout", away);
    return line;
  }

  /**
   * Shows what a candidate would make, once somebody stays on it.
   *
   * @param {CandidateRow} each
   * @param {number} number
   */
  async #look(each, number) {
    await new Promise((resolve) => setTimeout(resolve, this.section === "duet" ? 400 : 0)); // a dance takes seconds
    if (number === this.#wanted) await this.#ask({ kind: "candidate_clip", rules: each.rules }, number);
  }

  /**
   * Asks for a ghost and shows it, unless something else is wanted meanwhile.
   *
   * @param {any} question
   * @param {number} number
   */
  async #ask(question, number) {
    try {
      const { header, payload } = await this.app.connection.ask(question);
      const clip = await loadClip(payload);
      if (number === this.#wanted) this.#showGhost({ clip, start: header.start ?? 0 });
      else clip.dispose();
    } catch (error) {
      if (number === this.#wanted) this.app.say(/** @type {Error} */ (error).message, "error");
    }
  }

  /** @param {{clip: Clip, start: number} | null} ghost */
  #showGhost(ghost) {
    this.#ghost?.clip.dispose();
    this.#ghost = ghost;
    if (ghost) {
      ghost.clip.setGhost(GHOST, "#e0a100");
      this.app.stage.add(ghost.clip.object);
      this.#seek();
    }
    this.app.stage.render();
  }

  #seek() {
    if (!this.#ghost) return;
    const { clip, start } = this.#ghost;
    const time = this.app.transport.time - start;
    clip.seek(time < 0 || time > clip.duration ? clip.duration / 2 : time);
    this.app.stage.render();
  }
}

/** @param {RuleRow} rule */
function words(rule) {
  const part = [rule.source ?? []].flat().map((second) => second.toFixed(2));
  const where = part.length ? ` at ${part.join(" to ")} s` : "";
  return `${rule.forbid ? "not " : "pinned "}${rule.take ?? "anything"}${where}`;
}

/** @param {{take: string, mirrored?: boolean, source_start: number, source_stop: number}} piece */
function source(piece) {
  const mirrored = piece.mirrored ? ", mirrored" : "";
  if (piece.source_stop === piece.source_start) return `${piece.take}${mirrored}, held at ${piece.source_start.toFixed(2)} s`;
  return `${piece.take}${mirrored}, ${piece.source_start.toFixed(2)} to ${piece.source_stop.toFixed(2)} s`;
}

/** @param {number} value m² s */
function figure(value) {
  return (1e4 * value).toFixed(1);
}

/** @param {number} value */
function round(value) {
  return Math.round(1e4 * value) / 1e4;
}
