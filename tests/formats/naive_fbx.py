"""What an FBX scene means, one frame and one matrix at a time, written from the documents of the format."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from fbx_files import CONSTANT, CUBIC, NEXT, TCB, USER, Bone, Keys, Layer

ORDERS = ("xyz", "xzy", "yzx", "yxz", "zxy", "zyx", "xyz")  # the first named turns the vector first
WEIGHTED = 0x3000000


def turn(axis: str, degrees: float) -> np.ndarray:
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    out = np.eye(4)
    out[i, i], out[i, j], out[j, i], out[j, j] = c, -s, s, c
    return out


def euler(degrees: Sequence[float], order: str = "xyz") -> np.ndarray:
    out = np.eye(4)
    for axis in order:
        out = turn(axis, degrees["xyz".index(axis)]) @ out
    return out


def shift(by: Sequence[float]) -> np.ndarray:
    out = np.eye(4)
    out[:3, 3] = by
    return out


def local(bone: Bone, layers: Sequence[Layer], index: int, time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The whole local matrix, its rotation, and its scale."""
    get = bone.properties.get
    place, angles, scale = (
        combined(layers, index, f"Lcl {name}", get(f"Lcl {name}", default), time)
        for name, default in (("Translation", (0, 0, 0)), ("Rotation", (0, 0, 0)), ("Scaling", (1, 1, 1)))
    )
    active = get("RotationActive", 0)
    rotation = euler(angles, ORDERS[get("RotationOrder", 0)] if active else "xyz")
    if active:
        rotation = (
            euler(get("PreRotation", (0, 0, 0))) @ rotation @ np.linalg.inv(euler(get("PostRotation", (0, 0, 0))))
        )
    pivot, scaling_pivot = np.array(get("RotationPivot", (0, 0, 0))), np.array(get("ScalingPivot", (0, 0, 0)))
    before = shift(place) @ shift(get("RotationOffset", (0, 0, 0))) @ shift(pivot) @ rotation @ shift(-pivot)
    after = shift(get("ScalingOffset", (0, 0, 0))) @ shift(scaling_pivot) @ np.diag([*scale, 1]) @ shift(-scaling_pivot)
    return before @ after, rotation, np.diag([*scale, 1.0])


def world(bones: Sequence[Bone], layers: Sequence[Layer], time: float) -> np.ndarray:
    """Matrices of the bones in the world, shape ``(N, 4, 4)``."""
    whole, turned, scales = [], [], []
    for index, bone in enumerate(bones):
        matrix, rotation, scale = local(bone, layers, index, time)
        if bone.parent >= 0:
            above, round_, size = (part[bone.parent] for part in (whole, turned, scales))
            mode = bone.properties.get("InheritType", 1)
            place = above @ matrix[:, 3]
            if mode == 1:
                matrix = above @ matrix
            elif mode == 2:
                matrix = above @ np.linalg.inv(size) @ rotation @ scale
            else:
                stretch = np.eye(4)
                stretch[:3, :3] = np.linalg.inv(round_[:3, :3]) @ above[:3, :3]
                matrix = round_ @ rotation @ stretch @ scale
            matrix = np.column_stack([matrix[:, :3], place])
            rotation = round_ @ rotation
        whole.append(matrix)
        turned.append(rotation)
        scales.append(scale)
    return np.array(whole)


# ---- curves ----


def value(keys: Keys, time: float) -> float:
    """A curve at a time; automatic tangents are taken as half the mean slope and half the neighbouring slopes'."""
    times, values = keys.times, keys.rounded
    if time <= times[0]:
        return values[0]
    if time >= times[-1]:
        return values[-1]
    i = max(k for k in range(len(times)) if times[k] <= time)
    flags = keys.flags[i] if keys.flags else 0
    span, u = times[i + 1] - times[i], (time - times[i]) / (times[i + 1] - times[i])
    if flags & CONSTANT:
        return values[i + 1] if flags & NEXT and u > 0 else values[i]
    if not flags & CUBIC:
        return (1 - u) * values[i] + u * values[i + 1]
    first = second = 1 / 3
    if flags & WEIGHTED == WEIGHTED:
        packed = int(np.array([keys.data[i][2]], dtype=np.float32).view(np.uint32)[0])
        first, second = (packed & 0xFFFF) / 1e4, (packed >> 16) / 1e4
    leave = slopes(keys, i)[1]
    arrive = slopes(keys, i + 1)[0] if keys.flags[i + 1] & CUBIC and not keys.flags[i + 1] & USER else keys.data[i][1]
    low, high = 0.0, 1.0
    for _ in range(60):
        v = (low + high) / 2
        x = 3 * v * (1 - v) ** 2 * first + 3 * v * v * (1 - v) * (1 - second) + v**3
        low, high = (v, high) if x < u else (low, v)
    points = values[i], values[i] + first * span * leave, values[i + 1] - second * span * arrive, values[i + 1]
    return sum(math.comb(3, k) * v**k * (1 - v) ** (3 - k) * points[k] for k in range(4))


def slopes(keys: Keys, i: int) -> tuple[float, float]:
    """Slopes of a key's tangents on the left and on the right."""
    times, values, flags = keys.times, keys.rounded, keys.flags[i]
    if flags & USER:
        return (keys.data[i - 1][1] if i else 0.0), keys.data[i][0]
    chord = [(values[k + 1] - values[k]) / (times[k + 1] - times[k]) for k in range(len(times) - 1)]
    before, after = (chord[i - 1] if i else None), (chord[i] if i < len(chord) else None)
    if flags & TCB:
        tension, continuity, bias = keys.data[i][:3]
        half = 1.0 if before is None or after is None else 0.5
        b, a = before or 0.0, after or 0.0
        left = half * (1 - tension) * ((1 + bias) * (1 - continuity) * b + (1 - bias) * (1 + continuity) * a)
        right = half * (1 - tension) * ((1 + bias) * (1 + continuity) * b + (1 - bias) * (1 - continuity) * a)
        return left, right
    if before is None or after is None:
        end = after if before is None else before
        return end or 0.0, end or 0.0
    share = (times[i] - times[i - 1]) / (times[i + 1] - times[i - 1])
    mean = (values[i + 1] - values[i - 1]) / (times[i + 1] - times[i - 1])
    slope = 0.5 * mean + 0.5 * ((1 - share) * before + share * after)
    return slope, slope


# ---- layers ----


def combined(layers: Sequence[Layer], bone: int, name: str, still: Sequence[float], time: float) -> list[float]:
    """A property under layers whose rotations and scales are added axis by axis, or composed where they say so."""
    out = [float(v) for v in still]
    for number, layer in enumerate(layers):
        if not any(b == bone and n == name for b, n, _ in [*layer.keys, *layer.still]):
            continue
        own = [
            value(layer.keys[bone, name, axis], time)
            if (bone, name, axis) in layer.keys
            else layer.still.get((bone, name, axis), still["XYZ".index(axis)])
            for axis in "XYZ"
        ]
        mode = layer.properties.get("BlendMode", 0)
        weight = layer.properties.get("Weight", 100.0) / 100
        if layer.weight is not None:
            weight = value(layer.weight, time) / 100
        if number == 0 or mode == 1:
            out = own
        elif name == "Lcl Scaling" and not layer.properties.get("ScaleAccumulationMode", 0):
            out = [a ** (1 if mode == 0 else 1 - weight) * b**weight for a, b in zip(out, own, strict=True)]
        elif mode == 0:
            out = [a + weight * b for a, b in zip(out, own, strict=True)]
        else:
            out = [a + weight * (b - a) for a, b in zip(out, own, strict=True)]
    return out
