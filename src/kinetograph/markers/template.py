"""A body fitted to any set of markers that a table places on a reference body.

The reference body is scaled, first as a whole by the distances of markers on one segment, then segment by segment, left
and right alike, by linear least squares to poses of some frames. Bones and places are then measured as for every set.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.markers.alignment import aligned
from kinetograph.markers.sets import Place, reference_body
from kinetograph.markers.solver import Solver, derivatives, sampled
from kinetograph.markers.tips import with_tips
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton

_APART = 0.06  # metres: markers on one segment that are nearer say little on its size
_LEG = 0.83  # metres: the length of the reference body's leg
_SIZES = (0.3, 2.0)  # of the reference body, that people have
_ROUNDS = 4
_ALIKE = 0.1  # how much the scales of segments differ from that of the whole: a standard deviation
_OFF = 0.02  # metres: standard deviation of places on segments of the right size
_TRUNK = {"spine": "trunk", "chest": "trunk", "neck": "trunk", "toe": "foot"}


def first_body(places: Sequence[Place], points: FloatArray) -> tuple[Solver, FloatArray, FloatArray]:
    """A first estimate of a body, and where its markers are.

    Parameters
    ----------
    places : sequence of Place
        One a marker.
    points : ndarray, shape (F, M, 3)
        Metres, Y up, NaN where they are not seen.

    Returns
    -------
    solver : Solver
    places : ndarray, shape (M, 3)
        In the frames of their joints, metres.
    spread : ndarray, shape (M,)
        Standard deviations of these, metres.

    Raises
    ------
    RequestError
        Markers are too few or too far apart.
    """
    skeleton = _worn(places)
    joints = np.array([skeleton.index(place.segment) for place in places], dtype=np.int64)
    at, spread = np.array([place.at for place in places]), np.array([place.spread for place in places])
    size = _size(joints, at, points)
    template = (skeleton.offsets * size, at * size)
    skeleton = replace(skeleton, offsets=template[0])
    seen = np.isfinite(points[..., 0])
    guess = aligned(skeleton, joints, template[1], points)
    solver = Solver(skeleton, np.nan_to_num(points), seen, joints, guess)
    offsets, at = _scaled(sampled(solver), template)
    skeleton = with_tips(replace(skeleton, offsets=offsets), _LEG * size)
    return replace(solver, skeleton=skeleton, guess=aligned(skeleton, joints, at, points)), at, spread * size


def _worn(places: Sequence[Place]) -> Skeleton:
    """The part of the reference body that markers are on: what is above them, and the joint below each."""
    body = reference_body()
    marked = {place.segment for place in places}
    kept = {0}
    for joint, name in enumerate(body.names):
        parent = int(body.parents[joint])
        if name in marked or (parent >= 0 and body.names[parent] in marked and name not in ("spine",)):
            while joint > 0:
                kept.add(joint)
                joint = int(body.parents[joint])
    order = sorted(kept)
    parents = np.array([order.index(int(body.parents[j])) if j else -1 for j in order])
    return Skeleton(tuple(body.names[j] for j in order), parents, body.offsets[order])


def _size(joints: IntArray, places: FloatArray, points: FloatArray) -> float:
    """The body's size in that of the reference, by the distances between markers on one segment."""
    ratios, weights = [], []
    for a in range(len(joints)):
        for b in np.flatnonzero(joints[a + 1 :] == joints[a]) + a + 1:
            there = float(np.linalg.norm(places[a] - places[b]))
            apart = np.linalg.norm(points[:, a] - points[:, b], axis=-1)
            if there > _APART and np.isfinite(apart).any():
                ratios.append(float(np.nanmedian(apart)) / there)
                weights.append(there)
    if not ratios:
        raise RequestError("no two markers of one segment are seen at once; the size of the body cannot be found")
    order = np.argsort(ratios)
    half = np.searchsorted(np.cumsum(np.array(weights)[order]), 0.5 * sum(weights))
    size = float(ratios[int(order[half])])
    if not _SIZES[0] < size < _SIZES[1]:
        raise RequestError(
            f"the markers are as far apart as on a body of {1.75 * size:.3g} m; give the file's units with --units"
        )
    return size


def _scaled(some: Solver, template: tuple[FloatArray, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Offsets ``(J, 3)`` and places ``(M, 3)`` of a template whose segments are scaled, left and right alike."""
    skeleton = some.skeleton
    parts = [name.rpartition("_")[2] for name in skeleton.names]
    parts = [_TRUNK.get(part, part) for part in parts]
    groups = list(dict.fromkeys(parts))
    offset_groups = np.array([groups.index(parts[max(int(parent), 0)]) for parent in skeleton.parents])
    place_groups = np.array([groups.index(parts[joint]) for joint in some.joints])
    which = np.concatenate([np.repeat(offset_groups, 3), np.repeat(place_groups, 3)])
    flat = np.concatenate([part.reshape(-1) for part in template])
    spread = np.zeros((len(flat), len(groups)))
    spread[np.arange(len(flat)), which] = flat
    scales, places = np.ones(len(groups)), template[1]
    for _ in range(_ROUNDS):
        roots, rotations = some.poses(places, some.rest())
        motion = Motion(some.skeleton, roots, rot.normalize(rotations), 1.0)
        rows, misses = derivatives(some, motion, places)
        rows, noise = rows @ spread, _OFF**2 * len(motion)
        matrix = rows.T @ rows / noise + np.eye(len(groups)) / _ALIKE**2
        scales = scales + np.linalg.solve(matrix, rows.T @ misses / noise + (1.0 - scales) / _ALIKE**2)
        offsets, places = template[0] * scales[offset_groups, None], template[1] * scales[place_groups, None]
        some = replace(some, skeleton=replace(some.skeleton, offsets=offsets))
    return some.skeleton.offsets, places
