"""Controls before they are searched: paths that are too fast are walked, in space."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.methods.performance import Control, path_on_ground, path_speeds
from kinetograph.methods.performance.control import walkable
from kinetograph.take import Annotation, Take
from walkers import walk

_FPS = 60.0


def _path(speed: float, seconds: float) -> kg.Signal:
    """Along +z, with a slow turn to one side."""
    along = speed * np.arange(round(seconds * _FPS) + 1) / _FPS
    points = np.stack([np.sin(0.2 * along), np.zeros_like(along), along], axis=1)
    return kg.Signal(points[:, None], ("path",), "m", _FPS)


def test_a_path_that_people_can_walk_is_left_alone() -> None:
    control = Control(path_on_ground(_path(1.2, 4.0), 0.3), _FPS)
    assert walkable(control, 1.3) is control


def test_a_path_that_is_too_fast_goes_the_same_way_and_takes_longer() -> None:
    control = Control(path_on_ground(_path(4.0, 4.0), 0.3), _FPS)
    slow = walkable(control, 1.2)
    assert path_speeds(slow.points, _FPS).max() <= 1.01 * 1.2
    assert slow.late == pytest.approx(slow.duration - control.duration, abs=0.02)
    np.testing.assert_allclose(slow.points[[0, -1]], control.points[[0, -1]], atol=0.02)
    middle = control.points.mean(axis=1)
    nearest = np.linalg.norm(slow.points.mean(axis=1)[:, None] - middle, axis=-1).min(axis=1)
    assert nearest.max() < 0.04  # half of what a sample of the fast path covers


@pytest.mark.parametrize("fastest", [0.0, 1e-3])
def test_a_library_where_nobody_walks_does_not_make_a_path_last_for_ever(fastest: float) -> None:
    slow = walkable(Control(path_on_ground(_path(1.0, 4.0), 0.3), _FPS), fastest)
    assert slow.duration == pytest.approx(5 * 4.0, rel=0.01)
    assert np.isfinite(slow.points).all()


def test_only_the_part_that_is_too_fast_is_slowed() -> None:
    fast, walked = _path(4.0, 1.0).values, _path(1.0, 4.0).values
    values = np.concatenate([walked, walked[-1] + fast[1:]])
    control = Control(path_on_ground(kg.Signal(values, ("path",), "m", _FPS), 0.3), _FPS)
    slow = walkable(control, 1.2)
    np.testing.assert_allclose(slow.points[: int(3.5 * _FPS)], control.points[: int(3.5 * _FPS)], atol=1e-9)
    assert slow.late > 1.0


def test_the_motion_says_that_it_is_late_unless_times_are_kept(tmp_path: Path) -> None:
    library = kg.Library.create(tmp_path / "library")
    cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(13) / 2)
    library.add(Take("walk", {"body": walk(6.0, speed=1.0)}, cuts))
    path = _path(3.0, 3.0)
    late = kg.PerformanceControl().fit(library).synthesize(path)
    assert late.motion.duration == pytest.approx(3.0 + late.statistics["late"], abs=0.05)
    assert any("followed in space and its end is reached" in text for text in late.warnings)
    kept = replace(kg.PerformanceControl(), keep_time=True).fit(library).synthesize(path)
    assert kept.motion.duration == pytest.approx(3.0, abs=0.05)
    assert "late" not in kept.statistics
