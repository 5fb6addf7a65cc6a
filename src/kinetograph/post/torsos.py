"""Torsos as capsules, and how deep two of them overlap: bodies of partners who must not walk into one another.

A torso is three capsules: from hip to hip, between the middles of hips and shoulders, and from shoulder to shoulder.
Their radii are shares of the breadth of the shoulders, such that people who dance closely touch and hardly more: in
seven recorded dances two torsos never overlap by more than 6 cm, a shoulder pressed into a chest.

A body that is in its partner's is moved along the ground, and as slowly as it can be: the move begins before it is
needed and ends after.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.filters import running_max, smoothed
from kinetograph.kinematics import on_ground, role_positions
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton

CORNERS = ("left_hip", "right_hip", "left_shoulder", "right_shoulder")
"""The roles that a torso lies between."""
RADII = (0.3, 0.3, 0.22)
"""Radii of pelvis, spine and shoulders, as shares of the breadth of the shoulders."""
PASSES = 8
"""How often a body is moved at most: a move away from one instant may lead into another."""
UPRIGHT = 0.5
"""Least share of a push that lies along the ground; a torso that lies on another is pushed by less than it takes."""


@dataclass(frozen=True)
class TorsoSettings:
    """How a body is kept out of its partner's.

    Parameters
    ----------
    deepest : float
        Metres that torsos may overlap.
    calm : float
        Seconds before and after over which a body makes room.

    Raises
    ------
    RequestError
        Unless ``calm`` is positive and ``deepest`` a number.
    """

    deepest: float = 0.04
    calm: float = 0.5

    def __post_init__(self) -> None:
        if not (np.isfinite(self.deepest) and np.isfinite(self.calm) and self.calm > 0):
            raise RequestError(f"deepest must be a number and calm above 0, found {self.deepest} and {self.calm}")


@dataclass(frozen=True, eq=False)
class Torso:
    """The capsules of a torso over time.

    Parameters
    ----------
    starts, stops : ndarray, shape (F, 3, 3)
        The centres of each capsule's two balls, metres.
    radii : ndarray, shape (3,)
        Metres.
    """

    starts: FloatArray
    stops: FloatArray
    radii: FloatArray

    @property
    def middle(self) -> FloatArray:
        """The middle of its corners on the ground, shape ``(F, 3)``."""
        return on_ground(0.25 * (self.starts + self.stops)[:, ::2].sum(axis=1))

    def moved(self, shift: FloatArray) -> Torso:
        """The torso moved by ``shift``, shape ``(F, 3)`` metres."""
        return replace(self, starts=self.starts + shift[:, None], stops=self.stops + shift[:, None])


def has_torso(skeleton: Skeleton) -> bool:
    """Whether a skeleton has the roles that a torso lies between."""
    return skeleton.roles.keys() >= set(CORNERS)


def torso_of(motion: Motion) -> Torso:
    """The torso of a motion whose skeleton has one; see `has_torso`."""
    corners = np.moveaxis(role_positions(motion, CORNERS), 1, 0)
    hips, shoulders = corners[:2], corners[2:]
    starts = np.stack([hips[0], hips.mean(axis=0), shoulders[0]], axis=1)
    stops = np.stack([hips[1], shoulders.mean(axis=0), shoulders[1]], axis=1)
    breadth = float(np.median(np.linalg.norm(shoulders[0] - shoulders[1], axis=1)))
    return Torso(starts, stops, breadth * np.array(RADII))


def overlaps(own: Torso, other: Torso) -> FloatArray:
    """How deep two torsos are in one another.

    Parameters
    ----------
    own, other : Torso
        Over the same F frames.

    Returns
    -------
    ndarray, shape (F,)
        Metres between their surfaces, negated: of the pair of capsules that are deepest in one another, and less than 0
        where they are apart.

    Examples
    --------
    >>> def ball(x): return Torso(np.full((1, 3, 3), [x, 0, 0.0]), np.full((1, 3, 3), [x, 0, 0.0]), np.full(3, 0.1))
    >>> overlaps(ball(0.0), ball(0.15)).round(3).tolist()
    [0.05]
    """
    return np.asarray((-_gaps(own, other)[0]).max(axis=1))


def _gaps(own: Torso, other: Torso) -> tuple[FloatArray, FloatArray]:
    """For all nine pairs of capsules: gaps between their surfaces ``(F, 9)``, and unit vectors ``(F, 9, 3)`` across."""
    mine, theirs = (own.starts[:, :, None], own.stops[:, :, None]), (other.starts[:, None], other.stops[:, None])
    across = nearest_between(*mine, *theirs)
    apart = np.linalg.norm(across, axis=-1)
    gaps = apart - (own.radii[:, None] + other.radii)
    unit = across / np.maximum(apart, 1e-9)[..., None]
    return gaps.reshape(len(gaps), -1), unit.reshape(len(gaps), -1, 3)


def nearest_between(start: FloatArray, stop: FloatArray, other_start: FloatArray, other_stop: FloatArray) -> FloatArray:
    """The shortest vectors from other line segments to some.

    Parameters
    ----------
    start, stop : ndarray, shape (..., 3)
        Ends of the segments that the vectors lead to.
    other_start, other_stop : ndarray, shape (..., 3)
        Ends of the segments that they begin at.

    Returns
    -------
    ndarray, shape (..., 3)
    """
    first, second, between = stop - start, other_stop - other_start, start - other_start
    a, b, e = (np.sum(u * v, axis=-1) for u, v in ((first, first), (first, second), (second, second)))
    c, f = np.sum(first * between, axis=-1), np.sum(second * between, axis=-1)
    tiny = 1e-12
    s = np.clip((b * f - c * e) / np.maximum(a * e - b * b, tiny), 0.0, 1.0)
    t = np.clip((b * s + f) / np.maximum(e, tiny), 0.0, 1.0)
    s = np.clip((b * t - c) / np.maximum(a, tiny), 0.0, 1.0)
    return np.asarray(between + s[..., None] * first - t[..., None] * second)


def keep_apart(motion: Motion, partner: Motion, settings: TorsoSettings | None = None) -> Motion:
    """A motion moved along the ground so that its torso is not in its partner's.

    Parameters
    ----------
    motion : Motion
    partner : Motion
        Of the same frames. It stays where it is.
    settings : TorsoSettings, optional

    Returns
    -------
    Motion
        The same where there is room, and where a skeleton has no torso. Feet slide with the body: clean them
        afterwards.
    """
    settings = settings or TorsoSettings()
    if not (has_torso(motion.skeleton) and has_torso(partner.skeleton)):
        return motion
    own, other, shift = torso_of(motion), torso_of(partner), np.zeros((len(motion), 3))
    window = max(round(settings.calm * motion.fps), 1)
    for _ in range(PASSES):
        moved = own.moved(shift)
        push = _push(moved, other, settings.deepest)
        if not push.any():
            break
        shift += _spread(push, _side(moved.middle - other.middle, window), window)
    return replace(motion, translation=motion.translation + shift) if shift.any() else motion


def _push(own: Torso, other: Torso, deepest: float) -> FloatArray:
    """The moves ``(F, 3)`` along the ground that take a torso out of another, but for ``deepest`` metres."""
    gaps, across = _gaps(own, other)
    frames, worst = np.arange(len(gaps)), gaps.argmin(axis=1)
    needed = np.maximum(-gaps[frames, worst] - deepest, 0.0)
    level = across[frames, worst] * [1.0, 0.0, 1.0]
    size = np.linalg.norm(level, axis=1)
    along = level / np.maximum(size, 1e-9)[:, None]
    return np.asarray(along * (needed / np.maximum(size, UPRIGHT))[:, None])


def _side(apart: FloatArray, window: int) -> FloatArray:
    """Unit vectors ``(F, 3)`` on the ground, square to how a body passes its partner, to the side that it passes on.

    ``apart``, ``(F, 3)``, is where it is from its partner.
    """
    padded = np.pad(apart, ((window, window), (0, 0)), mode="edge")
    travel = padded[2 * window :] - padded[: -2 * window]
    square = np.cross([0.0, 1.0, 0.0], travel)
    square /= np.maximum(np.linalg.norm(square, axis=1), 1e-9)[:, None]
    passing = smoothed(np.sum(apart * square, axis=1), 0.5 * window)
    return np.asarray(square * np.where(passing < -1e-9, -1.0, 1.0)[:, None])


def _spread(push: FloatArray, side: FloatArray, window: int) -> FloatArray:
    """Pushes ``(F, 3)`` begun and ended smoothly, ``window`` frames before and after.

    Pushes back and then on, where a body goes straight through its partner, would cancel: they go to the ``side``.
    """
    size = np.linalg.norm(push, axis=1)
    weights = np.hanning(2 * window + 3)[1:-1]
    wide = np.pad(running_max(size, 2 * window + 1), window, mode="edge")
    envelope = np.convolve(wide, weights / weights.sum(), mode="valid")
    along, near = (smoothed(each, 0.5 * window, axis=0) for each in (push, size[:, None]))
    cancelled = near[:, 0] - np.linalg.norm(along, axis=1)
    along += smoothed(cancelled[:, None] * side, 0.25 * window, axis=0)
    return np.asarray(along * (envelope / np.maximum(np.linalg.norm(along, axis=1), 1e-12))[:, None])
