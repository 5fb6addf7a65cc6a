"""Making consecutive pieces meet.

Both blends share the gap at a seam between its two sides: the earlier piece is moved half of the way forward, the
later one half of the way back, and the correction fades away from the seam. They differ in how it fades:

- *linear* is the thesis' postprocess (chapter 5): along the whole piece, so that positions match.
- *inertialised* (the default) also removes the jump in velocity: a quintic that starts with half of the gap in
  position and velocity and reaches rest, with no acceleration at either end, after ``duration`` seconds.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.motion import Motion, concatenate, sample, transform

BLENDS = ("inertialised", "linear", "none")


@dataclass(frozen=True, eq=False)
class Clip:
    """A placed stretch of recording on the result's time line.

    motion: the source at its own rate; rotation, a quaternion ``(4,)``, and shift ``(3,)`` place it. start, stop:
    seconds in the result. source_start: the source's second at ``start``. stretch: result seconds per source second.
    The source goes on beyond both borders where it can.
    """

    motion: Motion
    rotation: FloatArray
    shift: FloatArray
    start: float
    stop: float
    source_start: float
    stretch: float

    def at(self, times: FloatArray, fps: float) -> Motion:
        """The placed source at ``times``, shape ``(T,)`` seconds in the result."""
        source = self.source_start + (times - self.start) / self.stretch
        return transform(sample(self.motion, source, fps), self.rotation, self.shift)


@dataclass(frozen=True, eq=False)
class Gap:
    """What the later side of a seam has over the earlier one: translation ``(3,)``, rotation vectors ``(J, 3)``, and
    their rates of change a second."""

    translation: FloatArray
    rotations: FloatArray
    velocity: FloatArray
    angular: FloatArray


def join(clips: list[Clip], fps: float, frames: int, blend: str = "inertialised", duration: float = 0.4) -> Motion:
    """One motion of ``frames`` frames at ``fps`` from clips that follow one another.

    blend: one of `BLENDS`. duration: seconds a seam is felt on either side; a piece that is shorter bounds it.
    Raises RequestError for another blend.
    """
    if blend not in BLENDS:
        raise RequestError(f"blend must be one of {', '.join(BLENDS)}, found {blend!r}")
    gaps = [measure_gap(a, b) for a, b in itertools.pairwise(clips)]
    times = np.arange(frames) / fps
    first = np.searchsorted(times, [c.start - 1e-9 for c in clips])
    first[0] = 0
    parts = []
    for i, (clip, low, high) in enumerate(zip(clips, first, [*first[1:], frames], strict=True)):
        own = times[low:high]
        if len(own) == 0:
            continue
        part = clip.at(own, fps)
        if blend != "none":
            before = gaps[i - 1] if i > 0 else None
            after = gaps[i] if i < len(gaps) else None
            part = _correct(part, clip, own, before, after, blend, duration)
        parts.append(part)
    joined = concatenate(parts)
    return replace(joined, rotations=rot.unroll(joined.rotations))


def measure_gap(before: Clip, after: Clip) -> Gap:
    """The gap where ``after`` takes over.

    Velocities are measured alike on both sides, so that there is no gap between pieces that were neighbours.
    """
    step = 1.0 / max(before.motion.fps, after.motion.fps)
    left, left_velocity, left_angular = _state(before, before.stop, step)
    right, right_velocity, right_angular = _state(after, after.start, step)
    turn = rot.multiply(right.rotations[0], rot.conjugate(left.rotations[0]))
    return Gap(
        translation=right.translation[0] - left.translation[0],
        rotations=rot.log(turn),
        velocity=right_velocity - left_velocity,
        angular=_rate_of_log(turn, left_angular, right_angular),
    )


def _rate_of_log(turn: FloatArray, left: FloatArray, right: FloatArray) -> FloatArray:
    """Rate of change a second of the rotation vector of ``turn``, ``(J, 4)``, between two frames that turn themselves.

    left, right ``(J, 3)``: their angular velocities. For small turns it is their difference; for large ones that
    would leave part of the jump, as rotation vectors do not add up.
    """
    step = 1e-3
    ahead = rot.multiply(rot.multiply(rot.exp(right * step), turn), rot.exp(-left * step))
    behind = rot.multiply(rot.multiply(rot.exp(-right * step), turn), rot.exp(left * step))
    change = (rot.log(ahead) - rot.log(behind)) / (2 * step)
    wraps = np.linalg.norm(change, axis=-1, keepdims=True) > 1.0 / step  # half a turn: the vector flips its sign
    return np.where(wraps, right - left, change)


def _state(clip: Clip, time: float, step: float) -> tuple[Motion, FloatArray, FloatArray]:
    """The pose of a clip at ``time`` and its rates of change, over ``step`` seconds before and after where there are.

    The source goes on beyond the clip's borders; where it ends, its rate is measured on the one side that is left.
    """
    begin = clip.start - clip.source_start * clip.stretch
    first, last = np.clip([time - step, time + step], begin, begin + clip.motion.duration * clip.stretch)
    span = max(last - first, 1e-9)
    pose = clip.at(np.array([time, first, last]), clip.motion.fps)
    turned = rot.multiply(pose.rotations[2], rot.conjugate(pose.rotations[1]))
    return pose, (pose.translation[2] - pose.translation[1]) / span, rot.log(turned) / span


def _correct(
    part: Motion, clip: Clip, times: FloatArray, before: Gap | None, after: Gap | None, blend: str, duration: float
) -> Motion:
    length = clip.stop - clip.start
    reach = length if blend == "linear" else min(duration, length)
    translation, turn = np.zeros((len(times), 3)), np.zeros((len(times), len(part.skeleton), 3))
    for gap, since, sign in ((before, times - clip.start, -0.5), (after, clip.stop - times, 0.5)):
        if gap is None:
            continue
        u = np.clip(since / reach, 0.0, 1.0)
        place, rate = (1 - u, np.zeros_like(u)) if blend == "linear" else quintic_decay(u)
        rate = rate * reach * -np.sign(sign)  # seen from the earlier side, time runs away from the seam backwards
        translation += sign * (np.outer(place, gap.translation) + np.outer(rate, gap.velocity))
        turn += sign * (place[:, None, None] * gap.rotations + rate[:, None, None] * gap.angular)
    return replace(
        part, translation=part.translation + translation, rotations=rot.multiply(rot.exp(turn), part.rotations)
    )


def quintic_decay(u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Responses at ``u`` in [0, 1] to a unit offset and to a unit velocity at 0, both at rest at 1.

    Quintics with p(0) = 1, p'(0) = p''(0) = 0 and r(0) = 0, r'(0) = 1, r''(0) = 0; value, slope and curvature vanish
    at 1.

    >>> [float(x) for x in quintic_decay(np.array([0.0]))[0]], [float(x) for x in quintic_decay(np.array([1.0]))[1]]
    ([1.0], [0.0])
    """
    place = 1 - u**3 * (10 - 15 * u + 6 * u**2)
    rate = u - u**3 * (6 - 8 * u + 3 * u**2)
    return place, rate
