"""The nodes of an FBX scene: their properties, curves and local transforms."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats.fbx.nodes import Node
from kinetograph.formats.fbx.times import TICKS

LARGEST = 1e12
"""Numbers beyond this are damage."""

_ORDERS = ("zyx", "yzx", "xzy", "zxy", "yxz", "xyz")  # of RotationOrder 0 to 5, the outermost rotation first

Properties = dict[str, list[Any]]
Curve = tuple[FloatArray, FloatArray]


@dataclass
class Model:
    """A node of the scene.

    Parameters
    ----------
    name : str
    kind : str
        ``"LimbNode"``, ``"Null"``, ...
    properties : dict of str to list
    parent : int
        Its parent among the models, -1 at the top.
    curves : dict of (str, int) to tuple of ndarray
        Times and values by what they move, ``"translation"``, ``"rotation"`` or ``"scale"``, and axis.
    """

    name: str
    kind: str
    properties: Properties
    parent: int
    curves: dict[tuple[str, int], Curve]

    def vector(self, key: str, default: float = 0.0) -> FloatArray:
        """A property of three numbers."""
        values = self.properties.get(key, [])[:3]
        good = len(values) == 3 and all(isinstance(v, int | float) and abs(v) < LARGEST for v in values)
        return np.array(values, dtype=np.float64) if good else np.full(3, default)

    def flag(self, key: str) -> int:
        """A property of one whole number, 0 where there is none."""
        values = self.properties.get(key, [0])
        return int(values[0]) if values and isinstance(values[0], int | float) and abs(values[0]) < LARGEST else 0


def parse_curve(path: Path, node: Node) -> Curve:
    """Times in seconds and values of an AnimationCurve. Raises FormatError."""
    keys, values = node.child("KeyTime"), node.child("KeyValueFloat")
    arrays = [part.values[0] for part in (keys, values) if part and part.values]
    if len(arrays) != 2 or not all(isinstance(a, np.ndarray) for a in arrays) or len(arrays[0]) != len(arrays[1]):
        raise FormatError(path, "expected an animation curve to have as many times as values")
    times, numbers = arrays[0].astype(np.float64) / TICKS, arrays[1].astype(np.float64)
    if len(times) == 0 or np.any(np.diff(times) <= 0) or np.abs(times).max() > 1e6:
        raise FormatError(path, "expected the times of an animation curve to increase")
    if not (np.isfinite(numbers).all() and np.abs(numbers).max() < LARGEST):
        raise FormatError(path, "expected finite numbers in an animation curve")
    return times, numbers


def local_transforms(model: Model, times: FloatArray | None) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The local transforms of a model.

    Parameters
    ----------
    model : Model
    times : ndarray, shape (F,), or None
        Seconds; ``None`` gives one frame with the pose without animation, its rotation zero.

    Returns
    -------
    translations : ndarray, shape (F, 3)
    rotations : ndarray, shape (F, 4)
    scales : ndarray, shape (F, 3)
    """
    shift = _animated(model, "translation", model.vector("Lcl Translation"), times)
    scale = _animated(model, "scale", model.vector("Lcl Scaling", 1.0), times)
    angles = _animated(model, "rotation", np.zeros(3) if times is None else model.vector("Lcl Rotation"), times)
    active = model.flag("RotationActive")
    order = _ORDERS[model.flag("RotationOrder") % 6] if active else "zyx"
    rotation = rot.from_euler(np.radians(angles)[:, ["xyz".index(axis) for axis in order]], order)
    if active:
        before, after = (_fixed(model.vector(key)) for key in ("PreRotation", "PostRotation"))
        rotation = rot.multiply(rot.multiply(before, rotation), rot.conjugate(after))
    pivot, scale_pivot = model.vector("RotationPivot"), model.vector("ScalingPivot")
    inside = -pivot + model.vector("ScalingOffset") + scale_pivot - scale * scale_pivot
    return shift + model.vector("RotationOffset") + pivot + rot.rotate(rotation, inside), rotation, scale


def _fixed(degrees: FloatArray) -> FloatArray:
    return rot.from_euler(np.radians(degrees)[::-1], "zyx")


def _animated(model: Model, what: str, still: FloatArray, times: FloatArray | None) -> FloatArray:
    out = np.tile(still, (1 if times is None else len(times), 1))
    for axis in range(3):
        if times is not None and (what, axis) in model.curves:
            keys, values = model.curves[what, axis]
            out[:, axis] = np.interp(times, keys, values)
    return out
