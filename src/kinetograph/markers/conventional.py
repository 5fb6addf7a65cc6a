"""The first estimate of a body that wears Plug-in-Gait markers, from joint centres and axes in single frames."""

from __future__ import annotations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.markers.plug_in_gait import MARKERS, Segment, leg_length, segments
from kinetograph.markers.solver import Solver
from kinetograph.markers.tips import with_tips
from kinetograph.skeleton import Skeleton


def conventional_body(names: list[str], points: FloatArray) -> tuple[Solver, FloatArray, list[int]]:
    """A first estimate of a body, and where its markers are.

    Parameters
    ----------
    names : list of str
        Of the set.
    points : ndarray, shape (F, M, 3)
        Metres, Y up, NaN where they are not seen.

    Returns
    -------
    solver : Solver
    places : ndarray, shape (K, 3)
        In the frames of their joints, metres.
    used : list of int
        The K markers that are on segments of the body: arms, head and trunk come with all of theirs.

    Raises
    ------
    RequestError
        No frame shows enough markers at once, or they are not as far apart as on a body.
    """
    body = segments({name: points[:, i] for i, name in enumerate(names)})
    used = [i for i, name in enumerate(names) if _segment_of(name) in body]
    names, points = [names[i] for i in used], points[:, used]
    seen = np.isfinite(points[..., 0])
    solver = Solver(_skeleton(body, names, points), np.nan_to_num(points), seen, _joints(body, names), _guess(body))
    return solver, _places(body, names, points), used


def _segment_of(name: str) -> str:
    return next(segment for segment, group in MARKERS.items() if name in group)


def _joints(body: dict[str, Segment], names: list[str]) -> IntArray:
    order = list(body)
    return np.array([order.index(_segment_of(name)) for name in names], dtype=np.int64)


def _in_axes(segment: Segment, points: FloatArray, name: str) -> FloatArray:
    """The median place, ``(3,)``, of points ``(F, 3)`` on a segment."""
    local = np.einsum("fba,fb->fa", segment.axes, points - segment.origin)
    known = local[np.isfinite(local).all(axis=1)]
    if len(known) == 0:
        raise RequestError(f"no frame shows {name} together with the markers next to it; too much is hidden")
    return np.asarray(np.median(known, axis=0))


def _places(body: dict[str, Segment], names: list[str], points: FloatArray) -> FloatArray:
    """Where the markers are on their segments, ``(M, 3)``."""
    return np.array([_in_axes(body[_segment_of(name)], points[:, i], name) for i, name in enumerate(names)])


def _skeleton(body: dict[str, Segment], names: list[str], points: FloatArray) -> Skeleton:
    order = list(body)
    parents = np.array([order.index(segment.parent) if segment.parent else -1 for segment in body.values()])
    offsets = np.zeros((len(order), 3))
    for i, (name, segment) in enumerate(body.items()):
        if segment.parent:
            offsets[i] = _in_axes(body[segment.parent], segment.origin, f"the joint {name}")
    leg = leg_length({name: points[:, i] for i, name in enumerate(names)})
    return with_tips(Skeleton(tuple(order), parents, offsets), leg)


def _guess(body: dict[str, Segment]) -> tuple[FloatArray, FloatArray]:
    """Every frame's pose from its own markers: roots ``(F, 3)`` and local rotations ``(F, J, 4)``.

    Where markers are missing, a joint is in its rest pose and the root as in the frame before.
    """
    frames = np.arange(len(body["hips"].origin))
    known = np.flatnonzero(np.isfinite(body["hips"].axes).all(axis=(1, 2)))
    held = known[np.maximum(np.searchsorted(known, frames, side="right") - 1, 0)]
    world: dict[str, FloatArray] = {"": np.broadcast_to(np.eye(3), (len(frames), 3, 3))}
    local = []
    for name, segment in body.items():
        above = world[segment.parent]
        own = segment.axes if segment.parent else segment.axes[held]
        world[name] = np.where(np.isfinite(own.sum(axis=(1, 2), keepdims=True)), own, above)
        local.append(rot.from_matrix(np.einsum("fba,fbc->fac", above, world[name])))
    return body["hips"].origin[held], np.stack(local, axis=1)
