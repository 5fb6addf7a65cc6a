"""Reading glTF: the joints of the skins, or else all nodes that move, and the first animation."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats import scene
from kinetograph.formats.conventions import to_metres_y_up
from kinetograph.formats.gltf.animation import PATHS, channels, first_animation, sample_times, sampled, unit_quaternions
from kinetograph.formats.gltf.buffers import Gltf, Json
from kinetograph.formats.names import unique
from kinetograph.formats.options import Loaded, ReadOptions
from kinetograph.take import Take

_MOST_NODES = 20_000


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """Read a ``.glb`` or ``.gltf`` file as a take in metres, Y up, with one motion per skin.

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

    Notes
    -----
    Joints are those of the skins, and their rest pose is the bind pose; without skins, every node that moves is a
    joint. The first animation is read. Buffers may be files in the same folder, or below it.
    """
    path = Path(path)
    options = options or ReadOptions()
    gltf = Gltf(path)
    notes: list[str] = []
    parents, order = _tree(gltf)
    animation = first_animation(gltf, notes)
    times, fps = sample_times(gltf, animation, options.fps, notes)
    nodes = _nodes(gltf, parents, order, animation, times)
    place = {node: i for i, node in enumerate(order)}
    joints = [place[node] for node in _joints(gltf, animation)]
    bind = _bind(gltf, nodes, place)
    motions = scene.motions(nodes, joints, bind, fps)
    converted = to_metres_y_up(motions, options.units or "metre", options.up or "y", options.keep)
    # named by the node above the root, which holds the character's name in files of this package
    tracks = converted.tracks([_name_above(nodes, motion.skeleton.names[0]) for motion in motions], notes)
    return Loaded(Take(path.stem, tracks), (*notes, *converted.notes))


def _name_above(nodes: scene.Nodes, root: str) -> str:
    above = int(nodes.parents[nodes.names.index(root)])
    return nodes.names[above] if above >= 0 else root


def _tree(gltf: Gltf) -> tuple[list[int], list[int]]:
    """Parents of the nodes, and the nodes with parents first."""
    nodes = gltf.objects("nodes")
    if not nodes or len(nodes) > _MOST_NODES:
        raise FormatError(gltf.path, f"expected 1 to {_MOST_NODES} nodes, found {len(nodes)}")
    parents = [-1] * len(nodes)
    for index, node in enumerate(nodes):
        children = node.get("children", [])
        for child in children if isinstance(children, list) else []:
            child = gltf.index({"child": child}, "child", len(nodes))
            if parents[child] >= 0 or child == index:
                raise FormatError(gltf.path, f"node {child} has two parents; nodes must form a tree")
            parents[child] = index
    order = scene.depth_first(parents)
    if order is None:
        raise FormatError(gltf.path, "nodes form a ring; they must form a tree")
    return parents, order


def _nodes(gltf: Gltf, parents: list[int], order: list[int], animation: Json, times: FloatArray) -> scene.Nodes:
    nodes = gltf.objects("nodes")
    place = {node: i for i, node in enumerate(order)}
    rest = [_local(gltf, nodes[node]) for node in order]
    parts = {key: np.array([transform[k] for transform in rest])[None] for k, key in enumerate(PATHS)}
    moves = channels(gltf, animation)
    for key in PATHS:
        if any(what == key for _, what, _ in moves):
            parts[key] = np.repeat(parts[key], len(times), axis=0)
    for node, what, sampler in moves:
        parts[what][:, place[node]] = sampled(gltf, sampler, what, times)
    names = unique([str(nodes[node].get("name", f"node_{node}"))[:200] for node in order], "joint", [])
    above = np.array([place[parents[node]] if parents[node] >= 0 else -1 for node in order])
    return scene.Nodes(tuple(names), above, parts["translation"], parts["rotation"], parts["scale"])


def _local(gltf: Gltf, node: Json) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Translation, rotation and scale of a node at rest."""
    if "matrix" in node:
        matrix = gltf.vector(node, "matrix", [0.0] * 16).reshape(4, 4).T
        scale = np.linalg.norm(matrix[:3, :3], axis=0)
        if np.any(scale < 1e-9):
            raise FormatError(gltf.path, "a node's matrix is flat")
        return matrix[:3, 3], rot.from_matrix(matrix[:3, :3] / scale), scale
    rotation = gltf.vector(node, "rotation", [0.0, 0.0, 0.0, 1.0])[[3, 0, 1, 2]]
    return (
        gltf.vector(node, "translation", [0.0] * 3),
        unit_quaternions(gltf, rotation[None])[0],
        gltf.vector(node, "scale", [1.0] * 3),
    )


def _joints(gltf: Gltf, animation: Json) -> list[int]:
    """The nodes that are joints."""
    count = len(gltf.objects("nodes"))
    nodes: set[int] = set()
    for skin in gltf.objects("skins"):
        joints = skin.get("joints", [])
        nodes |= {
            gltf.index({"joint": joint}, "joint", count) for joint in (joints if isinstance(joints, list) else [])
        }
    nodes = nodes or {node for node, *_ in channels(gltf, animation)}
    if not nodes:
        raise FormatError(gltf.path, "expected a skin or an animation, found neither: nothing in it moves")
    return sorted(nodes)


def _bind(gltf: Gltf, nodes: scene.Nodes, place: dict[int, int]) -> tuple[FloatArray, FloatArray]:
    """World positions and rotations of the nodes in the bind pose: that of the skins, or else of the nodes at rest."""
    document = gltf.objects("nodes")
    still = [_local(gltf, document[node]) for node in sorted(place, key=lambda n: place[n])]
    parts = [np.array([transform[k] for transform in still])[None] for k in range(3)]
    positions, rotations = (part[0] for part in scene.world(scene.Nodes(nodes.names, nodes.parents, *parts)))
    for skin in gltf.objects("skins"):
        if "inverseBindMatrices" not in skin:
            continue
        inverse = gltf.accessor(gltf.index(skin, "inverseBindMatrices", len(gltf.objects("accessors"))))
        joints = [place[joint] for joint in skin.get("joints", [])]
        if inverse.shape[1] != 16 or len(inverse) < len(joints):
            raise FormatError(gltf.path, f"expected {len(joints)} matrices of a skin, found {inverse.shape}")
        matrices = inverse[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)
        if np.any(np.abs(np.linalg.det(matrices)) < 1e-12):
            raise FormatError(gltf.path, "a bind matrix of a skin is flat")
        bind = np.asarray(np.linalg.inv(matrices), dtype=np.float64)
        positions[joints] = bind[:, :3, 3]
        axes = bind[:, :3, :3]
        rotations[joints] = rot.from_matrix(axes / np.linalg.norm(axes, axis=1, keepdims=True))
    return positions, rotations
