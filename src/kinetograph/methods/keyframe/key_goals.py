"""From keys to the goals of the timed search, and whether there is time enough between them."""

from __future__ import annotations

import itertools

import numpy as np

from kinetograph.arrays import BoolArray, IntArray
from kinetograph.errors import RequestError, TooSoonError, UnmetError
from kinetograph.keys import Key
from kinetograph.learn import Goal, least_interval
from kinetograph.methods.keyframe.features import nearest_frames
from kinetograph.methods.keyframe.index import PoseIndex
from kinetograph.methods.keyframe.key_parts import Aim, out_of_reach
from kinetograph.motion import Motion, heading_at
from kinetograph.post.part_targets import MISSED, TWISTED, are_met, misses
from kinetograph.post.reaching import reach_parts

MORE = 4
"""How many times more frames are tried for a key of a few parts."""


def goals_of(
    index: PoseIndex,
    aims: tuple[Aim, ...],
    *,
    candidates: int,
    slack: float,
    scale: float,
    reach: tuple[float, float],
) -> tuple[list[Goal], list[float]]:
    """What keys ask of the search.

    Parameters
    ----------
    index : PoseIndex
    aims : tuple of Aim
        One per key.
    candidates : int
        Frames tried for each key; `MORE` times as many for one of a few parts, which are moved to where it has them.
    slack : float
        Metres by which a candidate may be further off than the nearest frame.
    scale : float
        Metres between a key and a recorded frame that cost 1.
    reach : tuple of float
        Metres, and share of the distance between two pinned places, that a route may end away from a place.

    Returns
    -------
    goals : list of Goal
        One per key.
    nearest : list of float
        Metres between each key and the recorded pose that is nearest to it.

    Raises
    ------
    RequestError
        Where no recorded pose brings a key's parts to their places, with how near they come.
    """
    goals, nearest = [], []
    before: complex | None = None
    for number, aim in enumerate(aims):
        key, most = aim.key, candidates * (1 if aim.whole else MORE)
        frames, distances = nearest_frames(index.features, key, index.skeleton, index.barred, most=most, slack=slack)
        nearest.append(float(distances.min()))
        if aim.targets and not aim.whole:
            met = _that_reach(index, aim, frames)
            frames, distances = frames[met], distances[met]
        costs = (distances / scale) ** 2
        place, heading = pinned(key, first=number == 0)
        path = 0.0 if place is None or before is None else abs(place - before)
        window = _window(key, index.fps, first=number == 0)
        goals.append(Goal(frames, costs, window, place, heading, reach[0] + reach[1] * path, offset=aim.offset))
        before = place if place is not None else before
    return goals, nearest


def _that_reach(index: PoseIndex, aim: Aim, frames: IntArray) -> BoolArray:
    """Which frames have poses that bring the parts of a key to their places."""
    apart, twisted = misses(reach_parts(poses_at(index, frames), aim.targets), aim.targets)
    met = are_met(apart, twisted)
    if not met.any():
        least = int(np.argmin(np.maximum(apart / MISSED, twisted / TWISTED).max(axis=1)))
        what = out_of_reach(aim.key.label, index.skeleton, aim.targets, apart[least], twisted[least])
        raise UnmetError(what, aim.key.label)
    return met


def poses_at(index: PoseIndex, frames: IntArray) -> Motion:
    """The poses of some frames of an index, one after another."""
    owner = np.searchsorted(index.offsets, frames, side="right") - 1
    at = frames - index.offsets[owner]
    pairs = list(zip((index.examples[o].motion for o in owner), at, strict=True))
    root = np.stack([motion.translation[frame] for motion, frame in pairs])
    rotations = np.stack([motion.rotations[frame] for motion, frame in pairs])
    return Motion(index.skeleton, root, rotations, index.fps)


def pinned(key: Key, *, first: bool) -> tuple[complex | None, float | None]:
    """Where a key is on the ground, z + i x, and its heading; None where that is free.

    A first key that gives neither stands where it does in its clip.
    """
    place = None if key.position is None else complex(key.position[1], key.position[0])
    heading = key.heading
    if first:
        x, _, z = key.clip.translation[key.frame]
        place = complex(z, x) if place is None else place
        heading = heading_at(key.clip, key.frame) if heading is None else heading
    return place, heading


def _window(key: Key, fps: float, *, first: bool) -> tuple[float, float]:
    """The earliest and latest frame of the result at which a key is to be met."""
    if first or key.time is None:
        return (0.0, 0.0) if first else (0.0, np.inf)
    low, high = key.time
    if low == high:
        return float(round(low * fps)), float(round(low * fps))
    return float(np.ceil(low * fps - 1e-6)), float(np.floor(high * fps + 1e-6))


def require_time(
    index: PoseIndex, keys: tuple[Key, ...], goals: list[Goal], *, warp: float, longest: float, meet: float
) -> None:
    """Raise RequestError, with the least duration, where keys leave less time between them than recordings take.

    Parameters
    ----------
    index : PoseIndex
    keys : tuple of Key
    goals : list of Goal
        Those of the keys.
    warp : float
        Largest share by which an interval may be squeezed in time.
    longest : float
        Seconds of the longest interval.
    meet : float
        Metres within which poses meet; for the error's text.
    """
    earliest = 0.0
    for (a, b), (before, after) in zip(itertools.pairwise(goals), itertools.pairwise(keys), strict=True):
        between = f"from {before.label} to {after.label}"
        steps = _least_steps(index, a, b, warp)
        if not np.isfinite(steps):
            raise RequestError(
                f"no recordings lead {between}: nowhere do poses and velocities meet within {meet:g} m; "
                "add a recording that goes between, or raise meet"
            )
        quick = np.ceil(steps * (1 - warp))
        if b.window[1] < earliest + quick - 1e-9:
            asked = (b.window[1] - earliest) / index.fps
            raise TooSoonError(
                f"{between} takes {quick / index.fps:.2f} s at least ({steps / index.fps:.2f} s of recordings, "
                f"{warp:.0%} faster), and {asked:.2f} s are given; give it more time",
                after.label,
                float(quick / index.fps - asked),
            )
        if steps > longest * index.fps:
            raise RequestError(
                f"{between} takes {steps / index.fps:.2f} s at least, and an interval between two keys may last "
                f"{longest:g} s; raise longest"
            )
        earliest = max(earliest + quick, b.window[0])


def _least_steps(index: PoseIndex, before: Goal, after: Goal, warp: float) -> float:
    """The least steps of an interval, infinite where no recordings lead there."""
    steps = least_interval(index.graph, before, after, (after.window[1] - before.window[0]) * (1 + warp))
    # if it takes more than there is room for, if there is a route at all, the error says how much
    return steps if np.isfinite(steps) else least_interval(index.graph, before, after)
