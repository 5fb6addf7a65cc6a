"""Standing: where a path stands still for longer than people in the recordings do, one of their calm poses is held."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.kinematics import joint_positions, on_ground, role_positions
from kinetograph.learn import Arrivals, SegmentalPath
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.segments import Segment, Source
from kinetograph.motion import Motion
from kinetograph.rows import LatestRows
from kinetograph.segmentation import runs
from kinetograph.synthesis import Piece

POSES = 8
"""Poses of a library that may be held."""
APART = 1.0
"""Seconds between two of them in one recording."""
CALM = 0.3
"""Seconds over which speeds are taken."""
STANDS = 0.3
"""Metres per second: the joints of people who stand move by less in the mean."""
STILL = 0.05
"""Metres per second below which a path stands."""
REACH = 0.3
"""Seconds before and after over which that is measured."""
LONG = 2.0
"""Seconds that a path stands for at least where a pose is held: recorded pauses fill what is shorter."""
PRICE = 0.0005
"""What it costs to hold a pose, m^2 s per second: pauses that were recorded are used first."""


def calm_candidates(sources: Sequence[Source]) -> Iterator[tuple[float, Segment]]:
    """The poses that may be held, and how calm they are: with both feet on the floor, and close together."""
    for place, source in enumerate(sources):
        for score, second in calm_moments(source):
            yield score, Segment(place, second, second)


def calmest(found: Iterable[tuple[float, Segment]]) -> list[tuple[float, Segment]]:
    """The calmest of some poses, with how calm they are."""
    return sorted(found, key=lambda each: each[0])[:POSES]


def calm_moments(source: Source) -> Iterator[tuple[float, float]]:
    """A recording's calm poses, the calmest first: how calm, and the second."""
    motion = source.motion
    toes = on_ground(role_positions(motion, ("left_toe", "right_toe")))
    score = mean_speed(motion) + np.linalg.norm(toes[:, 0] - toes[:, 1], axis=-1)
    score[~_planted(source)] = np.inf
    for _ in range(POSES):
        frame = int(np.argmin(score))
        if not np.isfinite(score[frame]):
            return
        yield float(score[frame]), frame / motion.fps
        reach = round(APART * motion.fps)
        score[max(frame - reach, 0) : frame + reach + 1] = np.inf


def mean_speed(motion: Motion) -> FloatArray:
    """How fast the joints of a motion move in the mean, metres per second ``(F,)``, over `CALM` seconds."""
    if len(motion) < 2:
        return np.zeros(len(motion))
    velocity = np.gradient(joint_positions(motion), 1 / motion.fps, axis=0)
    return uniform_filter1d(np.linalg.norm(velocity, axis=-1).mean(axis=1), max(round(CALM * motion.fps), 1))


def _planted(source: Source) -> BoolArray:
    """The frames ``(F,)`` of a recording with a contact of each side, within the middle cycle of one that loops."""
    times = np.arange(len(source.motion)) / source.motion.fps
    planted = np.ones(len(times), dtype=np.bool_)
    if source.period:
        planted &= (times >= source.period) & (times < 2 * source.period)
    for side in ("left", "right"):
        notes = [n for n in source.annotations if n.kind == "contact" and n.label.startswith(side)]
        planted &= np.any([(times >= n.start) & (times <= n.stop) for n in notes], axis=0) if notes else False
    return planted


def standing(x: FloatArray, rate: float) -> BoolArray:
    """The samples ``(T + 1,)`` at which control points ``(T + 1, P, 3)`` stand still, for `LONG` at least."""
    reach = max(round(REACH * rate), 1)
    calm = uniform_filter1d(x, 2 * reach + 1, axis=0, mode="nearest")
    padded = np.pad(calm, [(reach, reach), (0, 0), (0, 0)], mode="edge")
    moved = np.linalg.norm(padded[2 * reach :] - padded[: -2 * reach], axis=-1).max(axis=1)
    still = moved * rate < STILL * 2 * reach
    stands = np.zeros(len(x), dtype=np.bool_)
    for start, stop in runs(still):
        if stop - start > min(LONG * rate, len(x) - 1):
            stands[start:stop] = True
    return stands


def only_standing(fitted: Fitted, x: FloatArray, arrivals: Iterable[Arrivals]) -> Iterable[Arrivals]:
    """The arrivals of steps 1, 2, ... with poses held, at their price, only where ``x`` ``(T + 1, P, 3)`` stands."""
    if not fitted.instances.held.any():
        yield from arrivals
        return
    moving = np.concatenate([[0], np.cumsum(~standing(x, fitted.settings.rate))])
    spans = fitted.search.durations[fitted.instances.held]
    for time, arrival in enumerate(arrivals, start=1):
        used = np.minimum(spans, time)
        yield _held(fitted, arrival, moving[time + 1] == moving[time - used], used)


def only_standing_early(fitted: Fitted, x: FloatArray, partial: dict[int, Arrivals]) -> dict[int, Arrivals]:
    """The same for segments left early where ``x`` ends."""
    if not fitted.instances.held.any():
        return partial
    stands = standing(x, fitted.settings.rate)
    held = {}
    for used, arrival in partial.items():
        legal = np.full(int(fitted.instances.held.sum()), stands[-used - 1 :].all())
        held[used] = _held(fitted, arrival, legal, np.full(len(legal), used))
    return held


def _held(fitted: Fitted, arrival: Arrivals, legal: BoolArray, used: IntArray) -> Arrivals:
    costs, held = arrival.costs.copy(), fitted.instances.held
    costs[held] = np.where(legal, costs[held] + PRICE * used / fitted.settings.rate, np.inf)
    return replace(arrival, costs=costs)


def only_standing_now(fitted: Fitted, samples: LatestRows, arrival: Arrivals, origins: IntArray) -> Arrivals:
    """The arrivals of the latest step of a control that still arrives: poses are held once it has stood for `LONG`.

    Parameters
    ----------
    fitted : Fitted
    samples : LatestRows
        The control so far, ``(P, 3)`` each.
    arrival : Arrivals
    origins : ndarray of int, shape (S,)
        The first steps of the states.
    """
    if not fitted.instances.held.any():
        return arrival
    rate = fitted.settings.rate
    count = int(np.ceil(LONG * rate)) + 2
    first = len(samples) - count
    stands = first >= 0 and bool(standing(samples.since(first), rate).all())
    used = len(samples) - 1 - np.maximum(origins[fitted.instances.held], 0)
    return _held(fitted, arrival, stands & (origins[fitted.instances.held] >= first), used)


def joined_holds(fitted: Fitted, path: SegmentalPath) -> SegmentalPath:
    """A sequence in which a pose that is held several times running is held once, for as long."""
    segments = fitted.instances.states[path.states, 0]
    ends = np.flatnonzero(np.append((segments[1:] != segments[:-1]) | ~fitted.instances.held[path.states[:-1]], True))
    firsts = np.concatenate([[0], ends[:-1] + 1])
    return replace(path, states=path.states[ends], starts=path.starts[firsts], stops=path.stops[ends])


def standing_warnings(fitted: Fitted, pieces: Sequence[Piece]) -> tuple[str, ...]:
    """What a person should know of the poses that are held."""
    held = [piece for piece in pieces if piece.held]
    if not held:
        return ()
    longest, seconds = max(held, key=lambda piece: piece.stop - piece.start), sum(p.stop - p.start for p in held)
    says = (
        f"the path stands still for long: poses are held for {seconds:.1f} s, breathing, "
        f"the longest from {longest.take} at {longest.source_start:.2f} s"
    )
    motion = next(source.motion for source in fitted.sources if source.take == longest.take)
    if mean_speed(motion)[round(longest.source_start * motion.fps)] < STANDS:
        return (says,)
    return (f"{says}; nobody in the recordings stands, so that it is a pose of walking: add a recording of standing",)
