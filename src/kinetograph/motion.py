"""Motions: one character over time, and what can be done to one without knowing what it means."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import DataError, RequestError
from kinetograph.sampling import bracket, interpolate
from kinetograph.skeleton import Skeleton


@dataclass(frozen=True, eq=False)
class Motion:
    """One character over ``F`` frames.

    translation: shape ``(F, 3)`` metres, the root joint in the world, Y up. rotations: shape ``(F, J, 4)`` unit
    quaternions, each joint in its parent's frame (the root's in the world). fps: frames a second. bones: ``None``
    where every bone is rigid, else shape ``(F, J, 3)`` metres, which replace the skeleton's offsets frame by frame
    (the root's row is unused).

    Raises DataError for shapes that disagree, values that are not finite, or quaternions off unit length by > 1e-3.
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
        if not (np.isfinite(self.translation).all() and np.isfinite(self.rotations).all()):
            raise DataError("a motion's values must be finite; look for NaN or inf in its source")
        norms = np.sqrt(np.einsum("fji,fji->fj", self.rotations, self.rotations))
        if np.abs(norms - 1.0).max() > 1e-3:
            frame, joint = np.unravel_index(int(np.abs(norms - 1.0).argmax()), norms.shape)
            raise DataError(
                f"rotations must be unit quaternions, found length {norms[frame, joint]:.4g} "
                f"at frame {frame}, joint {self.skeleton.names[joint]!r}; normalize them first"
            )

    def __len__(self) -> int:
        return len(self.translation)

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (len(self) - 1) / self.fps


def cut(motion: Motion, start: int, stop: int) -> Motion:
    """Frames ``start`` to ``stop - 1``. Raises RequestError where that is empty or outside the motion."""
    if not 0 <= start < stop <= len(motion):
        raise RequestError(f"frames {start} to {stop} are not within this motion's 0 to {len(motion)}")
    bones = None if motion.bones is None else motion.bones[start:stop]
    return replace(
        motion, translation=motion.translation[start:stop], rotations=motion.rotations[start:stop], bones=bones
    )


def sample(motion: Motion, times: npt.ArrayLike, fps: float) -> Motion:
    """The motion at ``times``, shape ``(T,)`` seconds, as a motion of rate ``fps``.

    Translations are interpolated linearly and rotations by slerp; times beyond the ends hold the end pose.
    """
    position = np.asarray(times, dtype=np.float64) * motion.fps
    lower, upper, u = bracket(position, len(motion))
    rotations = rot.slerp(motion.rotations[lower], motion.rotations[upper], u[:, None])
    bones = None if motion.bones is None else interpolate(motion.bones, position)
    return Motion(motion.skeleton, interpolate(motion.translation, position), rotations, fps, bones)


def resample(motion: Motion, fps: float) -> Motion:
    """The motion at another rate, up or down; the first frame stays, the last is the last that the rate meets.

    Raises RequestError unless ``fps`` is positive and finite.
    """
    if not (np.isfinite(fps) and fps > 0):
        raise RequestError(f"fps must be a positive number, found {fps}")
    if fps == motion.fps:
        return motion
    count = int(np.floor(motion.duration * fps * (1 + 1e-12) + 1e-6)) + 1
    return sample(motion, np.arange(count) / fps, fps)


def transform(motion: Motion, rotation: npt.ArrayLike, shift: npt.ArrayLike) -> Motion:
    """Turn about the origin by a quaternion, shape ``(4,)``, then move by ``shift``, shape ``(3,)`` metres."""
    q = np.asarray(rotation, dtype=np.float64)
    translation = rot.rotate(q, motion.translation) + np.asarray(shift, dtype=np.float64)
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.multiply(q, rotations[:, 0])
    return replace(motion, translation=translation, rotations=rotations)


def place(motion: Motion, turn: float, shift: npt.ArrayLike) -> Motion:
    """Turn about the vertical through the origin (radians, Y up), then move by ``shift``, shape ``(3,)`` metres.

    >>> stick = Motion(Skeleton(("root",), np.array([-1]), np.zeros((1, 3))), np.array([[1.0, 1, 0]]),
    ...                rot.identity(1, 1), 30.0)
    >>> place(stick, np.pi / 2, (0, 0, 0.5)).translation.round(6).tolist()
    [[0.0, 1.0, -0.5]]
    """
    return transform(motion, rot.about("y", turn), shift)


def concatenate(motions: list[Motion]) -> Motion:
    """Motions of one skeleton and rate, one after another. Raises RequestError where those differ."""
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


def heading(motion: Motion) -> FloatArray:
    """Turn of the root about the vertical, shape ``(F,)`` radians, unwrapped over time."""
    return np.unwrap(rot.heading(motion.rotations[:, 0]))


def close_loop(motion: Motion) -> Motion:
    """A clip that loops, made to end exactly in the pose it began with, turned and moved on by one cycle.

    What is missing at the end is spread evenly over the cycle, half of it taken from the beginning: every frame moves
    by at most half of the gap. The root keeps its path on the ground and its heading.
    """
    ramp = np.linspace(-0.5, 0.5, len(motion))
    turn, _ = loop_step(motion)
    last = motion.rotations[-1].copy()
    last[0] = rot.multiply(rot.about("y", -turn), last[0])
    gap = rot.log(rot.multiply(motion.rotations[0], rot.conjugate(last)))
    rise = motion.translation[0, 1] - motion.translation[-1, 1]
    correction = rot.exp(ramp[:, None, None] * gap)
    # the root's gap was measured after the cycle's turn was taken off; it is turned back on as far as a frame has got
    on = rot.about("y", turn * (ramp + 0.5))
    correction[:, 0] = rot.multiply(rot.multiply(on, correction[:, 0]), rot.conjugate(on))
    translation = motion.translation + np.outer(ramp, [0.0, rise, 0.0])
    return replace(motion, translation=translation, rotations=rot.multiply(correction, motion.rotations))


def loop_step(motion: Motion) -> tuple[float, FloatArray]:
    """Turn about the vertical in radians and shift ``(3,)`` in metres that take a looping clip's start to its end."""
    turn = float(rot.heading(rot.multiply(motion.rotations[-1, 0], rot.conjugate(motion.rotations[0, 0]))))
    shift = motion.translation[-1] - rot.rotate(rot.about("y", turn), motion.translation[0])
    shift[1] = 0.0
    return turn, shift


def repeat(motion: Motion, times: int) -> Motion:
    """A clip that loops, played ``times`` times, each cycle going on where and in the direction the last one ended.

    The clip's last frame is taken to be the pose of its first one, a cycle later; see `close_loop` for the rest.
    Raises RequestError unless ``times`` is at least 1.
    """
    if times < 1:
        raise RequestError(f"a clip can be repeated 1 time or more, found {times}")
    cycles = [close_loop(motion)]
    turn, shift = loop_step(motion)
    for _ in range(times - 1):
        cycles.append(place(cycles[-1], turn, shift))
    return concatenate([cycle if i == 0 else cut(cycle, 1, len(cycle)) for i, cycle in enumerate(cycles)])
