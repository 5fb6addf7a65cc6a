// A list of cards with thumbnails, of which only those in view are there: thousands of takes are no more work than ten.
import { Emitter, element } from "../../dom.js";

/**
 * @typedef {object} Card
 * @property {string} take
 * @property {string} detail a short line below the name
 * @property {string} [title] more, as a tooltip
 * @property {{start: number, stop: number}} [span] what was found of it, seconds
 *
 * @typedef {object} CardEvents
 * @property {Card} choose picked by the pointer or by Enter
 * @property {{first: number, count: number}} need cards that are not known yet came into view
 */

const HEIGHT = 132; // of a row, with its gap
const COLUMNS = 2;

/** @extends {Emitter<CardEvents>} */
export class Cards extends Emitter {
  /** @type {(Card | undefined)[]} */
  #cards = [];
  #active = 0;
  #chosen = "";
  /** @type {Map<number, HTMLElement>} */
  #shown = new Map();

  /** @param {import("../library/thumbnails.js").Thumbnails} thumbnails */
  constructor(thumbnails) {
    super();
    this.thumbnails = thumbnails;
    this.space = element("div", { class: "cards-space", role: "presentation" });
    this.element = element("div", {
      class: "cards", role: "listbox", tabindex: "0", "aria-label": "Takes",
      onscroll: () => this.draw(),
      onkeydown: (/** @type {KeyboardEvent} */ event) => this.#key(event),
      onfocus: () => this.#mark(),
      onblur: () => this.#mark(),
    }, this.space);
    new ResizeObserver(() => this.draw()).observe(this.element);
    thumbnails.came = () => this.#stills();
  }

  /**
   * @param {number} count how many there are
   * @param {string} [chosen] the take that is on the stage
   */
  setCount(count, chosen = "") {
    this.#cards = new Array(count);
    this.#active = 0;
    this.#chosen = chosen;
    this.#clear();
    this.space.style.height = `${Math.ceil(count / COLUMNS) * HEIGHT}px`;
    this.element.scrollTop = 0;
  }

  /**
   * @param {number} first
   * @param {Card[]} cards
   */
  set(first, cards) {
    cards.forEach((card, i) => (this.#cards[first + i] = card));
    this.#clear();
    this.draw();
  }

  /** The card that the arrow keys are at. */
  get active() {
    return this.#cards[this.#active] ?? null;
  }

  /** Draws the cards in view. */
  draw() {
    const top = Math.max(Math.floor(this.element.scrollTop / HEIGHT) - 1, 0);
    const bottom = Math.ceil((this.element.scrollTop + this.element.clientHeight) / HEIGHT) + 1;
    const [first, last] = [top * COLUMNS, Math.min(bottom * COLUMNS, this.#cards.length)];
    for (const [index, card] of this.#shown) if (index < first || index >= last) this.#drop(index, card);
    let missing = -1;
    for (let index = first; index < last; index++) {
      const card = this.#cards[index];
      if (!card && missing < 0) missing = index;
      if (card && !this.#shown.has(index)) this.#put(index, card);
    }
    if (missing >= 0) this.emit("need", { first: missing, count: 200 });
    this.#mark();
  }

  /**
   * @param {number} index
   * @param {Card} card
   */
  #put(index, card) {
    const canvas = element("canvas", { "aria-hidden": "true" });
    const made = element(
      "div",
      {
        class: "card", role: "option", id: `card-${index}`, title: card.title ?? card.take,
        "aria-posinset": index + 1, "aria-setsize": this.#cards.length, "aria-selected": "false",
        style: `top: ${Math.floor(index / COLUMNS) * HEIGHT}px; left: ${((index % COLUMNS) * 100) / COLUMNS}%`,
        onpointerenter: () => this.thumbnails.move(canvas, card.take, true),
        onpointerleave: () => this.thumbnails.move(canvas, card.take, this.#focused(index)),
        onclick: () => this.#choose(index),
      },
      canvas,
      element("span", { class: "card-name" }, card.take),
      element("span", { class: "card-detail" }, card.detail),
    );
    this.#shown.set(index, made);
    this.space.append(made);
    this.thumbnails.show(canvas, card.take);
  }

  /** @param {number} index */
  #choose(index) {
    const card = this.#cards[index];
    if (!card) return;
    this.#active = index;
    this.#chosen = card.take;
    this.#mark();
    this.emit("choose", card);
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    const page = Math.max(Math.floor(this.element.clientHeight / HEIGHT), 1) * COLUMNS;
    const steps = /** @type {Record<string, number>} */ ({
      ArrowRight: 1, ArrowLeft: -1, ArrowDown: COLUMNS, ArrowUp: -COLUMNS, PageDown: page, PageUp: -page, Home: -Infinity, End: Infinity,
    });
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key in steps) {
      this.#active = Math.min(Math.max(this.#active + steps[event.key], 0), Math.max(this.#cards.length - 1, 0));
      this.#scrollTo(this.#active);
    } else if (event.key === "Enter" || event.key === " ") this.#choose(this.#active);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** @param {number} index */
  #scrollTo(index) {
    const top = Math.floor(index / COLUMNS) * HEIGHT;
    const { scrollTop, clientHeight } = this.element;
    if (top < scrollTop) this.element.scrollTop = top;
    else if (top + HEIGHT > scrollTop + clientHeight) this.element.scrollTop = top + HEIGHT - clientHeight;
    this.draw();
  }

  /** Whether the keys are at a card. @param {number} index */
  #focused(index) {
    return index === this.#active && document.activeElement === this.element;
  }

  #mark() {
    const there = this.#shown.has(this.#active);
    if (there) this.element.setAttribute("aria-activedescendant", `card-${this.#active}`);
    else this.element.removeAttribute("aria-activedescendant");
    for (const [index, card] of this.#shown) {
      const at = this.#focused(index);
      card.classList.toggle("active", at);
      card.setAttribute("aria-selected", String(this.#cards[index]?.take === this.#chosen));
      const canvas = card.querySelector("canvas");
      if (canvas && !card.matches(":hover")) this.thumbnails.move(canvas, this.#cards[index]?.take ?? "", at);
    }
  }

  #stills() {
    for (const [index, card] of this.#shown) {
      const canvas = card.querySelector("canvas");
      if (canvas) this.thumbnails.show(canvas, this.#cards[index]?.take ?? "");
    }
  }

  /**
   * @param {number} index
   * @param {HTMLElement} card
   */
  #drop(index, card) {
    card.remove();
    this.#shown.delete(index);
  }

  #clear() {
    for (const [index, card] of this.#shown) this.#drop(index, card);
  }
}
