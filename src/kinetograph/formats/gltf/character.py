"""Reading a character from a glTF file: the skeleton and the skinned meshes of its skin, in the bind pose."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.character import Character, Colour, Skin
from kinetograph.errors import FormatError
from kinetograph.formats.capsules import rest_positions
from kinetograph.formats.gltf.buffers import Gltf
from kinetograph.formats.gltf.humanoid import HALF_TURN, humanoid_of
from kinetograph.formats.gltf.reader import bind_matrices, read_with_nodes, tree
from kinetograph.formats.gltf.structure import Node, Primitive
from kinetograph.formats.options import ReadOptions
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton

_GREY: Colour = (0.5, 0.5, 0.5)
_DRACO = "KHR_draco_mesh_compression"


def read_character(path: Path, notes: list[str]) -> Character:
    """Read the character of a ``.glb``, ``.gltf`` or ``.vrm`` file; its colours are kept, textures are not.

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
    if _DRACO in gltf.document.extensions_required:
        raise FormatError(path, f"its meshes are compressed ({_DRACO}): write it without compression")
    loaded, named = read_with_nodes(gltf, ReadOptions())
    take = loaded.take
    motion = next(iter(take.tracks.values()))
    if not gltf.document.skins:
        raise FormatError(path, "expected a skinned mesh, found none")
    if len(take.tracks) != 1 or not isinstance(motion, Motion):
        raise FormatError(path, f"expected one skinned character, found {len(take.tracks)} skeletons")
    skeleton = motion.skeleton
    exact = {node: skeleton.names.index(name) for name, node in named[0].items() if name in skeleton.names}
    joint_of = _joint_of_nodes(gltf, exact)
    worn = [node for node in gltf.document.nodes if node.skin is not None and node.mesh is not None]
    parts = [part for node in worn for part in _parts(gltf, node, skeleton, joint_of, exact)]
    if not parts:
        raise FormatError(path, "expected a skinned mesh of triangles, found none")
    if pictures := len(gltf.document.textures):
        notes.append(f"{pictures} pictures (textures) on the body are left out, its colours are kept")
    return Character(path.stem, skeleton, _joined(parts))


def _joint_of_nodes(gltf: Gltf, joints: dict[int, int]) -> list[int]:
    """The joint that each node is, or that it hangs on; the root for nodes that hang on none."""
    parents, order = tree(gltf)
    out = [0] * len(order)
    for node in order:
        out[node] = joints.get(node, out[parents[node]] if parents[node] >= 0 else 0)
    return out


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


def _parts(gltf: Gltf, node: Node, skeleton: Skeleton, joint_of: list[int], exact: dict[int, int]) -> list[Skin]:
    """One skin per group of primitives of a node's mesh, in metres relative to the root joint."""
    skin = gltf.pick(gltf.document.skins, node.skin, "skin")
    mesh = gltf.pick(gltf.document.meshes, node.mesh, "mesh")
    humanoid = humanoid_of(gltf)
    turn = HALF_TURN if humanoid is not None and humanoid.backward else rot.identity()
    bind = rot.rotate(turn, bind_matrices(gltf, skin)[:, :3, 3])
    own = np.array([i for i, joint in enumerate(skin.joints) if joint in exact], dtype=np.int64)
    if not len(own):
        return []  # it is worn by what was left out
    joints = np.array([joint_of[joint] for joint in skin.joints])
    scale = _scale(skeleton, joints[own], bind[own])
    first = own[np.argmin(joints[own])]  # the root, or of skins that lack it a joint whose place it tells
    root = bind[first] - rest_positions(skeleton)[joints[first]] / scale
    groups: dict[tuple[tuple[str, int], ...], list[Primitive]] = {}  # primitives of several materials share points
    for primitive in mesh.primitives:
        if primitive.mode == 4:
            groups.setdefault(tuple(sorted(primitive.attributes.items())), []).append(primitive)
    parts = [_part(gltf, group, joints) for group in groups.values()]
    return [
        replace(part, points=(rot.rotate(turn, part.points) - root) * scale, normals=rot.rotate(turn, part.normals))
        for part in parts
    ]


def _scale(skeleton: Skeleton, joints: IntArray, bind: FloatArray) -> float:
    """Metres in one of the mesh's units: lengths of bones in the world over those between bind matrices."""
    place = {int(joint): bind[i] for i, joint in enumerate(joints)}
    pairs = [(j, int(skeleton.parents[j])) for j in place if j and int(skeleton.parents[j]) in place]
    bound = sum(float(np.linalg.norm(place[a] - place[b])) for a, b in pairs)
    metres = sum(float(np.linalg.norm(skeleton.offsets[a])) for a, _ in pairs)
    return metres / bound if bound > 0 and metres > 0 else 1.0


def _part(gltf: Gltf, group: list[Primitive], joints: IntArray) -> Skin:
    """The skin of primitives that share their points, as the mesh has them."""
    attributes = group[0].attributes
    points, slots, weights = (gltf.accessor(attributes.get(key)) for key in ("POSITION", "JOINTS_0", "WEIGHTS_0"))
    corners = [_corners(gltf, primitive, len(points)) for primitive in group]
    if points.shape[1] != 3 or slots.shape != weights.shape or slots.shape != (len(points), 4):
        raise FormatError(gltf.path, "a skinned mesh's points and joints do not agree")
    if np.any(slots >= len(joints)) or np.any(slots < 0):
        raise FormatError(gltf.path, f"a skinned mesh is moved by a joint that its skin lacks: {int(slots.max())}")
    total = weights.sum(axis=1, keepdims=True)
    weights = np.where(total > 0, weights / np.where(total > 0, total, 1.0), [1.0, 0.0, 0.0, 0.0])
    if "NORMAL" in attributes:
        normals = gltf.accessor(attributes["NORMAL"])
    else:
        normals = np.tile([0.0, 1.0, 0.0], (len(points), 1))
    return Skin(
        points,
        normals,
        np.concatenate(corners),
        joints[slots.astype(np.int64)],
        weights,
        np.repeat(np.arange(len(group)), [len(triangles) for triangles in corners]),
        tuple(_material(gltf, primitive) for primitive in group),
    )


def _corners(gltf: Gltf, primitive: Primitive, points: int) -> IntArray:
    """The triangles of a primitive, ``(T, 3)``."""
    if primitive.indices is not None:
        corners = gltf.accessor(primitive.indices)[:, 0].astype(np.int64)
    else:
        corners = np.arange(points)
    if len(corners) % 3 or np.any(corners >= points) or np.any(corners < 0):
        raise FormatError(gltf.path, f"expected triangles of {points} points")
    return corners.reshape(-1, 3)


def _material(gltf: Gltf, primitive: Primitive) -> tuple[str, Colour]:
    if primitive.material is None:
        return "body", _GREY
    material = gltf.pick(gltf.document.materials, primitive.material, "material")
    red, green, blue, _ = material.pbr_metallic_roughness.base_color_factor or (*_GREY, 1.0)
    return material.name or "body", (red, green, blue)
