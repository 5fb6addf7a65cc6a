"""The recordings of a model as frames that may be steered: where bodies stand and face, and what is alike.

A body's place is its root's on the ground, and its facing that of its hips, both smoothed over the sway of a step. All
else is seen from there: the joints, their velocities, and the feet that are planted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, ComplexArray, FloatArray, IntArray, SingleArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import joint_positions, role_positions, velocities
from kinetograph.learn import FrameGraph
from kinetograph.methods.performance.segments import Source
from kinetograph.motion import Motion, sample
from kinetograph.post.foot_lock import planted_roles
from kinetograph.post.playing import Repertoire
from kinetograph.post.turning import facings
from kinetograph.sampling import sample_times

ROWS = 3
"""Rows in a unit."""
UNIT = 0.1
"""Seconds between states."""
SWAY = 0.12
"""Seconds, the width of the Gaussian that place and facing are smoothed by."""
FLAG = 0.1
"""Metres that a contact counts as."""
APART = 0.35
"""Seconds; frames of one recording that are closer are not jumped between."""
LEFT = 0.4
"""Seconds that a recording goes on for at least after a jump to it."""


@dataclass(frozen=True, eq=False)
class SteeringFrames:
    """Rows of all recordings, ``ROWS / UNIT`` a second, every ``ROWS``-th of which is a state.

    Parameters
    ----------
    repertoire : Repertoire
    source : ndarray of int, shape (M,)
        The recording of each row.
    second : ndarray, shape (M,)
        Its time there.
    place : ndarray of complex, shape (M,)
        Smoothed place on the ground in the recording.
    facing : ndarray, shape (M,)
        Smoothed facing, unwrapped within a recording.
    features : ndarray of float32, shape (M, C)
        What is compared at jumps, scaled so that squared distances are mean square metres of the joints.
    pivots : ndarray of complex, shape (M,)
        The planted point, from the body's place and facing; 0 in flight.
    starts : ndarray of int, shape (R + 1,)
        The first row of each recording, and their number.
    """

    repertoire: Repertoire
    source: IntArray
    second: FloatArray
    place: ComplexArray
    facing: FloatArray
    features: SingleArray
    pivots: ComplexArray
    starts: IntArray

    @classmethod
    def of(cls, sources: Sequence[Source]) -> SteeringFrames:
        """The frames of a model's recordings, those that are long enough.

        Raises
        ------
        RequestError
            Where none is.
        """
        long = [s for s in sources if s.motion.duration >= 2 * LEFT + UNIT]
        if not long:
            raise RequestError(f"steering needs recordings of {2 * LEFT + UNIT:.1f} s or more; there is none")
        repertoire = Repertoire.of([s.motion for s in long], [s.annotations for s in long])
        parts = [_rows(s.motion, repertoire, i) for i, s in enumerate(long)]
        starts = np.concatenate([[0], np.cumsum([len(p[0]) for p in parts])])
        second, place, facing, features, pivots = (np.concatenate(columns) for columns in zip(*parts, strict=True))
        source = np.repeat(np.arange(len(parts)), np.diff(starts))
        return cls(repertoire, source, second, place, facing, features, pivots, starts)

    @property
    def calmest(self) -> int:
        """The row whose joints move least, with motion left after it."""
        joints = len(self.repertoire.skeleton)
        speeds = np.linalg.norm(self.features[:, 3 * joints : 6 * joints], axis=1)
        left = self.second[self.starts[1:] - 1][self.source] - self.second
        return int(np.argmin(np.where(left >= LEFT, speeds, np.inf)))

    def row(self, recording: int, second: float) -> int:
        """The row nearest to a time of a recording."""
        first, stop = self.starts[recording], self.starts[recording + 1]
        return int(min(first + round(second * ROWS / UNIT), stop - 1))

    def between(self, values: npt.NDArray[np.generic], recording: int, second: float) -> npt.NDArray[np.generic]:
        """Values of rows at a time of a recording, linearly interpolated; held at its ends."""
        first, stop = self.starts[recording], self.starts[recording + 1]
        at = min(max(second * ROWS / UNIT, 0.0), stop - first - 1.0)
        low = min(int(at), int(stop - first) - 2)
        u = at - low
        return np.asarray((1 - u) * values[first + low] + u * values[first + low + 1])


def _rows(
    motion: Motion, repertoire: Repertoire, index: int
) -> tuple[FloatArray, ComplexArray, FloatArray, SingleArray, ComplexArray]:
    """Seconds, places, facings, features and pivots of a recording."""
    rate = ROWS / UNIT
    seconds = sample_times(motion.duration, rate)
    fine = sample(motion, seconds, rate)
    place, facing = smoothed_track(fine)
    positions = joint_positions(fine)
    planted = np.array([repertoire.planted_at(index, s) for s in seconds])
    back = rot.about("y", -facing)[:, None]
    ground = np.stack([place.imag, np.zeros(len(place)), place.real], axis=1)[:, None]
    local = rot.rotate(back, positions - ground)
    moving = rot.rotate(back, velocities(positions, rate)) * UNIT
    return seconds, place, facing, _features(local, moving, planted), _pivots(fine, planted, place, facing)


def _features(local: FloatArray, moving: FloatArray, planted: BoolArray) -> SingleArray:
    frames, joints = local.shape[:2]
    parts = [np.concatenate([local, moving], axis=1).reshape(frames, -1) / np.sqrt(joints)]
    if planted.shape[1]:
        parts.append(planted * FLAG / np.sqrt(planted.shape[1]))
    return np.concatenate(parts, axis=1).astype(np.float32)


def _pivots(motion: Motion, planted: BoolArray, place: ComplexArray, facing: FloatArray) -> ComplexArray:
    roles = planted_roles(motion.skeleton)
    if not roles:
        return np.zeros(len(motion), dtype=np.complex128)
    points = role_positions(motion, roles)
    flat = points[..., 2] + 1j * points[..., 0]
    count = planted.sum(axis=1)
    mean = np.where(count > 0, (flat * planted).sum(axis=1) / np.maximum(count, 1), place)
    seen = np.asarray((mean - place) * np.exp(-1j * facing))
    return _smooth(seen, motion.fps)  # else the body jerks from foot to foot


def smoothed_track(motion: Motion) -> tuple[ComplexArray, FloatArray]:
    """Where a body stands and faces, without the sway of its steps.

    Parameters
    ----------
    motion : Motion

    Returns
    -------
    place : ndarray of complex, shape (F,)
    facing : ndarray, shape (F,)
        Radians, unwrapped.
    """
    place = motion.translation[:, 2] + 1j * motion.translation[:, 0]
    facing = np.asarray(facings(motion), dtype=np.complex128)
    return _smooth(np.asarray(place), motion.fps), np.asarray(_smooth(facing, motion.fps).real)


def _smooth(values: ComplexArray, fps: float) -> ComplexArray:
    from scipy.ndimage import gaussian_filter1d  # on first use: the package itself loads without scipy

    width = int(4 * SWAY * fps + 0.5)
    padded = np.pad(values, width, mode="reflect", reflect_type="odd")
    return np.asarray(gaussian_filter1d(padded, SWAY * fps)[width : width + len(values)])


@dataclass(frozen=True, eq=False)
class States:
    """Frames a unit apart, and the graph over them.

    Parameters
    ----------
    rows : ndarray of int, shape (N,)
        The row of each state.
    graph : FrameGraph
    features : ndarray of float32, shape (N, C)
    first : ndarray of int, shape (R + 1,)
        The first state of each recording, and their number.
    open : ndarray of bool, shape (N,)
        Whether its recording goes on for long enough to jump to it.
    """

    rows: IntArray
    graph: FrameGraph
    features: SingleArray
    first: IntArray
    open: BoolArray

    def near(self, recording: int, second: float) -> int:
        """The state that is nearest to a time of a recording."""
        low, stop = self.first[recording], self.first[recording + 1]
        return int(min(low + max(round(second / UNIT), 0), stop - 1))


def make_states(frames: SteeringFrames, weight: float, constant: float, count: int = 64) -> States:
    """States every unit of every recording, with their cheapest jumps.

    Parameters
    ----------
    frames : SteeringFrames
    weight, constant : float
        A jump costs ``weight`` times the squared distance of the features, and ``constant``.
    count : int
        Jumps of a state.

    Returns
    -------
    States
    """
    spans = [np.arange(a, b, ROWS) for a, b in zip(frames.starts[:-1], frames.starts[1:], strict=True)]
    rows = np.concatenate(spans)
    goes_on = np.append(frames.source[rows[1:]] == frames.source[rows[:-1]], False)
    following = rows[np.minimum(np.arange(len(rows)) + goes_on, len(rows) - 1)]
    way = (frames.place[following] - frames.place[rows]) * np.exp(-1j * frames.facing[rows])
    turn = frames.facing[following] - frames.facing[rows]
    middle = frames.pivots[np.minimum(rows + ROWS // 2, following)]
    steps = np.stack([way.real, way.imag, turn, middle.real, middle.imag], axis=1)
    features = np.ascontiguousarray(frames.features[rows])
    ends = np.repeat(np.array([s[-1] for s in spans]), [len(s) for s in spans])
    open_ = (ends - rows) / (ROWS / UNIT) >= LEFT
    jumps, squares = _neighbours(frames, rows, features, open_, count)
    graph = FrameGraph(steps, goes_on, jumps, np.asarray(weight * squares + constant, dtype=np.float32))
    return States(rows, graph, features, np.concatenate([[0], np.cumsum([len(s) for s in spans])]), open_)


def _neighbours(
    frames: SteeringFrames, rows: IntArray, features: SingleArray, open_: BoolArray, count: int
) -> tuple[npt.NDArray[np.int32], FloatArray]:
    """The nearest states of each, and squared distances to them, ascending; inf where there are fewer."""
    size = np.einsum("ij,ij->i", features, features)
    count = min(count, len(rows))
    jumps = np.empty((len(rows), count), dtype=np.int32)
    squares = np.empty((len(rows), count))
    for start in range(0, len(rows), 512):
        block = slice(start, min(start + 512, len(rows)))
        d = np.maximum(size[block, None] + size[None] - 2 * features[block] @ features.T, 0.0)
        near = np.abs(rows[block, None] - rows[None]) <= APART * ROWS / UNIT
        d[near & (frames.source[rows[block], None] == frames.source[rows][None]) | ~open_[None]] = np.inf
        best = np.argpartition(d, count - 1, axis=1)[:, :count]
        order = np.take_along_axis(best, np.argsort(np.take_along_axis(d, best, axis=1), axis=1, kind="stable"), axis=1)
        jumps[block], squares[block] = order, np.take_along_axis(d, order, axis=1)
    return jumps, squares
