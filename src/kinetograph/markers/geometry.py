"""Axes of segments and centres of joints from points; what depends on a missing point is NaN."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray

_ROUNDS = 12


def length(v: FloatArray) -> FloatArray:
    """Lengths ``(...)`` of vectors ``(..., 3)``."""
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", v, v)))


def unit(v: FloatArray) -> FloatArray:
    """Vectors ``(..., 3)`` of length one; NaN where there is no direction."""
    size = length(v)[..., None]
    return np.asarray(v / np.where(size > 1e-9, size, np.nan))


def middle(a: FloatArray, b: FloatArray) -> FloatArray:
    """The points half-way between points, ``(..., 3)``."""
    return np.asarray(0.5 * (a + b))


def axes(**given: FloatArray) -> FloatArray:
    """Right-handed axes from two of them.

    Parameters
    ----------
    **given : ndarray, shape (F, 3)
        Two of ``x``, ``y`` and ``z``, of any length: the direction of the first is kept, the second is made
        perpendicular to it.

    Returns
    -------
    ndarray, shape (F, 3, 3)
        Unit axes as columns.

    Examples
    --------
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


def chord(above: FloatArray, marker: FloatArray, between: FloatArray, away: float) -> FloatArray:
    """The centre of a joint by the chord function.

    The lines from the centre to the marker and to the joint above are at a right angle, in the plane of those two and
    of ``between``.

    Parameters
    ----------
    above : ndarray, shape (F, 3)
        The centre of the joint above, metres.
    marker : ndarray, shape (F, 3)
        The marker on the joint.
    between : ndarray, shape (F, 3)
        A marker between the two joints.
    away : float
        Metres from the marker to the centre. The centre is on the other side of the line from ``above`` to the marker
        than ``between`` or, where this is negative, on the same side.

    Returns
    -------
    ndarray, shape (F, 3)

    References
    ----------
    Davis, Ounpuu, Tyburski, Gage: A gait analysis data collection and reduction technique. Human Movement Science 10,
    1991.
    """
    line = marker - above
    reach = length(line)[..., None]
    along = line / np.where(reach > 1e-9, reach, np.nan)
    aside = unit(between - above - np.sum((between - above) * along, axis=-1, keepdims=True) * along)
    sine = np.clip(abs(away) / reach, 0.0, 1.0)
    # a right angle at the centre: the centre lies on the circle over the line, `away` from the marker
    centre = marker - along * (abs(away) * sine) - np.sign(away) * aside * (abs(away) * np.sqrt(1 - sine * sine))
    return np.asarray(centre)


def hinge(above: FloatArray, marker: FloatArray, below: FloatArray, away: float, bent: float) -> FloatArray:
    """The unit normals of a limb's plane, through the joint above, the hinge's centre and the joint below.

    Parameters
    ----------
    above, below : ndarray, shape (F, 3)
        Centres of the joints above and below, metres.
    marker : ndarray, shape (F, 3)
        The marker on the hinge.
    away : float
        Metres from the marker to the hinge's centre, along the normal.
    bent : float
        Radians; the normals of limbs that bend by less are NaN.

    Returns
    -------
    ndarray, shape (F, 3)
    """
    normal = np.zeros_like(marker)
    for _ in range(_ROUNDS):
        centre = marker + away * normal
        upper, lower = centre - above, below - centre
        normal = unit(np.cross(upper, lower))
    sine = length(np.cross(upper, lower)) / np.maximum(length(upper) * length(lower), 1e-12)
    flexed = (sine > np.sin(bent)) | (np.sum(upper * lower, axis=-1) < 0)
    return np.where(flexed[..., None], normal, np.nan)
