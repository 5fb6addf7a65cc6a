// Opens motion files with three.js and writes where it puts their joints:
// node read_with_three.mjs REFERENCE.json OUT.json
// The reference says at what seconds to look: {file: {times}}. The answer has duration and
// positions {joint: [[x, y, z], ...]} in metres, "track/joint" where a file has several characters.
import { readFile, writeFile } from "node:fs/promises";
import * as THREE from "three";
import { BVHLoader } from "three/examples/jsm/loaders/BVHLoader.js";
import { FBXLoader } from "three/examples/jsm/loaders/FBXLoader.js";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";

globalThis.self ??= globalThis;
globalThis.window ??= globalThis;

const [referenceName, outName] = process.argv.slice(2);
const reference = JSON.parse(await readFile(referenceName, "utf8"));
const found = {};
for (const [file, entry] of Object.entries(reference)) {
  found[file] = await look(file, entry.times);
}
await writeFile(outName, JSON.stringify(found));

async function open(file) {
  const bytes = await readFile(file);
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
  if (file.endsWith(".bvh")) {
    const { skeleton, clip } = new BVHLoader().parse(bytes.toString("utf8"));
    const root = new THREE.Group();
    root.add(skeleton.bones[0]);
    return { root, clip, scale: 1 };
  }
  if (file.endsWith(".fbx")) {
    const root = new FBXLoader().parse(buffer, "");
    return { root, clip: root.animations[0], scale: 0.01 }; // three keeps a file's own centimetres
  }
  const gltf = await new GLTFLoader().parseAsync(buffer, "");
  return { root: gltf.scene, clip: gltf.animations[0], scale: 1 };
}

async function look(file, times) {
  const { root, clip, scale } = await open(file);
  const mixer = new THREE.AnimationMixer(root);
  const action = mixer.clipAction(clip);
  action.setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
  const positions = {};
  for (const time of times) {
    mixer.setTime(time);
    root.updateMatrixWorld(true);
    root.traverse((node) => {
      if (node.isBone) {
        const at = new THREE.Vector3().setFromMatrixPosition(node.matrixWorld);
        (positions[label(node)] ??= []).push([at.x * scale, at.y * scale, at.z * scale]);
      }
    });
  }
  return { duration: clip.duration, positions };
}

// the name in the file: loaders replace characters, and add numbers to names that occur again
function label(node) {
  let top = node;
  while (top.parent?.isBone) top = top.parent;
  const track = top.parent?.userData?.name ?? top.parent?.name ?? "";
  return `${track}/${node.userData?.name ?? node.name}`;
}
