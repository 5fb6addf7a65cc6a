"""Reading glTF: the joints of the skins or of a VRM humanoid, or else all nodes that move, and an animation."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats import scene
from kinetograph.formats.conventions import to_metres_y_up
from kinetograph.formats.gltf.animation import (
    PATHS,
    channels,
    chosen_animation,
    sample_times,
    sampled,
    unit_quaternions,
)
from kinetograph.formats.gltf.buffers import Gltf
from kinetograph.formats.gltf.humanoid import Humanoid, humanoid_of
from kinetograph.formats.gltf.structure import Animation, Extras, Node, SkinPart
from kinetograph.formats.names import unique
from kinetograph.formats.options import Loaded, ReadOptions
from kinetograph.motion import Motion, cut
from kinetograph.take import Take

_MOST_NODES = 20_000


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """Read a ``.glb``, ``.gltf``, ``.vrm`` or ``.vrma`` file as a take in metres, Y up, with one motion per skeleton.

    Parameters
    ----------
    path : str or Path
    options : ReadOptions, optional
        ``fps`` is the rate to sample at; without it, the rate that this package notes in its files, or that of the
        keys.

    Returns
    -------
    Loaded

    Raises
    ------
    FormatError
        The file is not glTF 2, refers to bytes that are not there, or its nodes form a ring.
    RequestError
        There is no animation of the name in ``options``.

    Notes
    -----
    Joints are those of the skins, and their rest pose is the bind pose; without skins, every node that moves is a
    joint. Of a VRM file the humanoid's bones are joints too, and have the roles that the file gives them. The first
    animation is read unless ``options`` names another; without any, a single frame. Buffers may be files in the same
    folder, or below it.
    """
    return read_with_nodes(Gltf(Path(path)), options or ReadOptions())[0]


def read_with_nodes(gltf: Gltf, options: ReadOptions) -> tuple[Loaded, list[dict[str, int]]]:
    """What is in a document, and the node of each joint by its name, of each motion."""
    notes: list[str] = []
    parents, order = tree(gltf)
    animation, called, known = chosen_animation(gltf, options.animation, notes)
    times, fps = sample_times(gltf, animation, options.fps, notes)
    nodes = _nodes(gltf, parents, order, animation, times)
    place = {node: i for i, node in enumerate(order)}
    humanoid = humanoid_of(gltf)
    joints = [place[node] for node in _joints(gltf, humanoid)]
    still = _at_rest(gltf, nodes, order)
    bind = _bind(gltf, still, place)
    motions = scene.motions(nodes, joints, bind, fps, scene.Rest(*still, shared=len(known) > 1))
    if humanoid is not None:
        motions = humanoid.body_of(motions, [nodes.names[place[node]] for node in range(len(order))], notes)
    index = dict(zip(nodes.names, order, strict=True))
    owners = [[index[name] for name in motion.skeleton.names] for motion in motions]
    above = [parents[joints[0]] if parents[joints[0]] >= 0 else joints[0] for joints in owners]
    motions = [_named(gltf, motion, joints, notes) for motion, joints in zip(motions, owners, strict=True)]
    named = [
        dict(zip(motion.skeleton.names, joints, strict=True)) for motion, joints in zip(motions, owners, strict=True)
    ]
    if options.fps is None:
        motions = [
            _as_noted(motion, gltf.document.nodes[node].noted) for motion, node in zip(motions, above, strict=True)
        ]
    keep = replace(options.keep, shared=len(known) > 1)
    converted = to_metres_y_up(motions, options.units or "metre", options.up or "y", keep)
    # named by the node above the root, which holds the character's name in files of this package
    tracks = converted.tracks([_name(gltf, node) for node in above], notes)
    loaded = Loaded(Take(gltf.path.stem, tracks, animation=called), (*notes, *converted.notes), known)
    return loaded, [named[i] for i in converted.indices]


def _name(gltf: Gltf, node: int) -> str:
    name = gltf.document.nodes[node].name
    return (f"node_{node}" if name is None else name)[:200]


def _named(gltf: Gltf, motion: Motion, nodes: list[int], notes: list[str]) -> Motion:
    """A motion whose joints are called as their nodes are: names need only differ within one skeleton."""
    names = unique([_name(gltf, node) for node in nodes], "joint", notes)
    return replace(motion, skeleton=replace(motion.skeleton, names=tuple(names)))


def _as_noted(motion: Motion, noted: Extras) -> Motion:
    """A motion with the rate and the number of frames that this package notes, where several characters differ."""
    fps = noted.fps if noted.fps is not None and 0 < noted.fps < motion.fps else motion.fps
    step = round(motion.fps / fps)
    if step > 1 and abs(motion.fps / step - fps) < 1e-6 * fps:
        bones = None if motion.bones is None else motion.bones[::step]
        motion = Motion(motion.skeleton, motion.translation[::step], motion.rotations[::step], fps, bones)
    return cut(motion, 0, noted.frames) if noted.frames is not None and 0 < noted.frames < len(motion) else motion


def tree(gltf: Gltf) -> tuple[list[int], list[int]]:
    """Parents of the nodes, and the nodes with parents first."""
    nodes = gltf.document.nodes
    if not nodes or len(nodes) > _MOST_NODES:
        raise FormatError(gltf.path, f"expected 1 to {_MOST_NODES} nodes, found {len(nodes)}")
    parents = [-1] * len(nodes)
    for index, node in enumerate(nodes):
        for child in node.children:
            gltf.pick(nodes, child, "child")
            if parents[child] >= 0 or child == index:
                raise FormatError(gltf.path, f"node {child} has two parents; nodes must form a tree")
            parents[child] = index
    order = scene.depth_first(parents)
    if order is None:
        raise FormatError(gltf.path, "nodes form a ring; they must form a tree")
    return parents, order


def _nodes(gltf: Gltf, parents: list[int], order: list[int], animation: Animation, times: FloatArray) -> scene.Nodes:
    place = {node: i for i, node in enumerate(order)}
    rest = [_local(gltf, gltf.document.nodes[node]) for node in order]
    parts = {key: np.array([transform[k] for transform in rest])[None] for k, key in enumerate(PATHS)}
    moves = channels(gltf, animation)
    for key in PATHS:
        if any(what == key for _, what, _ in moves):
            parts[key] = np.repeat(parts[key], len(times), axis=0)
    for node, what, sampler in moves:
        parts[what][:, place[node]] = sampled(gltf, sampler, what, times)
    above = np.array([place[parents[node]] if parents[node] >= 0 else -1 for node in order])
    names = tuple(unique([_name(gltf, node) for node in order], "joint", []))
    return scene.Nodes(names, above, parts["translation"], parts["rotation"], parts["scale"])


def _local(gltf: Gltf, node: Node) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Translation, rotation and scale of a node at rest."""
    if node.matrix is not None:
        matrix = np.array(node.matrix).reshape(4, 4).T
        scale = np.linalg.norm(matrix[:3, :3], axis=0)
        if np.any(scale < 1e-9):
            raise FormatError(gltf.path, "a node's matrix is flat")
        return matrix[:3, 3], rot.from_matrix(matrix[:3, :3] / scale), scale
    rotation = np.array(node.rotation)[[3, 0, 1, 2]]
    return np.array(node.translation), unit_quaternions(gltf, rotation[None])[0], np.array(node.scale)


def _joints(gltf: Gltf, humanoid: Humanoid | None) -> list[int]:
    """The nodes that are joints."""
    nodes: set[int] = set() if humanoid is None else set(humanoid.bones.values())
    if humanoid is None or not humanoid.animation:
        nodes |= {joint for skin in gltf.document.skins for joint in skin.joints}
    if not nodes:  # those that any animation moves, so that all are of one skeleton
        nodes = {node for animation in gltf.document.animations for node, *_ in channels(gltf, animation)}
    if not nodes:
        raise FormatError(gltf.path, "expected a skin or an animation, found neither: nothing in it moves")
    gltf.pick(gltf.document.nodes, max(nodes), "joint")
    return sorted(nodes)


def _at_rest(gltf: Gltf, nodes: scene.Nodes, order: list[int]) -> tuple[FloatArray, FloatArray]:
    """World positions and rotations of the nodes where no animation moves them."""
    still = [_local(gltf, gltf.document.nodes[node]) for node in order]
    parts = [np.array([transform[k] for transform in still])[None] for k in range(3)]
    positions, rotations = scene.world(scene.Nodes(nodes.names, nodes.parents, *parts))
    return positions[0], rotations[0]


def _bind(gltf: Gltf, still: tuple[FloatArray, FloatArray], place: dict[int, int]) -> tuple[FloatArray, FloatArray]:
    """World positions and rotations of the nodes in the bind pose: that of the skins, or else of the nodes at rest."""
    document = gltf.document
    positions, rotations = still[0].copy(), still[1].copy()
    for skin in document.skins:
        if skin.inverse_bind_matrices is None:
            continue
        gltf.pick(document.nodes, max(skin.joints, default=0), "joint")
        joints = [place[joint] for joint in skin.joints]
        bind = bind_matrices(gltf, skin)
        positions[joints] = bind[:, :3, 3]
        axes = bind[:, :3, :3]
        rotations[joints] = rot.from_matrix(axes / np.linalg.norm(axes, axis=1, keepdims=True))
    return positions, rotations


def bind_matrices(gltf: Gltf, skin: SkinPart) -> FloatArray:
    """The transforms ``(J, 4, 4)`` of the joints of a skin in its bind pose."""
    inverse = gltf.accessor(skin.inverse_bind_matrices)
    if inverse.shape[1] != 16 or len(inverse) < len(skin.joints):
        raise FormatError(gltf.path, f"expected {len(skin.joints)} matrices of a skin, found {inverse.shape}")
    matrices = inverse[: len(skin.joints)].reshape(-1, 4, 4).transpose(0, 2, 1)
    if np.any(np.abs(np.linalg.det(matrices)) < 1e-12):
        raise FormatError(gltf.path, "a bind matrix of a skin is flat")
    return np.asarray(np.linalg.inv(matrices), dtype=np.float64)
