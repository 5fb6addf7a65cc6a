"""Fewer segments: one for every cluster of like ones (Hsu 2004, section 4.4.2)."""

from __future__ import annotations

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.learn import complete_linkage, representatives
from kinetograph.methods.performance.segments import Segment, Source
from kinetograph.methods.performance.settings import PerformanceSettings
from kinetograph.sampling import interpolate

SAMPLES = 16
"""Samples of a segment that are compared."""
PAIR = 120
"""Bytes that a pair of segments takes while all are compared."""
MOST = 2_000_000_000
"""Bytes that clustering may take."""


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
    rows = []
    for segment in segments:
        source = sources[segment.source]
        at = np.linspace(segment.start, segment.stop, SAMPLES) * source.motion.fps
        both = [interpolate(source.control_points, at), interpolate(source.target_points, at)]
        rows.append(np.concatenate(both, axis=1))
    points = np.stack(rows)
    weights = np.full(points.shape[1:3], 1.0 / (SAMPLES * points.shape[2]))
    squares, _ = settings.alignment.align(points, points, weights)
    durations = np.array([s.duration for s in segments])
    apart = np.abs(durations[:, None] - durations) > max(settings.stretch, 1e-9)
    distances = np.sqrt(0.5 * (squares + squares.T))
    np.fill_diagonal(distances, 0.0)
    return np.where(apart, np.inf, distances)


def cluster_segments(
    sources: tuple[Source, ...],
    segments: tuple[Segment, ...],
    settings: PerformanceSettings,
    rng: np.random.Generator | None = None,
) -> tuple[Segment, ...]:
    """The segments that represent the clusters: medoids, or random ones given ``rng``.

    Raises RequestError, before anything is compared, for more segments than `MOST` bytes have room for.
    """
    taken, room = PAIR * len(segments) ** 2, int((MOST / PAIR) ** 0.5)
    if taken > MOST:
        raise RequestError(
            f"clustering compares all pairs of segments: {len(segments)} take {taken / 1e9:.1f} GB, and at most "
            f"{MOST / 1e9:g} GB are allowed, {room} segments; choose fewer takes, or leave clustering out: a large "
            "library is searched exactly without it"
        )
    distances = segment_distances(sources, segments, settings)
    labels = complete_linkage(distances, settings.cluster or 0.0)
    return tuple(segments[int(i)] for i in representatives(distances, labels, rng))
