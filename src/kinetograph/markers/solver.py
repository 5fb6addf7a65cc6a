"""Poses that bring a skeleton's markers to where they were recorded, and the bones that let them come nearest."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.kinematics import forward
from kinetograph.markers import _kernels
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton

_SAMPLES = 150  # frames of a take from which the body is measured
_ROUNDS = 8
_CENTRE, _PLACE = 0.015, 0.03  # metres that the first estimates of joints and of markers on bones are trusted to
_SKIN = 0.01  # metres that skin moves over bone
_INDEPENDENT = 30  # frames of a sample, as its errors are alike for a while
# radians that joints turn by from the rest pose about x, y and z, where markers hardly tell: knees are hinges,
# a collar bone does not turn about itself, and neighbours in the trunk share what they bend
_RANGES = {"knee": (9.0, 0.15, 0.15), "collar": (0.15, 0.5, 0.5), "hand": (0.15, 9.0, 9.0)}
_RANGES |= dict.fromkeys(("spine", "chest", "neck", "head"), (0.5, 0.5, 0.5))
_BRIDGED = 0.35  # radians that joints with hidden markers may be off the turns between those before and after
_FURTHEST = 0.05  # metres; a marker that misses by more is likely to be another one
_NEEDED = {"hips": 3, "chest": 3, "head": 3}  # markers that tell a segment's turn; two elsewhere
_SEEN_WITH = {"spine": "chest", "neck": "head"}  # segments without markers, and what carries them


@dataclass(frozen=True, eq=False)
class Solver:
    """A skeleton and the markers ``(F, M, 3)``: which are seen ``(F, M)``, and the joint that each is on ``(M,)``.

    guess: of each frame's pose, roots ``(F, 3)`` and local turns ``(F, J, 4)``.
    """

    skeleton: Skeleton
    points: FloatArray
    seen: BoolArray
    joints: IntArray
    guess: tuple[FloatArray, FloatArray]

    def poses(self, places: FloatArray, prior: tuple[FloatArray, FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Roots ``(F, 3)`` and local turns ``(F, J, 4)``, solved from the frame that shows most on, and back."""
        frames = len(self.points)
        first = int(np.argmax(self.seen.sum(axis=1)))
        roots, turns = np.empty((frames, 3)), np.empty((frames, len(self.skeleton), 4))
        # one layout of memory, so that the kernel is compiled once
        points, places = np.ascontiguousarray(self.points), np.ascontiguousarray(places)
        prior, guess = (
            (np.ascontiguousarray(first), np.ascontiguousarray(second)) for first, second in (prior, self.guess)
        )
        tree, marks = (self.skeleton.parents, np.ascontiguousarray(self.skeleton.offsets)), (self.joints, places)
        for order in (np.arange(first, frames, dtype=np.int64), np.arange(first, -1, -1, dtype=np.int64)):
            frame_by_frame = (order, _FURTHEST, roots, turns)
            _kernels.solve(points, np.ascontiguousarray(self.seen), tree, marks, prior, guess, *frame_by_frame)
        return roots, turns

    def rest(self) -> tuple[FloatArray, FloatArray]:
        """The rest pose as what joints are drawn to, so weakly that it only decides what no marker tells."""
        frames, joints = len(self.points), len(self.skeleton)
        ranges = np.array([_RANGES.get(name.rpartition("_")[2], (9.0,) * 3) for name in self.skeleton.names])
        weights = np.broadcast_to((_SKIN / ranges) ** 2, (frames, joints, 3)).copy()
        weights[:, 0] = 0.0
        return rot.identity(frames, joints), weights

    def motion(self, places: FloatArray, fps: float) -> Motion:
        """Every frame's pose; where markers are hidden, drawn to what lies between those before and after."""
        known = self._known()
        target, weights = self.rest()
        # what is hidden stays as it was, for a start
        roots, turns = self.poses(places, (target, weights * known[..., None]))
        if not known.all():
            for joint in np.flatnonzero(known.any(axis=0) & ~known.all(axis=0)).tolist():
                bridge = _bridged(turns, known, joint)
                target[:, joint] = np.where(known[:, joint, None], target[:, joint], bridge)
            prior = (target, np.where(known[..., None], weights, (_SKIN / _BRIDGED) ** 2))
            roots, turns = self.poses(places, prior)
        there = np.flatnonzero(self.seen.sum(axis=1) >= 3)
        roots = np.stack([np.interp(np.arange(len(roots)), there, roots[there, i]) for i in range(3)], axis=1)
        return Motion(self.skeleton, roots, rot.unroll(rot.normalize(turns)), fps)

    def _known(self) -> BoolArray:
        """Which joints' turns the markers of their segments tell, ``(F, J)``."""
        known = np.ones((len(self.points), len(self.skeleton)), dtype=np.bool_)
        for joint, name in enumerate(self.skeleton.names):
            own = self.joints == self.skeleton.index(_SEEN_WITH.get(name, name))
            needed = min(_NEEDED.get(name, 2), int(own.sum()))
            known[:, joint] = self.seen[:, own].sum(axis=1) >= needed
        return known


def _bridged(turns: FloatArray, known: BoolArray, joint: int) -> FloatArray:
    """A joint's turns ``(F, 4)``, those of frames that do not tell them between those before and after."""
    there = np.flatnonzero(known[:, joint])
    frames = np.arange(len(turns))
    after = np.searchsorted(there, frames)
    low, high = there[np.maximum(after - 1, 0)], there[np.minimum(after, len(there) - 1)]
    share = np.clip((frames - low) / np.maximum(high - low, 1), 0.0, 1.0)
    return rot.slerp(turns[low, joint], turns[high, joint], share)


def measured(solver: Solver, places: FloatArray) -> tuple[FloatArray, Solver]:
    """The markers' places ``(M, 3)`` and the skeleton, fitted to the movement of some frames."""
    chosen = np.unique(np.linspace(0, len(solver.points) - 1, _SAMPLES).astype(np.int64))
    guess = (solver.guess[0][chosen], solver.guess[1][chosen])
    some = Solver(solver.skeleton, solver.points[chosen], solver.seen[chosen], solver.joints, guess)
    first = (solver.skeleton.offsets, places)
    for _ in range(_ROUNDS):
        roots, turns = some.poses(places, some.rest())
        motion = Motion(some.skeleton, roots, rot.normalize(turns), 1.0)
        offsets, places = _refined(some, motion, places, first)
        some = replace(some, skeleton=replace(some.skeleton, offsets=offsets))
    return places, replace(solver, skeleton=some.skeleton)


def _refined(
    solver: Solver, motion: Motion, places: FloatArray, first: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Bones ``(J, 3)`` and places ``(M, 3)`` that fit the markers best in given poses, near a first guess of both."""
    rows, misses = _linear(solver, motion, places)
    joints, marks = len(solver.skeleton), len(places)
    held = np.repeat([_CENTRE, _PLACE], [3 * joints, 3 * marks]) ** -2.0
    now = np.concatenate([solver.skeleton.offsets.reshape(-1), places.reshape(-1)])
    start = np.concatenate([first[0].reshape(-1), first[1].reshape(-1)])
    noise = _SKIN**2 * len(motion) / _INDEPENDENT
    matrix = rows.T @ rows / noise + np.diag(held)
    now = now + np.linalg.solve(matrix, rows.T @ misses / noise + held * (start - now))
    return now[: 3 * joints].reshape(-1, 3), now[3 * joints :].reshape(-1, 3)


def _linear(solver: Solver, motion: Motion, places: FloatArray) -> tuple[FloatArray, FloatArray]:
    """How markers move with each bone and place, ``(3 F M, 3 J + 3 M)``, and what they miss, ``(3 F M,)``."""
    positions, turns = forward(motion)
    matrices = rot.to_matrix(turns)
    joints, marks = len(solver.skeleton), len(places)
    size = 3 * (joints + marks)
    found = positions[:, solver.joints] + np.einsum("fmab,mb->fma", matrices[:, solver.joints], places)
    rows = np.zeros((len(positions), marks, 3, size))
    for mark, joint in enumerate(solver.joints.tolist()):
        rows[:, mark, :, 3 * (joints + mark) : 3 * (joints + mark) + 3] = matrices[:, joint]
        while (parent := int(solver.skeleton.parents[joint])) >= 0:
            rows[:, mark, :, 3 * joint : 3 * joint + 3] = matrices[:, parent]
            joint = parent
    # the root moves freely with each frame: only what differs between a frame's markers counts
    share = solver.seen / np.maximum(solver.seen.sum(axis=1, keepdims=True), 1)
    misses = np.where(solver.seen[..., None], solver.points - found, 0.0)
    misses = (misses - np.einsum("fm,fma->fa", share, misses)[:, None]) * solver.seen[..., None]
    rows = (rows - np.einsum("fm,fmas->fas", share, rows)[:, None]) * solver.seen[..., None, None]
    return np.asarray(rows).reshape(-1, size), np.asarray(misses).reshape(-1)
