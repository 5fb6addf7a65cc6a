"""The nodes of an FBX scene: their properties and local transforms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.formats.fbx.curves import LARGEST
from kinetograph.formats.fbx.layers import Channel, animated
from kinetograph.formats.fbx.objects import Properties
from kinetograph.formats.inheritance import COMPONENTWISE, FULL, UNSCALED

_ORDERS = ("zyx", "yzx", "xzy", "zxy", "yxz", "xyz", "zyx")  # of RotationOrder 0 to 6, the outermost rotation first


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
    channels : dict of str to list of Channel
        What moves it, from the lowest layer up, by the property that it moves, ``"Lcl Rotation"``, ...
    """

    name: str
    kind: str
    properties: Properties
    parent: int
    channels: dict[str, list[Channel]]

    def vector(self, key: str, default: float = 0.0) -> FloatArray:
        """A property of three numbers."""
        values = self.properties.get(key, [])[:3]
        good = len(values) == 3 and all(isinstance(v, int | float) and abs(v) < LARGEST for v in values)
        return np.array(values, dtype=np.float64) if good else np.full(3, default)

    def flag(self, key: str, default: int = 0) -> int:
        """A property of one whole number."""
        values = self.properties.get(key, [default])
        good = values and isinstance(values[0], int | float) and abs(values[0]) < LARGEST
        return int(values[0]) if good else default

    @property
    def moves(self) -> bool:
        """Whether a curve moves it."""
        return any(curve is not None for part in self.channels.values() for channel in part for curve in channel.curves)

    @property
    def inherits(self) -> int:
        """How it inherits its parent's scale."""
        mode = self.flag("InheritType", FULL)
        return mode if mode in (COMPONENTWISE, UNSCALED) else FULL

    @property
    def order(self) -> str:
        """The order of its Euler angles, the outermost rotation first."""
        order = self.flag("RotationOrder")
        return _ORDERS[order] if self.free and 0 <= order < len(_ORDERS) else _ORDERS[0]

    @property
    def free(self) -> bool:
        """Whether its order and its rotations before and after count."""
        return bool(self.flag("RotationActive")) and not self.flag("RotationSpaceForLimitOnly")


def local_transforms(
    model: Model, times: FloatArray | None, zero: bool = False
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The local transforms of a model.

    Parameters
    ----------
    model : Model
    times : ndarray, shape (F,), or None
        Seconds; ``None`` gives one frame with the pose without animation.
    zero : bool
        Whether the angles of that pose are zero.

    Returns
    -------
    translations : ndarray, shape (F, 3)
    rotations : ndarray, shape (F, 4)
    scales : ndarray, shape (F, 3)
    """
    order = model.order
    shift, angles, scale = (_property(model, key, order, times) for key in ("Translation", "Rotation", "Scaling"))
    if zero:
        angles = np.zeros_like(angles)
    rotation = rot.from_euler(np.radians(angles)[:, ["xyz".index(axis) for axis in order]], order)
    if model.free:
        before, after = (_fixed(model.vector(key)) for key in ("PreRotation", "PostRotation"))
        rotation = rot.multiply(rot.multiply(before, rotation), rot.conjugate(after))
    pivot, scale_pivot = model.vector("RotationPivot"), model.vector("ScalingPivot")
    inside = -pivot + model.vector("ScalingOffset") + scale_pivot - scale * scale_pivot
    return shift + model.vector("RotationOffset") + pivot + rot.rotate(rotation, inside), rotation, scale


def _property(model: Model, key: str, order: str, times: FloatArray | None) -> FloatArray:
    name = f"Lcl {key}"
    still = model.vector(name, 1.0 if key == "Scaling" else 0.0)
    if times is None:
        return still[None]
    return animated(model.channels.get(name, []), name, order, still, times)


def _fixed(degrees: FloatArray) -> FloatArray:
    return rot.from_euler(np.radians(degrees)[::-1], "zyx")
