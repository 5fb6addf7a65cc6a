"""Recordings played frame by frame, with jumps from one to another that are joined and with planted feet held.

Recordings lie on cubic splines whose weights are made ready once, so that any moment of them, with its velocities, is
a sum of four rows: at any rate of playing a motion is as smooth as it was recorded.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.motion import Motion
from kinetograph.post import _joining_kernels as kernels
from kinetograph.post.foot_lock import FootLock, LockSettings, planted_roles
from kinetograph.post.footskate import contact_mask
from kinetograph.post.inertialisation import Inertialisation, Moving, Pose, pose_of
from kinetograph.sampling import spline_weights
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation


@dataclass(frozen=True, eq=False)
class Repertoire:
    """Recordings of one skeleton, ready to be played.

    Parameters
    ----------
    skeleton : Skeleton
    fps : tuple of float
        Rates of the recordings.
    weights : tuple of ndarray, shape (F + 2, 3 + 4 J)
        Spline weights of the poses of each recording.
    planted : tuple of ndarray of bool, shape (F, R)
        Whether each of `kinetograph.post.planted_roles` is in contact, frame by frame.
    """

    skeleton: Skeleton
    fps: tuple[float, ...]
    weights: tuple[FloatArray, ...]
    planted: tuple[BoolArray, ...]

    @classmethod
    def of(cls, motions: Sequence[Motion], contacts: Sequence[Iterable[Annotation]]) -> Repertoire:
        """Make recordings ready.

        Parameters
        ----------
        motions : sequence of Motion
            Of one skeleton.
        contacts : sequence of iterable of Annotation
            Annotations of each recording, contacts among them, in its seconds.

        Raises
        ------
        RequestError
            Without a recording, and for skeletons of different joints.
        """
        if not motions or any(m.skeleton.names != motions[0].skeleton.names for m in motions):
            raise RequestError("recordings that are played together need one skeleton; retarget them first")
        skeleton = motions[0].skeleton
        roles, planted = planted_roles(skeleton), []
        for motion, notes in zip(motions, contacts, strict=True):
            touching = tuple(note for note in notes if note.kind == "contact")
            masks = [contact_mask(touching, role, len(motion), motion.fps) for role in roles]
            planted.append(np.stack(masks, axis=1) if roles else np.zeros((len(motion), 0), dtype=np.bool_))
        weights = tuple(spline_weights(_rows(motion)) for motion in motions)
        return cls(skeleton, tuple(m.fps for m in motions), weights, tuple(planted))

    def __len__(self) -> int:
        return len(self.weights)

    def duration(self, recording: int) -> float:
        """Seconds from the first frame of a recording to the last."""
        return (len(self.planted[recording]) - 1) / self.fps[recording]

    def at(self, recording: int, second: float) -> Moving:
        """The pose of a recording at some time, and how it moves; beyond the ends it stands still."""
        weights, fps = self.weights[recording], self.fps[recording]
        joints = len(self.skeleton)
        row, rates = np.empty(3 + 4 * joints), np.empty(3 + 3 * joints)
        kernels.sample_row(weights, second * fps, fps, row, rates)
        return Moving(row, rates)

    def planted_at(self, recording: int, second: float) -> BoolArray:
        """Which of the roles are in contact at some time: at the frame that is nearest to it."""
        flags = self.planted[recording]
        at = min(max(round(second * self.fps[recording]), 0), len(flags) - 1)
        return np.asarray(flags[at])


def _rows(motion: Motion) -> FloatArray:
    rotations = rot.unroll(motion.rotations)
    return np.concatenate([motion.translation, rotations.reshape(len(motion), -1)], axis=1)


@dataclass(eq=False)
class Player:
    """Plays recordings frame by frame; made with none playing, so ``jump`` first.

    Parameters
    ----------
    repertoire : Repertoire
    half_life : float
        Seconds in which the gap at a jump halves.
    lock : LockSettings, optional
        How planted feet are held; None leaves them.
    """

    repertoire: Repertoire
    half_life: float = 0.1
    lock: LockSettings | None = field(default_factory=LockSettings)
    recording: int = field(default=-1, init=False)
    """Index of the recording that is playing."""
    second: float = field(default=0.0, init=False)
    """Time in it."""
    rate: float = field(default=1.0, init=False)
    """Seconds of it in one second, at the last step."""

    def __post_init__(self) -> None:
        self.rotation, self.shift = rot.identity(), np.zeros(3)
        self._joining = Inertialisation(len(self.repertoire.skeleton), self.half_life)
        self._lock = None if self.lock is None else FootLock(self.repertoire.skeleton, self.lock)

    def jump(self, recording: int, second: float, rotation: FloatArray, shift: FloatArray) -> None:
        """Play another moment from now on: what is shown goes on from where it is, with its velocity.

        Parameters
        ----------
        recording : int
        second : float
            Time in the recording that is now, at the pose shown last.
        rotation : ndarray, shape (4,)
            Unit quaternion that the recording is rotated by.
        shift : ndarray, shape (3,)
            Metres that it is then moved by.

        Raises
        ------
        RequestError
            If there is no such recording.
        """
        if not 0 <= recording < len(self.repertoire):
            raise RequestError(f"recording {recording} is not among 0 to {len(self.repertoire) - 1}")
        old = self.played() if self.recording >= 0 else None
        self.recording, self.second = recording, float(second)
        self.place(rotation, shift)
        if old is not None:
            self._joining.jump(old, self.played())

    def place(self, rotation: FloatArray, shift: FloatArray) -> None:
        """Move the recording that is playing, without a joint: by little from frame to frame."""
        self.rotation, self.shift = np.asarray(rotation, dtype=np.float64), np.asarray(shift, dtype=np.float64)

    def played(self) -> Moving:
        """The placed pose of the recording, and how it moves, before it is joined and locked."""
        moving = self.repertoire.at(self.recording, self.second)
        kernels.place_row(self.rotation, self.shift, moving.row, moving.rates)
        return Moving(moving.row, moving.rates * self.rate)

    def step(self, dt: float, rate: float = 1.0) -> Pose:
        """The pose ``dt`` seconds later.

        Parameters
        ----------
        dt : float
            Seconds, more than 0.
        rate : float
            Seconds of the recording in one second.

        Returns
        -------
        Pose

        Raises
        ------
        RequestError
            If nothing is playing yet, or for a step or a rate that is not positive and finite.
        """
        if self.recording < 0:
            raise RequestError("nothing is playing: jump to a recording first")
        if not (0.0 < dt < np.inf and 0.0 < rate < np.inf):
            raise RequestError(f"a step and a rate must be positive and finite, found {dt} and {rate}")
        self.rate = rate
        self.second += dt * rate
        self._joining.step(dt)
        row = self._joining.shown(self.played().row)
        if self._lock is not None:
            row = self._lock.step(row, self.repertoire.planted_at(self.recording, self.second), dt)
        return pose_of(row)
