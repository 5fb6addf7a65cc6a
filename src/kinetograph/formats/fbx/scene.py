"""The models of an FBX document, its settings, and the pose that its joints are bound in."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats import scene as scenes
from kinetograph.formats.fbx.models import LARGEST, Model, Properties, local_transforms, parse_curve
from kinetograph.formats.fbx.nodes import Node
from kinetograph.formats.fbx.times import TICKS
from kinetograph.formats.names import unique

_MOST_MODELS = 20_000
_CURVES = {"Lcl Translation": "translation", "Lcl Rotation": "rotation", "Lcl Scaling": "scale"}


class Scene:
    """The models of a document, parents first, and its settings.

    Parameters
    ----------
    path : Path
        For errors.
    document : Node
        What `kinetograph.formats.fbx.nodes.parse` returns. FormatError is raised where models do not form a tree or
        curves are damaged.
    """

    def __init__(self, path: Path, document: Node) -> None:
        self.path, self.document = path, document
        self.notes: list[str] = []
        self.settings = _properties(document.child("GlobalSettings"))
        objects = document.child("Objects")
        self.objects = {node.values[0]: node for node in objects.children if _is_object(node)} if objects else {}
        self.links = self._links()
        models = [key for key, node in self.objects.items() if node.name == "Model"]
        if len(models) > _MOST_MODELS:
            raise FormatError(path, f"more than {_MOST_MODELS} models; is this file damaged?")
        place = {key: i for i, key in enumerate(models)}
        parents = [-1] * len(models)
        for child, parent, _ in self.links:
            if child in place and parent in place:
                parents[place[child]] = place[parent]
        order = scenes.depth_first(parents)
        if order is None:
            raise FormatError(path, "models form a ring; they must form a tree")
        self.place = {models[i]: position for position, i in enumerate(order)}
        above = [self.place[models[parents[i]]] if parents[i] >= 0 else -1 for i in order]
        self.models = [self._model(models[i], parent) for i, parent in zip(order, above, strict=True)]
        self._attach_curves()

    def _links(self) -> list[tuple[Any, Any, str]]:
        """Connections: from, to, and the property that it goes to."""
        connections = self.document.child("Connections")
        rows = [node.values for node in connections.children if node.name in ("C", "Connect")] if connections else []
        rows = [row for row in rows if len(row) >= 3 and isinstance(row[1], int) and isinstance(row[2], int)]
        return [(row[1], row[2], str(row[3]) if len(row) > 3 else "") for row in rows]

    def setting(self, key: str, default: float) -> float:
        """A number of the global settings."""
        values = self.settings.get(key, [default])
        good = values and isinstance(values[0], int | float) and 0 < abs(values[0]) < 1e6
        return float(values[0]) if good else (0.0 if values and values[0] == 0 and key == "UpAxis" else default)

    @property
    def start(self) -> float:
        """Seconds at which the first animation stack begins; infinite where the file does not say."""
        stack = next((node for node in self.objects.values() if node.name == "AnimationStack"), None)
        ticks = (_properties(stack).get("LocalStart") or [None])[0]
        return ticks / TICKS if isinstance(ticks, int) else np.inf

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
        """Give the models the curves of the layer with the most curves."""
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
            self.notes.append("the file has no animation of a node: read its pose")
            return
        best = max(layers, key=lambda layer: len(layers[layer]))
        if len(layers) > 1:
            self.notes.append(f"{len(layers)} animation layers: read the one with the most curves")
        for target, key, number, curve in layers[best]:
            self.models[self.place[target]].curves[_CURVES[key], number] = parse_curve(self.path, self.objects[curve])

    def nodes(self, times: FloatArray) -> scenes.Nodes:
        """The models with their local transforms at some times, ``(F,)`` seconds."""
        names = unique([model.name or "node" for model in self.models], "joint", self.notes)
        return self._nodes(tuple(names), times)

    def bind(self, names: tuple[str, ...]) -> tuple[FloatArray, FloatArray]:
        """World positions ``(N, 3)`` and rotations ``(N, 4)`` in the bind pose, or else with local rotations zero."""
        positions, rotations = (part[0] for part in scenes.world(self._nodes(names, None)))
        for key, matrix in self._bind_matrices():
            if key in self.place:
                axes = matrix[:3, :3] / np.maximum(np.linalg.norm(matrix[:3, :3], axis=0), 1e-12)
                if abs(np.linalg.det(axes) - 1) < 1e-2:
                    positions[self.place[key]] = matrix[:3, 3]
                    rotations[self.place[key]] = rot.from_matrix(axes)
        return positions, rotations

    def _nodes(self, names: tuple[str, ...], times: FloatArray | None) -> scenes.Nodes:
        frames, count = 1 if times is None else len(times), len(self.models)
        shifts, rotations, scales = (np.empty((frames, count, n)) for n in (3, 4, 3))
        for i, model in enumerate(self.models):
            shifts[:, i], rotations[:, i], scales[:, i] = local_transforms(model, times)
        return scenes.Nodes(names, np.array([m.parent for m in self.models]), shifts, rotations, scales)

    def _bind_matrices(self) -> list[tuple[int, FloatArray]]:
        """World matrices of models in the bind pose, of Pose nodes and of the clusters of skins."""
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
        return [(key, m.reshape(4, 4).T) for key, m in shaped if np.abs(m).max() < LARGEST]


def _named(node: Node | None, name: str) -> bool:
    return node is not None and node.name == name


def _is_object(node: Node) -> bool:
    return len(node.values) >= 3 and isinstance(node.values[0], int) and isinstance(node.values[1], str)


def _properties(node: Node | None) -> Properties:
    table = node.child("Properties70") if node else None
    rows = (row.values for row in table.children if row.name == "P" and len(row.values) > 4) if table else ()
    return {str(row[0]): row[4:] for row in rows}
