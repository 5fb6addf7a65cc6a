"""Making consecutive pieces meet.

Both blends share the gap at a seam between its two sides: half of it is added to the earlier piece and half taken from
the later one, and the correction fades away from the seam. They differ in how it fades:

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
"""The blends that `join` knows."""


@dataclass(frozen=True, eq=False)
class Clip:
    """A placed interval of a recording on the time line of the result.

    The recording is used beyond both borders too, as far as it goes.

    Parameters
    ----------
    motion : Motion
        The recording at its own rate.
    rotation : ndarray, shape (4,)
        Unit quaternion that it is rotated by.
    shift : ndarray, shape (3,)
        Metres that it is then moved by.
    start, stop : float
        Seconds in the result.
    source_start : float
        Second of the recording at ``start``.
    stretch : float
        Seconds of the result per second of the recording; infinite where one pose is held.
    """

    motion: Motion
    rotation: FloatArray
    shift: FloatArray
    start: float
    stop: float
    source_start: float
    stretch: float

    def at(self, times: FloatArray, fps: float) -> Motion:
        """The placed recording at some times.

        Parameters
        ----------
        times : ndarray, shape (T,)
            Seconds in the result.
        fps : float
            Frames per second of the motion that is returned.

        Returns
        -------
        Motion
            ``T`` frames.
        """
        source = self.source_start + (times - self.start) / self.stretch
        return transform(sample(self.motion, source, fps), self.rotation, self.shift)


@dataclass(frozen=True, eq=False)
class Gap:
    """The difference of the later side of a seam from the earlier one.

    Parameters
    ----------
    translation : ndarray, shape (3,)
        Metres.
    rotations : ndarray, shape (J, 3)
        Rotation vectors in radians.
    velocity : ndarray, shape (3,)
        Difference of the root's velocities in metres per second.
    angular : ndarray, shape (J, 3)
        Rate of change of the rotation vectors, per second.
    """

    translation: FloatArray
    rotations: FloatArray
    velocity: FloatArray
    angular: FloatArray


def join(clips: list[Clip], fps: float, frames: int, blend: str = "inertialised", duration: float = 0.4) -> Motion:
    """One motion from clips that follow one another.

    Parameters
    ----------
    clips : list of Clip
        In order of time, without gaps.
    fps : float
        Frames per second of the result.
    frames : int
        Number of frames of the result.
    blend : str
        One of `BLENDS`.
    duration : float
        Seconds before and after a seam over which it is corrected; at most the length of the clip.

    Returns
    -------
    Motion

    Raises
    ------
    RequestError
        If there is no such blend.
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
            seams = (gaps[i - 1] if i > 0 else None, gaps[i] if i < len(gaps) else None)
            part = _correct(part, clip, own, seams, blend, duration)
        parts.append(part)
    joined = concatenate(parts)
    return replace(joined, rotations=rot.unroll(joined.rotations))


def measure_gap(before: Clip, after: Clip) -> Gap:
    """The gap between two clips where the second takes over.

    Velocities are measured alike on both sides, so that there is no gap between clips that follow one another in one
    recording.

    Parameters
    ----------
    before, after : Clip

    Returns
    -------
    Gap
    """
    step = 1.0 / max(before.motion.fps, after.motion.fps)
    left, left_velocity, left_angular = _state(before, before.stop, step)
    right, right_velocity, right_angular = _state(after, after.start, step)
    rotation = rot.multiply(right.rotations[0], rot.conjugate(left.rotations[0]))
    return Gap(
        translation=right.translation[0] - left.translation[0],
        rotations=rot.log(rotation),
        velocity=right_velocity - left_velocity,
        angular=_rate_of_log(rotation, left_angular, right_angular),
    )


def _rate_of_log(rotation: FloatArray, left: FloatArray, right: FloatArray) -> FloatArray:
    """Rate of change per second of the rotation vector of ``rotation``, ``(J, 4)``, between two frames that rotate.

    left, right ``(J, 3)``: their angular velocities. For small rotations it is their difference; for large ones that
    would leave part of the jump, as rotation vectors do not add up.
    """
    step = 1e-3
    ahead = rot.multiply(rot.multiply(rot.exp(right * step), rotation), rot.exp(-left * step))
    behind = rot.multiply(rot.multiply(rot.exp(-right * step), rotation), rot.exp(left * step))
    change = (rot.log(ahead) - rot.log(behind)) / (2 * step)
    wraps = np.linalg.norm(change, axis=-1, keepdims=True) > 1.0 / step  # at an angle of pi the vector flips its sign
    return np.where(wraps, right - left, change)


def _state(clip: Clip, time: float, step: float) -> tuple[Motion, FloatArray, FloatArray]:
    """The pose of a clip at ``time`` and its rates of change, over ``step`` seconds before and after where there are.

    The recording is used beyond the clip's borders; where it ends, the rate is measured on one side only.
    """
    first, last = np.array([time - step, time + step])
    if np.isfinite(clip.stretch):
        begin = clip.start - clip.source_start * clip.stretch
        first, last = np.clip([first, last], begin, begin + clip.motion.duration * clip.stretch)
    span = max(last - first, 1e-9)
    pose = clip.at(np.array([time, first, last]), clip.motion.fps)
    change = rot.multiply(pose.rotations[2], rot.conjugate(pose.rotations[1]))
    return pose, (pose.translation[2] - pose.translation[1]) / span, rot.log(change) / span


def _correct(
    part: Motion, clip: Clip, times: FloatArray, seams: tuple[Gap | None, Gap | None], blend: str, duration: float
) -> Motion:
    """The frames of a clip with its halves of the gaps at its start and its end."""
    length = clip.stop - clip.start
    reach = length if blend == "linear" else min(duration, length)
    translation, rotation = np.zeros((len(times), 3)), np.zeros((len(times), len(part.skeleton), 3))
    for gap, since, sign in ((seams[0], times - clip.start, -0.5), (seams[1], clip.stop - times, 0.5)):
        if gap is None:
            continue
        u = np.clip(since / reach, 0.0, 1.0)
        place, rate = (1 - u, np.zeros_like(u)) if blend == "linear" else quintic_decay(u)
        rate = rate * reach * -np.sign(sign)  # seen from the earlier side, time runs away from the seam backwards
        translation += sign * (np.outer(place, gap.translation) + np.outer(rate, gap.velocity))
        rotation += sign * (place[:, None, None] * gap.rotations + rate[:, None, None] * gap.angular)
    return replace(
        part, translation=part.translation + translation, rotations=rot.multiply(rot.exp(rotation), part.rotations)
    )


def quintic_decay(u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Quintics that fade from a unit offset, and from a unit velocity, at 0 to rest at 1.

    Parameters
    ----------
    u : ndarray, shape (...)
        From 0 to 1.

    Returns
    -------
    place : ndarray, shape (...)
        Quintic with p(0) = 1, p'(0) = p''(0) = 0.
    rate : ndarray, shape (...)
        Quintic with r(0) = 0, r'(0) = 1, r''(0) = 0. Value, slope and curvature of both are 0 at 1.

    Examples
    --------
    >>> [float(x) for x in quintic_decay(np.array([0.0]))[0]], [float(x) for x in quintic_decay(np.array([1.0]))[1]]
    ([1.0], [0.0])
    """
    place = 1 - u**3 * (10 - 15 * u + 6 * u**2)
    rate = u - u**3 * (6 - 8 * u + 3 * u**2)
    return place, rate
