"""Frames of axes and centres of joints from points; what depends on a point that is not there is NaN."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray

_ROUNDS = 12


def length(v: FloatArray) -> FloatArray:
    """Lengths, ``(...)``, of vectors ``(..., 3)``."""
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", v, v)))


def unit(v: FloatArray) -> FloatArray:
    """Vectors ``(..., 3)`` of length one; NaN where there is no direction."""
    size = length(v)[..., None]
    return np.asarray(v / np.where(size > 1e-9, size, np.nan))


def middle(a: FloatArray, b: FloatArray) -> FloatArray:
    """The points half-way, ``(..., 3)``."""
    return np.asarray(0.5 * (a + b))


def axes(**given: FloatArray) -> FloatArray:
    """Right-handed axes as columns, ``(F, 3, 3)``: the first one given is kept, the second one made square to it.

    >>> axes(y=np.array([[0.0, 2, 0]]), x=np.array([[3.0, 1, 0]]))[0].tolist() == np.eye(3).tolist()
    True
    """
    (first, along), (second, near) = given.items()
    i, j = "xyz".index(first), "xyz".index(second)
    k = 3 - i - j
    out = np.empty((*along.shape[:-1], 3, 3))
    out[..., i] = unit(along)
    third = unit(np.cross(out[..., i], near))
    out[..., k] = third if (j - i) % 3 == 1 else -third
    out[..., j] = np.cross(out[..., k], out[..., i]) if (i - k) % 3 == 1 else np.cross(out[..., i], out[..., k])
    return out


def chord(above: FloatArray, marker: FloatArray, beside: FloatArray, away: float) -> FloatArray:
    """The centre of a joint, ``(F, 3)``, by the chord function of Davis et al. (1991).

    It is ``away`` metres from the marker on the joint, at a right angle to the way from it to the joint ``above``, in
    the plane of those two and ``beside``, a marker between the two joints; on the far side of the line from ``above``
    to the marker than ``beside`` or, where ``away`` is negative, on the near one.
    """
    line = marker - above
    reach = length(line)[..., None]
    along = line / np.where(reach > 1e-9, reach, np.nan)
    aside = unit(beside - above - np.sum((beside - above) * along, axis=-1, keepdims=True) * along)
    sine = np.clip(abs(away) / reach, 0.0, 1.0)
    # a right angle at the centre: the centre lies on the circle over the line, `away` from the marker
    centre = marker - along * (abs(away) * sine) - np.sign(away) * aside * (abs(away) * np.sqrt(1 - sine * sine))
    return np.asarray(centre)


def hinge(above: FloatArray, marker: FloatArray, below: FloatArray, away: float, bent: float) -> FloatArray:
    """The unit normals, ``(F, 3)``, of a limb's plane: of ``above``, the hinge's centre and ``below``, as they turn.

    The centre is ``away`` metres from the marker along the normal. NaN where the limb bends by less than ``bent``
    radians.
    """
    normal = np.zeros_like(marker)
    for _ in range(_ROUNDS):
        centre = marker + away * normal
        upper, lower = centre - above, below - centre
        normal = unit(np.cross(upper, lower))
    sine = length(np.cross(upper, lower)) / np.maximum(length(upper) * length(lower), 1e-12)
    flexed = (sine > np.sin(bent)) | (np.sum(upper * lower, axis=-1) < 0)
    return np.where(flexed[..., None], normal, np.nan)
