"""The animations of an FBX document, which it calls stacks: which one is read, and what it does to the models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kinetograph.formats.animations import choose, labels
from kinetograph.formats.fbx.curves import Curve, parse_curve
from kinetograph.formats.fbx.layers import ADDITIVE, OVERRIDE, Channel, Layer
from kinetograph.formats.fbx.models import Model
from kinetograph.formats.fbx.objects import Objects, number

MOVED = ("Lcl Translation", "Lcl Rotation", "Lcl Scaling")
"""The properties of a model that animation moves."""

_AXES = ("d|X", "d|Y", "d|Z")


@dataclass(frozen=True)
class Stack:
    """An animation.

    Parameters
    ----------
    name : str
    start : float
        Seconds; infinite where the file does not say.
    layers : tuple of int
        Ids, from the lowest up.
    groups : dict of int to list of int
        The ids of the curve nodes of each layer that set properties of models.
    curves : int
        How many curves they have.
    """

    name: str
    start: float
    layers: tuple[int, ...]
    groups: dict[int, list[int]]
    curves: int

    @property
    def moves(self) -> bool:
        """Whether it moves any model."""
        return self.curves > 0


def find_stacks(objects: Objects, models: Mapping[int, int], ticks: int) -> list[Stack]:
    """The animations of a document.

    Parameters
    ----------
    objects : Objects
    models : mapping of int to int
        Ids of the models.
    ticks : int
        Units of time in a second.

    Returns
    -------
    list of Stack
        Without stacks, or where they have no layers that move anything, one of all that is animated.
    """
    groups: dict[int, list[int]] = {}
    curves: dict[int, int] = {}
    for key in objects.all("AnimationCurveNode"):
        targets = objects.above.get(key, ())
        if any(target in models and to in MOVED for target, to in targets):
            for layer in {target for target, to in targets if objects.is_a(target, "AnimationLayer")} or {0}:
                groups.setdefault(layer, []).append(key)
                curves[layer] = curves.get(layer, 0) + sum(1 for _ in objects.under(key, "AnimationCurve"))
    stacks = []
    for key in objects.all("AnimationStack"):
        layers = tuple(dict.fromkeys(child for child, _ in objects.under(key, "AnimationLayer")))
        start = (objects.properties(key).get("LocalStart") or [None])[0]
        seconds = start / ticks if isinstance(start, int) and abs(start / ticks) < 1e6 else np.inf
        own = {layer: groups.get(layer, []) for layer in layers}
        stacks.append(Stack(objects.name(key), seconds, layers, own, sum(curves.get(layer, 0) for layer in layers)))
    if sum(curves.values()) and not any(stack.moves for stack in stacks):
        name, start = (stacks[0].name, stacks[0].start) if stacks else ("", np.inf)
        return [Stack(name, start, tuple(groups), groups, sum(curves.values()))]
    return stacks


def choose_stack(
    path: Path, stacks: Sequence[Stack], wanted: str | None, notes: list[str]
) -> tuple[int, tuple[str, ...]]:
    """Which of several animations is read, and the names of those that move anything.

    Parameters
    ----------
    path : Path
    stacks : sequence of Stack
        At least one.
    wanted : str or None
        Its name, or its number from 1.
    notes : list of str

    Returns
    -------
    number : int
    names : tuple of str
    """
    names = labels([stack.name for stack in stacks])
    moving = [i for i, stack in enumerate(stacks) if stack.moves]
    if wanted in names:  # one that moves nothing may be asked for by its name
        return names.index(wanted or ""), tuple(names[i] for i in moving)
    known = tuple(names[i] for i in moving or range(len(stacks)))
    index = choose(path, known, wanted, notes)
    return (moving or range(len(stacks)))[index], known


def attach(path: Path, objects: Objects, stack: Stack, models: Mapping[int, Model], ticks: int) -> list[str]:
    """Give models the channels of an animation; notes on what is not read exactly.

    Parameters
    ----------
    path : Path
    objects : Objects
    stack : Stack
    models : mapping of int to Model
        By their ids.
    ticks : int

    Returns
    -------
    list of str
    """
    notes: list[str] = []
    for position, key in enumerate(stack.layers):
        values = objects.properties(key)
        if number(values, "Mute", 0):
            notes.append(f"animation layer {objects.name(key)!r} is muted: left out")
            continue
        layer = _layer(path, objects, key, ticks)
        if (
            position
            and layer.mode == OVERRIDE
            and (layer.weight < 1 or layer.weights is not None)
            and stack.groups[key]
        ):
            notes.append(f"animation layer {layer.name!r} overrides those below in part: read as if in whole")
        for group in stack.groups[key]:
            curves = _curves(path, objects, group, ticks)
            given = objects.properties(group)
            first, second, third = (number(given, axis, 0.0) if axis in given else None for axis in _AXES)
            channel = Channel(layer, curves, (first, second, third), position == 0)
            for target, to in objects.above.get(group, ()):
                if target in models and to in MOVED:
                    models[target].channels.setdefault(to, []).append(channel)
    return notes


def _layer(path: Path, objects: Objects, key: int, ticks: int) -> Layer:
    if key not in objects.nodes:
        return Layer()
    values = objects.properties(key)
    weights = None
    for group, to in objects.under(key, "AnimationCurveNode"):
        if to == "Weight":
            found = [curve for curve, _ in objects.under(group, "AnimationCurve")]
            weights = parse_curve(path, objects.nodes[found[0]], ticks) if found else None
    return Layer(
        objects.name(key),
        int(number(values, "BlendMode", ADDITIVE)),
        number(values, "Weight", 100.0) / 100.0,
        weights,
        number(values, "RotationAccumulationMode", 0) == 0,
        number(values, "ScaleAccumulationMode", 0) == 0,
    )


def _curves(path: Path, objects: Objects, group: int, ticks: int) -> tuple[Curve | None, Curve | None, Curve | None]:
    curves: dict[str, Curve | None] = {}
    for key, axis in objects.under(group, "AnimationCurve"):
        if axis in _AXES:
            curves[axis] = parse_curve(path, objects.nodes[key], ticks)
    return curves.get("d|X"), curves.get("d|Y"), curves.get("d|Z")
