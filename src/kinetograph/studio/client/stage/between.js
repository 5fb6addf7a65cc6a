// Lines between bodies: to where the recorded follower is, and between hands that hold each other.
import { BufferGeometry, Color, Float32BufferAttribute, Group, LineBasicMaterial, LineSegments } from "three";
import { onTheme } from "../dom.js";

/**
 * @typedef {import("./body.js").Clip} Clip
 * @typedef {import("../messages.js").HandsRow} HandsRow
 * @typedef {{follower: number, leader: number, truth: number}} Who the indices of the characters; -1 where there is none
 */

/** What is drawn between the bodies of a duet. */
export class Between {
  /** @type {Clip | null} */
  #clip = null;
  /** @type {Who} */
  #who = { follower: 0, leader: -1, truth: -1 };
  /** @type {HandsRow[]} */
  #holds = [];

  /** Whether lines go from each joint to where it was recorded. */
  distances = false;
  /** Whether hands that hold each other are joined. */
  hands = true;

  /** @param {import("./stage.js").Stage} stage */
  constructor(stage) {
    this.stage = stage;
    this.errors = lines();
    this.met = lines();
    this.missed = lines();
    this.object = new Group();
    this.object.add(this.errors, this.met, this.missed);
    onTheme(() => this.#colour());
    this.#colour();
  }

  /**
   * @param {Clip | null} clip
   * @param {Who} who
   */
  show(clip, who) {
    this.#clip = clip;
    this.#who = who;
    this.#holds = [];
  }

  /** @param {HandsRow[]} holds */
  setHolds(holds) {
    this.#holds = holds;
  }

  /** @param {number} time seconds */
  seek(time) {
    const clip = this.#clip;
    const { follower, leader, truth } = this.#who;
    const own = clip && clip.positions(time, follower);
    set(this.errors, clip && own && this.distances && truth >= 0 ? pairs(own, clip.positions(time, truth)) : []);
    const held = clip && own && this.hands && leader >= 0 ? this.#holds.filter(({ start, stop }) => start <= time && time <= stop) : [];
    const theirs = clip && held.length ? clip.positions(time, leader) : null;
    const line = (/** @type {HandsRow} */ hold) => (clip && own && theirs ? [...joint(clip, follower, own, hold.own), ...joint(clip, leader, theirs, hold.theirs)] : []);
    set(this.met, held.filter((hold) => hold.met ?? true).flatMap(line));
    set(this.missed, held.filter((hold) => !(hold.met ?? true)).flatMap(line));
  }

  #colour() {
    const style = getComputedStyle(document.documentElement);
    const colours = { errors: "--warn", met: "--good", missed: "--bad" };
    for (const [name, colour] of Object.entries(colours)) {
      const material = /** @type {LineBasicMaterial} */ (this[/** @type {"errors"} */ (name)].material);
      material.color.copy(new Color(style.getPropertyValue(colour).trim() || "#888"));
    }
    this.stage.render();
  }
}

function lines() {
  const made = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ depthTest: false, transparent: true }));
  made.frustumCulled = false;
  made.renderOrder = 5;
  return made;
}

/**
 * @param {LineSegments} of
 * @param {number[]} points x, y, z of both ends of each line
 */
function set(of, points) {
  of.visible = points.length > 0;
  if (points.length) of.geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
}

/**
 * @param {Float64Array} from
 * @param {Float64Array} to
 */
function pairs(from, to) {
  const out = [];
  for (let i = 0; i < Math.min(from.length, to.length); i += 3) out.push(from[i], from[i + 1], from[i + 2], to[i], to[i + 1], to[i + 2]);
  return out;
}

/**
 * @param {Clip} clip
 * @param {number} character
 * @param {Float64Array} positions
 * @param {string} name
 */
function joint(clip, character, positions, name) {
  const at = 3 * Math.max(clip.tracks[character].character.joints.indexOf(name), 0);
  return positions.slice(at, at + 3);
}
