"""Fewer segments: one for every cluster of like ones (Hsu 2004, section 4.4.2).

All pairs whose durations a stretch can bring together are compared, in tiles; only those within the threshold are kept.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from time import process_time

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.learn import Alignment, ClosePairs, Fixed, Ground, Rigid, linked
from kinetograph.methods.performance.segments import Segment, Source
from kinetograph.methods.performance.settings import PerformanceSettings
from kinetograph.sampling import interpolate

SAMPLES = 16
"""Samples of a segment that are compared."""
PAIR = 36
"""Bytes that a pair within the threshold takes."""
MOST = 2_000_000_000
"""Bytes that clustering may take."""
LONGEST = 60.0
"""Seconds of processor time that clustering may take."""
TILE = (128, 2048)
"""Segments that are compared with so many others at a time."""
SYMMETRIC = (Ground, Rigid, Fixed)
"""Groups in which it is as far one way as the other."""
TRIED = (4096, 8, 32)
"""From so many segments on, so many times so many are compared first, to estimate what all would take."""


@dataclass(frozen=True, eq=False)
class Compared:
    """Segments made ready to be compared, by duration.

    Parameters
    ----------
    points : ndarray, shape (N, SAMPLES, P, 3)
        Control and target points, metres.
    durations : ndarray, shape (N,)
        Seconds, ascending.
    order : ndarray of int, shape (N,)
        Which segment each is.
    alignment : Alignment
    stretch : float
        Seconds by which durations may differ.
    """

    points: FloatArray
    durations: FloatArray
    order: IntArray
    alignment: Alignment
    stretch: float

    @classmethod
    def of(cls, sources: tuple[Source, ...], segments: tuple[Segment, ...], settings: PerformanceSettings) -> Compared:
        """The segments of some sources."""
        durations = np.array([s.duration for s in segments])
        order = np.argsort(durations, kind="stable")
        points = np.stack([_samples(sources[segments[i].source], segments[i]) for i in order])
        return cls(points, durations[order], order, settings.alignment, max(settings.stretch, 1e-9))

    def between(self, rows: IntArray, columns: IntArray, both: bool = True) -> FloatArray:
        """Root-mean-square distances ``(B, N)``, metres; infinite where no stretch can bring durations together.

        The mean of aligning each with the other, ``both`` worked out even where they differ by no more than rounding.
        """
        x, a = self.points[rows], self.points[columns]
        weights = np.full(x.shape[1:3], 1.0 / (SAMPLES * x.shape[2]))
        squares, _ = self.alignment.align(x, a, weights)
        if both or not isinstance(self.alignment, SYMMETRIC):
            squares = 0.5 * (squares + self.alignment.align(a, x, weights)[0].T)
        distances = np.sqrt(squares)
        apart = np.abs(self.durations[rows][:, None] - self.durations[columns]) > self.stretch
        distances[apart] = np.inf
        distances[rows[:, None] == columns] = 0.0
        return distances

    def reach(self) -> IntArray:
        """Before which each segment's ``(N,)`` durations are within the stretch, to within rounding."""
        return np.searchsorted(self.durations, self.durations + self.stretch * (1 + 1e-9), side="right")


def segment_distances(
    sources: tuple[Source, ...], segments: tuple[Segment, ...], settings: PerformanceSettings
) -> FloatArray:
    """Root-mean-square distances between segments.

    Control and target points are compared together, after the best alignment (4.1), both segments stretched to one
    length. Segments whose durations no stretch can bring together are infinitely far apart.

    Parameters
    ----------
    sources : tuple of Source
    segments : tuple of Segment
    settings : PerformanceSettings

    Returns
    -------
    ndarray, shape (N, N)
        Metres.
    """
    compared = Compared.of(sources, segments, settings)
    place = np.argsort(compared.order)
    return compared.between(place, place)


def cluster_segments(
    sources: tuple[Source, ...],
    segments: tuple[Segment, ...],
    settings: PerformanceSettings,
    rng: np.random.Generator | None = None,
) -> tuple[Segment, ...]:
    """The segments that represent the clusters: medoids, or random ones given ``rng``.

    Raises RequestError, before they are compared, for segments that would take more than `MOST` bytes or `LONGEST`
    seconds.
    """
    compared, threshold = Compared.of(sources, segments, settings), settings.cluster or 0.0
    if len(segments) >= TRIED[0]:
        require_room(compared, threshold)
    labels = linked(ClosePairs.of(len(segments), close_pairs(compared, threshold)))
    return tuple(segments[i] for i in sorted(represented(compared, labels, rng)))


def close_pairs(compared: Compared, threshold: float) -> Iterator[tuple[IntArray, IntArray, FloatArray]]:
    """The pairs within a threshold, and their distances, a tile after another."""
    count, reach = len(compared.durations), compared.reach()
    for low in range(0, count, TILE[0]):
        yield from _close_to(compared, np.arange(low, min(low + TILE[0], count)), reach, threshold)


def _close_to(
    compared: Compared, rows: IntArray, reach: IntArray, threshold: float
) -> Iterator[tuple[IntArray, IntArray, FloatArray]]:
    """The pairs within a threshold of some segments in a row with those after them."""
    for low in range(rows[0], reach[rows[-1]], TILE[1]):
        columns = np.arange(low, min(low + TILE[1], reach[rows[-1]]))
        distances = compared.between(rows, columns, both=False)
        i, j = np.nonzero((distances <= threshold) & (rows[:, None] < columns))
        yield rows[i], columns[j], distances[i, j]


def require_room(compared: Compared, threshold: float) -> None:
    """Refuse segments of which all pairs would take too much memory or time, as told from those of a few."""
    count, reach = len(compared.durations), compared.reach()
    compared.between(np.arange(2), np.arange(2))  # compiles
    began, close, tried = process_time(), 0, 0
    for low in np.linspace(0, count - TRIED[2], TRIED[1]).astype(np.int64):
        rows = np.arange(low, low + TRIED[2])
        close += sum(len(i) for i, _, _ in _close_to(compared, rows, reach, threshold))
        tried += int(np.sum(reach[rows] - rows))
    pairs = int(np.sum(reach - np.arange(count)))
    spent, taken = (process_time() - began) * pairs / tried, PAIR * close * pairs / tried
    if taken > MOST or spent > LONGEST:
        raise RequestError(
            f"clustering would compare {pairs / 1e6:.0f} million pairs of {count} segments, which takes about "
            f"{spent:.0f} s and {taken / 1e9:.1f} GB, and at most {LONGEST:g} s and {MOST / 1e9:g} GB are allowed; "
            "choose fewer takes or a smaller distance, or leave clustering out: a large library is searched exactly "
            "without it"
        )


def represented(compared: Compared, labels: IntArray, rng: np.random.Generator | None) -> list[int]:
    """One segment of each cluster, numbered as they came: the medoid, or a random one given ``rng``."""
    clusters: dict[int, list[int]] = {}
    for place in np.argsort(compared.order):
        clusters.setdefault(int(labels[place]), []).append(int(place))
    if rng is not None:
        return [int(compared.order[rng.choice(np.array(members))]) for members in clusters.values()]
    return [int(compared.order[medoid(compared, np.array(members))]) for members in clusters.values()]


def medoid(compared: Compared, members: IntArray) -> int:
    """The member with the least sum of distances to the others, the first of such."""
    if len(members) <= 2:
        return int(members[0])
    tiles = [members[low : low + TILE[0]] for low in range(0, len(members), TILE[0])]
    return int(members[np.argmin(np.concatenate([compared.between(rows, members).sum(axis=1) for rows in tiles]))])


def _samples(source: Source, segment: Segment) -> FloatArray:
    """Control and target points ``(SAMPLES, P, 3)`` of a segment."""
    at = np.linspace(segment.start, segment.stop, SAMPLES) * source.motion.fps
    both = [interpolate(source.control_points, at), interpolate(source.target_points, at)]
    return np.concatenate(both, axis=1)
