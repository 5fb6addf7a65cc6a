"""Fitting poses to markers, and bones and the markers' places on them to poses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.kinematics import forward
from kinetograph.markers import _kernels
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton

ROUNDS = 8
"""How often bones and places are fitted, and poses to them."""

_SAMPLES = 150  # frames of a take from which the body is measured
_CENTRE, _PLACE = 0.015, 0.03  # metres: standard deviations of the first estimates of joints and of places on bones
_SKIN = 0.01  # metres: standard deviation of skin over bone
_INDEPENDENT = 30  # frames of a sample whose errors are independent of each other
# radians: standard deviations of joints from the rest pose about x, y and z, where markers hardly decide: knees are
# hinges, a collar bone does not rotate about itself, and neighbours in the trunk bend alike
_RANGES = {"knee": (9.0, 0.15, 0.15), "collar": (0.15, 0.5, 0.5), "hand": (0.15, 9.0, 9.0)}
_RANGES |= dict.fromkeys(("spine", "chest", "neck", "head"), (0.5, 0.5, 0.5))
_BRIDGED = 0.35  # radians: standard deviation of joints with hidden markers from the rotations before and after
_FURTHEST = 0.05  # metres: a marker that misses by more is probably another one
_NEEDED = {"hips": 3, "chest": 3, "head": 3}  # markers that determine a segment's rotation; two elsewhere
_SEEN_WITH = {"spine": "chest", "neck": "head"}  # segments without markers, and those whose markers count


@dataclass(frozen=True, eq=False)
class Solver:
    """A skeleton and the markers that it is fitted to.

    Parameters
    ----------
    skeleton : Skeleton
    points : ndarray, shape (F, M, 3)
        The markers, metres.
    seen : ndarray of bool, shape (F, M)
    joints : ndarray of int, shape (M,)
        The joint that each marker is on.
    guess : tuple of ndarray, shapes (F, 3) and (F, J, 4)
        Roots and local rotations from which each frame may begin.
    ranges : mapping of str to tuple of float, optional
        More of what joints resist: by the last word of a joint's name, radians about x, y and z.
    """

    skeleton: Skeleton
    points: FloatArray
    seen: BoolArray
    joints: IntArray
    guess: tuple[FloatArray, FloatArray]
    ranges: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)

    def poses(self, places: FloatArray, prior: tuple[FloatArray, FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Solve the poses, beginning with the frame that shows most markers, forwards and then backwards.

        Parameters
        ----------
        places : ndarray, shape (M, 3)
            Of the markers in the frames of their joints, metres.
        prior : tuple of ndarray, shapes (F, J, 4) and (F, J, 3)
            Rotations that joints are drawn to, and how strongly.

        Returns
        -------
        roots : ndarray, shape (F, 3)
        rotations : ndarray, shape (F, J, 4)
            Local.
        """
        frames = len(self.points)
        first = int(np.argmax(self.seen.sum(axis=1)))
        roots, rotations = np.empty((frames, 3)), np.empty((frames, len(self.skeleton), 4))
        # one layout of memory, so that the kernel is compiled once
        points, places = np.ascontiguousarray(self.points), np.ascontiguousarray(places)
        prior, guess = (
            (np.ascontiguousarray(first), np.ascontiguousarray(second)) for first, second in (prior, self.guess)
        )
        tree = (self.skeleton.parents, np.ascontiguousarray(self.skeleton.offsets))
        attached = (self.joints, places)
        for order in (np.arange(first, frames, dtype=np.int64), np.arange(first, -1, -1, dtype=np.int64)):
            frame_by_frame = (order, _FURTHEST, roots, rotations)
            _kernels.solve(points, np.ascontiguousarray(self.seen), tree, attached, prior, guess, *frame_by_frame)
        return roots, rotations

    def rest(self) -> tuple[FloatArray, FloatArray]:
        """The rest pose as a prior, so weak that it only decides what no marker does; see ``poses``."""
        frames, joints = len(self.points), len(self.skeleton)
        known = {**_RANGES, **self.ranges}
        ranges = np.array([known.get(name.rpartition("_")[2], (9.0,) * 3) for name in self.skeleton.names])
        weights = np.broadcast_to((_SKIN / ranges) ** 2, (frames, joints, 3)).copy()
        weights[:, 0] = 0.0
        return rot.identity(frames, joints), weights

    def motion(self, places: FloatArray, fps: float) -> Motion:
        """Fit every frame's pose; where markers are hidden, rotations are drawn to those between frames that show them.

        Parameters
        ----------
        places : ndarray, shape (M, 3)
            Of the markers in the frames of their joints, metres.
        fps : float

        Returns
        -------
        Motion
        """
        known = self._known()
        target, weights = self.rest()
        # first without a prior for what is hidden, which then stays as in the frame before
        roots, rotations = self.poses(places, (target, weights * known[..., None]))
        if not known.all():
            for joint in np.flatnonzero(known.any(axis=0) & ~known.all(axis=0)).tolist():
                bridge = _bridged(rotations, known, joint)
                target[:, joint] = np.where(known[:, joint, None], target[:, joint], bridge)
            prior = (target, np.where(known[..., None], weights, (_SKIN / _BRIDGED) ** 2))
            roots, rotations = self.poses(places, prior)
        sure = np.flatnonzero(self.seen.sum(axis=1) >= 3)
        roots = np.stack([np.interp(np.arange(len(roots)), sure, roots[sure, i]) for i in range(3)], axis=1)
        return Motion(self.skeleton, roots, rot.unroll(rot.normalize(rotations)), fps)

    def _known(self) -> BoolArray:
        """The joints whose rotations the markers of their segments determine, ``(F, J)``."""
        known = np.ones((len(self.points), len(self.skeleton)), dtype=np.bool_)
        for joint, name in enumerate(self.skeleton.names):
            other = _SEEN_WITH.get(name, name)
            own = self.joints == self.skeleton.index(other if other in self.skeleton.names else name)
            needed = min(_NEEDED.get(name, 2), int(own.sum()))
            known[:, joint] = self.seen[:, own].sum(axis=1) >= needed
        return known


def _bridged(rotations: FloatArray, known: BoolArray, joint: int) -> FloatArray:
    """A joint's rotations ``(F, 4)``, interpolated in frames that do not determine them."""
    sure = np.flatnonzero(known[:, joint])
    frames = np.arange(len(rotations))
    after = np.searchsorted(sure, frames)
    low, high = sure[np.maximum(after - 1, 0)], sure[np.minimum(after, len(sure) - 1)]
    share = np.clip((frames - low) / np.maximum(high - low, 1), 0.0, 1.0)
    return rot.slerp(rotations[low, joint], rotations[high, joint], share)


def sampled(solver: Solver) -> Solver:
    """The solver of some frames, spread over the take, from which the body is measured."""
    chosen = np.unique(np.linspace(0, len(solver.points) - 1, _SAMPLES).astype(np.int64))
    guess = (solver.guess[0][chosen], solver.guess[1][chosen])
    return replace(solver, points=solver.points[chosen], seen=solver.seen[chosen], guess=guess)


def measured(
    solver: Solver, places: FloatArray, rounds: int = ROUNDS, spread: FloatArray | float = _PLACE
) -> tuple[FloatArray, Solver]:
    """Fit bones and the markers' places to the movement of some frames.

    Parameters
    ----------
    solver : Solver
        With a first estimate of the bones.
    places : ndarray, shape (M, 3)
        A first estimate of the markers' places in the frames of their joints, metres.
    rounds : int
    spread : ndarray, shape (M,), or float
        Metres: standard deviations of the first estimates of places.

    Returns
    -------
    places : ndarray, shape (M, 3)
    solver : Solver
        With the fitted bones.
    """
    some = sampled(solver)
    first = (solver.skeleton.offsets, places)
    for _ in range(rounds):
        roots, rotations = some.poses(places, some.rest())
        motion = Motion(some.skeleton, roots, rot.normalize(rotations), 1.0)
        offsets, places = _refined(some, motion, places, first, spread)
        some = replace(some, skeleton=replace(some.skeleton, offsets=offsets))
    return places, replace(solver, skeleton=some.skeleton)


def _refined(
    solver: Solver,
    motion: Motion,
    places: FloatArray,
    first: tuple[FloatArray, FloatArray],
    spread: FloatArray | float,
) -> tuple[FloatArray, FloatArray]:
    """Bones ``(J, 3)`` and places ``(M, 3)`` that fit the markers best in given poses, near a first estimate."""
    rows, misses = derivatives(solver, motion, places)
    joints, markers = len(solver.skeleton), len(places)
    deviations = np.concatenate([np.full(joints, _CENTRE), np.broadcast_to(spread, markers)])
    held = np.repeat(deviations, 3) ** -2.0
    now = np.concatenate([solver.skeleton.offsets.reshape(-1), places.reshape(-1)])
    start = np.concatenate([first[0].reshape(-1), first[1].reshape(-1)])
    noise = _SKIN**2 * len(motion) / _INDEPENDENT
    matrix = rows.T @ rows / noise + np.diag(held)
    now = now + np.linalg.solve(matrix, rows.T @ misses / noise + held * (start - now))
    return now[: 3 * joints].reshape(-1, 3), now[3 * joints :].reshape(-1, 3)


def derivatives(solver: Solver, motion: Motion, places: FloatArray) -> tuple[FloatArray, FloatArray]:
    """How markers move with bones and places, and what they miss, both without the movement of a whole frame.

    Parameters
    ----------
    solver : Solver
    motion : Motion
        With the solver's skeleton and frames.
    places : ndarray, shape (M, 3)

    Returns
    -------
    rows : ndarray, shape (3 F M, 3 J + 3 M)
        Derivatives by the offsets of joints and the places of markers.
    misses : ndarray, shape (3 F M,)
        Metres.
    """
    positions, rotations = forward(motion)
    matrices = rot.to_matrix(rotations)
    joints, markers = len(solver.skeleton), len(places)
    size = 3 * (joints + markers)
    posed = positions[:, solver.joints] + np.einsum("fmab,mb->fma", matrices[:, solver.joints], places)
    rows = np.zeros((len(positions), markers, 3, size))
    for marker, joint in enumerate(solver.joints.tolist()):
        rows[:, marker, :, 3 * (joints + marker) : 3 * (joints + marker) + 3] = matrices[:, joint]
        while (parent := int(solver.skeleton.parents[joint])) >= 0:
            rows[:, marker, :, 3 * joint : 3 * joint + 3] = matrices[:, parent]
            joint = parent
    # the root moves freely with each frame: only what differs between a frame's markers counts
    share = solver.seen / np.maximum(solver.seen.sum(axis=1, keepdims=True), 1)
    misses = np.where(solver.seen[..., None], solver.points - posed, 0.0)
    misses = (misses - np.einsum("fm,fma->fa", share, misses)[:, None]) * solver.seen[..., None]
    rows = (rows - np.einsum("fm,fmas->fas", share, rows)[:, None]) * solver.seen[..., None, None]
    return np.asarray(rows).reshape(-1, size), np.asarray(misses).reshape(-1)
