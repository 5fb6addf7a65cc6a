"""Live control: the same search, told the control one frame at a time."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph import rows
from kinetograph.errors import RequestError
from kinetograph.kinematics import role_positions
from kinetograph.methods.performance import (
    PerformanceControl,
    PerformanceModel,
    PointsByRole,
    at_rate,
    left_early,
    points_of,
)
from kinetograph.methods.performance.scoring import arrivals_at
from kinetograph.methods.performance.window import LatestWindow
from kinetograph.motion import Motion, cut
from kinetograph.post.hand_follow import HandFollow
from kinetograph.synthesis import LivePose, Synthesis
from kinetograph.take import Annotation, Take
from walkers import walk

_FPS = 30.0
_METHOD = PerformanceControl(stretch=0.1)


def _model(folder: Path, method: PerformanceControl = _METHOD) -> PerformanceModel:
    times = np.arange(241) / _FPS
    recording = walk(8.0, speed=1.0 + 0.25 * np.sin(0.9 * times), turn_rate=0.6 * np.cos(0.7 * times))
    library = kg.Library.create(folder / "library")
    library.add(Take("walk", {"body": recording}, _cuts("body")))
    return method.fit(library)


def _cuts(track: str) -> tuple[Annotation, ...]:
    return tuple(Annotation(track, "cut", "", t, t) for t in np.arange(17) / 2)


def _control(duration: float = 5.0) -> Motion:
    times = np.arange(round(duration * _FPS) + 1) / _FPS
    return walk(duration, speed=1.1, turn_rate=0.5 * np.sin(times))


def _live(model: PerformanceModel, control: Motion, lag: float | None) -> tuple[Synthesis, list[kg.Piece]]:
    live = model.start(control.fps, lag)
    pieces = []
    for frame in range(len(control)):
        live.step(cut(control, frame, frame + 1))
        pieces += live.pieces[len(pieces) :]
    return live.finish(), pieces


def _what(pieces: list[kg.Piece] | tuple[kg.Piece, ...]) -> list[tuple[str, float]]:
    return [(piece.take, piece.source_start) for piece in pieces]


@pytest.mark.parametrize("beam", [None, 0.02])
def test_without_a_lag_it_is_the_offline_result(tmp_path: Path, beam: float | None) -> None:
    model = _model(tmp_path, replace(_METHOD, beam=beam))
    control = _control()
    offline = model.synthesize(control)
    live, pieces = _live(model, control, None)
    assert live.cost == pytest.approx(offline.cost, rel=1e-6)
    assert _what(live.pieces) == _what(offline.pieces)
    np.testing.assert_allclose(live.motion.translation, offline.motion.translation, atol=1e-6)
    assert _what(pieces) == _what(offline.pieces)[: len(pieces)]


def test_velocities_come_a_frame_later_and_are_the_same(tmp_path: Path) -> None:
    leader = walk(8.0, turn_rate=0.4)
    take = Take("pair", {"leader": leader, "follower": walk(8.0, speed=1.2)}, _cuts("follower"))
    library = kg.Library.create(tmp_path / "pairs")
    library.add(take)
    method = replace(_METHOD, control_points=PointsByRole({"left_toe": 1.0, "right_toe": 1.0}, velocity=0.2))
    model = method.fit(library, track="follower")
    control = _control(3.0)
    assert _live(model, control, None)[0].cost == pytest.approx(model.synthesize(control).cost, rel=1e-6)


@pytest.mark.parametrize("lag", [0.0, 0.2, 0.6, 1.5])
def test_committed_pieces_stay_and_come_in_time(tmp_path: Path, lag: float) -> None:
    model, control = _model(tmp_path), _control()
    live, pieces, known = model.start(control.fps, lag), list[kg.Piece](), []
    for frame in range(len(control)):
        live.step(cut(control, frame, frame + 1))
        pieces += live.pieces[len(pieces) :]
        known.append(len(pieces))
    result = live.finish()
    assert _what(result.pieces)[: len(pieces)] == _what(pieces)
    for frame, count in enumerate(known):
        shown = np.floor((frame / _FPS + 1e-6) * 10) / 10 - max(lag, 0.1)
        begun = [piece for piece in result.pieces if piece.start < shown - 0.1]  # borders move by less than a step
        assert shown < 0 or count >= len(begun)
    assert result.cost >= model.synthesize(control).cost - 1e-9
    assert len(result.motion) == len(control)


def test_the_stretch_of_a_committed_piece_is_open_until_it_ends(tmp_path: Path) -> None:
    model, control = _model(tmp_path), _control()
    result, pieces = _live(model, control, 0.2)
    moved = [abs(a.stop - b.stop) for a, b in zip(pieces, result.pieces, strict=False)]
    assert max(moved) > 1 / _FPS + 1e-9
    assert max(moved) <= 2 * _METHOD.stretch + 2 / _METHOD.rate


def test_one_window_is_aligned_as_many_are(tmp_path: Path) -> None:
    model = _model(tmp_path)
    x = at_rate(points_of(model.method, _control(2.0)), _FPS, model.method.rate)
    quick = LatestWindow.of(model.fitted)
    for stop in (2, 4, 9):
        one, other = quick.arrivals_at(x[: stop + 1]), arrivals_at(model.fitted, x[: stop + 1])
        np.testing.assert_allclose(one.costs, other.costs, atol=1e-9)
        np.testing.assert_allclose(one.tails, other.tails, atol=1e-5)
    for used, other in left_early(model.fitted, x[:12]).items():
        one = quick.under_way(x[11 - used : 12])
        longer = model.fitted.search.durations > used
        np.testing.assert_allclose(one.costs[longer], other.costs[longer], atol=1e-9)
        np.testing.assert_allclose(one.heads[longer], other.heads[longer], atol=1e-5)
        assert np.isinf(one.costs[~longer]).all()


def test_more_lag_than_the_control_is_long_changes_nothing(tmp_path: Path) -> None:
    model, control = _model(tmp_path), _control()
    assert _live(model, control, 60.0)[0].cost == pytest.approx(model.synthesize(control).cost, rel=1e-6)


def test_points_are_taken_as_well_as_poses(tmp_path: Path) -> None:
    model, control = _model(tmp_path), _control(2.0)
    live = model.start(control.fps)
    for points in points_of(model.method, control):
        live.step(points)
    assert live.finish().cost == pytest.approx(model.synthesize(control).cost, rel=1e-6)


def test_what_cannot_be_live_says_so(tmp_path: Path) -> None:
    model = _model(tmp_path)
    with pytest.raises(RequestError, match="fps must be positive and lag 0 or more, found 30 and -1"):
        model.start(30, -1)
    with pytest.raises(RequestError, match=r"expected a frame of finite control points \(2, 3\), found shape \(3, 3\)"):
        model.start(30.0).step(np.zeros((3, 3)))
    with pytest.raises(RequestError, match="finite control points"):
        model.start(30.0).step(np.full((2, 3), np.nan))
    live = model.start(30.0)
    live.step(np.zeros((2, 3)))
    with pytest.raises(RequestError, match="the control is too short"):
        live.finish()


# ---- frames ----


def _frames(model: PerformanceModel, control: Motion, lag: float, keep: bool = True) -> list[LivePose]:
    live = model.start(control.fps, lag, keep)
    poses: list[LivePose] = []
    for frame in range(len(control)):
        poses += live.step(cut(control, frame, frame + 1))
        assert not poses or poses[-1].time <= frame / control.fps - lag + 1e-6  # no sooner than they are decided
    return [*poses, *live.rest()]


def test_without_a_lag_the_whole_is_the_offline_one_bit_by_bit(tmp_path: Path) -> None:
    model, control = _model(tmp_path), _control()
    live, offline = _live(model, control, None)[0], model.synthesize(control)
    assert (live.motion.rotations == offline.motion.rotations).all()
    assert (live.motion.translation == offline.motion.translation).all()


@pytest.mark.parametrize("lag", [0.3, 0.8])
def test_frames_come_in_order_without_gaps_and_follow_the_control(tmp_path: Path, lag: float) -> None:
    model, control = _model(tmp_path), _control()
    poses = _frames(model, control, lag)
    assert np.allclose([pose.time for pose in poses], np.arange(len(poses)) / _FPS)
    assert len(poses) == len(control)
    hips = np.array([pose.translation for pose in poses])
    away = np.linalg.norm((hips - control.translation)[:, [0, 2]], axis=1)
    assert np.median(away) < 0.1
    assert away.max() < 0.4
    steps = np.linalg.norm(np.diff(hips, axis=0), axis=1) * _FPS
    assert steps.max() < 2.5  # metres per second: nobody leaps at a seam
    motion = Motion(control.skeleton, hips, np.array([pose.rotations for pose in poses]), _FPS)
    turned = rot.angle_between(motion.rotations[1:], motion.rotations[:-1]).max() * _FPS
    recorded = model.fitted.sources[0].motion.rotations
    assert turned < 2.0 * rot.angle_between(recorded[1:], recorded[:-1]).max() * _FPS


def test_what_is_forgotten_changes_no_frame_and_memory_stays_flat(tmp_path: Path) -> None:
    model, control = _model(tmp_path), _control(20.0)
    kept, forgotten = _frames(model, control, 0.4), _frames(model, control, 0.4, keep=False)
    assert len(kept) == len(forgotten)
    assert all((a.rotations == b.rotations).all() for a, b in zip(kept, forgotten, strict=True))
    assert all((a.translation == b.translation).all() for a, b in zip(kept, forgotten, strict=True))
    live = model.start(control.fps, 0.4, keep=False)
    sizes, steps = [], []
    for frame in range(len(control)):
        live.step(cut(control, frame, frame + 1))
        search = live._search
        sizes.append(search.samples.since(0).nbytes + search._state.back.nbytes)
        steps.append(len(search.committed))
    assert max(sizes[300:]) < 1.5 * max(sizes[150:300])
    assert max(steps) == 1
    with pytest.raises(RequestError, match="not kept"):
        live.finish()
    with pytest.raises(RequestError, match="without a lag"):
        model.start(30.0, None, keep=False)


def test_what_is_known_to_come_lowers_the_cost(tmp_path: Path) -> None:
    model, control = _model(tmp_path), _control(8.0)
    points = points_of(model.method, control)
    costs = {}
    for known in (False, True):
        live = model.start(control.fps, 0.2, forecast=False)
        for i, point in enumerate(points):
            live.step(point, points[i + 1 :] if known else None)
        costs[known] = live.path().score
    assert costs[True] < 0.8 * costs[False]
    assert costs[True] <= 1.4 * model.synthesize(control).cost


def test_a_hand_follows_what_it_holds_with_bounded_speed_and_lets_go(tmp_path: Path) -> None:
    body = walk(2.0)
    follow = HandFollow("left")
    goal = role_positions(body, ("left_hand",))[0, 0] + [0.1, 0.15, 0.1]
    shown, offsets = [], []
    for frame in range(len(body)):
        still = cut(body, 0, 1)
        made = follow.step(still, goal if frame < 30 else None, 1 / _FPS)
        shown.append(role_positions(made, ("left_hand",))[0, 0])
        offsets.append(follow.offset)
    changes = np.linalg.norm(np.diff(offsets, axis=0), axis=1) * _FPS
    assert changes.max() <= follow.settings.fastest + 1e-9
    assert np.linalg.norm(shown[29] - goal) < 0.01
    assert np.linalg.norm(shown[-1] - role_positions(body, ("left_hand",))[0, 0]) < 0.01


def _bad(points: np.ndarray) -> list[np.ndarray]:
    """Frames of control points that cannot be followed."""
    spoilt = []
    for value in (np.nan, np.inf, 1e200, -1e9):
        wrong = points.copy()
        wrong[0, 0] = value
        spoilt.append(wrong)
    return [*spoilt, points[:, :2], np.concatenate([points, points]), points[None]]


@pytest.mark.parametrize("keep", [False, True])
def test_bad_points_are_refused_in_one_line_and_leave_no_trace(tmp_path: Path, keep: bool) -> None:
    model = _model(tmp_path)
    points = points_of(model.method, _control(4.0))
    clean, attacked = model.start(_FPS, 0.4, keep), model.start(_FPS, 0.4, keep)
    for i, point in enumerate(points):
        for bad in _bad(point) if i % 20 in (0, 7) else ():
            with pytest.raises(RequestError, match=r"^expected .*control points") as caught:
                attacked.step(bad)
            assert "\n" not in str(caught.value)
        for a, b in zip(clean.step(point), attacked.step(point), strict=True):
            assert np.array_equal(a.rotations, b.rotations)
            assert np.array_equal(a.translation, b.translation)
            assert np.isfinite(a.translation).all()


def test_frames_of_another_body_are_refused_and_the_first_goes_on(tmp_path: Path) -> None:
    model, control = _model(tmp_path), _control(3.0)
    names = control.skeleton.names
    taller = replace(control, skeleton=replace(control.skeleton, offsets=1.1 * control.skeleton.offsets))
    renamed = replace(control, skeleton=replace(control.skeleton, names=(*names[:-1], "tail")))
    clean, attacked = model.start(_FPS, 0.4), model.start(_FPS, 0.4)
    for i in range(len(control)):
        if i in (5, 50):
            for other in (taller, renamed):
                with pytest.raises(RequestError, match="skeleton that the control began with"):
                    attacked.step(cut(other, i, i + 1))
            with pytest.raises(RequestError, match="one frame, found one of 2"):
                attacked.step(cut(control, i, i + 2))
        for a, b in zip(clean.step(cut(control, i, i + 1)), attacked.step(cut(control, i, i + 1)), strict=True):
            assert np.array_equal(a.rotations, b.rotations)
    np.testing.assert_array_equal(clean.finish().motion.rotations, attacked.finish().motion.rotations)


@pytest.mark.parametrize("lag", [0.4, None])
def test_what_is_kept_in_memory_is_bounded_though_the_whole_is_wanted(
    tmp_path: Path, lag: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rows, "IN_MEMORY", 20_000)
    model = _model(tmp_path)
    points = points_of(model.method, _control(80.0))
    live = model.start(_FPS, lag)
    pointers, sizes = {}, {}
    for i, point in enumerate(points):
        live.step(point)
        kept = live._arrived.kept
        assert kept is not None
        pointers[i] = live._search._state.back.nbytes
        sizes[i] = kept.nbytes + live._search.samples.since(0).nbytes + live._arrived.latest.since(0).nbytes
    early, late = range(600, 1200), range(1800, 2400)
    assert max(sizes[i] for i in late) == max(sizes[i] for i in early) <= 40_000
    grown = max(pointers[i] for i in late) - max(pointers[i] for i in early)
    assert grown / 400 < 60  # bytes a step of the search, where all states would take 4 each
    whole = live.finish()
    assert np.isfinite(whole.motion.translation).all()
    assert len(whole.motion) == len(points)


def test_a_swept_search_over_a_long_control_is_the_offline_result(tmp_path: Path) -> None:
    model, control = _model(tmp_path), _control(60.0)
    offline = model.synthesize(control)
    live, _ = _live(model, control, None)
    assert _what(live.pieces) == _what(offline.pieces)
    assert live.cost == pytest.approx(offline.cost, rel=1e-6)
