"""Clustering says beforehand what it would take, rather than running out of memory."""

from __future__ import annotations

import pytest

from kinetograph.errors import RequestError
from kinetograph.methods.performance import PerformanceControl
from kinetograph.methods.performance.clustering import MOST, PAIR, cluster_segments
from kinetograph.methods.performance.segments import Segment


def test_more_segments_than_there_is_room_for_are_refused_before_any_is_looked_at() -> None:
    count = int((MOST / PAIR) ** 0.5)
    segments = tuple(Segment(0, float(i), i + 1.0) for i in range(20_000))
    with pytest.raises(RequestError, match=rf"20000 take 48.0 GB, and at most 2 GB are allowed, {count} segments"):
        cluster_segments((), segments, PerformanceControl(cluster=0.1))
    with pytest.raises(IndexError):  # as many as there is room for are looked at
        cluster_segments((), segments[:count], PerformanceControl(cluster=0.1))
