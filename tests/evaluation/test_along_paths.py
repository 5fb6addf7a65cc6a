"""Requests on paths: what is asked for, and what is measured."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.evaluation import evaluate_moves, evaluate_requests, path_requests
from kinetograph.evaluation.along_paths import KINDS, at_pace, hips_path, moments_in
from kinetograph.evaluation.metrics import accelerations
from kinetograph.evaluation.played import Played
from kinetograph.library import Facts, describe_takes
from kinetograph.methods.performance import PerformanceControl
from kinetograph.motion import Motion
from kinetograph.skeleton import Landmark
from kinetograph.synthesis import Piece, Synthesis
from kinetograph.take import Annotation, Take
from walkers import walk


def arm_up(motion: Motion, second: float) -> Motion:
    """A motion whose left arm is stretched up for a moment."""
    times = np.arange(len(motion)) / motion.fps
    rotations = motion.rotations.copy()
    joint = motion.skeleton.names.index("left_shoulder")
    angle = np.pi * np.exp(-(((times - second) / 0.4) ** 2))
    rotations[:, joint] = rot.multiply(rot.about("z", angle), rotations[:, joint])
    return replace(motion, rotations=rotations)


def with_head(motion: Motion) -> Motion:
    """The stick figure with a head."""
    skeleton = motion.skeleton
    return replace(
        motion, skeleton=replace(skeleton, roles={**skeleton.roles, "head": Landmark(0, np.array([0.0, 0.7, 0.0]))})
    )


@pytest.fixture
def libraries(tmp_path: Path) -> tuple[kg.Library, kg.Library]:
    """A library with walks, a run and a turn, and one with a longer walk."""
    library, walks = kg.Library.create(tmp_path / "library"), kg.Library.create(tmp_path / "walks")
    cuts = tuple(Annotation("motion", "cut", "", t, t) for t in np.arange(13) / 2)
    for name, motion in (
        ("straight", walk(6.0)),
        ("left", walk(6.0, turn_rate=0.5)),
        ("quick", walk(6.0, speed=2.0, period=0.5)),
        ("round", walk(6.0, speed=0.2, turn_rate=2.5)),
        ("waves", arm_up(walk(6.0, speed=0.3), 3.0)),
    ):
        library.add(Take(name, {"motion": with_head(motion)}, cuts))
    describe_takes(library, {"quick": Facts(tags=frozenset({"run"}))})
    walks.add(Take("other", {"motion": with_head(walk(16.0, turn_rate=0.1))}))
    return library, walks


def test_what_a_take_shows_is_found_where_it_is(libraries: tuple[kg.Library, kg.Library]) -> None:
    found = moments_in(libraries[0])
    assert {(each.kind, each.take) for each in found} == {("turn", "round"), ("wave", "waves")}
    assert {each.kind for each in found} <= set(KINDS)
    assert next(each.second for each in found if each.kind == "wave") == pytest.approx(3.0, abs=0.4)


def test_requests_are_met_and_the_same_for_a_seed(libraries: tuple[kg.Library, kg.Library]) -> None:
    library, walks = libraries
    model = PerformanceControl().fit(library)
    requests = path_requests(library, walks, 2, np.random.default_rng(0))
    again = path_requests(library, walks, 2, np.random.default_rng(0))
    assert [r.name for r in requests] == [r.name for r in again]
    for row in evaluate_requests(model, requests):
        assert not row.refused
        assert row.miss_mm < 1.0
        assert row.off < 4 * row.off_plain + 0.02
    assert all(12 - 1e-6 <= r.path.duration <= 16 + 1e-6 for r in requests)


def test_a_span_is_made_of_the_move_at_its_pace(libraries: tuple[kg.Library, kg.Library]) -> None:
    library, walks = libraries
    path = hips_path(walks.take("other").motion(), 0.0, 14.0)
    faster, span = at_pace(path, 2.0)
    speeds = np.linalg.norm(np.diff(faster.values[:, 0], axis=0), axis=1) * faster.fps
    times = np.arange(len(speeds)) / faster.fps
    middle = (times > span[0] + 0.6) & (times < span[1] - 0.1)
    np.testing.assert_allclose(speeds[middle], 2.0, atol=0.1)
    (row,) = evaluate_moves(PerformanceControl().fit(library), [path], "run")
    assert row.share > 0.95


def test_walks_that_are_too_short_are_refused(libraries: tuple[kg.Library, kg.Library]) -> None:
    with pytest.raises(RequestError, match="no take of the library of walks lasts 12 s"):
        path_requests(libraries[0], libraries[0], 1, np.random.default_rng(0))


def test_keys_at_places_are_where_the_path_is_at_their_times(libraries: tuple[kg.Library, kg.Library]) -> None:
    timed, placed = (path_requests(*libraries, 3, np.random.default_rng(7), placed=placed) for placed in (False, True))
    for by_time, by_place in zip(timed, placed, strict=True):
        assert by_time.moments == by_place.moments
        points = by_time.path.values[:, 0]
        for one, other in zip(by_time.keys, by_place.keys, strict=True):
            assert one.key.time is not None
            assert other.key.time is None
            stop = round(one.key.time[0] * by_time.path.fps)
            length = np.linalg.norm(np.diff(points[: stop + 1], axis=0), axis=1).sum()
            assert other.along == pytest.approx(length, abs=0.02)


def test_what_recordings_do_themselves_does_not_count() -> None:
    calm = walk(4.0)
    jerk = calm.translation.copy()
    jerk[60, 1] += 0.1
    wild = replace(calm, translation=jerk)
    piece = Piece("wild", "motion", 0.0, 4.0, 0.0, 4.0)
    made = Synthesis(wild, (piece,), 0.0)
    usual = float(accelerations(calm).max())
    sources = [SimpleNamespace(take=name, mirrored=False, motion=m) for name, m in (("calm", calm), ("wild", wild))]
    assert Played(sources).accelerations(made, usual).max() == pytest.approx(1.0)  # type: ignore[arg-type]
    # another take that plays there is calm, and a recording counts only near the frame that plays
    for take, start in (("calm", 0.0), ("wild", 1.0)):
        other = replace(made, pieces=(replace(piece, take=take, source_start=start, source_stop=start + 4.0),))
        expected = accelerations(wild).max() / usual
        assert Played(sources).accelerations(other, usual).max() == pytest.approx(expected)  # type: ignore[arg-type]
