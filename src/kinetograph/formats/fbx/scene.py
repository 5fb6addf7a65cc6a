"""The models of an FBX document, its settings, and the pose that its joints are bound in."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats import scene as scenes
from kinetograph.formats.fbx.curves import LARGEST, Curve
from kinetograph.formats.fbx.document import Document
from kinetograph.formats.fbx.models import Model, local_transforms
from kinetograph.formats.fbx.objects import Objects, Properties, number, properties
from kinetograph.formats.fbx.stacks import attach, choose_stack, find_stacks
from kinetograph.formats.names import unique

_LIMBS = ("LimbNode", "Limb", "Root", "Effector")
_MOST_MODELS = 20_000
_SETTINGS = 1e6  # numbers of the settings beyond this are damage


class Scene:
    """The models of a document, parents first, its settings, and one of its animations.

    Parameters
    ----------
    path : Path
        For errors.
    document : Document
        FormatError is raised where models do not form a tree or curves are damaged.
    animation : str, optional
        The name of the animation; the first unless given. RequestError is raised where there is none of that name.
    """

    def __init__(self, path: Path, document: Document, animation: str | None = None) -> None:
        self.path = path
        self.notes: list[str] = []
        self.settings = properties(document.root.child("GlobalSettings"))
        self.objects = Objects(document.root)
        template = _template(document)
        models = self.objects.all("Model")
        if len(models) > _MOST_MODELS:
            raise FormatError(path, f"more than {_MOST_MODELS} models; is this file damaged?")
        parents = _parents(self.objects, models)
        order = scenes.depth_first(parents)
        if order is None:
            raise FormatError(path, "models form a ring; they must form a tree")
        self.place = {models[i]: position for position, i in enumerate(order)}
        above = [self.place[models[parents[i]]] if parents[i] >= 0 else -1 for i in order]
        self.models = [self._model(models[i], parent, template) for i, parent in zip(order, above, strict=True)]
        self.animation = ""
        self.animations: tuple[str, ...] = ()
        self.start = np.inf
        self._animate(document.ticks, animation)

    def _model(self, key: int, parent: int, template: Properties) -> Model:
        kind = str(self.objects.nodes[key].values[2])
        return Model(self.objects.name(key), kind, template | self.objects.properties(key), parent, {})

    def _animate(self, ticks: int, wanted: str | None) -> None:
        """Give the models the curves of an animation."""
        stacks = find_stacks(self.objects, self.place, ticks)
        if stacks or wanted is not None:
            chosen, self.animations = choose_stack(self.path, stacks, wanted, self.notes)
            by_id = {key: self.models[place] for key, place in self.place.items()}
            self.animation, self.start = stacks[chosen].name, stacks[chosen].start
            self.notes += attach(self.path, self.objects, stacks[chosen], by_id, ticks)
        if not any(model.moves for model in self.models):
            self.notes.append("the file has no animation of a node: read its pose")

    def setting(self, key: str, default: float) -> float:
        """A number of the global settings."""
        value = number(self.settings, key, default)
        return value if abs(value) < _SETTINGS else default

    def curves(self) -> list[Curve]:
        """The curves that move models."""
        channels = (channel for model in self.models for part in model.channels.values() for channel in part)
        return [curve for channel in channels for curve in channel.curves if curve is not None]

    def nodes(self, times: FloatArray) -> scenes.Nodes:
        """The models with their local transforms at some times, ``(F,)`` seconds."""
        names = unique([model.name or "node" for model in self.models], "joint", self.notes)
        return self._nodes(tuple(names), times)

    def bind(self, names: tuple[str, ...]) -> tuple[FloatArray, FloatArray]:
        """World positions ``(N, 3)`` and rotations ``(N, 4)`` in the bind pose, or else with local rotations zero."""
        positions, rotations = (part[0] for part in scenes.world(self._nodes(names, None, zero=True)))
        for key, matrix in self._bind_matrices():
            if key in self.place:
                axes = matrix[:3, :3] / np.maximum(np.linalg.norm(matrix[:3, :3], axis=0), 1e-12)
                if abs(np.linalg.det(axes) - 1) < 1e-2:
                    positions[self.place[key]] = matrix[:3, 3]
                    rotations[self.place[key]] = rot.from_matrix(axes)
        return positions, rotations

    def rest(self, names: tuple[str, ...]) -> scenes.Rest:
        """The pose without animation."""
        positions, rotations = (part[0] for part in scenes.world(self._nodes(names, None)))
        return scenes.Rest(positions, rotations, shared=len(self.animations) > 1)

    def _nodes(self, names: tuple[str, ...], times: FloatArray | None, zero: bool = False) -> scenes.Nodes:
        frames, count = 1 if times is None else len(times), len(self.models)
        shifts, rotations, scales = (np.empty((frames, count, n)) for n in (3, 4, 3))
        for i, model in enumerate(self.models):
            shifts[:, i], rotations[:, i], scales[:, i] = local_transforms(model, times, zero)
            if not max(np.abs(shifts[:, i]).max(), np.abs(scales[:, i]).max()) < LARGEST:
                raise FormatError(self.path, f"{model.name!r} is moved or scaled beyond any measure")
        if np.all(scales == scales[:1]):
            scales = scales[:1].copy()
        inherits = np.array([model.inherits for model in self.models], dtype=np.int64)
        return scenes.Nodes(
            names, np.array([m.parent for m in self.models], dtype=np.int64), shifts, rotations, scales, inherits
        )

    def joints(self) -> list[int]:
        """The models that are joints: limbs, and what skins are bound to, or else all that move."""
        bound = {model for key in self.objects.all("Deformer") for model, _ in self.objects.under(key, "Model")}
        places = {self.place[model] for model in bound}
        places |= {place for place, model in enumerate(self.models) if model.kind in _LIMBS}
        return sorted(places) or [place for place, model in enumerate(self.models) if model.moves]

    def _bind_matrices(self) -> list[tuple[int, FloatArray]]:
        """World matrices of models in the bind pose, of Pose nodes and of the clusters of skins."""
        out = []
        for key, node in self.objects.nodes.items():
            if node.name == "Pose" and node.values[2] == "BindPose":
                for pose in node.all("PoseNode"):
                    model = pose.child("Node")
                    if model and model.values and isinstance(model.values[0], int):
                        out.append((model.values[0], pose.numbers("Matrix")))
            elif node.name == "Deformer" and (link := node.numbers("TransformLink")) is not None:
                out.extend((child, link) for child, _ in self.objects.below.get(key, ()))
        shaped = [(key, m.astype(np.float64)) for key, m in out if m is not None and m.shape == (16,)]
        return [(key, m.reshape(4, 4).T) for key, m in shaped if np.abs(m).max() < LARGEST]


def _parents(objects: Objects, models: list[int]) -> list[int]:
    place = {key: i for i, key in enumerate(models)}
    parents = [-1] * len(models)
    for key, i in place.items():
        for parent, _ in objects.above.get(key, ()):
            if parent in place:
                parents[i] = place[parent]
    return parents


def _template(document: Document) -> Properties:
    """The properties that models have unless they give their own."""
    definitions = document.root.child("Definitions")
    kinds = definitions.all("ObjectType") if definitions else iter(())
    model = next((kind for kind in kinds if kind.text() == "Model"), None)
    return properties(model.child("PropertyTemplate")) if model else {}
