"""Reading a character from a glTF file: the skeleton and the skinned meshes of its skin, in the bind pose."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.character import Character, Colour, Skin
from kinetograph.errors import FormatError
from kinetograph.formats.gltf.buffers import Gltf, Json
from kinetograph.formats.gltf.reader import read
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton

_GREY: Colour = (0.5, 0.5, 0.5)


def read_character(path: Path, notes: list[str]) -> Character:
    """Read the character of a ``.glb`` or ``.gltf`` file with one skin; its colours are kept, textures are not.

    Parameters
    ----------
    path : Path
    notes : list of str
        Gets a line on textures that are left out.

    Returns
    -------
    Character

    Raises
    ------
    FormatError
        There is no skinned mesh, or more than one skeleton.
    """
    gltf = Gltf(path)
    take = read(path).take
    motion = next(iter(take.tracks.values()))
    if len(take.tracks) != 1 or not isinstance(motion, Motion) or not gltf.objects("skins"):
        raise FormatError(path, f"expected one skinned character, found {len(take.tracks)} skeletons")
    skeleton = motion.skeleton
    parts = [
        part
        for node in gltf.objects("nodes")
        if "skin" in node and "mesh" in node
        for part in _parts(gltf, node, skeleton)
    ]
    if not parts:
        raise FormatError(path, "expected a skinned mesh of triangles, found none")
    if pictures := len(gltf.objects("textures")):
        notes.append(f"{pictures} pictures (textures) on the body are left out, its colours are kept")
    return Character(path.stem, skeleton, _joined(parts))


def _joined(parts: list[Skin]) -> Skin:
    starts = np.cumsum([0, *(len(part.points) for part in parts)])
    tints = np.cumsum([0, *(len(part.palette) for part in parts)])
    return Skin(
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.normals for part in parts]),
        np.concatenate([part.triangles + start for part, start in zip(parts, starts[:-1], strict=True)]),
        np.concatenate([part.joints for part in parts]),
        np.concatenate([part.weights for part in parts]),
        np.concatenate([part.tints + tint for part, tint in zip(parts, tints[:-1], strict=True)]),
        tuple(entry for part in parts for entry in part.palette),
    )


def _parts(gltf: Gltf, node: Json, skeleton: Skeleton) -> list[Skin]:
    """One skin per group of primitives of a node's mesh, in metres relative to the root joint."""
    skins, meshes = gltf.objects("skins"), gltf.objects("meshes")
    skin = skins[gltf.index(node, "skin", len(skins))]
    mesh = meshes[gltf.index(node, "mesh", len(meshes))]
    inverse = gltf.accessor(gltf.index(skin, "inverseBindMatrices", len(gltf.objects("accessors"))))
    matrices = np.linalg.inv(inverse.reshape(-1, 4, 4).transpose(0, 2, 1))
    bind = np.asarray(matrices[:, :3, 3], dtype=np.float64)
    nodes = gltf.objects("nodes")
    names = [str(nodes[joint].get("name", f"node_{joint}"))[:200] for joint in skin["joints"]]
    place = {name: joint for joint, name in enumerate(skeleton.names)}
    if not set(names) & set(place) or len(set(names)) < len(names):
        raise FormatError(gltf.path, "the joints of a skin need names of their own")
    # what a root above the hips or a helper beside them moves, the body's own root moves
    joints = np.array([place.get(name, 0) for name in names])
    own = np.array([name in place for name in names])
    scale = _scale(skeleton, joints[own], bind[own])
    first = int(np.argmin(np.where(own, joints, len(skeleton))))
    root = bind[first]
    groups: dict[str, list[Json]] = {}  # primitives of several materials often share their points
    for primitive in gltf.list_of(mesh, "primitives"):
        if primitive.get("mode", 4) == 4:
            groups.setdefault(json.dumps(primitive.get("attributes"), sort_keys=True), []).append(primitive)
    return [_part(gltf, group, joints, root, scale) for group in groups.values()]


def _scale(skeleton: Skeleton, joints: IntArray, bind: FloatArray) -> float:
    """Metres in one of the mesh's units: lengths of bones in the world over those between bind matrices."""
    place = {int(joint): bind[i] for i, joint in enumerate(joints)}
    pairs = [(j, int(skeleton.parents[j])) for j in place if j and int(skeleton.parents[j]) in place]
    bound = sum(float(np.linalg.norm(place[a] - place[b])) for a, b in pairs)
    metres = sum(float(np.linalg.norm(skeleton.offsets[a])) for a, _ in pairs)
    return metres / bound if bound > 0 and metres > 0 else 1.0


def _part(gltf: Gltf, group: list[Json], joints: IntArray, root: FloatArray, scale: float) -> Skin:
    given = group[0].get("attributes")
    attributes: Json = given if isinstance(given, dict) else {}
    count = len(gltf.objects("accessors"))
    points, slots, weights = (
        gltf.accessor(gltf.index(attributes, key, count)) for key in ("POSITION", "JOINTS_0", "WEIGHTS_0")
    )
    corners = [_corners(gltf, primitive, len(points)) for primitive in group]
    if points.shape[1] != 3 or slots.shape != weights.shape or slots.shape != (len(points), 4):
        raise FormatError(gltf.path, "a skinned mesh's points and joints do not agree")
    if np.any(slots >= len(joints)) or np.any(slots < 0):
        raise FormatError(gltf.path, f"a skinned mesh is moved by a joint that its skin lacks: {int(slots.max())}")
    total = weights.sum(axis=1, keepdims=True)
    weights = np.where(total > 0, weights / np.where(total > 0, total, 1.0), [1.0, 0.0, 0.0, 0.0])
    if "NORMAL" in attributes:
        normals = gltf.accessor(gltf.index(attributes, "NORMAL", count))
    else:
        normals = np.tile([0.0, 1.0, 0.0], (len(points), 1))
    return Skin(
        (points - root) * scale,
        normals,
        np.concatenate(corners),
        joints[slots.astype(np.int64)],
        weights,
        np.repeat(np.arange(len(group)), [len(triangles) for triangles in corners]),
        tuple(_material(gltf, primitive) for primitive in group),
    )


def _corners(gltf: Gltf, primitive: Json, points: int) -> IntArray:
    """The triangles of a primitive, ``(T, 3)``."""
    if "indices" in primitive:
        accessor = gltf.index(primitive, "indices", len(gltf.objects("accessors")))
        corners = gltf.accessor(accessor)[:, 0].astype(np.int64)
    else:
        corners = np.arange(points)
    if len(corners) % 3 or np.any(corners >= points) or np.any(corners < 0):
        raise FormatError(gltf.path, f"expected triangles of {points} points")
    return corners.reshape(-1, 3)


def _material(gltf: Gltf, primitive: Json) -> tuple[str, Colour]:
    materials = gltf.objects("materials")
    if "material" not in primitive or not materials:
        return "body", _GREY
    material = materials[gltf.index(primitive, "material", len(materials))]
    surface = material.get("pbrMetallicRoughness")
    colour = gltf.vector(surface if isinstance(surface, dict) else {}, "baseColorFactor", [*_GREY, 1.0])
    return str(material.get("name", "body")), (float(colour[0]), float(colour[1]), float(colour[2]))
