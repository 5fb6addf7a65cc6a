"""A walker or a point that drives a body, as sessions drive it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.live import PathDriver
from kinetograph.live.items import Frame, Point
from kinetograph.methods.performance import PerformanceControl, PerformanceModel
from kinetograph.motion import Motion, cut
from kinetograph.take import Annotation, Take
from walkers import walk


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> PerformanceModel:
    times = np.arange(241) / 30.0
    recording = walk(8.0, speed=1.0 + 0.25 * np.sin(0.9 * times), turn_rate=0.6 * np.cos(0.7 * times))
    library = kg.Library.create(tmp_path_factory.mktemp("path_driver") / "library")
    cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(17) / 2)
    library.add(Take("walk", {"body": recording}, cuts))
    return PerformanceControl(stretch=0.1).fit(library)


def _driven(driver: PathDriver, items: list[tuple[float, Point | Frame]], until: float) -> Motion:
    """The motion of items that arrive at their times, looked at a hundred times a second."""
    frames: list[Motion] = []
    at = 0
    for tick in range(round(until * 100)):
        now = tick / 100
        while at < len(items) and items[at][0] <= now:
            driver.take("d", [items[at][1]], now)
            at += 1
        frames += driver.advance(now)
    frames += driver.rest()
    translation = np.concatenate([frame.translation for frame in frames])
    rotations = np.concatenate([frame.rotations for frame in frames])
    return Motion(frames[0].skeleton, translation, rotations, frames[0].fps)


def test_points_that_arrive_unevenly_are_walked_along(model: PerformanceModel) -> None:
    rng = np.random.default_rng(0)
    times = np.sort(rng.uniform(0, 6, 400))
    items: list[tuple[float, Point | Frame]] = [(t, Point(t, np.array([0.0, 0.0, 1.1 * t]))) for t in times.tolist()]
    driver = PathDriver(model, lag=0.4)
    made = _driven(driver, items, 6.2)
    assert made.duration == pytest.approx(5.9, abs=0.3)
    seconds = np.arange(len(made)) / made.fps + times[0]
    assert np.median(np.abs(made.translation[:, 2] - 1.1 * seconds)) < 0.15
    assert np.median(np.abs(made.translation[:, 0])) < 0.15
    assert any("heard" in note for note in driver.notes())


def test_a_walker_is_followed_as_well_as_a_point(model: PerformanceModel) -> None:
    walker = walk(5.0, speed=1.1)
    items: list[tuple[float, Point | Frame]] = [
        (i / walker.fps, Frame(i / walker.fps, cut(walker, i, i + 1))) for i in range(len(walker))
    ]
    made = _driven(PathDriver(model, lag=0.4), items, 5.2)
    common = min(len(made), len(walker))
    away = np.linalg.norm((made.translation[:common] - walker.translation[:common])[:, [0, 2]], axis=1)
    assert np.median(away) < 0.12


def test_silence_is_standing_still_and_nothing_raises(model: PerformanceModel, tmp_path: Path) -> None:
    items: list[tuple[float, Point | Frame]] = [
        (i / 50, Point(i / 50, np.array([0.0, 0.0, i / 50]))) for i in range(150)
    ]
    items.append((3.0, Point(1.0, np.array([9.0, 0.0, 9.0]))))  # a point from the past
    items.append((3.01, Frame(3.01, cut(walk(1.0), 0, 1))))  # and a body in place of a point
    made = _driven(PathDriver(model, lag=0.4), items, 6.0)
    assert made.duration > 5.0
    assert np.abs(made.translation[-1, [0, 2]]).max() < 4.0


def test_a_control_of_another_kind_is_said_once(model: PerformanceModel) -> None:
    driver = PathDriver(model, lag=0.4)
    for i in range(20):
        driver.take("d", [Point(i / 30, np.array([np.inf, 0.0, 0.0]))], i / 30)
        driver.advance(i / 30)
    assert len([note for note in driver.notes() if "finite" in note]) == 1


def test_frames_of_another_body_and_places_out_of_range_are_left_out_and_said(model: PerformanceModel) -> None:
    walker = walk(3.0, speed=1.1)
    other = replace(walker, skeleton=replace(walker.skeleton, offsets=2.0 * walker.skeleton.offsets))
    far = replace(walker, translation=walker.translation + 1e200)
    items: list[tuple[float, Point | Frame]] = []
    for i in range(len(walker)):
        items.append((i / walker.fps, Frame(i / walker.fps, cut(walker, i, i + 1))))
        for odd in (other, far) if i % 5 == 2 else ():
            items.append((i / walker.fps + 0.01, Frame(i / walker.fps + 0.01, cut(odd, i, i + 1))))
    driver = PathDriver(model, lag=0.4)
    made = _driven(driver, items, 3.2)
    notes = driver.notes()
    assert sum("skeleton that the control began with" in note for note in notes) == 1
    assert sum("within 100 km" in note for note in notes) == 1
    common = min(len(made), len(walker))
    away = np.linalg.norm((made.translation[:common] - walker.translation[:common])[:, [0, 2]], axis=1)
    assert np.median(away) < 0.15


def test_a_long_gap_is_not_followed_frame_by_frame(model: PerformanceModel) -> None:
    driver, made = PathDriver(model, lag=0.4), []
    for i in range(60):
        driver.take("d", [Point(i / 30, np.array([0.0, 0.0, i / 30]))], i / 30)
        driver.advance(i / 30)
    before = driver._taken
    made = driver.advance(600.0)
    assert driver._taken - before < 6 * driver.fps
    assert 0 < len(made) < 6 * driver.output_rate
    assert any("nothing was heard" in note for note in driver.notes())
    for i in range(60):
        driver.take("d", [Point(600.1 + i / 30, np.array([0.0, 0.0, 2.0 + i / 30]))], 600.1 + i / 30)
        made += driver.advance(600.1 + i / 30)
    assert np.isfinite(np.concatenate([frame.translation for frame in made])).all()
    assert made[-1].translation[0, 2] > 2.5
