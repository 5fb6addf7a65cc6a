"""FBX files made from a description of a scene: in text or binary, of version 6 or 7, either order of bytes."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from kinetograph.formats.fbx.nodes import Node, make

TICKS = 46_186_158_000
CONSTANT, LINEAR, CUBIC = 0x2, 0x4, 0x8
NEXT, AUTO, TCB, USER = 0x100, 0x100, 0x200, 0x400
_AXES = "XYZ"
_ENUMS = ("RotationOrder", "InheritType", "TimeMode", "BlendMode", "RotationAccumulationMode", "ScaleAccumulationMode")
_SWITCHES = ("RotationActive", "Mute")
_KEYS = ("KeyTime", "KeyValueFloat", "KeyAttrFlags", "KeyAttrDataFloat", "KeyAttrRefCount")


class Letter(str):
    """A letter without quotation marks."""


@dataclass(frozen=True)
class Keys:
    """Keys of a curve: seconds, values, and for each key its flags and four numbers."""

    times: Sequence[float]
    values: Sequence[float]
    flags: Sequence[int] = ()
    data: Sequence[Sequence[float]] = ()
    after: str = "C"

    @property
    def rounded(self) -> list[float]:
        """The values as a file has them."""
        return [float(v) for v in np.array(self.values, dtype=np.float32)]

    def nodes(self) -> list[Node]:
        count = len(self.times)
        data = np.array(self.data or [[0.0] * 4] * count, dtype=np.float32)
        return [
            make("KeyTime", np.round(np.array(self.times) * TICKS).astype(np.int64)),
            make("KeyValueFloat", np.array(self.values, dtype=np.float32)),
            make("KeyAttrFlags", np.array(self.flags or [LINEAR] * count, dtype=np.int32)),
            make("KeyAttrDataFloat", data.reshape(-1)),
            make("KeyAttrRefCount", np.ones(count, dtype=np.int32)),
            make("Post-Extrapolation", children=[make("Type", Letter(self.after)), make("Repetition", -1)]),
        ]


@dataclass(frozen=True)
class Bone:
    """A model."""

    name: str
    parent: int = -1
    properties: Mapping[str, Any] = field(default_factory=dict)
    kind: str = "LimbNode"


@dataclass(frozen=True)
class Layer:
    """A layer: keys by bone, property and axis, and what the axes without keys are."""

    keys: Mapping[tuple[int, str, str], Keys]
    properties: Mapping[str, float] = field(default_factory=dict)
    still: Mapping[tuple[int, str, str], float] = field(default_factory=dict)
    weight: Keys | None = None


@dataclass(frozen=True)
class Stack:
    name: str
    layers: Sequence[Layer]


def weights(right: float, left: float) -> float:
    """The weights of two tangents, packed as in a file."""
    return float(np.array([round(right * 1e4) | round(left * 1e4) << 16], dtype=np.uint32).view(np.float32)[0])


def scene(bones: Sequence[Bone], stacks: Sequence[Stack] = (), settings: Mapping[str, Any] | None = None) -> list[Node]:
    """The nodes of a document."""
    objects, links, ids = [], [], iter(range(100, 10**9))

    def add(kind: str, name: str, under: str, *children: Node) -> int:
        key = next(ids)
        objects.append(make(kind, np.int64(key), name, under, children=children))
        return key

    def link(child: int, parent: int, to: str = "") -> None:
        links.append(make("C", "OP" if to else "OO", np.int64(child), np.int64(parent), *([to] if to else [])))

    keys: list[int] = []
    for bone in bones:
        keys.append(add("Model", f"{bone.name}\x00\x01Model", bone.kind, table(bone.properties)))
        link(keys[-1], keys[bone.parent] if bone.parent >= 0 else 0)
    for stack in stacks:
        top = add("AnimationStack", f"{stack.name}\x00\x01AnimStack", "")
        for number, layer in enumerate(stack.layers):
            under = add("AnimationLayer", f"L{number}\x00\x01AnimLayer", "", table(layer.properties))
            link(under, top)
            if layer.weight is not None:
                group = add("AnimationCurveNode", "Weight\x00\x01AnimCurveNode", "")
                link(group, under)
                link(group, under, "Weight")
                link(add("AnimationCurve", "\x00\x01AnimCurve", "", *layer.weight.nodes()), group, "d|Weight")
            for bone, name in dict.fromkeys((b, n) for b, n, _ in [*layer.keys, *layer.still]):
                still = {
                    f"d|{axis}": layer.still[bone, name, axis] for axis in _AXES if (bone, name, axis) in layer.still
                }
                group = add("AnimationCurveNode", f"{name}\x00\x01AnimCurveNode", "", table(still))
                link(group, under)
                link(group, keys[bone], name)
                for axis in _AXES:
                    if (bone, name, axis) in layer.keys:
                        curve = add("AnimationCurve", "\x00\x01AnimCurve", "", *layer.keys[bone, name, axis].nodes())
                        link(curve, group, f"d|{axis}")
    return [
        make("FBXHeaderExtension", children=[make("FBXHeaderVersion", 1003)]),
        make("GlobalSettings", children=[table(settings or {})]),
        make("Objects", children=objects),
        make("Connections", children=links),
    ]


def table(properties: Mapping[str, Any]) -> Node:
    """The table of properties of an object, with the types that Blender insists on."""
    rows = []
    for name, value in properties.items():
        if not np.isscalar(value):
            kind = (name, "") if name.startswith("Lcl ") else ("Vector3D", "Vector")
            rows.append(make("P", name, *kind, "A", *map(float, value)))
        elif isinstance(value, int):
            kind = ("enum", "") if name in _ENUMS else ("bool", "") if name in _SWITCHES else ("int", "Integer")
            rows.append(make("P", name, *kind, "", value))
        else:
            rows.append(make("P", name, "double", "Number", "", float(value)))
    return make("Properties70", children=rows)


# ---- as bytes ----


def text(nodes: Sequence[Node], version: int = 7400) -> bytes:
    """A file in text."""
    out = [f"; FBX {version // 1000}.{version // 100 % 10}.0 project file\n; made for a test\n"]
    for node in nodes:
        _write_text(node, out, "", version)
    return "\n".join(out).encode()


def _write_text(node: Node, out: list[str], indent: str, version: int) -> None:
    words = []
    for value in node.values:
        if isinstance(value, Letter):
            words.append(str(value))
        elif isinstance(value, str):
            name, separator, kind = value.partition("\x00\x01")
            shown = f"{kind}::{name}" if separator else value
            words.append('"' + shown.replace('"', "&quot;") + '"')
        elif isinstance(value, np.ndarray):
            if version >= 7000 and node.name == "KeyAttrDataFloat":
                value = value.view(np.int32)
            numbers = f"\n{indent}\t\t,".join(
                ",".join(repr(number) for number in value[i : i + 20].tolist()) for i in range(0, len(value), 20)
            )
            words.append(f"*{len(value)} {{\n{indent}\ta: {numbers}\n{indent}}}" if version >= 7000 else numbers)
        elif isinstance(value, bytes):
            words.append('""')
        else:
            words.append(repr(float(value)) if isinstance(value, float) else str(int(value)))
    line = f"{indent}{node.name}: " + ", ".join(words)
    if not node.children:
        out.append(line)
        return
    out.append(line + " {")
    out.append(f"{indent}\t; what is inside")
    for child in node.children:
        _write_text(child, out, indent + "\t", version)
    out.append(indent + "}")


def binary(nodes: Sequence[Node], version: int = 7400, order: str = "<") -> bytes:
    """A binary file."""
    out = bytearray(b"Kaydara FBX Binary  \x00\x1a" + bytes([order == ">"]) + struct.pack(order + "I", version))
    for node in nodes:
        _write_binary(node, out, version, order)
    return bytes(out + bytes(25 if version >= 7500 else 13) + bytes(200))


def _write_binary(node: Node, out: bytearray, version: int, order: str) -> None:
    head = struct.Struct(order + ("3QB" if version >= 7500 else "3IB"))
    values = [
        v for value in node.values for v in (value if isinstance(value, np.ndarray) and version < 7000 else [value])
    ]
    properties = b"".join(_value(value, order) for value in values)
    start, name = len(out), node.name.encode()
    out += bytes(head.size) + name + properties
    for child in node.children:
        _write_binary(child, out, version, order)
    if node.children:
        out += bytes(head.size)
    head.pack_into(out, start, len(out), len(values), len(properties), len(name))


def _value(value: Any, order: str) -> bytes:
    if isinstance(value, Letter):
        return b"C" + value.encode()
    if isinstance(value, str | bytes):
        raw = value.encode() if isinstance(value, str) else value
        return (b"S" if isinstance(value, str) else b"R") + struct.pack(order + "I", len(raw)) + raw
    if isinstance(value, np.ndarray):
        raw = value.astype(value.dtype.newbyteorder(order)).tobytes()
        kind = {"f4": b"f", "f8": b"d", "i8": b"l", "i4": b"i"}[value.dtype.str[1:]]
        return kind + struct.pack(order + "3I", len(value), 0, len(raw)) + raw
    if isinstance(value, float | np.floating):
        return b"D" + struct.pack(order + "d", value)
    if isinstance(value, np.int64) or abs(value) >= 2**31:
        return b"L" + struct.pack(order + "q", value)
    return b"I" + struct.pack(order + "i", value)


# ---- version 6 ----


def as_version_6(nodes: Sequence[Node]) -> list[Node]:
    """The same document with names for ids, and its animations as takes; only their lowest layers."""
    objects = next(node for node in nodes if node.name == "Objects").children
    links = [node.values for node in nodes if node.name == "Connections" for node in node.children]
    by_id = {int(node.values[0]): node for node in objects}
    names = {0: "Scene\x00\x01Model"} | {key: node.values[1] for key, node in by_id.items()}
    kinds = {key: node.name for key, node in by_id.items()} | {0: "Model"}
    above = {int(child): int(parent) for _, child, parent, *_ in links if kinds[int(parent)] == "Model"}
    parents: dict[tuple[int, str], list[int]] = {}
    for _, child, parent, *to in links:
        parents.setdefault((int(parent), to[0] if to else ""), []).append(int(child))
    settings = [_old(node) for node in nodes if node.name == "GlobalSettings"]
    models = [_old(Node(n.name, n.values[1:], n.children)) for n in objects if n.name == "Model"]
    takes = []
    for key, node in by_id.items():
        if node.name == "AnimationStack":
            layer = parents[key, ""][0]
            takes.append(_take(node, layer, by_id, parents, links, names))
    connections = [
        make("Connect", "OO", names[key], names[above[key]]) for key, node in by_id.items() if node.name == "Model"
    ]
    return [
        make("FBXHeaderExtension", children=[make("FBXVersion", 6100)]),
        make("Objects", children=[*models, *settings]),
        make("Connections", children=connections),
        make("Takes", children=[make("Current", ""), *takes]),
    ]


def _old(node: Node) -> Node:
    children = []
    for child in node.children:
        if child.name == "Properties70":
            rows = [make("Property", *row.values[:2], *row.values[3:]) for row in child.children]
            child = make("Properties60", children=rows)
        children.append(child)
    return Node(node.name, node.values, children)


def _take(
    stack: Node,
    layer: int,
    by_id: dict[int, Node],
    parents: dict[tuple[int, str], list[int]],
    links: list[list[Any]],
    names: dict[int, str],
) -> Node:
    parts: dict[int, list[Node]] = {}
    for group in parents.get((layer, ""), []):
        model, to = next((int(parent), to[0]) for _, child, parent, *to in links if child == group and to)
        axes = []
        for axis in _AXES:
            for curve in parents.get((group, f"d|{axis}"), []):
                axes.append(make("Channel", axis, children=_old_keys(by_id[curve])))
        letter = {"Lcl Translation": "T", "Lcl Rotation": "R", "Lcl Scaling": "S"}[to]
        parts.setdefault(model, []).append(make("Channel", letter, children=axes))
    models = [
        make("Model", names[model], children=[make("Channel", "Transform", children=channels)])
        for model, channels in parts.items()
    ]
    span = make("LocalTime", np.int64(0), np.int64(TICKS))
    return make("Take", stack.values[1].partition("\x00")[0], children=[span, *models])


def _old_keys(curve: Node) -> list[Node]:
    parts = {node.name[3:]: node.values[0] for node in curve.children if node.name in _KEYS}
    times, numbers = parts["Time"], parts["ValueFloat"]
    flags = np.repeat(parts["AttrFlags"], parts["AttrRefCount"])
    data = np.repeat(parts["AttrDataFloat"].reshape(-1, 4), parts["AttrRefCount"], axis=0)
    values: list[Any] = []
    for time, number, flag, row in zip(times, numbers, flags, data, strict=True):
        values += [np.int64(time), float(number)]
        if flag & CONSTANT:
            values += [Letter("C"), Letter("n" if flag & NEXT else "s")]
        elif flag & CUBIC and flag & USER:
            packed = int(row[2:3].view(np.uint32)[0])
            values += [Letter("U"), Letter("s"), float(row[0]), float(row[1])]
            weighted = flag & 0x3000000
            values += [Letter("a"), (packed & 0xFFFF) / 1e4, (packed >> 16) / 1e4] if weighted else [Letter("n")]
        else:
            values += [Letter("L")]
    return [make("Default", 0.0), make("KeyVer", 4005), make("KeyCount", len(times)), make("Key", *values)]
