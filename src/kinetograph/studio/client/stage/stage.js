// The stage: camera, lights, ground, and frames that are drawn only where something changed.
import {
  BufferGeometry, Color, DirectionalLight, Float32BufferAttribute, Fog, Group, HemisphereLight, Line, LineBasicMaterial, LineSegments,
  Matrix4, PerspectiveCamera, Plane, Raycaster, Scene, Spherical, Vector2, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { element, onTheme } from "../dom.js";

/** @typedef {"corner" | "front" | "side" | "top"} View */

const REACH = 40; // metres of ground around the middle of the view
const PART = 4; // metres: drawing in software loses lines that reach behind the camera
const LIGHT = new Vector3(0.45, 1.6, 0.55); // towards the light
const SLOW = 40; // milliseconds of waiting for a frame from which on fewer pixels are drawn while something moves
const MANY = 15; // frames by which that is judged
const STILL = 2; // pixels of the picture by pixel of the page, while nothing moves
const REST = 250; // milliseconds after which nothing moves
const PERSON = 1.8; // metres
const NEAR = 4.2; // metres from which one person is seen whole
const MOST_POINTS = 1000; // of a path on the ground
const TURN = Math.PI / 24; // radians of a press of a key
const NEARER = 1.15; // share of the distance
const FAR = 200; // metres beyond which the ground is not pointed at
const DIRECTIONS = { corner: [0.55, 0.42, 1], front: [0, 0.25, 1], side: [1, 0.25, 0], top: [0, 1, 0.001] };

/** What is seen. Call {@link Stage.render} after a change; a frame is drawn before the next refresh of the screen. */
export class Stage {
  #floor = 0;
  #pending = 0;
  /** @type {Set<() => void>} */
  #callbacks = new Set();
  /** @type {(() => [number, number, number] | null) | null} */
  #followed = null;
  #asked = 0;
  #waits = new Waits();
  /** Whether frames take long. */
  #slow = false;
  #resting = 0;
  /** How many frames were drawn. */
  drawn = 0;
  /** Whether the picture is the final one of what is shown: nothing waits to be drawn. */
  isStill = false;
  #busy = false;
  #pathMaterial = new LineBasicMaterial({ depthTest: false, depthWrite: false });
  #shade = 0.25;

  /** @param {HTMLElement} parent is filled by the canvas */
  constructor(parent) {
    this.parent = parent;
    /** Whether frames are drawn without a graphics card, which takes three times as long with smooth edges. */
    this.software = isSoftware();
    this.renderer = new WebGLRenderer({ antialias: !this.software, stencil: true, powerPreference: "high-performance" });
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "The stage: bodies on the ground. Control and arrow keys orbit, plus and minus come nearer and go away.");
    this.canvas.addEventListener("keydown", (event) => this.#key(event));
    parent.append(this.canvas);
    this.scene = new Scene();
    this.scene.fog = new Fog("#000", 10, 30);
    this.camera = new PerspectiveCamera(38, 1, 0.1, 400);
    this.controls = this.#orbit();
    this.ground = makeGround();
    /** Paths on the ground. */
    this.paths = new Group();
    this.scene.add(this.ground, this.paths, ...makeLights());
    this.view("corner");
    this.#colour();
    onTheme(() => this.#colour());
    new ResizeObserver(() => this.#resize()).observe(parent);
    this.#resize();
  }

  /** Height of the ground, metres. */
  get floor() {
    return this.#floor;
  }

  set floor(height) {
    const shift = height - this.#floor;
    this.#floor = height;
    this.ground.position.y = height;
    this.paths.position.y = height;
    this.controls.target.y += shift;
    this.camera.position.y += shift;
    this.controls.update();
    this.render();
  }

  /**
   * @param {...import("three").Object3D} objects
   */
  add(...objects) {
    this.scene.add(...objects);
    this.render();
  }

  /**
   * @param {...import("three").Object3D} objects
   */
  remove(...objects) {
    this.scene.remove(...objects);
    this.render();
  }

  /**
   * Draws paths on the ground, in place of those before.
   *
   * @param {Float32Array[]} paths x, y, z a point, metres; heights do not count
   */
  path(paths) {
    for (const old of this.paths.children.slice()) {
      old.removeFromParent();
      /** @type {Line} */ (old).geometry.dispose();
    }
    this.paths.add(...paths.map((points) => groundPath(points, this.#pathMaterial)));
    this.render();
  }

  /** Asks for a frame. Many calls before it is drawn are one. */
  render() {
    this.isStill = false;
    if (this.#pending) return;
    this.#asked = performance.now();
    this.#pending = requestAnimationFrame(() => this.#draw());
  }

  /**
   * Calls back before every frame that is drawn; the function returned stops that.
   *
   * @param {() => void} callback
   * @returns {() => void}
   */
  onFrame(callback) {
    this.#callbacks.add(callback);
    return () => void this.#callbacks.delete(callback);
  }

  /**
   * The point of the ground that the pointer is on.
   *
   * @param {{clientX: number, clientY: number}} event
   * @returns {{x: number, z: number} | null} metres; null above the horizon
   */
  groundPoint(event) {
    const point = this.ray(event).ray.intersectPlane(new Plane(new Vector3(0, 1, 0), -this.#floor), new Vector3());
    if (!point || point.distanceTo(this.camera.position) > FAR) return null;
    return { x: point.x, z: point.z };
  }

  /**
   * The ray through the pointer, to pick objects with.
   *
   * @param {{clientX: number, clientY: number}} event
   * @returns {Raycaster}
   */
  ray(event) {
    const box = this.canvas.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * 2 - 1;
    const y = 1 - ((event.clientY - box.top) / box.height) * 2;
    const raycaster = new Raycaster();
    this.camera.updateMatrixWorld();
    raycaster.setFromCamera(new Vector2(x, y), this.camera);
    return raycaster;
  }

  /**
   * Where a point of the world is on the page; for labels, and for tests that point at something.
   *
   * @param {number} x
   * @param {number} y
   * @param {number} z
   * @returns {{clientX: number, clientY: number}}
   */
  screenPoint(x, y, z) {
    const box = this.canvas.getBoundingClientRect();
    this.camera.updateMatrixWorld();
    const at = new Vector3(x, y, z).project(this.camera);
    return { clientX: box.left + ((at.x + 1) / 2) * box.width, clientY: box.top + ((1 - at.y) / 2) * box.height };
  }

  /**
   * Looks from another side at what is looked at.
   *
   * @param {View} from
   */
  view(from) {
    const distance = Math.max(this.camera.position.distanceTo(this.controls.target), 4.5);
    const direction = new Vector3().fromArray(DIRECTIONS[from]).normalize();
    this.camera.position.copy(this.controls.target).addScaledVector(direction, distance);
    this.controls.update();
    this.render();
  }

  /**
   * Brings a box into view, from the side that is looked from.
   *
   * @param {import("three").Box3} box
   */
  frame(box) {
    const centre = box.getCenter(new Vector3());
    const radius = Math.max(box.getSize(new Vector3()).length() / 2, 1);
    const direction = this.camera.position.clone().sub(this.controls.target).normalize();
    const half = (this.camera.fov * Math.PI) / 360;
    const narrow = Math.atan(Math.tan(half) * Math.min(this.camera.aspect, 1));
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).addScaledVector(direction, (0.92 * radius) / Math.sin(narrow));
    this.controls.update();
    this.render();
  }

  /** Comes as near to what is looked at as shows one person. */
  closeUp() {
    const direction = this.camera.position.clone().sub(this.controls.target).normalize();
    this.controls.target.y = this.#floor + PERSON / 2;
    this.camera.position.copy(this.controls.target).addScaledVector(direction, NEAR / Math.min(this.camera.aspect, 1));
    this.controls.update();
    this.render();
  }

  /**
   * Keeps the camera with something that moves, at the distance and angle that it has.
   *
   * @param {(() => [number, number, number] | null) | null} where its position at every frame; null lets go
   */
  follow(where) {
    this.#followed = where;
    this.render();
  }

  /** Frees what the graphics card holds. */
  dispose() {
    cancelAnimationFrame(this.#pending);
    clearTimeout(this.#resting);
    this.controls.dispose();
    this.renderer.dispose();
    this.canvas.remove();
  }

  #orbit() {
    const controls = new OrbitControls(this.camera, this.canvas);
    controls.target.set(0, 0.9, 0);
    controls.maxPolarAngle = Math.PI / 2 - 0.02;
    controls.minDistance = 0.5;
    controls.maxDistance = 80;
    controls.screenSpacePanning = false;
    controls.zoomToCursor = true;
    controls.addEventListener("change", () => this.render());
    return controls;
  }

  /**
   * Orbits by Ctrl and arrows, and comes nearer by plus and minus.
   *
   * @param {KeyboardEvent} event
   */
  #key(event) {
    const orbit = event.ctrlKey && { ArrowLeft: [-TURN, 0], ArrowRight: [TURN, 0], ArrowUp: [0, -TURN], ArrowDown: [0, TURN] }[event.key];
    const nearer = !event.ctrlKey && { "+": 1 / NEARER, "-": NEARER }[event.key];
    if (!orbit && !nearer) return;
    event.preventDefault();
    const { target, maxPolarAngle, minDistance, maxDistance } = this.controls;
    const at = new Spherical().setFromVector3(this.camera.position.clone().sub(target));
    if (orbit) at.theta += orbit[0];
    if (orbit) at.phi = Math.min(Math.max(at.phi + orbit[1], 0.01), maxPolarAngle);
    if (nearer) at.radius = Math.min(Math.max(at.radius * nearer, minDistance), maxDistance);
    this.camera.position.setFromSpherical(at).add(target);
    this.controls.update();
    this.render();
  }

  #draw() {
    this.#pending = 0;
    this.#slow ||= this.#waits.add(performance.now() - this.#asked) > SLOW;
    if (this.renderer.getPixelRatio() !== this.#pixels()) this.renderer.setPixelRatio(this.#pixels());
    this.drawn += 1;
    for (const callback of [...this.#callbacks]) callback();
    this.#goAlong();
    const { target } = this.controls;
    this.ground.position.set(Math.round(target.x / 10) * 10, this.#floor, Math.round(target.z / 10) * 10);
    const distance = this.camera.position.distanceTo(target);
    const fog = /** @type {Fog} */ (this.scene.fog);
    [fog.near, fog.far] = [distance + 4, distance + Math.min(14 + 1.5 * distance, REACH)];
    this.#flattenShadows();
    this.renderer.render(this.scene, this.camera);
    clearTimeout(this.#resting);
    this.#resting = setTimeout(() => this.#drawStill(), REST);
  }

  /**
   * Draws what stands still again with more pixels, where moving pictures are drawn with few: what a person looks at
   * for longer has smooth edges, and what moves does not wait for them.
   */
  #drawStill() {
    if (this.#pending || this.#busy) return;
    this.isStill = true;
    if (this.#pixels() >= STILL) return;
    this.renderer.setPixelRatio(STILL);
    this.renderer.render(this.scene, this.camera);
  }

  /** While the machine has something better to do, what stands still is not drawn again. */
  set busy(/** @type {boolean} */ busy) {
    if (this.#busy && !busy) this.render();
    this.#busy = busy;
  }

  /** Pixels of the picture by pixel of the page, while it moves. */
  #pixels() {
    return this.software || this.#slow ? 1 : Math.min(devicePixelRatio, STILL);
  }

  #goAlong() {
    const at = this.#followed?.();
    if (!at) return;
    const shift = new Vector3(at[0] - this.controls.target.x, 0, at[2] - this.controls.target.z);
    this.controls.target.add(shift);
    this.camera.position.add(shift);
    this.camera.lookAt(this.controls.target);
  }

  /** Shadows are the bodies themselves, projected on the ground away from the light. */
  #flattenShadows() {
    const { x, y, z } = LIGHT;
    const [dx, dz, floor] = [-x / y, -z / y, this.#floor];
    const flat = new Matrix4().set(1, dx, 0, -dx * floor, 0, 0, 0, floor, 0, dz, 1, -dz * floor, 0, 0, 0, 1);
    this.scene.traverse((object) => {
      if (!object.userData.isShadow) return;
      object.matrixWorld.copy(flat);
      /** @type {import("three").MeshBasicMaterial} */ (/** @type {import("three").Mesh} */ (object).material).opacity = this.#shade;
    });
  }

  #colour() {
    const style = getComputedStyle(this.parent);
    const colour = (/** @type {string} */ name, /** @type {string} */ fallback) => new Color(style.getPropertyValue(name).trim() || fallback);
    const sky = colour("--stage", "#202227");
    this.scene.background = sky;
    this.#shade = Number(style.getPropertyValue("--stage-shade")) || 0.25;
    /** @type {Fog} */ (this.scene.fog).color.copy(sky);
    this.ground.children.forEach((lines, i) => {
      const material = /** @type {LineBasicMaterial} */ (/** @type {LineSegments} */ (lines).material);
      material.color.copy(colour(["--stage-line", "--stage-line-strong"][i], "#444"));
    });
    this.#pathMaterial.color.copy(colour("--stage-path", "#888"));
    this.render();
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.parent;
    if (!width || !height) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.render();
  }
}

/** How long frames are waited for. */
class Waits {
  /** @type {number[]} */
  #latest = [];

  /**
   * Takes another wait in, and gives the median of the latest; 0 until there are enough.
   *
   * @param {number} milliseconds
   * @returns {number}
   */
  add(milliseconds) {
    this.#latest.push(milliseconds);
    if (this.#latest.length <= MANY) return 0;
    this.#latest.shift();
    return [...this.#latest].sort((a, b) => a - b)[MANY >> 1];
  }
}

function isSoftware() {
  const gl = element("canvas").getContext("webgl2");
  if (!gl) return false;
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

function makeLights() {
  const sun = new DirectionalLight("#ffffff", 2.1);
  sun.position.copy(LIGHT).multiplyScalar(10);
  return [new HemisphereLight("#ffffff", "#8d8f98", 1.9), sun];
}

/** Lines every metre, and stronger ones every five. */
function makeGround() {
  /** @type {number[]} */
  const fine = [];
  /** @type {number[]} */
  const strong = [];
  for (let at = -REACH; at <= REACH; at++)
    for (let from = -REACH; from < REACH; from += PART)
      (at % 5 ? fine : strong).push(at, 0, from, at, 0, from + PART, from, 0, at, from + PART, 0, at);
  const ground = new Group();
  ground.add(...[fine, strong].map(lines));
  return ground;
}

/**
 * @param {Float32Array} points
 * @param {LineBasicMaterial} material
 */
function groundPath(points, material) {
  const geometry = new BufferGeometry();
  const step = Math.ceil(points.length / 3 / MOST_POINTS);
  const kept = [];
  for (let i = 0; i < points.length; i += 3 * step) kept.push(points[i], 0, points[i + 2]);
  kept.push(points[points.length - 3], 0, points[points.length - 1]);
  geometry.setAttribute("position", new Float32BufferAttribute(kept, 3));
  const made = new Line(geometry, material);
  made.renderOrder = -1.5;
  made.frustumCulled = false;
  return made;
}

/** @param {number[]} points */
function lines(points) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
  const made = new LineSegments(geometry, new LineBasicMaterial({ depthTest: false, depthWrite: false }));
  made.renderOrder = -2;
  made.frustumCulled = false;
  return made;
}
