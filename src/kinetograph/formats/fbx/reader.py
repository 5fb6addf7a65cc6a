"""Reading FBX: the joints, their curves, and the pose that they are bound in."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats import scene as scenes
from kinetograph.formats.conventions import UPS, scale_motion, to_metres_y_up
from kinetograph.formats.fbx.nodes import Node, parse
from kinetograph.formats.names import unique
from kinetograph.formats.options import Loaded, ReadOptions
from kinetograph.take import Take

TICKS = 46_186_158_000
"""Units of FBX time in a second."""

# frames a second by the number of GlobalSettings' TimeMode
TIME_MODES = {1: 120.0, 2: 100.0, 3: 60.0, 4: 50.0, 5: 48.0, 6: 30.0, 7: 30.0, 8: 30 / 1.001, 9: 30 / 1.001, 10: 25.0}
TIME_MODES |= {11: 24.0, 12: 1000.0, 13: 24 / 1.001, 15: 96.0, 16: 72.0, 17: 60 / 1.001, 18: 120 / 1.001}
ORDERS = ("zyx", "yzx", "xzy", "zxy", "yxz", "xyz")  # of RotationOrder 0 to 5, the outermost turn first
_LIMBS = ("LimbNode", "Limb", "Root", "Effector")
_LARGEST = 1e12
_MOST_MODELS = 20_000
_CURVES = {"Lcl Translation": "shift", "Lcl Rotation": "turn", "Lcl Scaling": "scale"}

Properties = dict[str, list[Any]]
Curve = tuple[FloatArray, FloatArray]


@dataclass
class Model:
    """A node of the scene: its name, its properties, its parent among the models, and curves by property and axis."""

    name: str
    kind: str
    properties: Properties
    parent: int
    curves: dict[tuple[str, int], Curve]

    def vector(self, key: str, default: float = 0.0) -> FloatArray:
        """A property of three numbers."""
        found = self.properties.get(key, [])[:3]
        good = len(found) == 3 and all(isinstance(v, int | float) and abs(v) < _LARGEST for v in found)
        return np.array(found, dtype=np.float64) if good else np.full(3, default)

    def flag(self, key: str) -> int:
        """A property of one whole number, 0 where there is none."""
        found = self.properties.get(key, [0])
        return int(found[0]) if found and isinstance(found[0], int | float) and abs(found[0]) < _LARGEST else 0


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """A binary FBX file as a take in metres, Y up, with a motion a skeleton.

    Joints are the limb nodes, or else the nodes that move; they rest in the bind pose that the file gives, or else
    with all turns at zero. Of several animations the one with the most curves is read, by straight lines between its
    keys, at ``options.fps`` or at the rate of the keys.

    Raises FormatError for what is not binary FBX 7, damaged files, and scenes without joints.
    """
    path = Path(path)
    options = options or ReadOptions()
    document = parse(path)
    scene = _Scene(path, document)
    notes = scene.notes
    joints = [i for i, m in enumerate(scene.models) if m.kind in _LIMBS]
    joints = joints or [i for i, m in enumerate(scene.models) if m.curves]
    if not joints:
        raise FormatError(path, "expected a skeleton or nodes that move, found neither")
    times, fps = _times(path, scene, options.fps)
    nodes = scene.nodes(times)
    bind = scene.bind(nodes)
    motions = scenes.motions(nodes, joints, bind, fps)
    units = options.units
    if units is None:
        factor = 0.01 * scene.setting("UnitScaleFactor", 1.0)
        motions, units = [scale_motion(motion, factor) for motion in motions], "metre"
    up = options.up or UPS[int(scene.setting("UpAxis", 1.0)) % 3]
    converted = to_metres_y_up(motions, units, up)
    names = ["motion"]
    if len(motions) > 1:
        names = unique([motion.skeleton.names[0] for motion in motions], "track", notes)
    return Loaded(Take(path.stem, dict(zip(names, converted.motions, strict=True))), (*notes, *converted.notes))


class _Scene:
    """The models of a document, parents first, and its settings."""

    def __init__(self, path: Path, document: Node) -> None:
        self.path, self.document = path, document
        self.notes: list[str] = []
        self.settings = _properties(document.child("GlobalSettings"))
        objects = document.child("Objects")
        self.objects = {node.values[0]: node for node in objects.children if _is_object(node)} if objects else {}
        self.links = self._links()
        found = [key for key, node in self.objects.items() if node.name == "Model"]
        if len(found) > _MOST_MODELS:
            raise FormatError(path, f"more than {_MOST_MODELS} models; is this file damaged?")
        place = {key: i for i, key in enumerate(found)}
        parents = [-1] * len(found)
        for child, parent, _ in self.links:
            if child in place and parent in place:
                parents[place[child]] = place[parent]
        order = scenes.depth_first(parents)
        if order is None:
            raise FormatError(path, "models hang on each other in a ring; they must form a tree")
        self.keys = [found[i] for i in order]
        self.place = {key: i for i, key in enumerate(self.keys)}
        self.models = [self._model(found[i], self.place[found[parents[i]]] if parents[i] >= 0 else -1) for i in order]
        self._attach_curves()

    def _links(self) -> list[tuple[Any, Any, str]]:
        """Connections: from, to, and the property that it goes to."""
        connections = self.document.child("Connections")
        rows = [node.values for node in connections.children if node.name in ("C", "Connect")] if connections else []
        rows = [row for row in rows if len(row) >= 3 and isinstance(row[1], int) and isinstance(row[2], int)]
        return [(row[1], row[2], str(row[3]) if len(row) > 3 else "") for row in rows]

    def setting(self, key: str, default: float) -> float:
        """A number of the global settings."""
        found = self.settings.get(key, [default])
        good = found and isinstance(found[0], int | float) and 0 < abs(found[0]) < 1e6
        return float(found[0]) if good else (0.0 if found and found[0] == 0 and key == "UpAxis" else default)

    @property
    def start(self) -> float:
        """Seconds at which the first animation stack begins; infinite where none says."""
        stack = next((node for node in self.objects.values() if node.name == "AnimationStack"), None)
        found = _properties(stack).get("LocalStart") or [None]
        return found[0] / TICKS if isinstance(found[0], int) else np.inf

    def _model(self, key: int, parent: int) -> Model:
        node = self.objects[key]
        name = str(node.values[1]).partition("\x00")[0]
        return Model(name.rpartition("::")[2], str(node.values[2]), self._template() | _properties(node), parent, {})

    def _template(self) -> Properties:
        definitions = self.document.child("Definitions")
        kinds = definitions.all("ObjectType") if definitions else iter(())
        model = next((kind for kind in kinds if kind.values[:1] == ["Model"]), None)
        return _properties(model.child("PropertyTemplate")) if model else {}

    def _attach_curves(self) -> None:
        """Give the models the curves of the layer that has most of them."""
        into: dict[int, list[tuple[int, str]]] = {}
        for child, parent, key in self.links:
            into.setdefault(child, []).append((parent, key))
        layers: dict[int, list[tuple[int, str, int, int]]] = {}
        for curve, node in self.objects.items():
            if node.name != "AnimationCurve":
                continue
            for group, axis in into.get(curve, []):
                targets = into.get(group, [])
                layer = next((p for p, _ in targets if _named(self.objects.get(p), "AnimationLayer")), 0)
                for target, key in targets:
                    if target in self.place and key in _CURVES and axis in ("d|X", "d|Y", "d|Z"):
                        layers.setdefault(layer, []).append((target, key, "XYZ".index(axis[2]), curve))
        if not layers:
            self.notes.append("the file has no animation of a node: its pose stands for it")
            return
        best = max(layers, key=lambda layer: len(layers[layer]))
        if len(layers) > 1:
            self.notes.append(f"{len(layers)} animation layers: read the one with the most curves")
        for target, key, number, curve in layers[best]:
            self.models[self.place[target]].curves[_CURVES[key], number] = _curve(self.path, self.objects[curve])

    def nodes(self, times: FloatArray) -> scenes.Nodes:
        """Local transforms at ``times``."""
        frames, count = len(times), len(self.models)
        shifts, turns, scales = np.empty((frames, count, 3)), np.empty((frames, count, 4)), np.empty((frames, count, 3))
        for i, model in enumerate(self.models):
            shifts[:, i], turns[:, i], scales[:, i] = _local(model, times)
        names = unique([model.name or "node" for model in self.models], "joint", self.notes)
        return scenes.Nodes(tuple(names), np.array([m.parent for m in self.models]), shifts, turns, scales)

    def bind(self, nodes: scenes.Nodes) -> tuple[FloatArray, FloatArray]:
        """World positions and rotations of the models in the bind pose, or else with their turns at zero."""
        parts = [_local(model, None) for model in self.models]
        stacked = [np.stack([part[k] for part in parts], axis=1) for k in range(3)]
        positions, turns = scenes.world(scenes.Nodes(nodes.names, nodes.parents, *stacked))
        at, turn = positions[0], turns[0]
        for key, matrix in self._bind_matrices():
            if key in self.place:
                axes = matrix[:3, :3] / np.maximum(np.linalg.norm(matrix[:3, :3], axis=0), 1e-12)
                if abs(np.linalg.det(axes) - 1) < 1e-2:
                    at[self.place[key]], turn[self.place[key]] = matrix[:3, 3], rot.from_matrix(axes)
        return at, turn

    def _bind_matrices(self) -> list[tuple[int, FloatArray]]:
        out = []
        for key, node in self.objects.items():
            if node.name == "Pose" and node.values[2] == "BindPose":
                for pose in node.all("PoseNode"):
                    model, matrix = pose.child("Node"), pose.child("Matrix")
                    if model and matrix and model.values and matrix.values:
                        out.append((model.values[0], matrix.values[0]))
            elif node.name == "Deformer" and (link := node.child("TransformLink")) and link.values:
                out.extend((child, link.values[0]) for child, parent, _ in self.links if parent == key)
        shaped = [(key, np.asarray(m, np.float64)) for key, m in out if isinstance(m, np.ndarray) and m.shape == (16,)]
        return [(key, m.reshape(4, 4).T) for key, m in shaped if np.abs(m).max() < _LARGEST]


def _named(node: Node | None, name: str) -> bool:
    return node is not None and node.name == name


def _is_object(node: Node) -> bool:
    return len(node.values) >= 3 and isinstance(node.values[0], int) and isinstance(node.values[1], str)


def _properties(node: Node | None) -> Properties:
    table = node.child("Properties70") if node else None
    rows = (row.values for row in table.children if row.name == "P" and len(row.values) > 4) if table else ()
    return {str(row[0]): row[4:] for row in rows}


def _curve(path: Path, node: Node) -> Curve:
    keys, values = node.child("KeyTime"), node.child("KeyValueFloat")
    arrays = [part.values[0] for part in (keys, values) if part and part.values]
    if len(arrays) != 2 or not all(isinstance(a, np.ndarray) for a in arrays) or len(arrays[0]) != len(arrays[1]):
        raise FormatError(path, "expected an animation curve to have as many times as values")
    times, numbers = arrays[0].astype(np.float64) / TICKS, arrays[1].astype(np.float64)
    if len(times) == 0 or np.any(np.diff(times) <= 0) or np.abs(times).max() > 1e6:
        raise FormatError(path, "expected the times of an animation curve to increase")
    if not (np.isfinite(numbers).all() and np.abs(numbers).max() < _LARGEST):
        raise FormatError(path, "expected finite numbers in an animation curve")
    return times, numbers


def _times(path: Path, scene: _Scene, given: float | None) -> tuple[FloatArray, float]:
    if given is not None and not (np.isfinite(given) and given > 0):
        raise FormatError(path, f"fps must be a positive number, found {given}")
    keys = [times for model in scene.models for times, _ in model.curves.values() if len(times) > 1]
    start = min((float(times[0]) for times in keys), default=0.0)
    stop = max((float(times[-1]) for times in keys), default=0.0)
    fps = given or _rate(scene, keys)
    # from the stack's own start, so that files recorded together stay together; on the grid of its frames
    start = min(start, scene.start if abs(scene.start) < 1e6 else start)
    start = np.floor(start * fps + 1e-3) / fps
    count = (stop - start) * fps
    if not count * len(scene.models) <= scenes.most_values(path.stat().st_size):
        raise FormatError(path, f"{stop - start:g} s at {fps:g} frames a second are too many; give --fps")
    return start + np.arange(round(count) + 1) / fps, fps


def _rate(scene: _Scene, keys: list[FloatArray]) -> float:
    """That of the keys where they are even, or else of the settings."""
    mode = int(scene.setting("TimeMode", 0.0))
    custom = scene.setting("CustomFrameRate", 30.0)
    stated = TIME_MODES.get(mode, custom if mode == 14 and custom > 0 else 30.0)
    longest = max(keys, key=len, default=np.zeros(1))
    steps = np.diff(longest)
    if len(steps) and np.ptp(steps) < 0.02 * np.median(steps):
        found = 1.0 / float(np.median(steps))
        near = [rate for rate in (stated, *TIME_MODES.values()) if abs(rate / found - 1) < 5e-4]
        fps = near[0] if near else found
        if not near or near[0] != stated:
            scene.notes.append(f"keys are {fps:g} a second, though the file says {stated:g} frames a second")
        return fps
    scene.notes.append(f"keys are not evenly spaced: sampled at {stated:g} frames a second")
    return stated


def _local(model: Model, times: FloatArray | None) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Translation, rotation and scale at ``times``, or in the rest pose: turns at zero."""
    shift = _animated(model, "shift", model.vector("Lcl Translation"), times)
    scale = _animated(model, "scale", model.vector("Lcl Scaling", 1.0), times)
    angles = _animated(model, "turn", np.zeros(3) if times is None else model.vector("Lcl Rotation"), times)
    active = model.flag("RotationActive")
    order = ORDERS[model.flag("RotationOrder") % 6] if active else "zyx"
    turn = rot.from_euler(np.radians(angles)[:, ["xyz".index(axis) for axis in order]], order)
    if active:
        before, after = (_fixed(model.vector(key)) for key in ("PreRotation", "PostRotation"))
        turn = rot.multiply(rot.multiply(before, turn), rot.conjugate(after))
    pivot, scale_pivot = model.vector("RotationPivot"), model.vector("ScalingPivot")
    inside = -pivot + model.vector("ScalingOffset") + scale_pivot - scale * scale_pivot
    return shift + model.vector("RotationOffset") + pivot + rot.rotate(turn, inside), turn, scale


def _fixed(degrees: FloatArray) -> FloatArray:
    return rot.from_euler(np.radians(degrees)[::-1], "zyx")


def _animated(model: Model, what: str, still: FloatArray, times: FloatArray | None) -> FloatArray:
    out = np.tile(still, (1 if times is None else len(times), 1))
    for axis in range(3):
        if times is not None and (what, axis) in model.curves:
            keys, values = model.curves[what, axis]
            out[:, axis] = np.interp(times, keys, values)
    return out
