// A path on the ground: a ribbon, dots at even times, and a handle to drag it by.
import {
  BufferGeometry, CircleGeometry, Color, DoubleSide, Float32BufferAttribute, Group, InstancedMesh, Mesh, MeshBasicMaterial, Object3D, RingGeometry,
} from "three";
import { onTheme } from "../../dom.js";
import { evenly, speeds, strange } from "./path.js";

/** @typedef {import("./path.js").Row} Row */
/** @typedef {import("../../messages.js").Pace} Pace */

const WIDTH = 0.05; // metres
const DOT = 0.2; // seconds between dots
const MOST = 3000; // dots

/** What is drawn of a path. */
export class PathView {
  /** @type {Row[]} */
  #path = [];
  /** @type {Pace | null} */
  #pace = null;

  /** @param {import("../../stage/stage.js").Stage} stage */
  constructor(stage) {
    this.stage = stage;
    /** What to add to a stage. */
    this.object = new Group();
    this.ribbon = flat(new BufferGeometry(), 1, true);
    this.dots = new InstancedMesh(lying(new CircleGeometry(1, 20)), material(2), MOST);
    this.dots.frustumCulled = false;
    this.dots.renderOrder = 2;
    this.handle = flat(lying(new RingGeometry(0.11, 0.15, 32)), 3);
    this.mover = flat(lying(new CircleGeometry(0.12, 32)), 3);
    this.arrow = flat(arrow(), 2);
    this.handle.visible = this.mover.visible = this.arrow.visible = false;
    this.object.add(this.ribbon, this.dots, this.handle, this.mover, this.arrow);
    onTheme(() => this.show(this.#path, this.#pace));
    stage.onFrame(() => (this.object.position.y = stage.floor + 0.004));
  }

  /**
   * @param {Row[]} path
   * @param {Pace | null} pace
   */
  show(path, pace) {
    this.#path = path;
    this.#pace = pace;
    const drawn = path.length > 1;
    this.ribbon.visible = this.dots.visible = drawn;
    if (drawn) {
      this.#drawRibbon();
      this.#drawDots();
    }
    for (const mesh of [this.handle, this.mover, this.arrow]) /** @type {MeshBasicMaterial} */ (mesh.material).color.copy(this.#colour("--accent"));
    this.stage.render();
  }

  /**
   * Shows a handle at a point.
   *
   * @param {{x: number, z: number} | null} point
   */
  showHandle(point) {
    put(this.handle, point);
    this.stage.render();
  }

  /**
   * Shows a dot that moves.
   *
   * @param {{x: number, z: number} | null} point
   */
  showMover(point) {
    put(this.mover, point);
    this.stage.render();
  }

  /**
   * Shows where a walk begins facing.
   *
   * @param {number | null} degrees from z to x
   */
  showFacing(degrees) {
    const first = this.#path[0];
    put(this.arrow, first && degrees !== null ? { x: first[1], z: first[2] } : null);
    this.arrow.rotation.y = ((degrees ?? 0) * Math.PI) / 180;
    this.stage.render();
  }

  /** @param {string} name */
  #colour(name) {
    return new Color(getComputedStyle(this.stage.parent).getPropertyValue(name).trim() || "#888");
  }

  #drawRibbon() {
    const points = evenly(this.#path, 1 / 30);
    const pace = speeds(this.#path, 1 / 30);
    const [fine, bad] = [this.#colour("--accent"), this.#colour("--bad")];
    /** @type {number[]} */
    const places = [];
    /** @type {number[]} */
    const colours = [];
    /** @type {number[]} */
    const triangles = [];
    let [nx, nz] = [1, 0];
    points.forEach(([, x, z], i) => {
      const [a, b] = [points[Math.max(i - 1, 0)], points[Math.min(i + 1, points.length - 1)]];
      const length = Math.hypot(b[1] - a[1], b[2] - a[2]);
      if (length > 1e-4) [nx, nz] = [(b[2] - a[2]) / length, (a[1] - b[1]) / length];
      const wrong = strange(pace[Math.min(i, pace.length - 1)].speed, this.#pace);
      const half = (wrong ? 1.6 : 1) * (WIDTH / 2);
      places.push(x + half * nx, 0, z + half * nz, x - half * nx, 0, z - half * nz);
      const { r, g, b: blue } = wrong ? bad : fine;
      colours.push(r, g, blue, r, g, blue);
      if (i) triangles.push(2 * i - 2, 2 * i - 1, 2 * i, 2 * i, 2 * i - 1, 2 * i + 1);
    });
    this.ribbon.geometry.dispose();
    this.ribbon.geometry = new BufferGeometry();
    this.ribbon.geometry.setAttribute("position", new Float32BufferAttribute(places, 3));
    this.ribbon.geometry.setAttribute("color", new Float32BufferAttribute(colours, 3));
    this.ribbon.geometry.setIndex(triangles);
  }

  #drawDots() {
    const rows = speeds(this.#path, DOT).slice(0, MOST);
    const [fine, bad] = [this.#colour("--text"), this.#colour("--bad")];
    const one = new Object3D();
    rows.forEach(({ x, z, speed }, i) => {
      const whole = i % Math.round(1 / DOT) === 0;
      one.position.set(x, 0, z);
      one.scale.setScalar(whole ? 0.07 : 0.04);
      one.updateMatrix();
      this.dots.setMatrixAt(i, one.matrix);
      this.dots.setColorAt(i, strange(speed, this.#pace) ? bad : fine);
    });
    this.dots.count = rows.length;
    this.dots.instanceMatrix.needsUpdate = true;
    if (this.dots.instanceColor) this.dots.instanceColor.needsUpdate = true;
  }
}

/**
 * @param {Mesh} mesh
 * @param {{x: number, z: number} | null} point
 */
function put(mesh, point) {
  mesh.visible = point !== null;
  if (point) mesh.position.set(point.x, 0, point.z);
}

/**
 * @param {BufferGeometry} geometry
 * @param {number} order
 * @param {boolean} [vertexColors]
 */
function flat(geometry, order, vertexColors = false) {
  const mesh = new Mesh(geometry, material(order, vertexColors));
  mesh.renderOrder = order;
  mesh.frustumCulled = false;
  return mesh;
}

/**
 * @param {number} order what is higher lies above
 * @param {boolean} [vertexColors]
 */
function material(order, vertexColors = false) {
  return new MeshBasicMaterial({ side: DoubleSide, vertexColors, depthWrite: false, polygonOffset: true, polygonOffsetFactor: -order, polygonOffsetUnits: -4 * order });
}

/** @param {BufferGeometry} geometry in the plane of x and y */
function lying(geometry) {
  return geometry.rotateX(-Math.PI / 2);
}

/** An arrow along z. */
function arrow() {
  const geometry = new BufferGeometry();
  const places = [-0.03, 0, 0.1, 0.03, 0, 0.1, 0.03, 0, 0.5, -0.03, 0, 0.5, -0.11, 0, 0.5, 0.11, 0, 0.5, 0, 0, 0.72];
  geometry.setAttribute("position", new Float32BufferAttribute(places, 3));
  geometry.setIndex([0, 1, 2, 0, 2, 3, 4, 5, 6]);
  return geometry;
}
