"""Units and axes of files: what they mean, how to guess them, and the way to metres, Y up, right-handed.

The units are guessed from the size of the body, the upward axis from its motion: rest poses say nothing about the
world, as in files whose rest pose stands along y while the recording stands along z.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import end_positions, joint_positions, role_positions
from kinetograph.motion import Motion

UNITS: dict[str, float] = {
    "metre": 1.0,
    "centimetre": 0.01,
    "millimetre": 0.001,
    "inch": 0.0254,
    "foot": 0.3048,
    "cmu": 0.0254 / 0.45,
}
"""Metres in one unit; ``cmu`` is that of Carnegie Mellon's skeletons, 1/0.45 inch."""

UPS: tuple[str, ...] = ("x", "y", "z")

_PLAUSIBLE = (1.2, 2.2)  # metres: how tall people stand
_TYPICAL = 1.65
# what a unit that few files use must gain in log height: legs alone in centimetres are no giant in inches
_RARITY = {"metre": 0.0, "centimetre": 0.0, "millimetre": 0.0, "inch": 0.3, "foot": 0.6, "cmu": 0.3}
_STEADY = 0.02  # of the body's size: how much the lowest point strays on a floor
_FLOOR_WEIGHT = 0.6  # chosen so that clips of getting up and of walking along an axis are both told safely
_MOST_BONES = 500  # no body has more; to look for roles in thousands takes minutes
_SAMPLES = 64  # frames looked at for a guess
_QUARTER_TURNS: dict[str, FloatArray] = {
    "x": rot.about("z", np.pi / 2),
    "y": rot.identity(),
    "z": rot.about("x", -np.pi / 2),
}


@dataclass(frozen=True, eq=False)
class Converted:
    """Motions in metres, Y up, and notes on what was guessed."""

    motions: tuple[Motion, ...]
    notes: tuple[str, ...]


def unit_factor(units: str) -> float:
    """Metres in one of ``units``. Raises RequestError for a name that is not in `UNITS`.

    >>> unit_factor("inch")
    0.0254
    """
    if units not in UNITS:
        raise RequestError(f"unknown units {units!r}; expected one of {', '.join(UNITS)}")
    return UNITS[units]


def check_up(up: str) -> str:
    """``up`` itself. Raises RequestError unless it is ``"x"``, ``"y"`` or ``"z"``."""
    if up not in UPS:
        raise RequestError(f"unknown upward axis {up!r}; expected one of {', '.join(UPS)}")
    return up


def to_metres_y_up(motions: Sequence[Motion], units: str | None, up: str | None) -> Converted:
    """Bring motions, in the units and axes of one file, to metres and Y up; ``None`` guesses.

    Motions of one file share their units and axes, so they are guessed from all of them together. Their skeletons
    get the roles that can be found.
    """
    notes = []
    if units is None:
        units, note = guess_units(motions)
        notes.append(note)
    motions = [_with_roles(scale_motion(motion, unit_factor(units))) for motion in motions]
    if up is None:
        up, note = guess_up(motions)
        notes.append(note)
    return Converted(tuple(from_up(motion, check_up(up)) for motion in motions), tuple(notes))


def guess_units(motions: Sequence[Motion]) -> tuple[str, str]:
    """The name of the units, of `UNITS`, in which the tallest character is most like a person, and a note.

    How tall a character would stand is how far apart any two of its joints get in the frames sampled, bar the
    farthest; arms spread wide reach as far as a body is tall, so that a guess between units 2 or more apart is safe.
    """
    height = max(_stature(motion) for motion in motions)
    if height <= 0.0 or not np.isfinite(height):
        return "metre", "units not given, and the skeleton has no size: taken as metres"
    units = min(UNITS, key=lambda name: abs(np.log(height * UNITS[name] / _TYPICAL)) + _RARITY[name])
    stands = height * UNITS[units]
    note = f"units not given: guessed {units}, as the skeleton would stand {stands:.2f} m tall"
    if not _PLAUSIBLE[0] <= stands <= _PLAUSIBLE[1]:
        note += "; unlikely for a person, so check it with --units"
    return units, note


def guess_up(motions: Sequence[Motion]) -> tuple[str, str]:
    """The axis that points up in the world, of motions in metres, and a note.

    Up is the axis along which heads are above feet, and along which the lowest point of the body stays where it is.
    One alone fails on people who begin lying on the floor, the other on those who walk along an axis.
    """
    evidence = [_uprightness(motion) - _FLOOR_WEIGHT * np.log(_floor_change(motion) + _STEADY) for motion in motions]
    scores = np.mean(evidence, axis=0)
    # a still skeleton without roles tells nothing; Y is then the likeliest
    best = int(np.argmax(scores + np.array([0.0, 1e-6, 0.0])))
    return UPS[best], f"up axis not given: guessed {UPS[best]}, from where heads, feet and the floor are"


def scale_motion(motion: Motion, factor: float) -> Motion:
    """The motion with every length multiplied by ``factor``."""
    if factor == 1.0:
        return motion
    skeleton = motion.skeleton
    scaled = replace(
        skeleton,
        offsets=skeleton.offsets * factor,
        end_offsets=skeleton.end_offsets * factor,
        roles={role: replace(mark, offset=mark.offset * factor) for role, mark in skeleton.roles.items()},
    )
    bones = None if motion.bones is None else motion.bones * factor
    return replace(motion, skeleton=scaled, translation=motion.translation * factor, bones=bones)


def from_up(motion: Motion, up: str) -> Motion:
    """A motion whose axis ``up`` points up, turned so that Y does; for z, ``(x, y, z)`` becomes ``(x, z, -y)``.

    Only the root turns: the joints' own frames, and with them the rest offsets, stay as they are.
    """
    return motion if up == "y" else _turn_root(motion, _QUARTER_TURNS[up])


def turn_points(points: FloatArray, up: str) -> FloatArray:
    """Points, shape ``(..., 3)``, of a world whose axis ``up`` points up, as they are where Y does.

    >>> turn_points(np.array([1.0, 2.0, 3.0]), "z").round(9).tolist()
    [1.0, 3.0, -2.0]
    """
    return points if up == "y" else rot.rotate(_QUARTER_TURNS[up], points)


def to_up(motion: Motion, up: str) -> Motion:
    """A motion with Y up turned so that the axis ``up`` points up: the inverse of `from_up`."""
    return motion if up == "y" else _turn_root(motion, rot.conjugate(_QUARTER_TURNS[up]))


def _turn_root(motion: Motion, turn: FloatArray) -> Motion:
    offsets = motion.skeleton.offsets.copy()
    offsets[0] = rot.rotate(turn, offsets[0])
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.multiply(turn, rotations[:, 0])
    translation = rot.rotate(turn, motion.translation)
    skeleton = replace(motion.skeleton, offsets=offsets)
    return replace(motion, skeleton=skeleton, translation=translation, rotations=rotations)


def _sampled(motion: Motion) -> Motion:
    """At most `_SAMPLES` frames, spread over the motion."""
    frames = np.unique(np.linspace(0, len(motion) - 1, _SAMPLES).astype(np.int64))
    bones = None if motion.bones is None else motion.bones[frames]
    return replace(motion, translation=motion.translation[frames], rotations=motion.rotations[frames], bones=bones)


def _with_roles(motion: Motion) -> Motion:
    from kinetograph.roles import with_found_roles

    if len(motion.skeleton) > _MOST_BONES:
        return motion
    return replace(motion, skeleton=with_found_roles(motion.skeleton))


def _stature(motion: Motion) -> float:
    """How far apart the joints of the body get in 19 of 20 frames sampled, in the motion's own units."""
    positions = _body_positions(_sampled(motion))
    # the farthest two of many points, without all pairs: along 13 directions their extent is within 4 % of it
    directions = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)])[14:]
    along = positions @ (directions / np.linalg.norm(directions, axis=1, keepdims=True)).T
    return float(np.percentile(np.ptp(along, axis=1).max(axis=1), 95))


def _uprightness(motion: Motion) -> FloatArray:
    """Mean over frames of the direction from the feet to the head, shape ``(3,)``, without its sign.

    Zero where the skeleton has no head or no feet.
    """
    roles = motion.skeleton.roles
    feet = [role for role in ("left_foot", "right_foot") if role in roles]
    heads = [role for role in ("head", "neck", "chest", "hips") if role in roles][:1]
    if not feet or not heads:
        return np.zeros(3)
    positions = role_positions(_sampled(motion), [*heads, *feet])
    body = positions[:, 0] - positions[:, 1:].mean(axis=1)
    length = np.linalg.norm(body, axis=-1, keepdims=True)
    return np.asarray(np.abs(np.mean(body / np.maximum(length, 1e-9), axis=0)))


def _floor_change(motion: Motion) -> FloatArray:
    """Spread over frames of the lowest point along each axis, shape ``(3,)``, in body sizes and at most 1."""
    positions = _body_positions(_sampled(motion))
    lowest = positions.min(axis=1)
    spread = np.percentile(lowest, 90, axis=0) - np.percentile(lowest, 10, axis=0)
    size = max(float(np.ptp(positions, axis=1).max()), 1e-9)
    return np.minimum(np.asarray(spread) / size, 1.0)


def _body_positions(motion: Motion) -> FloatArray:
    """Positions, shape ``(F, J + E, 3)``, of joints and end sites."""
    return np.concatenate([joint_positions(motion), end_positions(motion)], axis=1)
