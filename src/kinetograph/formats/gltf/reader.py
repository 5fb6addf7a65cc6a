"""Reading glTF: the joints of the skins, or else all nodes that move, and one animation."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats import scene
from kinetograph.formats.conventions import to_metres_y_up
from kinetograph.formats.gltf.buffers import Gltf, Json
from kinetograph.formats.names import unique
from kinetograph.formats.options import Loaded, ReadOptions
from kinetograph.take import Take

_PATHS = {"translation": 3, "rotation": 4, "scale": 3}
_MOST_NODES = 20_000
_RATES = (24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 240.0)


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """A ``.glb`` or ``.gltf`` file as a take in metres, Y up, with a motion a skin.

    Joints are those of the skins, in whose bind pose the skeletons rest; without skins, every node that moves. The
    first animation is read, sampled at ``options.fps``, at the rate that this package noted in the file, or at that of
    its keys. Buffers may lie in files beside it, never outside of its folder.

    Raises FormatError for what is not glTF 2, for numbers that are not there, and for rings of nodes.
    """
    path = Path(path)
    options = options or ReadOptions()
    gltf = Gltf(path)
    notes: list[str] = []
    parents, order = _tree(gltf)
    animation = _animation(gltf, notes)
    times, fps = _times(gltf, animation, options.fps, notes)
    nodes = _nodes(gltf, parents, order, animation, times)
    place = {node: i for i, node in enumerate(order)}
    joints = [place[node] for node in _joints(gltf, animation)]
    bind = _bind(gltf, nodes, place)
    found = scene.motions(nodes, joints, bind, fps)
    converted = to_metres_y_up(found, options.units or "metre", options.up or "y")
    names = ["motion"]
    if len(found) > 1:
        # named by the node above the root, which holds the character's name in files of this package
        names = unique(
            [_label(gltf, parents, order, motion.skeleton.names[0], nodes) for motion in found], "track", notes
        )
    return Loaded(Take(path.stem, dict(zip(names, converted.motions, strict=True))), (*notes, *converted.notes))


def _label(gltf: Gltf, parents: list[int], order: list[int], root: str, nodes: scene.Nodes) -> str:
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
        raise FormatError(gltf.path, "nodes go round in a ring; nodes must form a tree")
    return parents, order


def _animation(gltf: Gltf, notes: list[str]) -> Json:
    animations = gltf.objects("animations")
    if not animations:
        notes.append("the file has no animation: its pose stands for it")
        return {}
    if len(animations) > 1:
        others = ", ".join(repr(str(a.get("name", "")))[:40] for a in animations[1:6])
        notes.append(f"{len(animations)} animations: read the first one, not {others}")
    return animations[0]


def _channels(gltf: Gltf, animation: Json) -> list[tuple[int, str, Json]]:
    """Node, path and sampler of each channel of an animation."""
    samplers = gltf.list_of(animation, "samplers")
    out = []
    for channel in gltf.list_of(animation, "channels"):
        target = channel.get("target")
        if isinstance(target, dict) and target.get("path") in _PATHS and "node" in target:
            node = gltf.index(target, "node", len(gltf.objects("nodes")))
            out.append((node, str(target["path"]), samplers[gltf.index(channel, "sampler", len(samplers))]))
    return out


def _times(gltf: Gltf, animation: Json, given: float | None, notes: list[str]) -> tuple[FloatArray, float]:
    """Times to sample at, and their rate."""
    if given is not None and not (np.isfinite(given) and given > 0):
        raise FormatError(gltf.path, f"fps must be a positive number, found {given}")
    channels = _channels(gltf, animation)
    accessors = len(gltf.objects("accessors"))
    keys = {index: gltf.accessor(index)[:, 0] for index in {gltf.index(s, "input", accessors) for *_, s in channels}}
    for times in keys.values():
        if len(times) == 0 or np.any(np.diff(times) <= 0) or abs(times[0]) > 1e6 or abs(times[-1]) > 1e6:
            raise FormatError(gltf.path, "expected the times of an animation to increase")
    start = min((float(times[0]) for times in keys.values()), default=0.0)
    stop = max((float(times[-1]) for times in keys.values()), default=0.0)
    noted = [e.get("fps") for node in gltf.objects("nodes") if isinstance(e := node.get("extras"), dict)]
    fps = given or next((float(f) for f in noted if isinstance(f, int | float) and 0 < f < 1e5), None)
    if fps is None:
        longest = max(keys.values(), key=len, default=np.zeros(1))
        step = float(np.median(np.diff(longest))) if len(longest) > 1 else 1 / 30
        fps = next((rate for rate in _RATES if abs(rate * step - 1) < 1e-3), 1.0 / step)
        notes.append(f"rate not given: {fps:g} frames a second, as far apart as the keys are")
    count = (stop - start) * fps
    if not count * len(gltf.objects("nodes")) <= scene.most_values(gltf.size):
        raise FormatError(gltf.path, f"{stop - start:g} s at {fps:g} frames a second are too many; give --fps")
    return start + np.arange(round(count) + 1) / fps, fps


def _nodes(gltf: Gltf, parents: list[int], order: list[int], animation: Json, times: FloatArray) -> scene.Nodes:
    nodes = gltf.objects("nodes")
    place = {node: i for i, node in enumerate(order)}
    rest = [_local(gltf, nodes[node]) for node in order]
    parts = {key: np.array([transform[k] for transform in rest])[None] for k, key in enumerate(_PATHS)}
    channels = _channels(gltf, animation)
    for key in _PATHS:
        if any(what == key for _, what, _ in channels):
            parts[key] = np.repeat(parts[key], len(times), axis=0)
    for node, what, sampler in channels:
        parts[what][:, place[node]] = _sampled(gltf, sampler, what, times)
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
    turn = gltf.vector(node, "rotation", [0.0, 0.0, 0.0, 1.0])[[3, 0, 1, 2]]
    return (
        gltf.vector(node, "translation", [0.0] * 3),
        _unit(gltf, turn[None])[0],
        gltf.vector(node, "scale", [1.0] * 3),
    )


def _sampled(gltf: Gltf, sampler: Json, what: str, times: FloatArray) -> FloatArray:
    accessors = len(gltf.objects("accessors"))
    keys = gltf.accessor(gltf.index(sampler, "input", accessors))[:, 0]
    values = gltf.accessor(gltf.index(sampler, "output", accessors))
    kind = sampler.get("interpolation", "LINEAR")
    if kind == "CUBICSPLINE" and values.shape == (3 * len(keys), _PATHS[what]):
        return _splined(gltf, keys, values.reshape(len(keys), 3, -1), what, times)
    if values.shape != (len(keys), _PATHS[what]):
        raise FormatError(gltf.path, f"expected {len(keys)} values of a {what}, found {values.shape}")
    if what == "rotation":
        values = _unit(gltf, values[:, [3, 0, 1, 2]])
        kind = "SLERP" if kind == "LINEAR" else kind
    return scene.interpolate(times, keys, values, str(kind))


def _splined(gltf: Gltf, keys: FloatArray, values: FloatArray, what: str, times: FloatArray) -> FloatArray:
    if what != "rotation":
        return scene.spline(times, keys, values)
    values = values[..., [3, 0, 1, 2]]
    values[:, 1] = _unit(gltf, values[:, 1])
    found = scene.spline(times, keys, values)
    if np.any(np.linalg.norm(found, axis=1) < 1e-3):
        raise FormatError(gltf.path, "a spline of rotations passes through zero")
    return rot.normalize(found)


def _unit(gltf: Gltf, turns: FloatArray) -> FloatArray:
    if np.any(np.abs(np.linalg.norm(turns, axis=-1) - 1) > 0.1):
        raise FormatError(gltf.path, "expected unit quaternions as rotations")
    return rot.normalize(turns)


def _joints(gltf: Gltf, animation: Json) -> list[int]:
    """The nodes that are joints."""
    count = len(gltf.objects("nodes"))
    found: set[int] = set()
    for skin in gltf.objects("skins"):
        joints = skin.get("joints", [])
        found |= {
            gltf.index({"joint": joint}, "joint", count) for joint in (joints if isinstance(joints, list) else [])
        }
    found = found or {node for node, *_ in _channels(gltf, animation)}
    if not found:
        raise FormatError(gltf.path, "expected a skin or an animation, found neither: nothing in it moves")
    return sorted(found)


def _bind(gltf: Gltf, nodes: scene.Nodes, place: dict[int, int]) -> tuple[FloatArray, FloatArray]:
    """World positions and rotations of the nodes in the bind pose: of the skins, or else as the nodes stand."""
    document = gltf.objects("nodes")
    still = [_local(gltf, document[node]) for node in sorted(place, key=lambda n: place[n])]
    parts = [np.array([transform[k] for transform in still])[None] for k in range(3)]
    positions, turns = scene.world(scene.Nodes(nodes.names, nodes.parents, *parts))
    at, turn = positions[0], turns[0]
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
        at[joints] = bind[:, :3, 3]
        axes = bind[:, :3, :3]
        turn[joints] = rot.from_matrix(axes / np.linalg.norm(axes, axis=1, keepdims=True))
    return at, turn
