"""Which segments belong together, and which are out of the ordinary: what a path is preferably performed by.

In a library of everything, a path that several recordings explain is performed by one person in one style, and walked
rather than danced: a change of either costs a little, and so does motion that is not everyday.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.kinematics import velocities
from kinetograph.methods.everyday import WALKING, everyday_frames
from kinetograph.methods.performance.control_points import GroundPath
from kinetograph.methods.performance.segments import Segment, Source
from kinetograph.methods.performance.settings import PerformanceSettings
from kinetograph.motion import Motion

UPRIGHT = replace(WALKING, tilt=float(np.radians(12.0)))
"""How people are carried who walk along a path: in takes of walking, trunks are within 10 degrees of upright."""
RUN = 2.0
"""Metres per second from which on people who are carried as runners are; slower, they lean and do something else."""
ANYONE = -1
"""The origin of a pose that is held: whoever it is, nothing changes."""


def origins_of(sources: Sequence[Source], segments: Sequence[Segment]) -> IntArray | None:
    """A number for the person and the style of each segment, the same where both are; None where all are the same.

    The style is the label of an annotation of the kind ``style`` in the middle of a segment and, besides, the tags of
    its take.

    Parameters
    ----------
    sources : sequence of Source
    segments : sequence of Segment

    Returns
    -------
    ndarray of int, shape (N,), or None
        `ANYONE` for a pose that is held.
    """
    numbers: dict[tuple[str, frozenset[str], tuple[str, ...]], int] = {}
    origins = np.full(len(segments), ANYONE, dtype=np.int64)
    for place, segment in enumerate(segments):
        source = sources[segment.source]
        if not segment.held:
            key = (source.person, source.tags, _styles(source, segment))
            origins[place] = numbers.setdefault(key, len(numbers))
    return origins if len(numbers) > 1 else None


def _styles(source: Source, segment: Segment) -> tuple[str, ...]:
    """The labels of the styles in the middle of a segment."""
    middle = 0.5 * (segment.start + segment.stop)
    middle = middle % source.period if source.period else middle
    styles = (note for note in source.annotations if note.kind == "style")
    return tuple(sorted(note.label for note in styles if note.start <= middle <= note.stop))


def unusual_shares(sources: Sequence[Source], segments: Sequence[Segment]) -> FloatArray:
    """The share of each segment during which nobody walks, runs, stands or turns, shape ``(N,)``; 0 for held poses."""
    counts = []
    for source in sources:
        walking, running = everyday_frames(source.motion, UPRIGHT)
        counts.append(np.concatenate([[0.0], np.cumsum(~(walking | (running & _fast(source.motion))))]))
    shares = np.zeros(len(segments))
    for place, segment in enumerate(segments):
        if not segment.held:
            count, fps = counts[segment.source], sources[segment.source].motion.fps
            low, high = round(segment.start * fps), round(segment.stop * fps) + 1
            high = min(high, len(count) - 1)
            shares[place] = (count[high] - count[low]) / max(high - low, 1)
    return shares


def _fast(motion: Motion) -> BoolArray:
    """The frames ``(F,)`` in which a body goes as fast as people who run."""
    speed = np.linalg.norm(velocities(motion.translation, motion.fps)[:, [0, 2]], axis=1)
    return np.asarray(uniform_filter1d(speed, max(round(motion.fps / 2), 1), mode="nearest") >= RUN)


def drawn(settings: PerformanceSettings) -> bool:
    """Whether paths may be drawn, for which unusual motion costs more."""
    return isinstance(settings.control_points, GroundPath) and settings.unusual > 0
