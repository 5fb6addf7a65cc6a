"""Units and axes of files: what they mean, how they are guessed, and how they are converted to metres, Y up.

The units are guessed from the size of the body, the upward axis from its motion: a rest pose says nothing about the
world, as there are files whose rest pose stands along y while the recording stands along z.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.formats.bodies import BODIES, Keep, OwnRoot, choose_bodies, with_own_root
from kinetograph.formats.names import unique
from kinetograph.kinematics import end_positions, joint_positions, role_positions
from kinetograph.motion import Motion, transform
from kinetograph.roles import is_body
from kinetograph.skeleton import Ancestor, Skeleton

UNITS: dict[str, float] = {
    "metre": 1.0,
    "centimetre": 0.01,
    "millimetre": 0.001,
    "inch": 0.0254,
    "foot": 0.3048,
    "cmu": 0.0254 / 0.45,
}
"""Metres in one unit; ``cmu`` is the unit of Carnegie Mellon's skeletons, 1/0.45 inch."""

UPS: tuple[str, ...] = ("x", "y", "z")
"""The axes that may point up."""

_PLAUSIBLE = (1.2, 2.2)  # metres: how tall people stand
_TYPICAL = 1.65
# in log height, against units that few files use: legs alone in centimetres are not a giant in inches
_RARITY = {"metre": 0.0, "centimetre": 0.0, "millimetre": 0.0, "inch": 0.3, "foot": 0.6, "cmu": 0.3}
_STEADY = 0.02  # of the body's size: how much the lowest point varies on a floor
_FLOOR_WEIGHT = 0.6  # chosen so that clips of getting up and of walking along an axis are both recognised
_UPSIDE_DOWN = -0.5  # how far feet are above heads, in the mean, of the length between them
_SAMPLES = 64  # frames looked at for a guess
_TO_Y_UP: dict[str, FloatArray] = {
    "x": rot.about("z", np.pi / 2),
    "y": rot.identity(),
    "z": rot.about("x", -np.pi / 2),
}


@dataclass(frozen=True, eq=False)
class Converted:
    """The motions of a file, converted.

    Parameters
    ----------
    motions : tuple of Motion
        In metres, Y up.
    notes : tuple of str
        What was left out and guessed.
    indices : tuple of int
        Which of the file's motions these are.
    roots : tuple of OwnRoot or None
        What was taken of each, in the file's units and axes; None for all of it.
    meaning : tuple of str
        The units and the upward axis.
    """

    motions: tuple[Motion, ...]
    notes: tuple[str, ...]
    indices: tuple[int, ...]
    roots: tuple[OwnRoot | None, ...]
    meaning: tuple[str, str]

    def like(self, motion: Motion) -> Motion:
        """More frames of the first motion, as the file has them, converted in the same way."""
        motion = motion if self.roots[0] is None else with_own_root(motion, self.roots[0])
        return from_up(scale_motion(motion, unit_factor(self.meaning[0])), self.meaning[1])

    def tracks(self, names: Sequence[str], notes: list[str]) -> dict[str, Motion]:
        """The motions by track: ``motion`` for one, else the names of those chosen of a file's motions, made unique."""
        chosen = ["motion"] if len(self.motions) == 1 else unique([names[i] for i in self.indices], "track", notes)
        return dict(zip(chosen, self.motions, strict=True))


def unit_factor(units: str) -> float:
    """Metres in one of ``units``.

    Parameters
    ----------
    units : str
        A name in `UNITS`.

    Returns
    -------
    float

    Raises
    ------
    RequestError
        The name is unknown.

    Examples
    --------
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


def to_metres_y_up(motions: Sequence[Motion], units: str | None, up: str | None, keep: Keep = BODIES) -> Converted:
    """Choose the bodies of one file, convert their motions to metres, Y up, and find the roles of their skeletons.

    Parameters
    ----------
    motions : sequence of Motion
        All motions of a file, which share its units and axes.
    units : str or None
        A name in `UNITS`; ``None`` guesses from all motions together.
    up : {"x", "y", "z"} or None
        The upward axis; ``None`` guesses.
    keep : Keep
        What is kept besides the bodies.

    Returns
    -------
    Converted

    Raises
    ------
    RequestError
        The units or the axis are unknown.
    """
    bodies = choose_bodies(motions, keep)
    notes, guessed = list(bodies.notes), []
    if units is None:
        units, note = guess_units(bodies.motions)
        guessed.append(note)
    converted = [scale_motion(motion, unit_factor(units)) for motion in bodies.motions]
    if up is None:
        up, note = guess_up(converted)
        guessed.append(note)
    if guessed:
        notes.append("; ".join(guessed))
    upright = tuple(from_up(motion, check_up(up)) for motion in converted)
    return Converted(upright, tuple(notes), bodies.indices, bodies.roots, (units, up))


def guess_units(motions: Sequence[Motion]) -> tuple[str, str]:
    """The units in which the tallest character is most like a person, and a note.

    Parameters
    ----------
    motions : sequence of Motion
        All motions of a file.

    Returns
    -------
    units : str
        A name in `UNITS`.
    note : str
        What was guessed, and why.

    Notes
    -----
    A body's height is that of its skeleton. Without roles that show it, it is the largest distance between two joints
    in the frames sampled, without the largest outliers: arms spread wide reach as far as a body is tall, so that units
    that differ by a factor of 2 or more are not confused.
    """
    bodies = [motion for motion in motions if is_body(motion.skeleton)]
    height = max((motion.skeleton.height for motion in bodies if _whole(motion.skeleton)), default=0.0)
    height = height or max(_stature(motion) for motion in bodies or motions)
    if height <= 0.0 or not np.isfinite(height):
        return "metre", "units not given, and the skeleton has no size: taken as metres"
    units = min(UNITS, key=lambda name: abs(np.log(height * UNITS[name] / _TYPICAL)) + _RARITY[name])
    stands = height * UNITS[units]
    note = f"units not given: guessed {units}, as the skeleton would stand {stands:.2f} m tall"
    if not _PLAUSIBLE[0] <= stands <= _PLAUSIBLE[1]:
        note += "; unlikely for a person, so check it with --units"
    return units, note


def guess_up(motions: Sequence[Motion]) -> tuple[str, str]:
    """The axis that points up in the world, and a note.

    Parameters
    ----------
    motions : sequence of Motion
        All motions of a file, in metres.

    Returns
    -------
    up : {"x", "y", "z"}
    note : str
        What was guessed, and why.

    Notes
    -----
    Up is the axis along which heads are above feet, and along which the lowest point of the body does not change. The
    first alone fails on people who begin lying on the floor, the second on those who walk along an axis.
    """
    evidence = [_uprightness(motion) - _FLOOR_WEIGHT * np.log(_floor_change(motion) + _STEADY) for motion in motions]
    scores = np.mean(evidence, axis=0)
    # a still skeleton without roles gives no evidence; Y is then the likeliest
    best = int(np.argmax(scores + np.array([0.0, 1e-6, 0.0])))
    return UPS[best], f"up axis not given: guessed {UPS[best]}, from where heads, feet and the floor are"


def righted(motion: Motion) -> tuple[Motion, list[str]]:
    """A motion in a world with Y up, rotated by half a circle about x where the body is upside down, and a note.

    Poses that come from video are often in the axes of a camera, whose y points down.

    Parameters
    ----------
    motion : Motion

    Returns
    -------
    motion : Motion
    notes : list of str
    """
    if _upward(motion)[1] > _UPSIDE_DOWN:
        return motion, []
    note = "the body is upside down in most frames, as in a camera's axes: rotated by half a circle about x"
    return transform(motion, rot.about("x", np.pi), np.zeros(3)), [note]


def scale_motion(motion: Motion, factor: float) -> Motion:
    """The motion with every length multiplied by ``factor``."""
    if factor == 1.0:
        return motion
    skeleton = motion.skeleton
    scaled = replace(
        skeleton,
        offsets=skeleton.offsets * factor,
        end_offsets=skeleton.end_offsets * factor,
        roles={role: replace(point, offset=point.offset * factor) for role, point in skeleton.roles.items()},
        ancestors=tuple(replace(node, translation=node.translation * factor) for node in skeleton.ancestors),
    )
    bones = None if motion.bones is None else motion.bones * factor
    return replace(motion, skeleton=scaled, translation=motion.translation * factor, bones=bones)


def from_up(motion: Motion, up: str) -> Motion:
    """A motion of a world whose axis ``up`` points up, in a world where Y does.

    Only the root is rotated: the joints' own frames, and with them the rest offsets, stay as they are.

    Parameters
    ----------
    motion : Motion
    up : {"x", "y", "z"}
        For z, ``(x, y, z)`` becomes ``(x, z, -y)``.

    Returns
    -------
    Motion
    """
    return motion if up == "y" else rotate_world(motion, _TO_Y_UP[up])


def points_from_up(points: FloatArray, up: str) -> FloatArray:
    """Points of a world whose axis ``up`` points up, in a world where Y does.

    Parameters
    ----------
    points : ndarray, shape (..., 3)
    up : {"x", "y", "z"}

    Returns
    -------
    ndarray, shape (..., 3)

    Examples
    --------
    >>> points_from_up(np.array([1.0, 2.0, 3.0]), "z").round(9).tolist()
    [1.0, 3.0, -2.0]
    """
    return points if up == "y" else rot.rotate(_TO_Y_UP[up], points)


def to_up(motion: Motion, up: str) -> Motion:
    """A motion with Y up in a world whose axis ``up`` points up: the inverse of `from_up`."""
    return motion if up == "y" else rotate_world(motion, rot.conjugate(_TO_Y_UP[up]))


def _rotated(ancestors: tuple[Ancestor, ...], rotation: FloatArray) -> tuple[Ancestor, ...]:
    """Nodes above a root whose outermost is rotated in the world, and with it the others."""
    if not ancestors:
        return ()
    top = ancestors[0]
    at = Ancestor(top.name, rot.rotate(rotation, top.translation), rot.multiply(rotation, top.rotation))
    return (at, *ancestors[1:])


def rotate_world(motion: Motion, rotation: FloatArray) -> Motion:
    """A motion in a world rotated about its origin by a unit quaternion, shape ``(4,)``."""
    offsets = motion.skeleton.offsets.copy()
    offsets[0] = rot.rotate(rotation, offsets[0])
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.multiply(rotation, rotations[:, 0])
    translation = rot.rotate(rotation, motion.translation)
    skeleton = replace(motion.skeleton, offsets=offsets, ancestors=_rotated(motion.skeleton.ancestors, rotation))
    return replace(motion, skeleton=skeleton, translation=translation, rotations=rotations)


def _sampled(motion: Motion) -> Motion:
    """At most ``_SAMPLES`` frames, spread over the motion."""
    frames = np.unique(np.linspace(0, len(motion) - 1, _SAMPLES).astype(np.int64))
    bones = None if motion.bones is None else motion.bones[frames]
    return replace(motion, translation=motion.translation[frames], rotations=motion.rotations[frames], bones=bones)


def _whole(skeleton: Skeleton) -> bool:
    """Whether roles show how tall a skeleton is."""
    found = skeleton.roles.keys()
    return {"hips", "left_foot", "right_foot"} <= found and bool({"neck", "head"} & found)


def _stature(motion: Motion) -> float:
    """The largest distance between joints in 19 of 20 frames sampled, in the motion's own units."""
    positions = _body_positions(_sampled(motion))
    # the largest distance between many points, without all pairs: their extent along 13 directions is within 4 % of it
    directions = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)])[14:]
    along = positions @ (directions / np.linalg.norm(directions, axis=1, keepdims=True)).T
    return float(np.percentile(np.ptp(along, axis=1).max(axis=1), 95))


def _uprightness(motion: Motion) -> FloatArray:
    """The direction from the feet to the head, shape ``(3,)``, without its sign."""
    return np.abs(_upward(motion))


def _upward(motion: Motion) -> FloatArray:
    """Mean over frames of the direction from the feet to the head, shape ``(3,)``.

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
    return np.asarray(np.mean(body / np.maximum(length, 1e-9), axis=0))


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
