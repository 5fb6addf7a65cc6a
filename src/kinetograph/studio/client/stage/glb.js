// Reading the GLB files that Kinetograph writes: characters, each a tree of joints, a skin and their motion.
//
// three's own loader renames nodes, makes a mesh of every material and interpolates linearly. This reader keeps names as
// they are in the file, makes one mesh a character, and leaves interpolation to `spline.js`.

const MAGIC = 0x46546c67;
const COMPONENTS = { 5121: Uint8Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };
const WIDTHS = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT4: 16 };

/**
 * The mesh of a character. Vertices that differ in colour are apart.
 *
 * @typedef {object} Skin
 * @property {Float32Array} positions metres, as at the start of the motion without any rotation
 * @property {Float32Array} normals
 * @property {Uint16Array} joints four a vertex
 * @property {Float32Array} weights four a vertex
 * @property {Float32Array} colours linear red, green and blue a vertex
 * @property {Uint32Array} triangles
 * @property {Float32Array} inverses a matrix a joint, columns first
 */

/**
 * A character of a file.
 *
 * @typedef {object} Character
 * @property {string} name that of its track
 * @property {string[]} joints
 * @property {Int32Array} parents index of each joint's parent, -1 for the root
 * @property {Float32Array} offsets a translation a joint; the root's is where the motion starts
 * @property {Skin | null} skin
 * @property {number} fps
 * @property {number} frames
 * @property {Float32Array} translation of the root, three a frame, metres
 * @property {Float32Array} rotations x, y, z, w of every joint of every frame
 * @property {Float32Array | null} bones a translation of every joint of every frame, where bones are not rigid
 */

/**
 * Reads a GLB file.
 *
 * @param {ArrayBuffer} buffer
 * @returns {Character[]}
 */
export function readGlb(buffer) {
  const file = new Reader(buffer);
  const skins = /** @type {any[]} */ (file.json.skins ?? []);
  if (skins.length === 0) throw new Error("expected a GLB file with a skinned character, found none");
  return skins.map((skin, index) => readCharacter(file, skin, index));
}

/** The JSON and the binary part of a file. */
class Reader {
  /** @param {ArrayBuffer} buffer */
  constructor(buffer) {
    const view = new DataView(buffer);
    if (buffer.byteLength < 28 || view.getUint32(0, true) !== MAGIC) throw new Error("expected a GLB file");
    const length = view.getUint32(12, true);
    this.json = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 20, length)));
    this.buffer = buffer;
    this.start = 20 + length + 8;
  }

  /**
   * @param {number} index of an accessor
   * @returns {Float32Array | Uint32Array | Uint16Array | Uint8Array}
   */
  values(index) {
    const accessor = this.json.accessors[index];
    const view = this.json.bufferViews[accessor.bufferView];
    const Kind = COMPONENTS[/** @type {keyof typeof COMPONENTS} */ (accessor.componentType)];
    const count = accessor.count * WIDTHS[/** @type {keyof typeof WIDTHS} */ (accessor.type)];
    const from = this.start + (view.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
    return new Kind(this.buffer, from, count);
  }

  /**
   * @param {number} index of an accessor
   * @returns {Float32Array}
   */
  floats(index) {
    const values = this.values(index);
    return values instanceof Float32Array ? values : Float32Array.from(values);
  }
}

/**
 * @param {Reader} file
 * @param {any} skin
 * @param {number} index
 * @returns {Character}
 */
function readCharacter(file, skin, index) {
  const nodes = /** @type {any[]} */ (file.json.nodes);
  const place = new Map(skin.joints.map((/** @type {number} */ node, /** @type {number} */ joint) => [node, joint]));
  const parents = new Int32Array(skin.joints.length).fill(-1);
  for (const [node, joint] of place)
    for (const child of nodes[node].children ?? []) if (place.has(child)) parents[place.get(child)] = joint;
  const offsets = new Float32Array(skin.joints.flatMap((/** @type {number} */ node) => nodes[node].translation ?? [0, 0, 0]));
  const owner = nodes.find((node) => (node.children ?? []).includes(skin.joints[0]));
  const body = nodes.find((node) => node.skin === index && node.mesh !== undefined);
  return {
    name: skin.name ?? owner?.name ?? "motion",
    joints: skin.joints.map((/** @type {number} */ node) => String(nodes[node].name)),
    parents,
    offsets,
    skin: body ? readSkin(file, skin, file.json.meshes[body.mesh].primitives) : null,
    ...readMotion(file, place, offsets, owner?.extras?.fps),
  };
}

/**
 * @param {Reader} file
 * @param {Map<number, number>} place joints by node
 * @param {Float32Array} offsets
 * @param {number | undefined} noted frames per second
 */
function readMotion(file, place, offsets, noted) {
  const animation = file.json.animations?.[0] ?? { channels: [], samplers: [] };
  const own = animation.channels.filter((/** @type {any} */ channel) => place.has(channel.target.node));
  const times = own.length ? file.floats(animation.samplers[own[0].sampler].input) : new Float32Array(1);
  const frames = times.length;
  const fps = noted ?? (frames > 1 ? (frames - 1) / (times[frames - 1] - times[0]) : 30);
  const rotations = new Float32Array(frames * place.size * 4);
  for (let i = 3; i < rotations.length; i += 4) rotations[i] = 1;
  let translation = new Float32Array(frames * 3).map((_, i) => offsets[i % 3]);
  /** @type {Float32Array | null} */
  let bones = null;
  for (const channel of own) {
    const joint = place.get(channel.target.node) ?? 0;
    const values = file.floats(animation.samplers[channel.sampler].output);
    if (channel.target.path === "rotation") scatter(values, 4, rotations, joint, place.size);
    else if (channel.target.path === "translation" && joint === 0) translation = new Float32Array(values);
    else if (channel.target.path === "translation") {
      bones ??= new Float32Array(frames * place.size * 3).map((_, i) => offsets[i % (place.size * 3)]);
      scatter(values, 3, bones, joint, place.size);
    }
  }
  return { fps, frames, translation, rotations, bones };
}

/**
 * @param {Float32Array} values of one joint
 * @param {number} width
 * @param {Float32Array} into of all joints
 * @param {number} joint
 * @param {number} joints
 */
function scatter(values, width, into, joint, joints) {
  for (let frame = 0; frame < values.length / width; frame++)
    for (let k = 0; k < width; k++) into[(frame * joints + joint) * width + k] = values[frame * width + k];
}

/**
 * One mesh of all primitives, each with vertices of its own.
 *
 * @param {Reader} file
 * @param {any} skin
 * @param {any[]} primitives
 * @returns {Skin}
 */
function readSkin(file, skin, primitives) {
  const parts = primitives.map((primitive) => readPart(file, primitive));
  const starts = parts.map((_, i) => parts.slice(0, i).reduce((sum, part) => sum + part.weights.length / 4, 0));
  return {
    positions: joined(parts.map((part) => part.positions)),
    normals: joined(parts.map((part) => part.normals)),
    joints: Uint16Array.from(joined(parts.map((part) => part.joints))),
    weights: joined(parts.map((part) => part.weights)),
    colours: joined(parts.map((part) => part.colours)),
    triangles: Uint32Array.from(parts.flatMap((part, i) => Array.from(part.triangles, (corner) => corner + starts[i]))),
    inverses: file.floats(skin.inverseBindMatrices),
  };
}

/**
 * @param {Reader} file
 * @param {any} primitive
 */
function readPart(file, primitive) {
  const corners = file.values(primitive.indices);
  const used = [...new Set(corners)];
  const place = new Map(used.map((vertex, i) => [vertex, i]));
  const material = file.json.materials?.[primitive.material];
  const colour = material?.pbrMetallicRoughness?.baseColorFactor ?? [0.55, 0.55, 0.55];
  return {
    positions: picked(file.floats(primitive.attributes.POSITION), used, 3),
    normals: picked(file.floats(primitive.attributes.NORMAL), used, 3),
    joints: picked(file.floats(primitive.attributes.JOINTS_0), used, 4),
    weights: picked(file.floats(primitive.attributes.WEIGHTS_0), used, 4),
    colours: new Float32Array(used.length * 3).map((_, i) => colour[i % 3]),
    triangles: Array.from(corners, (corner) => place.get(corner) ?? 0),
  };
}

/**
 * @param {Float32Array} values
 * @param {number[]} rows
 * @param {number} width
 */
function picked(values, rows, width) {
  const out = new Float32Array(rows.length * width);
  rows.forEach((row, i) => out.set(values.subarray(row * width, (row + 1) * width), i * width));
  return out;
}

/** @param {Float32Array[]} parts */
function joined(parts) {
  const out = new Float32Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    out.set(part, at);
    at += part.length;
  }
  return out;
}
