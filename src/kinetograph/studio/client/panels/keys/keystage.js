// Keys on the stage: their poses as ghosts at their places, a gizmo for place and heading, handles on hands and feet, and
// the alternatives.
import {
  ConeGeometry, Group, Mesh, MeshBasicMaterial, Plane, RingGeometry, SphereGeometry, Vector3,
} from "three";
import { loadClip } from "../../stage/body.js";
import { COLOURS } from "./keyoptions.js";

/**
 * @typedef {import("../../messages.js").KeyRow} KeyRow
 * @typedef {import("../../messages.js").EndPlaces} EndPlaces
 * @typedef {import("../../stage/body.js").Clip} Clip
 * @typedef {{position: [number, number], heading: number}} Place metres x and z, degrees
 *
 * @typedef {object} StageEvents
 * @property {(index: number) => void} select
 * @property {(place: Place, done: boolean, part: "position" | "heading") => void} place
 * @property {(role: string, at: [number, number, number], done: boolean) => void} end
 * @property {(number: number) => void} choose an alternative was clicked
 */

const KEY = "#b07800";
const ACCENT = "#0b62c4";
const DISC = 0.42; // metres
const NOSE = 0.62;
const SPACE = 1.1; // metres between alternatives
const NEAR = 0.14; // metres from a ray within which a body is clicked

/** A pose, fetched once and shown as often as it is the same. */
class Ghost {
  /** @type {Clip | null} */
  #clip = null;
  #name = "";

  /** @param {import("../../studio.js").App} app */
  constructor(app) {
    this.app = app;
    this.group = new Group();
    this.opacity = 0.3;
    this.colour = KEY;
  }

  /**
   * @param {KeyRow} row
   * @param {Place} place
   */
  show(row, { position, heading }) {
    this.group.position.set(position[0], 0, position[1]);
    this.group.rotation.y = (heading * Math.PI) / 180;
    this.#clip?.setGhost(this.opacity, this.colour);
    void this.#fetch(row);
  }

  /** Where the joints are in the world. */
  joints() {
    this.group.updateMatrixWorld();
    return this.#clip ? Object.values(this.#clip.pose(0)).map((at) => new Vector3(...at).applyMatrix4(this.group.matrixWorld)) : [];
  }

  dispose() {
    this.#name = "gone";
    this.#clip?.dispose();
    this.group.removeFromParent();
  }

  /** @param {KeyRow} row */
  async #fetch({ pose, moved = {} }) {
    const name = JSON.stringify([pose, moved]);
    if (name === this.#name) return;
    this.#name = name;
    try {
      const { payload } = await this.app.connection.ask({ kind: "key_pose", row: { pose, moved } });
      if (this.#name !== name) return;
      const clip = await loadClip(payload);
      if (this.#name !== name) return clip.dispose();
      this.#clip?.dispose();
      this.#clip = clip;
      clip.setGhost(this.opacity, this.colour);
      this.group.add(clip.object);
      this.app.stage.render();
    } catch {
      // what is wrong with a key is said when the keys are solved
    }
  }
}

/** What is on the stage for keys. */
export class KeyStage {
  /** @type {Ghost[]} */
  #ghosts = [];
  #selected = -1;
  /** @type {Place} */
  #place = { position: [0, 0], heading: 0 };
  /** @type {((event: PointerEvent, done: boolean) => void) | null} */
  #drag = null;

  /**
   * @param {import("../../studio.js").App} app
   * @param {StageEvents} events
   */
  constructor(app, events) {
    this.app = app;
    this.events = events;
    this.root = new Group();
    this.preview = new Ghost(app);
    this.preview.opacity = 0.45;
    this.preview.colour = ACCENT;
    this.gizmo = gizmo();
    this.handles = new Group();
    this.root.add(this.gizmo, this.handles);
    const parent = app.stage.parent;
    parent.addEventListener("pointerdown", (event) => this.#press(event), { capture: true });
    parent.addEventListener("pointermove", (event) => this.#hover(event));
    this.shown = false;
    /** @type {{clip: Clip, number: number}[]} the motions that are not the one chosen */
    this.others = [];
  }

  enter() {
    this.shown = true;
    this.app.stage.add(this.root);
  }

  leave() {
    this.shown = false;
    this.app.stage.canvas.style.cursor = "";
    this.app.stage.remove(this.root);
    this.showAlternatives([]);
  }

  /**
   * @param {KeyRow[]} rows
   * @param {Place[]} places
   * @param {number} selected
   * @param {EndPlaces | null} ends of the key that is selected
   */
  show(rows, places, selected, ends) {
    while (this.#ghosts.length > rows.length) this.#ghosts.pop()?.dispose();
    while (this.#ghosts.length < rows.length) {
      const ghost = new Ghost(this.app);
      this.#ghosts.push(ghost);
      this.root.add(ghost.group);
    }
    rows.forEach((row, i) => {
      this.#ghosts[i].opacity = i === selected ? 0.55 : 0.28;
      this.#ghosts[i].show(row, places[i]);
    });
    this.#selected = selected;
    this.gizmo.visible = this.handles.visible = selected >= 0 && selected < rows.length;
    if (this.gizmo.visible) this.#put(places[selected]);
    this.#showHandles(ends);
    this.app.stage.render();
  }

  /**
   * The pose that is looked for in a recording, next to what is shown.
   *
   * @param {KeyRow | null} row
   * @param {Place} place
   */
  showPreview(row, place) {
    this.preview.group.removeFromParent();
    if (row) {
      this.root.add(this.preview.group);
      this.preview.show(row, place);
    }
    this.app.stage.render();
  }

  /**
   * Motions that are not the one chosen.
   *
   * @param {{clip: Clip, number: number}[]} others
   * @param {boolean} [beside] each further to the right, as it is seen now; else where they are
   */
  showAlternatives(others, beside = false) {
    for (const { clip } of this.others) clip.dispose();
    this.others = others;
    const right = new Vector3(1, 0, 0).applyQuaternion(this.app.stage.camera.quaternion).setY(0).normalize();
    others.forEach(({ clip, number }, i) => {
      clip.setGhost(0.4, COLOURS[number]);
      if (beside) clip.object.position.copy(right).multiplyScalar(SPACE * (i + 1));
      this.root.add(clip.object);
    });
    this.seek(this.app.transport.time);
  }

  /** @param {number} seconds */
  seek(seconds) {
    for (const { clip } of this.others) clip.seek(seconds);
    this.app.stage.render();
  }

  /**
   * Where something to drag is in the world: a hand or foot by its role, or `position` or `heading`.
   *
   * @param {string} part
   * @returns {number[]}
   */
  pointOf(part) {
    const found = [...this.handles.children, ...this.gizmo.children].find((each) => each.name === part);
    this.root.updateMatrixWorld();
    return found?.getWorldPosition(new Vector3()).toArray() ?? [0, 0, 0];
  }

  /** @param {Place} place */
  #put(place) {
    this.#place = place;
    for (const each of [this.gizmo, this.handles]) {
      each.position.set(place.position[0], each === this.gizmo ? this.app.stage.floor + 0.01 : 0, place.position[1]);
      each.rotation.y = (place.heading * Math.PI) / 180;
    }
    const ghost = this.#ghosts[this.#selected]?.group;
    ghost?.position.set(place.position[0], 0, place.position[1]);
    if (ghost) ghost.rotation.y = (place.heading * Math.PI) / 180;
  }

  /** @param {EndPlaces | null} places */
  #showHandles(places) {
    const ends = Object.entries(places?.ends ?? {});
    while (this.handles.children.length > ends.length) this.handles.remove(this.handles.children[0]);
    while (this.handles.children.length < ends.length) this.handles.add(dot());
    ends.forEach(([role, at], i) => {
      const handle = this.handles.children[i];
      handle.name = role;
      if (!this.#drag) handle.position.set(...at);
    });
  }

  /** @param {PointerEvent} event */
  #press(event) {
    if (!this.shown || event.button !== 0 || event.target !== this.app.stage.canvas) return;
    const grabbed = this.#grab(event);
    if (!grabbed) return this.#click(event);
    event.stopPropagation();
    event.preventDefault();
    this.#drag = grabbed;
    const move = (/** @type {PointerEvent} */ moved) => grabbed(moved, false);
    const stop = (/** @type {PointerEvent} */ released) => {
      removeEventListener("pointermove", move);
      removeEventListener("pointerup", stop);
      removeEventListener("pointercancel", stop);
      this.#drag = null;
      grabbed(released, true);
    };
    addEventListener("pointermove", move);
    addEventListener("pointerup", stop);
    addEventListener("pointercancel", stop);
  }

  /**
   * What the pointer takes hold of.
   *
   * @param {PointerEvent} event
   * @returns {((event: PointerEvent, done: boolean) => void) | null}
   */
  #grab(event) {
    if (!this.gizmo.visible) return null;
    const ray = this.app.stage.ray(event);
    const handle = ray.intersectObjects(this.handles.children, false)[0]?.object;
    if (handle) return this.#moveEnd(handle);
    const part = ray.intersectObjects(this.gizmo.children, false)[0]?.object.name;
    if (part === "heading") return (moved, done) => this.#turn(moved, done);
    return part ? this.#movePlace(event) : null;
  }

  /** @param {PointerEvent} pressed */
  #movePlace(pressed) {
    const from = this.app.stage.groundPoint(pressed);
    const { position, heading } = this.#place;
    return (/** @type {PointerEvent} */ event, /** @type {boolean} */ done) => {
      const to = this.app.stage.groundPoint(event);
      if (from && to) this.#put({ position: [position[0] + to.x - from.x, position[1] + to.z - from.z], heading });
      this.events.place(this.#place, done, "position");
      this.app.stage.render();
    };
  }

  /**
   * @param {PointerEvent} event
   * @param {boolean} done
   */
  #turn(event, done) {
    const { position } = this.#place;
    const to = this.app.stage.groundPoint(event);
    if (to) this.#put({ position, heading: (Math.atan2(to.x - position[0], to.z - position[1]) * 180) / Math.PI });
    this.events.place(this.#place, done, "heading");
    this.app.stage.render();
  }

  /** @param {import("three").Object3D} handle */
  #moveEnd(handle) {
    const normal = this.app.stage.camera.getWorldDirection(new Vector3());
    const plane = new Plane().setFromNormalAndCoplanarPoint(normal, handle.getWorldPosition(new Vector3()));
    return (/** @type {PointerEvent} */ event, /** @type {boolean} */ done) => {
      const at = this.app.stage.ray(event).ray.intersectPlane(plane, new Vector3());
      if (at) handle.position.copy(this.handles.worldToLocal(at));
      this.events.end(handle.name, /** @type {[number, number, number]} */ (handle.position.toArray().map((v) => Number(v.toFixed(4)))), done);
      this.app.stage.render();
    };
  }

  /** @param {PointerEvent} event */
  #hover(event) {
    if (!this.shown || this.#drag || event.buttons) return;
    this.app.stage.canvas.style.cursor = this.#grab(event) ? "grab" : "";
  }

  /**
   * Clicking a body chooses it: an alternative, or a key.
   *
   * @param {PointerEvent} event
   */
  #click(event) {
    const [x, y] = [event.clientX, event.clientY];
    const release = (/** @type {PointerEvent} */ released) => {
      if (Math.hypot(released.clientX - x, released.clientY - y) > 4) return;
      const { ray } = this.app.stage.ray(released);
      const far = (/** @type {Vector3[]} */ joints) => Math.min(...joints.map((at) => ray.distanceToPoint(at)), Infinity);
      const world = (/** @type {Clip} */ clip) => Object.values(clip.pose(this.app.transport.time)).map((at) => new Vector3(...at).add(clip.object.position));
      const own = this.app.clip ? far(world(this.app.clip)) : Infinity;
      const bodies = [
        ...this.others.map(({ clip, number }) => ({ at: far(world(clip)), choose: () => this.events.choose(number) })),
        ...this.#ghosts.map((ghost, i) => ({ at: far(ghost.joints()), choose: () => this.events.select(i) })),
      ].sort((a, b) => a.at - b.at);
      if (bodies.length && bodies[0].at < Math.min(NEAR, own)) bodies[0].choose();
    };
    addEventListener("pointerup", release, { once: true });
  }
}

/** A disc that is dragged over the ground, with a nose that is dragged around. */
function gizmo() {
  const made = new Group();
  const ring = new Mesh(new RingGeometry(DISC - 0.06, DISC, 48), flat(KEY, 0.95));
  const disc = new Mesh(new RingGeometry(0, DISC - 0.06, 48), flat(KEY, 0.22));
  for (const each of [ring, disc]) {
    each.rotation.x = -Math.PI / 2;
    each.name = "position";
  }
  const nose = new Mesh(new ConeGeometry(0.09, 0.2, 20), flat(KEY, 0.95));
  nose.rotation.x = Math.PI / 2;
  nose.position.set(0, 0.02, NOSE);
  nose.name = "heading";
  made.add(disc, ring, nose);
  made.visible = false;
  made.traverse((each) => (each.renderOrder = 3));
  return made;
}

function dot() {
  const made = new Mesh(new SphereGeometry(0.045, 16, 12), flat(ACCENT, 0.95));
  made.renderOrder = 4;
  return made;
}

/**
 * @param {string} color
 * @param {number} opacity
 */
function flat(color, opacity) {
  return new MeshBasicMaterial({ color, opacity, transparent: true, depthTest: false, depthWrite: false, fog: false, side: 2 });
}
