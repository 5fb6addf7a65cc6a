"""FBX 6, whose objects have names in place of ids and whose takes hold keys, translated to the objects of FBX 7."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from kinetograph.errors import FormatError
from kinetograph.formats.fbx.curves import (
    CONSTANT,
    CONSTANT_NEXT,
    CUBIC,
    EXACT_WEIGHTS,
    LINEAR,
    PROGRESSIVE,
    TCB,
    TIME_INDEPENDENT,
    USER,
    WEIGHTED_LEFT,
    WEIGHTED_RIGHT,
)
from kinetograph.formats.fbx.nodes import Node, Value, make

_PARTS = {"T": "Lcl Translation", "R": "Lcl Rotation", "S": "Lcl Scaling"}
_SMOOTH = CUBIC | TIME_INDEPENDENT | PROGRESSIVE
# the letter of a cubic key, the numbers that follow it, and the flags that they mean
_TANGENTS = {
    "s": (2, CUBIC | USER),
    "b": (2, CUBIC | USER),
    "a": (0, _SMOOTH),
    "d": (1, _SMOOTH),
    "p": (2, _SMOOTH),
    "q": (2, _SMOOTH),
    "t": (3, CUBIC | TCB),
}
_WEIGHTS = {"n": "", "c": "", "a": "rl", "l": "l", "r": "r"}  # the letter of weights, and those that follow it
_LATER = 4005  # of KeyVer


def modernise(path: Path, root: Node) -> Node:
    """The document with objects, connections and animation as in FBX 7. Raises FormatError."""
    translation = _Translation(path)
    out = Node("")
    for node in root.children:
        if node.name == "Objects":
            settings = [_with_properties(child) for child in node.children if child.name == "GlobalSettings"]
            out.children += settings or [_settings_of_version_5(root)]
            translation.add_objects(node)
        elif node.name == "Connections":
            translation.connect(node)
        elif node.name == "Takes":
            for take in node.all("Take"):
                translation.add_take(take)
        else:
            out.children.append(node)
    out.children.append(make("Objects", children=translation.objects))
    out.children.append(make("Connections", children=translation.links))
    return out


class _Translation:
    """Objects and connections under construction."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.ids: dict[str, int] = {"Model::Scene": 0, "Scene\x00\x01Model": 0}
        self.objects: list[Node] = []
        self.links: list[Node] = []
        self.fresh = itertools.count(1)

    def id(self, name: str) -> int:
        """The id of an object that has a name and a kind."""
        if name not in self.ids:
            self.ids[name] = next(self.fresh)
        return self.ids[name]

    def object(self, node: str, name: str, kind: str, *children: Node) -> int:
        """Add an object of the animation and return its id."""
        key = next(self.fresh)
        self.objects.append(make(node, key, name, kind, children=children))
        return key

    def link(self, child: int, parent: int, key: str = "") -> None:
        """Connect an object to another, or to one of its properties."""
        self.links.append(make("C", "OP" if key else "OO", child, parent, *([key] if key else [])))

    def add_objects(self, objects: Node) -> None:
        """Add the objects of the document."""
        for node in objects.children:
            if node.text() and self.id(node.text()) > 0:
                children = [self._child(child) for child in _with_properties(node).children]
                kind = node.values[1] if len(node.values) > 1 and isinstance(node.values[1], str) else ""
                self.objects.append(make(node.name, self.id(node.text()), node.text(), kind, children=children))

    def _child(self, child: Node) -> Node:
        """A child of an object, the names of models in a bind pose made ids."""
        if child.name != "PoseNode":
            return child
        name = child.child("Node")
        if name is None or not name.text():
            return child
        parts = [part for part in child.children if part is not name]
        return make("PoseNode", children=[*parts, make("Node", self.id(name.text()))])

    def connect(self, connections: Node) -> None:
        """Add the connections of the document."""
        for node in connections.children:
            row = node.values
            if node.name in ("Connect", "C") and len(row) >= 3 and isinstance(row[1], str) and isinstance(row[2], str):
                self.link(self.id(row[1]), self.id(row[2]), str(row[3]) if len(row) > 3 else "")

    def add_take(self, take: Node) -> None:
        """Add a take as a stack with one layer."""
        rows = []
        for name, key in (("LocalTime", "Local"), ("ReferenceTime", "Reference")):
            span = take.numbers(name)
            if span is not None and len(span) == 2 and span.dtype.kind == "i":
                rows += [
                    make("P", f"{key}{end}", "KTime", "Time", "", int(ticks))
                    for end, ticks in zip(("Start", "Stop"), span, strict=True)
                ]
        stack = self.object("AnimationStack", take.text(), "", make("Properties70", children=rows))
        layer = self.object("AnimationLayer", "BaseLayer", "")
        self.link(layer, stack)
        for model in take.all("Model"):
            for channel in model.all("Channel"):
                if model.text() and channel.text() == "Transform":
                    self.add_channels(channel, self.id(model.text()), layer)

    def add_channels(self, transform: Node, model: int, layer: int) -> None:
        """Add what moves a model."""
        for channel in transform.all("Channel"):
            key = _PARTS.get(channel.text())
            if key is None:
                continue
            axes = {axis: c for c in channel.all("Channel") if (axis := c.text()) in ("X", "Y", "Z")}
            defaults = [
                make("P", f"d|{axis}", "Number", "", "A", float(numbers[0]))
                for axis, child in axes.items()
                if (numbers := child.numbers("Default")) is not None and len(numbers)
            ]
            group = self.object("AnimationCurveNode", key, "", make("Properties70", children=defaults))
            self.link(group, layer)
            self.link(group, model, key)
            for axis, child in axes.items():
                parts = _curve_parts(self.path, child)
                if parts:
                    self.link(self.object("AnimationCurve", "", "", *parts), group, f"d|{axis}")


def _with_properties(node: Node) -> Node:
    """A node with its table of properties in the form of version 7."""
    children = []
    for child in node.children:
        if child.name == "Properties60":
            rows = [row.values for row in child.children if row.name == "Property" and len(row.values) >= 3]
            child = make("Properties70", children=[make("P", row[0], row[1], "", *row[2:]) for row in rows])
        children.append(child)
    return Node(node.name, node.values, children)


def _settings_of_version_5(root: Node) -> Node:
    """Global settings from those that older files have at their end."""
    old = root.child("Version5")
    settings = old.child("Settings") if old else None
    rate = settings.child("FrameRate") if settings else None
    try:
        fps = float(rate.values[0]) if rate and rate.values else 0.0
    except (ValueError, TypeError):
        fps = 0.0
    rows = [make("P", "TimeMode", "enum", "", "", 14), make("P", "CustomFrameRate", "double", "", "", fps)]
    return make("GlobalSettings", children=[make("Properties70", children=rows if 0 < fps < 1e6 else [])])


def _curve_parts(path: Path, channel: Node) -> list[Node]:
    """The arrays of a curve from the keys of a channel; none without keys. Raises FormatError."""
    values = channel.child("Key")
    if values is None or not values.values:
        return []
    version = channel.numbers("KeyVer")
    later = version is None or version[0] >= _LATER
    listed = values.values[0].tolist() if isinstance(values.values[0], np.ndarray) else values.values
    count = channel.numbers("KeyCount")
    keys = list(_keys(path, iter(listed), later))
    if count is not None and len(keys) != count[0]:
        raise FormatError(path, f"expected {count[0]} keys of a curve, found {len(keys)}")
    data = np.array([(*numbers, 0.0) for *_, numbers, _ in keys])
    parts = [
        make("KeyTime", np.array([time for time, *_ in keys], dtype=np.int64)),
        make("KeyValueFloat", np.array([value for _, value, *_ in keys], dtype=np.float64)),
        make("KeyAttrFlags", np.array([flags for _, _, flags, *_ in keys], dtype=np.int64)),
        make("KeyAttrDataFloat", data.reshape(-1)),
        make("KeyAttrRefCount", np.ones(len(keys), dtype=np.int64)),
        make(EXACT_WEIGHTS, np.array([weights for *_, weights in keys]).reshape(-1)),
    ]
    return parts + [node for node in channel.children if node.name.endswith("-Extrapolation")]


Key = tuple[int, float, int, tuple[float, float, float], tuple[float, float]]


def _keys(path: Path, values: Iterator[Value], later: bool) -> Iterator[Key]:
    """Time, value, flags, three numbers and weights of each key."""
    try:
        for time in values:
            if not isinstance(time, int | float) or not abs(time) < 2**63:
                raise ValueError
            value, letter = float(next(values)), next(values)
            flags, numbers, weights = LINEAR, (0.0, 0.0, 0.0), (0.0, 0.0)
            if letter == "C":
                flags = CONSTANT | (CONSTANT_NEXT if next(values) == "n" else 0)
            elif letter == "U":
                flags, numbers, weights = _tangents(values, later)
            elif letter != "L":
                raise ValueError
            yield int(time), value, flags, numbers, weights
    except (ValueError, TypeError, OverflowError, KeyError, StopIteration):
        raise FormatError(path, "a curve's keys are damaged") from None


def _tangents(values: Iterator[Value], later: bool) -> tuple[int, tuple[float, float, float], tuple[float, float]]:
    """Flags, three numbers and weights of a cubic key. Raises KeyError or ValueError."""
    letter = next(values)
    count, flags = _TANGENTS[letter]
    numbers = [float(next(values)) for _ in range(count)] + [0.0] * (3 - count)
    weights = {"r": 0.0, "l": 0.0}
    groups = {"t": 0, "a": int(later), "p": 1 + later, "q": 1 + later}.get(letter, 1)
    for _ in range(groups):
        for side in _WEIGHTS[next(values)]:
            flags |= WEIGHTED_RIGHT if side == "r" else WEIGHTED_LEFT
            weights[side] = float(next(values))
    three: Any = tuple(numbers) if flags & (USER | TCB) else (0.0, 0.0, 0.0)
    return flags, three, (weights["r"], weights["l"])
