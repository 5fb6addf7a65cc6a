"""Motions: one character over time, and the operations that need no knowledge of what the motion means.

Resampling, cutting, placing in the world, joining, and closing and repeating of clips that loop.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.display import notebook_html
from kinetograph.errors import DataError, RequestError
from kinetograph.sampling import REACH, sample_times, spline
from kinetograph.skeleton import Skeleton

_CHECKED = 4096  # frames that are looked at together, so that a long motion is checked in little memory


@dataclass(frozen=True, eq=False)
class Motion:
    """One character over ``F`` frames.

    Parameters
    ----------
    skeleton : Skeleton
        The joints, ``J`` of them.
    translation : ndarray, shape (F, 3)
        Position of the root joint in the world in metres, Y up.
    rotations : ndarray, shape (F, J, 4)
        Unit quaternions ``(w, x, y, z)``, each joint in its parent's frame, the root in the world.
    fps : float
        Frames per second.
    bones : ndarray, shape (F, J, 3), optional
        Offsets in metres that replace the skeleton's frame by frame, for bones that are not rigid. The root's row is
        unused.

    Raises
    ------
    DataError
        If shapes disagree, a value is not finite, or the length of a quaternion differs from 1 by more than 1e-3.
    """

    skeleton: Skeleton
    translation: FloatArray
    rotations: FloatArray
    fps: float
    bones: FloatArray | None = None

    def __post_init__(self) -> None:
        set_field = object.__setattr__
        set_field(self, "translation", np.asarray(self.translation, dtype=np.float64))
        set_field(self, "rotations", np.asarray(self.rotations, dtype=np.float64))
        set_field(self, "fps", float(self.fps))
        frames, joints = self.translation.shape[0], len(self.skeleton)
        if self.translation.shape != (frames, 3) or self.rotations.shape != (frames, joints, 4):
            raise DataError(
                f"expected translation (F, 3) and rotations (F, {joints}, 4), "
                f"found {self.translation.shape} and {self.rotations.shape}"
            )
        if frames == 0:
            raise DataError("a motion needs at least one frame, found none")
        if self.bones is not None:
            set_field(self, "bones", np.asarray(self.bones, dtype=np.float64))
            if self.bones.shape != (frames, joints, 3):
                raise DataError(f"expected bones ({frames}, {joints}, 3), found {self.bones.shape}")
            if not np.isfinite(self.bones).all():
                raise DataError("a motion's bones must be finite; look for NaN or inf in its source")
        if not (np.isfinite(self.fps) and self.fps > 0):
            raise DataError(f"fps must be a positive number, found {self.fps}")
        for first in range(0, frames, _CHECKED):
            self._check_values(first)

    def _check_values(self, first: int) -> None:
        """Raise DataError where some frames, from one on, are not finite or have other than unit quaternions."""
        rotations = self.rotations[first : first + _CHECKED]
        if not (np.isfinite(self.translation[first : first + _CHECKED]).all() and np.isfinite(rotations).all()):
            raise DataError("a motion's values must be finite; look for NaN or inf in its source")
        norms = np.sqrt(np.einsum("fji,fji->fj", rotations, rotations))
        if np.abs(norms - 1.0).max(initial=0.0) > 1e-3:
            frame, joint = np.unravel_index(int(np.abs(norms - 1.0).argmax()), norms.shape)
            raise DataError(
                f"rotations must be unit quaternions, found length {norms[frame, joint]:.4g} "
                f"at frame {first + frame}, joint {self.skeleton.names[joint]!r}; normalize them first"
            )

    def __len__(self) -> int:
        return len(self.translation)

    def _repr_html_(self) -> str:
        return notebook_html(self)

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (len(self) - 1) / self.fps


def cut(motion: Motion, start: int, stop: int) -> Motion:
    """Frames ``start`` to ``stop - 1`` of a motion.

    Parameters
    ----------
    motion : Motion
    start, stop : int
        First frame, and the frame after the last.

    Returns
    -------
    Motion

    Raises
    ------
    RequestError
        If the interval is empty or outside the motion.
    """
    if not 0 <= start < stop <= len(motion):
        raise RequestError(f"frames {start} to {stop} are not within this motion's 0 to {len(motion)}")
    bones = None if motion.bones is None else motion.bones[start:stop]
    return replace(
        motion, translation=motion.translation[start:stop], rotations=motion.rotations[start:stop], bones=bones
    )


def sample(motion: Motion, times: npt.ArrayLike, fps: float) -> Motion:
    """A motion at given times.

    Positions and quaternions lie on cubic splines through the frames, so that a motion is as smooth at a higher rate,
    or stretched, as at its own; times beyond the ends hold the end pose.

    Parameters
    ----------
    motion : Motion
    times : array_like, shape (T,)
        Seconds in the motion.
    fps : float
        Frames per second of the result.

    Returns
    -------
    Motion
        ``T`` frames, one per time.
    """
    position = np.asarray(times, dtype=np.float64) * motion.fps
    near = cut(motion, *_around(position, len(motion)))
    position = np.clip(position, 0, len(motion) - 1) - _around(position, len(motion))[0]
    rotations = rot.normalize(spline(rot.unroll(near.rotations), position))
    bones = None if near.bones is None else spline(near.bones, position)
    return Motion(motion.skeleton, spline(near.translation, position), rotations, fps, bones)


def _around(position: FloatArray, frames: int) -> tuple[int, int]:
    """The frames ``start`` to ``stop - 1`` that samples at fractional frames depend on."""
    low, high = np.clip([position.min(initial=frames), position.max(initial=0)], 0, frames - 1)
    return max(int(low) - REACH, 0), min(int(np.ceil(high)) + REACH + 1, frames)


def resample(motion: Motion, fps: float) -> Motion:
    """A motion at another rate, up or down.

    The first frame is kept; the last one is the last that the new rate reaches within the motion.

    Parameters
    ----------
    motion : Motion
    fps : float
        Frames per second of the result.

    Returns
    -------
    Motion

    Raises
    ------
    RequestError
        If ``fps`` is not positive and finite.
    """
    if not (np.isfinite(fps) and fps > 0):
        raise RequestError(f"fps must be a positive number, found {fps}")
    if fps == motion.fps:
        return motion
    return sample(motion, sample_times(motion.duration, fps), fps)


def transform(motion: Motion, rotation: npt.ArrayLike, shift: npt.ArrayLike) -> Motion:
    """Rotate a motion about the origin and then move it.

    Parameters
    ----------
    motion : Motion
    rotation : array_like, shape (4,)
        Unit quaternion.
    shift : array_like, shape (3,)
        Metres.

    Returns
    -------
    Motion
    """
    q = np.asarray(rotation, dtype=np.float64)
    translation = rot.rotate(q, motion.translation) + np.asarray(shift, dtype=np.float64)
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.multiply(q, rotations[:, 0])
    return replace(motion, translation=translation, rotations=rotations)


def place(motion: Motion, angle: float, shift: npt.ArrayLike) -> Motion:
    """Rotate a motion about the vertical through the origin and then move it.

    Parameters
    ----------
    motion : Motion
    angle : float
        Radians about +Y.
    shift : array_like, shape (3,)
        Metres.

    Returns
    -------
    Motion

    Examples
    --------
    >>> stick = Motion(Skeleton(("root",), np.array([-1]), np.zeros((1, 3))), np.array([[1.0, 1, 0]]),
    ...                rot.identity(1, 1), 30.0)
    >>> place(stick, np.pi / 2, (0, 0, 0.5)).translation.round(6).tolist()
    [[0.0, 1.0, -0.5]]
    """
    return transform(motion, rot.about("y", angle), shift)


def concatenate(motions: list[Motion]) -> Motion:
    """Motions of one skeleton and one rate, one after another.

    Parameters
    ----------
    motions : list of Motion
        At least one. Where some have bones that are not rigid, the others get the offsets of their skeleton.

    Returns
    -------
    Motion

    Raises
    ------
    RequestError
        If joints or rates differ.
    """
    first = motions[0]
    for motion in motions[1:]:
        if motion.skeleton.names != first.skeleton.names or motion.fps != first.fps:
            raise RequestError("only motions of one skeleton and one rate can be joined; resample or retarget first")
    bones = None
    if any(m.bones is not None for m in motions):
        rigid = [np.broadcast_to(m.skeleton.offsets, (len(m), len(m.skeleton), 3)) for m in motions]
        bones = np.concatenate([m.bones if m.bones is not None else r for m, r in zip(motions, rigid, strict=True)])
    return Motion(
        first.skeleton,
        np.concatenate([m.translation for m in motions]),
        np.concatenate([m.rotations for m in motions]),
        first.fps,
        bones,
    )


def root_facing(skeleton: Skeleton, rotations: FloatArray) -> FloatArray:
    """Rotations of a root from where it is when the body stands: in the rest pose, or in the stance if there is one.

    Parameters
    ----------
    skeleton : Skeleton
    rotations : ndarray, shape (..., 4)
        Of the root in the world.

    Returns
    -------
    ndarray, shape (..., 4)
    """
    return rotations if skeleton.stance is None else rot.multiply(rotations, rot.conjugate(skeleton.stance[0]))


def headings(motion: Motion) -> FloatArray:
    """Heading of the root at every frame, shape ``(F,)`` radians, see `kinetograph.rotations.heading`.

    Parameters
    ----------
    motion : Motion

    Returns
    -------
    ndarray, shape (F,)
        0 where the root faces as it does when the body stands.
    """
    return rot.heading(root_facing(motion.skeleton, motion.rotations[:, 0]))


def heading_at(motion: Motion, frame: int) -> float:
    """Heading of the root in one frame, radians, see `headings`."""
    return float(rot.heading(root_facing(motion.skeleton, motion.rotations[frame, 0])))


def unwrapped_headings(motion: Motion) -> FloatArray:
    """Heading of the root at every frame, without jumps of 2 pi from frame to frame.

    Parameters
    ----------
    motion : Motion

    Returns
    -------
    ndarray, shape (F,)
        Radians; the first lies between -pi and pi, as `kinetograph.rotations.heading` gives it.
    """
    return np.unwrap(headings(motion))


def close_loop(motion: Motion) -> Motion:
    """A clip that loops, changed to end in exactly the pose it began with, one cycle further on.

    The gap at the end is spread evenly over the cycle, half of it before and half after the middle, so that every
    frame is changed by at most half of the gap. The root keeps its path on the ground and its heading.

    Parameters
    ----------
    motion : Motion
        One cycle; its last frame is nearly the pose of its first.

    Returns
    -------
    Motion
        As many frames.
    """
    ramp = np.linspace(-0.5, 0.5, len(motion))
    angle, _ = loop_step(motion)
    last = motion.rotations[-1].copy()
    last[0] = rot.multiply(rot.about("y", -angle), last[0])
    gap = rot.log(rot.multiply(motion.rotations[0], rot.conjugate(last)))
    rise = motion.translation[0, 1] - motion.translation[-1, 1]
    correction = rot.exp(ramp[:, None, None] * gap)
    # the root's gap is measured without the cycle's change of heading; each frame is rotated by its share of that
    on = rot.about("y", angle * (ramp + 0.5))
    correction[:, 0] = rot.multiply(rot.multiply(on, correction[:, 0]), rot.conjugate(on))
    translation = motion.translation + np.outer(ramp, [0.0, rise, 0.0])
    return replace(motion, translation=translation, rotations=rot.multiply(correction, motion.rotations))


def loop_step(motion: Motion) -> tuple[float, FloatArray]:
    """The placement that takes the start of a looping clip to its end.

    Parameters
    ----------
    motion : Motion
        One cycle.

    Returns
    -------
    angle : float
        Radians about the vertical, as `place` takes them.
    shift : ndarray, shape (3,)
        Metres along the ground.
    """
    angle = float(rot.heading(rot.multiply(motion.rotations[-1, 0], rot.conjugate(motion.rotations[0, 0]))))
    shift = motion.translation[-1] - rot.rotate(rot.about("y", angle), motion.translation[0])
    shift[1] = 0.0
    return angle, shift


def repeat(motion: Motion, times: int) -> Motion:
    """A clip that loops, played several times; every cycle starts where the one before ended, in its direction.

    Parameters
    ----------
    motion : Motion
        One cycle. Its last frame is taken to be the pose of its first one, a cycle later; the gap between the two is
        spread over the cycle, see `close_loop`.
    times : int
        How often it is played.

    Returns
    -------
    Motion

    Raises
    ------
    RequestError
        If ``times`` is less than 1.
    """
    if times < 1:
        raise RequestError(f"a clip can be repeated 1 time or more, found {times}")
    cycles = [close_loop(motion)]
    angle, shift = loop_step(motion)
    for _ in range(times - 1):
        cycles.append(place(cycles[-1], angle, shift))
    return concatenate([cycle if i == 0 else cut(cycle, 1, len(cycle)) for i, cycle in enumerate(cycles)])
