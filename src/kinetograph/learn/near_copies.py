"""Sequences that are copies of others, or of parts of them, but for small differences.

Short windows, reduced to a few numbers, are looked up in a tree; windows of two sequences that are alike at one lag are
a candidate. A candidate is fitted in time (lag and speed) by least squares, and grown as far as the two go together.
What two fits of one performance differ by is nearly constant, so that a constant difference counts apart.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray

STRIDE, SAMPLES = 4, 4
"""Rows from one sample of a short window to the next, and how many there are."""
SPAN = STRIDE * (SAMPLES - 1)
EVERY = 5
"""Rows from one window that is looked up to the next."""
NEIGHBOURS = 24
"""Windows that are looked up for each at most."""
_Pairs = tuple[IntArray, IntArray]  # rows at which windows begin, of two sequences
_NUMBERS = 12
_FITTED = 64  # rows that are fitted at most, about
_SETTLED = 0.01  # rows
_ROUGHLY = 2.5  # half a row of lag is left
_SAMPLED = 20_000


@dataclass(frozen=True)
class Nearness:
    """What counts as a copy. Lengths are in the unit of the rows.

    Parameters
    ----------
    window : float
        Distance of two reduced windows up to which they make a candidate.
    varying : float
        Root mean square of what two copies differ by, but for a constant.
    constant : float
        Root mean square of the constant.
    share : float
        The part of a sequence's own movement that the difference has at most, as a ratio of squares.
    still : float
        Root mean square of velocities below which a window is not looked up.
    least : int
        Rows of a copy at least.
    speed : float
        By how much the speeds may differ, as a share.
    """

    window: float = 0.6
    varying: float = 0.045
    constant: float = 0.12
    share: float = 0.1
    still: float = 0.03
    least: int = 15
    speed: float = 0.1


@dataclass(frozen=True, eq=False)
class Sequences:
    """Rows of sequences, end to end: for each of some points a place and a velocity, six numbers.

    Parameters
    ----------
    rows : ndarray of float32, shape (N, 6 R)
    offsets : ndarray of int, shape (E + 1,)
    swap : ndarray of int, shape (R,)
        The point that each one is in the mirror image, in which the first of three coordinates changes its sign.
    """

    rows: SingleArray
    offsets: IntArray
    swap: IntArray

    def __len__(self) -> int:
        return len(self.offsets) - 1

    def of(self, number: int, mirrored: bool = False) -> SingleArray:
        """The rows of a sequence, or of its mirror image."""
        own = self.rows[self.offsets[number] : self.offsets[number + 1]]
        if not mirrored:
            return own
        image = own.reshape(len(own), -1, 6)[:, self.swap].copy()
        image[:, :, [0, 3]] *= -1
        return image.reshape(len(own), -1)


@dataclass(frozen=True)
class Match:
    """Where a sequence is a copy of another.

    Parameters
    ----------
    first, second : int
        The sequences.
    mirrored : bool
        Whether one is like the other's mirror image.
    start, stop : int
        Rows of the first: from ``start`` to before ``stop``.
    shift, speed : float
        Row ``t`` of the first is row ``speed * t + shift`` of the second.
    distance : float
        Root mean square of what they differ by.
    """

    first: int
    second: int
    mirrored: bool
    start: int
    stop: int
    shift: float
    speed: float
    distance: float


@dataclass(frozen=True, eq=False)
class Lookup:
    """Windows of sequences, reduced, in a tree."""

    sequences: Sequences
    mean: SingleArray
    pose: FloatArray
    window: FloatArray
    tree: cKDTree
    places: IntArray

    @classmethod
    def of(cls, sequences: Sequences) -> Lookup | None:
        """Every window of some sequences; None where all are too short."""
        mean = np.asarray(sequences.rows.mean(axis=0), dtype=np.float32)
        some = sequences.rows[:: max(len(sequences.rows) // _SAMPLED, 1)]
        pose = _axes(some - mean)
        parts = [_windows((sequences.of(each) - mean) @ pose) for each in range(len(sequences))]
        places = [np.stack([np.full(len(part), i), np.arange(len(part))], axis=1) for i, part in enumerate(parts)]
        long = np.concatenate(parts) if parts else np.zeros((0, 1))
        if not len(long):
            return None
        window = _axes(long)
        return cls(sequences, mean, pose, window, cKDTree(long @ window), np.concatenate(places))

    def reduced(self, rows: SingleArray) -> FloatArray:
        """The windows of a sequence."""
        return np.asarray(_windows((rows - self.mean) @ self.pose) @ self.window)


def _axes(rows: FloatArray | SingleArray) -> FloatArray:
    """The directions in which rows differ most."""
    some = np.asarray(rows[:: max(len(rows) // _SAMPLED, 1)], dtype=np.float64)
    return np.asarray(np.linalg.eigh(some.T @ some)[1][:, ::-1][:, :_NUMBERS])


def _windows(rows: FloatArray) -> FloatArray:
    count = max(len(rows) - SPAN, 0)
    return np.concatenate([rows[STRIDE * i : STRIDE * i + count] for i in range(SAMPLES)], axis=1)


def matches(
    lookup: Lookup, numbers: Sequence[int], nearness: Nearness | None = None, *, later: bool = False
) -> Iterator[Match]:
    """Where some sequences are copies of others.

    Parameters
    ----------
    lookup : Lookup
    numbers : sequence of int
        The sequences that are compared with all others.
    nearness : Nearness, optional
    later : bool
        Compare each with those after it only, so that a pair is found once.

    Yields
    ------
    Match
        The longest of every pair and side.
    """
    used = nearness or Nearness()
    for number in numbers:
        for mirrored in (False, True):
            own = lookup.sequences.of(number, mirrored)
            for other, lags in _candidates(lookup, number, own, used).items():
                if other == number or (later and other < number):
                    continue
                theirs = lookup.sequences.of(other)
                near = [pairs for pairs in lags if _worth(own, theirs, pairs, used)]
                best = _longest(own, theirs, near, used)
                if best:
                    yield Match(number, other, mirrored, *best)


def _candidates(lookup: Lookup, number: int, own: SingleArray, nearness: Nearness) -> dict[int, list[_Pairs]]:
    """By sequence, the windows that are alike at lags that several agree on."""
    reduced = lookup.reduced(own)[::EVERY]
    starts = np.flatnonzero(_moving(own, nearness.still)[: len(reduced) * EVERY : EVERY]) * EVERY
    if not len(starts):
        return {}
    asked = reduced[starts // EVERY]
    found_at = lookup.tree.query(asked, NEIGHBOURS, eps=0.5, distance_upper_bound=nearness.window)
    far, near = np.asarray(found_at[0]), np.asarray(found_at[1])
    kept = np.isfinite(far)
    begins = np.repeat(starts, kept.sum(axis=1))
    places = lookup.places[near[kept]]
    found: dict[int, list[_Pairs]] = {}
    for other in np.unique(places[:, 0]).tolist():
        of = places[:, 0] == other
        if other != number:
            found[other] = _agreeing((begins[of], places[of, 1]), len(own), len(lookup.sequences.of(other)))
    return {other: pairs for other, pairs in found.items() if pairs}


def _agreeing(pairs: _Pairs, own: int, other: int) -> list[_Pairs]:
    """The pairs of windows at each of the three lags that most agree on, within two rows."""
    begins, places = pairs
    lags = places - begins
    counted = Counter((lags // 2).tolist())
    for lag, votes in Counter((lags // 2 + 1).tolist()).items():
        counted[lag] += votes
    enough = 1 if min(own, other) < 2 * SPAN else 2
    agreeing = [np.abs(lags - 2 * lag) <= 2 for lag, votes in counted.most_common(3) if votes >= enough]
    different = {of.tobytes(): of for of in agreeing if of.any()}
    return [(begins[of], places[of]) for of in different.values()]


def _moving(rows: SingleArray, still: float) -> BoolArray:
    """Whether the window that begins at each row moves enough to tell it from others."""
    if len(rows) <= SPAN:
        return np.zeros(0, dtype=np.bool_)
    squares = np.square(rows.reshape(len(rows), -1, 6)[:, :, 3:]).sum(axis=2).mean(axis=1)
    sums = np.concatenate([[0.0], np.cumsum(squares, dtype=np.float64)])
    return np.asarray((sums[SPAN + 1 :] - sums[: -SPAN - 1]) / (SPAN + 1) > still**2)


def _longest(
    own: SingleArray, other: SingleArray, candidates: Sequence[_Pairs], nearness: Nearness
) -> tuple[int, int, float, float, float] | None:
    """The longest copy at some lags; a copy of nearly all is not looked for again."""
    best = None
    for pairs in candidates:
        found = _grown(own, other, pairs, nearness)
        if found and (best is None or found[1] - found[0] > best[1] - best[0]):
            best = found
        if best and best[1] - best[0] >= 0.9 * min(len(own), len(other)):
            break
    return best


def _worth(own: SingleArray, other: SingleArray, pairs: _Pairs, nearness: Nearness) -> bool:
    """Whether the windows of a candidate, as they are, are nearly as near as a copy's."""
    shift, speed = _guessed(pairs, nearness)
    rows = np.unique((pairs[0][:, None] + np.arange(0, SPAN + 1, 2)).ravel())
    _, gaps = _gaps(own, other, shift, speed, rows)
    return len(gaps) > 0 and _mean_square(gaps - gaps.mean(axis=0)) < (_ROUGHLY * nearness.varying) ** 2


def _grown(
    own: SingleArray, other: SingleArray, pairs: _Pairs, nearness: Nearness
) -> tuple[int, int, float, float, float] | None:
    """The copy around some windows: start, stop, shift, speed and distance; None where there is none."""
    start, stop = int(pairs[0].min()), int(pairs[0].max()) + SPAN + 1
    shift, speed = _guessed(pairs, nearness)
    for turn in range(3):
        shift, speed = _fitted(own, other, (start, stop), (shift, speed), turn > 0)
        if abs(speed - 1.0) > nearness.speed:
            return None
        rows, gaps = _gaps(own, other, shift, speed)
        inside = gaps[(rows >= start) & (rows < stop)]
        if len(inside) < nearness.least:
            return None
        apart = _smoothed(np.square(gaps - inside.mean(axis=0)).sum(axis=1) * 6 / own.shape[1])
        span = _around(apart < nearness.varying**2, (start + stop) // 2 - int(rows[0]))
        if span is None or span[1] - span[0] < nearness.least:
            return None
        start, stop = int(rows[0]) + span[0], int(rows[0]) + span[1]
    return _judged(own, (rows, gaps), (start, stop), (shift, speed), nearness)


def _guessed(pairs: _Pairs, nearness: Nearness) -> tuple[float, float]:
    """The lag and the speed that pairs of windows show."""
    begins, places = pairs
    if np.ptp(begins) < 3 * SPAN:
        return float(np.median(places - begins)), 1.0
    speed, shift = np.polyfit(begins, places, 1)
    if abs(speed - 1.0) > nearness.speed:
        return float(np.median(places - begins)), 1.0
    return float(shift), float(speed)


def _judged(
    own: SingleArray,
    apart: tuple[IntArray, FloatArray],
    span: tuple[int, int],
    timing: tuple[float, float],
    nearness: Nearness,
) -> tuple[int, int, float, float, float] | None:
    rows, gaps = apart
    inside = gaps[(rows >= span[0]) & (rows < span[1])]
    constant = _mean_square(inside.mean(axis=0, keepdims=True))
    varying = _mean_square(inside - inside.mean(axis=0))
    part = own[span[0] : span[1]]
    moved = _mean_square(part - part.mean(axis=0))
    if constant > nearness.constant**2 or varying > min(nearness.varying**2, nearness.share * moved):
        return None
    return *span, *timing, float(np.sqrt(constant + varying))


def _mean_square(gaps: FloatArray | SingleArray) -> float:
    return float(np.square(gaps).sum(axis=1).mean() * 6 / gaps.shape[1])


def _gaps(
    own: SingleArray, other: SingleArray, shift: float, speed: float, some: IntArray | None = None
) -> tuple[IntArray, FloatArray]:
    """The rows that have one in the other sequence, and what they differ by; velocities count at one speed."""
    asked = np.arange(len(own)) if some is None else some
    times: FloatArray = np.asarray(speed * asked + shift, dtype=np.float64)
    inside = (times >= -1e-9) & (times <= len(other) - 1 + 1e-9)
    rows = asked[inside]
    if not len(rows):
        return rows, np.zeros((0, own.shape[1]))
    theirs = _at(other, times[inside]).reshape(len(rows), -1, 6)
    theirs[:, :, 3:] *= speed
    return rows, own[rows] - theirs.reshape(len(rows), -1)


def _at(rows: SingleArray, times: FloatArray) -> FloatArray:
    """Rows at times between them, by cubic interpolation (Catmull and Rom)."""
    last = len(rows) - 1
    low = np.clip(np.floor(times).astype(np.int64), 0, max(last - 1, 0))
    t = (times - low)[:, None].astype(np.float32)
    before, after, beyond = (
        rows[np.maximum(low - 1, 0)],
        rows[np.minimum(low + 1, last)],
        rows[np.minimum(low + 2, last)],
    )
    here = rows[low]
    bent = t * (2 * before - 5 * here + 4 * after - beyond + t * (3 * (here - after) + beyond - before))
    return np.asarray(here + 0.5 * t * (after - before + bent), dtype=np.float64)


def _fitted(
    own: SingleArray, other: SingleArray, span: tuple[int, int], timing: tuple[float, float], speeds: bool
) -> tuple[float, float]:
    """The lag, and the speed if asked, at which a span of rows differs least, by Gauss and Newton's method."""
    shift, speed = timing
    some = np.arange(span[0], span[1], max((span[1] - span[0]) // _FITTED, 1))
    for _ in range(4):
        rows, gaps = _gaps(own, other, shift, speed, some)
        if len(rows) < 3:
            break
        times: FloatArray = np.asarray(speed * rows + shift, dtype=np.float64)
        slope = _at(other, np.clip(times + 0.5, 0, len(other) - 1)) - _at(
            other, np.clip(times - 0.5, 0, len(other) - 1)
        )
        middle = rows.mean()
        columns = [slope, slope * (rows - middle)[:, None]] if speeds else [slope]
        centred = np.stack([(column - column.mean(axis=0)).ravel() for column in columns])
        gain = centred @ centred.T
        steps = np.linalg.solve(gain + 1e-9 * np.eye(len(gain)), centred @ (gaps - gaps.mean(axis=0)).ravel())
        faster = float(np.clip(steps[1], -0.05, 0.05)) if speeds else 0.0
        shift, speed = shift + float(np.clip(steps[0], -1, 1)) - faster * middle, speed + faster
        if abs(steps[0]) < _SETTLED:
            break
    return float(shift), float(speed)


def _smoothed(values: FloatArray, width: int = 5) -> FloatArray:
    """Running means, over fewer at the ends."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    low = np.maximum(np.arange(len(values)) - width // 2, 0)
    high = np.minimum(np.arange(len(values)) + width // 2 + 1, len(values))
    return np.asarray((sums[high] - sums[low]) / (high - low))


def _around(good: BoolArray, middle: int) -> tuple[int, int] | None:
    """The run of rows around a row, or the longest one."""
    if not good.any():
        return None
    edges = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(np.int8)))
    runs = list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
    own = [run for run in runs if run[0] <= middle < run[1]]
    return max(own or runs, key=lambda run: run[1] - run[0])


def joined(found: Sequence[Match]) -> tuple[Match, ...]:
    """The longest match of each pair of sequences, mirrored or not; of two as long, the nearer."""
    by_pair: dict[tuple[int, int], list[Match]] = defaultdict(list)
    for each in found:
        by_pair[min(each.first, each.second), max(each.first, each.second)].append(each)
    return tuple(
        max(of, key=lambda each: (each.stop - each.start, -each.distance)) for _, of in sorted(by_pair.items())
    )
