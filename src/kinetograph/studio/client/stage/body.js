// Bodies: clips that are scrubbed, and bodies that are posed as poses arrive.
//
// A clip is a GLB file of Kinetograph with one character or several. Positions are metres in the world, exactly those of
// the motion that was encoded: a body is never shifted. Where the ground is, is the stage's affair.
import {
  Bone, Box3, BufferAttribute, BufferGeometry, Color, CustomBlending, DetachedBindMode, Group, Matrix4, MeshBasicMaterial,
  MeshLambertMaterial, Quaternion, Skeleton, SkinnedMesh, Vector3, EqualStencilFunc, IncrementStencilOp,
} from "three";
import { readGlb } from "./glb.js";
import { Spline } from "./spline.js";

/** @typedef {import("./glb.js").Character} Character */
/** @typedef {Record<string, [number, number, number]>} Positions world positions in metres by name of the joint */

const CERTAIN = new Color("#7a93b8");
const UNCERTAIN = new Color("#ffe23d");
const SHADOW_ORDER = -1;

/**
 * Reads a clip.
 *
 * @param {ArrayBuffer} buffer a GLB file that `kinetograph.formats.gltf.encode` made
 * @returns {Promise<Clip>}
 */
export async function loadClip(buffer) {
  return new Clip(readGlb(buffer));
}

/**
 * Reads a body to pose, from any clip of its skeleton.
 *
 * @param {ArrayBuffer} buffer a GLB file that `kinetograph.formats.gltf.encode` made
 * @returns {Promise<LiveBody>}
 */
export async function loadLiveBody(buffer) {
  return new LiveBody(readGlb(buffer)[0]);
}

/** One or several characters and their motion. */
export class Clip {
  /** @param {Character[]} characters */
  constructor(characters) {
    /** What to add to a stage. */
    this.object = new Group();
    /** @type {string[]} names of the characters, in the order of the file */
    this.characters = characters.map((character) => character.name);
    this.figures = characters.map((character) => new Figure(character));
    this.tracks = characters.map((character) => new Track(character));
    this.object.add(...this.figures.map((figure) => figure.object));
    /** Frames per second of the first character. */
    this.fps = characters[0].fps;
    /** Seconds to the last frame. */
    this.duration = Math.max(...this.tracks.map((track) => track.duration));
    /** @type {string[]} as in the file; of several characters, `character/joint` */
    this.joints = characters.flatMap((character) => this.#names(character));
    /** Seconds that are shown. */
    this.time = 0;
    this.seek(0);
  }

  /**
   * Shows the pose of a time; times beyond the ends hold the end pose.
   *
   * @param {number} seconds
   */
  seek(seconds) {
    this.time = seconds;
    this.tracks.forEach((track, i) => this.figures[i].apply(track.at(seconds)));
  }

  /**
   * Where the joints are at a time. What is shown stays as it is.
   *
   * @param {number} seconds
   * @returns {Positions}
   */
  pose(seconds) {
    return Object.assign({}, ...this.tracks.map((track) => named(this.#names(track.character), track.positions(seconds))));
  }

  /**
   * Where the joints of one character are at a time.
   *
   * @param {number} seconds
   * @param {number} [character] its index
   * @returns {Float64Array} x, y, z of every joint in the order of the file
   */
  positions(seconds, character = 0) {
    return this.tracks[character].positions(seconds);
  }

  /**
   * The root's position at a time.
   *
   * @param {number} seconds
   * @param {number} [character] its index
   * @returns {[number, number, number]}
   */
  root(seconds, character = 0) {
    const pose = this.tracks[character].at(seconds);
    return [pose[0], pose[1], pose[2]];
  }

  /**
   * Where a root goes, frame by frame.
   *
   * @param {number} [character] its index
   * @returns {Float32Array} x, y, z a frame, metres
   */
  path(character = 0) {
    return this.tracks[character].character.translation;
  }

  /**
   * The space that the roots move in, half a metre around them, and the height of a person.
   *
   * @returns {Box3}
   */
  box() {
    const box = new Box3();
    const point = new Vector3();
    for (const { character } of this.tracks)
      for (let i = 0; i < character.translation.length; i += 3) box.expandByPoint(point.fromArray(character.translation, i));
    return box.expandByVector(new Vector3(0.5, 0.9, 0.5));
  }

  /**
   * Shows the clip as a ghost, or in full again.
   *
   * @param {number} opacity 1 is in full
   * @param {string | null} [colour] any colour of CSS; its own colours where there is none
   */
  setGhost(opacity, colour = null) {
    for (const figure of this.figures) figure.setGhost(opacity, colour);
  }

  /**
   * Colours the body by a value at each joint, such as how uncertain it is.
   *
   * @param {Float32Array | null} values from 0 to 1; of all characters' joints; null for the body's own colours
   */
  setJointColours(values) {
    let start = 0;
    for (const figure of this.figures) {
      figure.setJointColours(values && values.subarray(start, start + figure.joints.length));
      start += figure.joints.length;
    }
  }

  /** Frees what the graphics card holds, and takes the clip off its stage. */
  dispose() {
    this.object.removeFromParent();
    for (const figure of this.figures) figure.dispose();
  }

  /** @param {Character} character */
  #names(character) {
    return this.characters.length === 1 ? character.joints : character.joints.map((joint) => `${character.name}/${joint}`);
  }
}

/** A body that shows poses as they arrive. */
export class LiveBody {
  /** @param {Character} character */
  constructor(character) {
    this.figure = new Figure(character);
    /** What to add to a stage. */
    this.object = this.figure.object;
    /** @type {string[]} as in the file */
    this.joints = character.joints;
    this.character = character;
    /** The pose that is shown: x, y, z of the root, then x, y, z, w of every joint. */
    this.shown = new Track(character).at(0).slice();
    this.figure.apply(this.shown);
  }

  /**
   * Shows a pose.
   *
   * @param {Float32Array} pose root x, y, z in metres, then w, x, y, z of every joint in the order of the file
   */
  apply(pose) {
    const { shown, joints } = this;
    shown.set(pose.subarray(0, 3));
    for (let i = 3; i < 3 + 4 * joints.length; i += 4) {
      shown.set(pose.subarray(i + 1, i + 4), i);
      shown[i + 3] = pose[i];
    }
    this.figure.apply(shown);
  }

  /**
   * Where the joints are in the pose that is shown.
   *
   * @returns {Positions}
   */
  pose() {
    return named(this.joints, forward(this.character, this.shown));
  }

  /** @returns {[number, number, number]} the root's position */
  root() {
    return [this.shown[0], this.shown[1], this.shown[2]];
  }

  /**
   * @param {number} opacity 1 is in full
   * @param {string | null} [colour] any colour of CSS
   */
  setGhost(opacity, colour = null) {
    this.figure.setGhost(opacity, colour);
  }

  /** @param {Float32Array | null} values from 0 to 1, one a joint */
  setJointColours(values) {
    this.figure.setJointColours(values);
  }

  /** Frees what the graphics card holds, and takes the body off its stage. */
  dispose() {
    this.object.removeFromParent();
    this.figure.dispose();
  }
}

/** The motion of one character: poses at any time. */
class Track {
  /** @param {Character} character */
  constructor(character) {
    this.character = character;
    this.duration = (character.frames - 1) / character.fps;
    const { frames, translation, rotations, bones, joints } = character;
    const parts = [[translation, 3], [rotations, 4 * joints.length], ...(bones ? [[bones, 3 * joints.length]] : [])];
    const width = parts.reduce((sum, part) => sum + Number(part[1]), 0);
    const rows = new Float32Array(frames * width);
    let start = 0;
    for (const [values, own] of /** @type {[Float32Array, number][]} */ (parts)) {
      for (let frame = 0; frame < frames; frame++) rows.set(values.subarray(frame * own, (frame + 1) * own), frame * width + start);
      start += own;
    }
    this.spline = new Spline(rows, width);
    this.pose = new Float64Array(width);
  }

  /**
   * Root x, y, z, then x, y, z, w of every joint, then x, y, z of every bone where they are not rigid.
   *
   * @param {number} seconds
   * @returns {Float64Array} valid until the next call
   */
  at(seconds) {
    const { pose } = this;
    this.spline.at(seconds * this.character.fps, pose);
    for (let i = 3; i < 3 + 4 * this.character.joints.length; i += 4) {
      const length = Math.hypot(pose[i], pose[i + 1], pose[i + 2], pose[i + 3]) || 1;
      for (let k = i; k < i + 4; k++) pose[k] /= length;
    }
    return pose;
  }

  /** @param {number} seconds */
  positions(seconds) {
    return forward(this.character, this.at(seconds));
  }
}

/**
 * Forward kinematics.
 *
 * @param {Character} character
 * @param {Float64Array} pose
 * @returns {Float64Array} x, y, z of every joint in the world
 */
function forward(character, pose) {
  const { parents, offsets, joints } = character;
  const bones = pose.length > 3 + 4 * joints.length ? pose.subarray(3 + 4 * joints.length) : offsets;
  const places = joints.map(() => new Vector3());
  const rotations = joints.map((_, joint) => new Quaternion().fromArray(pose, 3 + 4 * joint));
  const out = new Float64Array(3 * joints.length);
  joints.forEach((_, joint) => {
    const parent = parents[joint];
    if (parent < 0) places[joint].fromArray(pose);
    else {
      places[joint].fromArray(bones, 3 * joint).applyQuaternion(rotations[parent]).add(places[parent]);
      rotations[joint].premultiply(rotations[parent]);
    }
    places[joint].toArray(out, 3 * joint);
  });
  return out;
}

/**
 * @param {string[]} joints
 * @param {Float64Array} positions
 * @returns {Positions}
 */
function named(joints, positions) {
  return Object.fromEntries(joints.map((name, i) => [name, [positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]]]));
}

/** One character's bones, its mesh and its shadow on the ground. */
class Figure {
  /** @param {Character} character */
  constructor(character) {
    this.character = character;
    this.joints = character.joints;
    this.object = new Group();
    this.bones = character.joints.map(() => new Bone());
    this.bones.forEach((bone, joint) => {
      bone.position.fromArray(character.offsets, 3 * joint);
      (character.parents[joint] < 0 ? this.object : this.bones[character.parents[joint]]).add(bone);
    });
    /** @type {SkinnedMesh | null} */
    this.body = null;
    /** @type {SkinnedMesh | null} */
    this.shadow = null;
    /** @type {SkinnedMesh | null} */
    this.depth = null;
    if (character.skin) this.#addBody(character.skin);
  }

  /**
   * @param {Float64Array} pose as a {@link Track} gives it
   */
  apply(pose) {
    const { bones, joints } = this;
    const moved = pose.length > 3 + 4 * joints.length ? 3 + 4 * joints.length : 0;
    bones[0].position.fromArray(pose, 0);
    for (let joint = 0; joint < bones.length; joint++) {
      bones[joint].quaternion.fromArray(pose, 3 + 4 * joint);
      if (moved && joint) bones[joint].position.fromArray(pose, moved + 3 * joint);
    }
  }

  /**
   * @param {number} opacity
   * @param {string | null} colour
   */
  setGhost(opacity, colour) {
    if (!this.body || !this.shadow) return;
    const ghost = opacity < 1;
    const material = /** @type {MeshLambertMaterial} */ (this.body.material);
    material.transparent = ghost;
    material.opacity = opacity;
    material.vertexColors = colour === null;
    material.color.set(colour ?? "#ffffff");
    material.needsUpdate = true;
    this.shadow.visible = !ghost;
    if (ghost) this.depth ??= this.#addDepth();
    if (this.depth) this.depth.visible = ghost;
  }

  /** @param {Float32Array | null} values */
  setJointColours(values) {
    const skin = this.character.skin;
    if (!this.body || !skin) return;
    const colours = this.body.geometry.getAttribute("color");
    const out = /** @type {Float32Array} */ (colours.array);
    const [from, to] = [CERTAIN, UNCERTAIN].map(({ r, g, b }) => [r, g, b]);
    if (!values) out.set(skin.colours);
    for (let vertex = 0; values && vertex < colours.count; vertex++) {
      let share = 0;
      for (let k = 4 * vertex; k < 4 * vertex + 4; k++) share += skin.weights[k] * values[skin.joints[k]];
      share = Math.min(Math.max(share, 0), 1);
      for (let k = 0; k < 3; k++) out[3 * vertex + k] = from[k] * (1 - share) + to[k] * share;
    }
    colours.needsUpdate = true;
  }

  dispose() {
    for (const mesh of [this.body, this.shadow, this.depth]) {
      if (!mesh) continue;
      mesh.geometry.dispose();
      /** @type {MeshBasicMaterial} */ (mesh.material).dispose();
      mesh.skeleton.dispose();
    }
  }

  /** @param {import("./glb.js").Skin} skin */
  #addBody(skin) {
    const geometry = new BufferGeometry();
    const arrays = { position: [skin.positions, 3], normal: [skin.normals, 3], skinIndex: [skin.joints, 4], skinWeight: [skin.weights, 4] };
    for (const [name, [values, width]] of /** @type {[string, [Float32Array, number]][]} */ (Object.entries(arrays)))
      geometry.setAttribute(name, new BufferAttribute(values, width));
    geometry.setAttribute("color", new BufferAttribute(skin.colours.slice(), 3));
    geometry.setIndex(new BufferAttribute(skin.triangles, 1));
    const inverses = this.bones.map((_, joint) => new Matrix4().fromArray(skin.inverses, 16 * joint));
    const skeleton = new Skeleton(this.bones, inverses);
    this.body = bound(geometry, new MeshLambertMaterial({ vertexColors: true }), skeleton);
    this.shadow = bound(geometry, shadowMaterial(), skeleton);
    this.shadow.bindMode = DetachedBindMode; // stands where its bones are, and is flattened by its own matrix
    this.shadow.matrixWorldAutoUpdate = false;
    this.shadow.renderOrder = SHADOW_ORDER;
    this.shadow.userData.isShadow = true;
    this.object.add(this.body, this.shadow);
  }

  /** What keeps the inside of a ghost from showing: its depth, drawn before its colours. */
  #addDepth() {
    const body = /** @type {SkinnedMesh} */ (this.body);
    const material = new MeshBasicMaterial({ colorWrite: false, transparent: true });
    const mesh = bound(body.geometry, material, body.skeleton);
    mesh.renderOrder = -1;
    this.object.add(mesh);
    return mesh;
  }
}

/**
 * @param {BufferGeometry} geometry
 * @param {import("three").Material} material
 * @param {Skeleton} skeleton
 */
function bound(geometry, material, skeleton) {
  const mesh = new SkinnedMesh(geometry, material);
  mesh.bind(skeleton, new Matrix4());
  mesh.frustumCulled = false; // its bounds would be those of the first pose
  return mesh;
}

/** A material that darkens every point of the ground once, however many limbs are above it. */
function shadowMaterial() {
  return new MeshBasicMaterial({
    color: "#000000", opacity: 0.25, depthTest: false, depthWrite: false, fog: false,
    blending: CustomBlending, // blends among what is opaque, so that bodies are drawn over it
    stencilWrite: true, stencilFunc: EqualStencilFunc, stencilRef: 0, stencilZPass: IncrementStencilOp,
  });
}
