"""Layers of FBX animation, and the value of a property that several of them move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.formats.fbx.curves import Curve

ADDITIVE, OVERRIDE, BLENDED = 0, 1, 2
"""How a layer joins those below: added, in their place, or between the two by its weight (a layer's BlendMode)."""

_WHOLE = 0.99999  # weights from here on are 1


@dataclass(frozen=True, eq=False)
class Layer:
    """A layer.

    Parameters
    ----------
    name : str
    mode : int
        `ADDITIVE`, `OVERRIDE` or `BLENDED`.
    weight : float
        0 to 1.
    weights : Curve, optional
        The weight in percent over time.
    composes_rotations : bool
        Rotations are composed, in place of adding their angles.
    multiplies_scales : bool
    """

    name: str = ""
    mode: int = ADDITIVE
    weight: float = 1.0
    weights: Curve | None = None
    composes_rotations: bool = True
    multiplies_scales: bool = True


@dataclass(frozen=True, eq=False)
class Channel:
    """What a layer does to a property of three numbers.

    Parameters
    ----------
    layer : Layer
    curves : tuple of Curve or None
        One for each axis.
    defaults : tuple of float or None
        The values of the axes without curves; ``None`` leaves the model's own.
    base : bool
        Whether the layer is the lowest, whose values are taken as they are.
    """

    layer: Layer
    curves: tuple[Curve | None, Curve | None, Curve | None]
    defaults: tuple[float | None, float | None, float | None]
    base: bool


def animated(channels: Sequence[Channel], name: str, order: str, still: FloatArray, times: FloatArray) -> FloatArray:
    """A property over time.

    Parameters
    ----------
    channels : sequence of Channel
        From the lowest layer up.
    name : str
        ``"Lcl Rotation"``, ...
    order : str
        Of the model's Euler angles, the outermost first.
    still : ndarray, shape (3,)
        The property without animation; angles in degrees.
    times : ndarray, shape (F,)
        Seconds.

    Returns
    -------
    ndarray, shape (F, 3)
    """
    out = np.tile(still, (len(times), 1))
    for channel in channels:
        value = _values(channel, still, times)
        if channel.base or channel.layer.mode == OVERRIDE:
            out = value
            continue
        weight = _weight(channel.layer, times)
        if name == "Lcl Rotation" and channel.layer.composes_rotations:
            out = _composed(out, value, weight, channel.layer.mode, order)
        elif name == "Lcl Scaling" and channel.layer.multiplies_scales:
            lower = 1.0 if channel.layer.mode == ADDITIVE else 1.0 - weight[:, None]
            out = _power(out, lower) * _power(value, weight[:, None])
        elif channel.layer.mode == ADDITIVE:
            out = out + weight[:, None] * value
        else:
            out = out + weight[:, None] * (value - out)
    return out


def _values(channel: Channel, still: FloatArray, times: FloatArray) -> FloatArray:
    out = np.empty((len(times), 3))
    for axis, (curve, default) in enumerate(zip(channel.curves, channel.defaults, strict=True)):
        if curve is not None:
            out[:, axis] = curve.at(times)
        else:
            out[:, axis] = still[axis] if default is None else default
    return out


def _weight(layer: Layer, times: FloatArray) -> FloatArray:
    weight = np.full(len(times), layer.weight) if layer.weights is None else layer.weights.at(times) / 100.0
    return np.asarray(np.where(weight > _WHOLE, 1.0, np.maximum(weight, 0.0)))


def _composed(below: FloatArray, above: FloatArray, weight: FloatArray, mode: int, order: str) -> FloatArray:
    """Angles of a layer's rotations on those below, both in degrees, shape ``(F, 3)``."""
    axes = ["xyz".index(axis) for axis in order]
    first, second = (rot.from_euler(np.radians(angles)[:, axes], order) for angles in (below, above))
    if mode == ADDITIVE:
        rotation = rot.multiply(first, rot.slerp(np.tile(rot.identity(), (len(weight), 1)), second, weight))
    else:
        rotation = rot.slerp(first, second, weight)
    out = np.empty_like(below)
    out[:, axes] = np.degrees(rot.to_euler(rotation, order))
    return out


def _power(base: FloatArray, exponent: FloatArray | float) -> FloatArray:
    return np.asarray(np.where(exponent <= np.zeros(1), 1.0, np.sign(base) * np.abs(base) ** exponent))
