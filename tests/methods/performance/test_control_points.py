"""Readings of a control, and partners whose steps are known."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.errors import RequestError
from kinetograph.evaluation import distinct_share, joint_error, leave_one_dance_out, mean_rows
from kinetograph.kinematics import role_positions
from kinetograph.methods.performance import GroundPath, PerformanceControl, PointsByRole, partner_control, usual_grip
from kinetograph.motion import Motion, place, resample
from kinetograph.post.assemble import PostSettings
from kinetograph.take import Annotation, Take
from walkers import stick_figure, walk

_FEET = {"left_toe": 1.0, "right_toe": 2.0}
_ENDS = {"left_toe": 1.0, "right_toe": 1.0, "left_hand": 1.0, "right_hand": 1.0}
_PLAIN = PostSettings(blend="none", footskate=False, handholds=None)


def _pair(name: str, phase: float, duration: float = 8.0) -> Take:
    """A leader who wanders, and a follower who walks half a turn away, a metre beside."""
    times = np.arange(round(duration * 30) + 1) / 30
    leader = walk(duration, speed=1.0 + 0.25 * np.sin(0.9 * times + phase), turn_rate=0.6 * np.cos(0.7 * times + phase))
    follower = place(leader, 0.0, (1.0, 0.0, 0.3))
    cuts = tuple(Annotation("follower", "cut", "", t, t) for t in np.arange(int(duration * 2) + 1) / 2)
    return Take(name, {"leader": leader, "follower": follower}, cuts)


def _library(folder: Path, *takes: Take) -> kg.Library:
    library = kg.Library.create(folder / "library")
    for take in takes:
        library.add(take)
    return library


_METHOD = PerformanceControl(stretch=0.0, control_points=PointsByRole(_ENDS), post=_PLAIN)


# ---- readings ----


def test_points_are_those_of_the_roles() -> None:
    motion = walk(2.0)
    reading = PointsByRole(_FEET)
    np.testing.assert_allclose(reading.points(motion), role_positions(motion, ("left_toe", "right_toe")))
    np.testing.assert_allclose(reading.weights(), [1.0, 2.0])


def test_two_points_ahead_and_behind_weigh_velocity_against_position() -> None:
    one, other = walk(2.0), walk(2.0, speed=0.8)
    plain, fast = PointsByRole(_FEET), PointsByRole(_FEET, velocity=0.3)

    def distance(reading: PointsByRole) -> np.ndarray:
        gap = reading.points(one) - reading.points(other)
        return np.einsum("fpi,fpi,p->f", gap, gap, reading.weights())

    speeds = [np.gradient(plain.points(m), 1 / 30, axis=0) for m in (one, other)]
    extra = 0.3**2 * np.einsum("fpi,p->f", (speeds[0] - speeds[1]) ** 2, plain.weights())
    np.testing.assert_allclose(distance(fast), distance(plain) + extra)


def test_a_signal_is_read_by_its_names() -> None:
    values = np.arange(24.0).reshape(2, 4, 3)
    signal = kg.Signal(values, ("head", "right_toe", "nose", "left_toe"), "m", 30.0)
    np.testing.assert_allclose(PointsByRole(_FEET).points(signal), values[:, [3, 1]])
    with pytest.raises(RequestError, match="the control has no point left_hand; its columns are head, right_toe, nose"):
        PointsByRole({"left_hand": 1.0}).points(signal)


def test_readings_that_make_no_sense() -> None:
    with pytest.raises(RequestError, match="control points need positive weights by role, found"):
        PointsByRole({"head": 0})
    with pytest.raises(RequestError, match="velocity must be 0 s or more, found -1"):
        PointsByRole(velocity=-1)
    with pytest.raises(RequestError, match=r"hip_distance must be a positive number, found 0\.0"):
        GroundPath(0.0)
    with pytest.raises(RequestError, match="span must be 1 cut or more, found 0"):
        PerformanceControl(span=0)


# ---- partners ----


def test_a_follower_is_recovered_from_the_leader(tmp_path: Path) -> None:
    take = _pair("a", 0.0)
    model = _METHOD.fit(_library(tmp_path, take, _pair("b", 2.0)), track="follower")
    result = model.synthesize(take.motion("leader"))
    assert joint_error(result.motion, take.motion("follower")) < 1e-3
    elsewhere = [place(take.motion(t), 1.1, (3.0, 0.0, 2.0)) for t in ("leader", "follower")]
    assert joint_error(model.synthesize(elsewhere[0]).motion, elsewhere[1]) < 1e-3


def test_a_leader_of_another_rate_leads_alike(tmp_path: Path) -> None:
    take = _pair("a", 0.0)
    model = _METHOD.fit(_library(tmp_path, take), track="follower")
    result = model.synthesize(resample(take.motion("leader"), 50.0))
    assert result.motion.fps == 30.0
    assert joint_error(result.motion, take.motion("follower")) < 0.01


def test_segments_of_several_cuts_begin_at_every_cut(tmp_path: Path) -> None:
    library = _library(tmp_path, _pair("a", 0.0, duration=4.0))
    segments = replace(_METHOD, span=2).fit(library, track="follower").fitted.instances.segments
    assert [(s.start, s.stop) for s in segments] == [(t / 2, t / 2 + 1) for t in range(7)]


def test_partners_without_cuts_are_cut_at_their_beats(tmp_path: Path) -> None:
    take = _pair("a", 0.0)
    model = _METHOD.fit(_library(tmp_path, Take("a", take.tracks)), track="follower")
    assert model.notes == ("1 take had no cuts and was cut at beats (a); library segment does so once",)
    durations = [s.duration for s in model.fitted.instances.segments]
    np.testing.assert_allclose(durations, 0.5, atol=0.1)


def test_dancers_of_nearly_one_build_share_a_library(tmp_path: Path) -> None:
    small = stick_figure(0.97)
    take, other = _pair("a", 0.0), _pair("b", 2.0)
    follower = other.motion("follower")
    other = Take("b", {**other.tracks, "follower": Motion(small, follower.translation, follower.rotations, 30.0)})
    model = _METHOD.fit(_library(tmp_path, take, other), track="follower")
    heights = {s.motion.skeleton.height for s in model.fitted.sources}
    assert len(heights) == 1


def test_tracks_and_controls_that_are_not_there(tmp_path: Path) -> None:
    library = _library(tmp_path, _pair("a", 0.0))
    with pytest.raises(RequestError, match=r"name one of its motions \(leader, follower\), found 'singer'"):
        _METHOD.fit(library, track="singer")
    drummer = replace(_METHOD, control_points=PointsByRole(_ENDS, track="drummer"))
    with pytest.raises(RequestError, match="expected a track 'drummer' to control 'follower', found leader"):
        drummer.fit(library, track="follower")
    valid = np.ones((30, 4), dtype=bool)
    valid[12, 2] = False
    signal = kg.Signal(np.zeros((30, 4, 3)), tuple(_ENDS), "m", 30.0, valid)
    with pytest.raises(RequestError, match=r"the control misses 1 samples, the first at 0\.40 s; fill them in first"):
        _METHOD.fit(library, track="follower").synthesize(signal)


# ---- handholds ----


def test_hands_that_are_held_in_the_recording_are_held_in_the_result(tmp_path: Path) -> None:
    take = _pair("a", 0.0)
    hold = Annotation("follower", "handhold", "right_hand:left_hand", 0.5, 7.5)
    near = Take("a", {**take.tracks, "follower": place(take.motion("leader"), 0.0, (0.1, 0.0, 0.0))}, take.annotations)
    library = _library(tmp_path, Take("a", near.tracks, (*near.annotations, hold)))
    method = replace(_METHOD, post=PostSettings(footskate=False, limits=None))  # elbows of stick figures never bend
    result = method.fit(library, track="follower").synthesize(take.motion("leader"))
    carried = [n for n in result.annotations if n.kind == "handhold"]
    assert [(n.label, round(n.start, 2), round(n.stop, 2)) for n in carried] == [("right_hand:left_hand", 0.5, 7.5)]
    assert result.statistics["handhold_residual_p95"] < 0.01
    assert 0.0 < result.statistics["constraints_moved_mean"] < result.statistics["constraints_moved_most"] < 0.2
    stiff = replace(method, post=PostSettings(footskate=False)).fit(library, track="follower")
    assert stiff.synthesize(take.motion("leader")).statistics["handhold_residual_p95"] > 0.01


def test_holds_that_a_person_tells_are_met_in_place_of_the_recorded_ones(tmp_path: Path) -> None:
    take = _pair("a", 0.0)
    near = {**take.tracks, "follower": place(take.motion("leader"), 0.0, (0.1, 0.0, 0.0))}
    recorded = Annotation("follower", "handhold", "right_hand:left_hand", 0.5, 7.5)
    model = replace(_METHOD, post=PostSettings(footskate=False, limits=None)).fit(
        _library(tmp_path, Take("a", near, (*take.annotations, recorded))), track="follower"
    )
    leader = take.motion("leader")
    told = Annotation("leader", "handhold", "right_hand:left_hand", 2.0, 4.0)
    result = model.synthesize(Take("new", {"leader": leader}, (told,)))
    assert [n for n in result.annotations if n.kind == "handhold"] == [replace(told, track="motion")]
    assert result.statistics["handhold_residual_p95"] < 0.01
    held = model.synthesize(Take("new", {"leader": leader})).annotations
    assert [n.start for n in held if n.kind == "handhold"] == pytest.approx([0.5], abs=0.05)


def test_the_usual_grip_is_the_mean_of_a_holds_recordings(tmp_path: Path) -> None:
    take = _pair("a", 0.0)
    holds = (
        Annotation("follower", "handhold", "right_hand:left_hand", 1.0, 2.0),
        Annotation("follower", "handhold", "left_hand:left_hand", 3.0, 5.0),
    )
    library = _library(tmp_path, replace(take, annotations=(*take.annotations, *holds)))
    sources = _METHOD.fit(library, track="follower").fitted.sources
    grips = sources[0].grips["right_hand:left_hand"]
    np.testing.assert_allclose(usual_grip(sources, "right_hand:left_hand"), grips[30:61:3].mean(axis=0), atol=1e-9)
    some = usual_grip(sources, "right_hand:right_hand")
    assert not np.allclose(some, usual_grip(sources, "right_hand:left_hand"))
    assert usual_grip((), "right_hand:left_hand").tolist() == [0.0, 0.0, 0.0]


# ---- evaluation ----


def test_leaving_dances_out_gives_a_row_a_take_and_method(tmp_path: Path) -> None:
    library = _library(tmp_path, _pair("a", 0.0), _pair("b", 0.3), _pair("c", 0.6))
    rows = leave_one_dance_out(_METHOD, library, "follower")
    assert len(rows) == 21
    means = {row.method: row for row in mean_rows(rows)}
    others = {
        "holds given",
        "nearest segment",
        "5 nearest frames",
        "ridge regression",
        "constant pose",
        "commonest name",
    }
    assert set(means) == {"segments", *others}
    assert means["segments"].joint_cm < means["constant pose"].joint_cm
    assert means["segments"].joint_cm == pytest.approx(np.mean([r.joint_cm for r in rows if r.method == "segments"]))
    assert 0 < means["segments"].distinct <= 1
    assert np.isnan(means["constant pose"].slide)


def test_a_recording_used_twice_counts_once() -> None:
    piece = kg.Piece("a", "body", 1.0, 2.0, 0.0, 1.0)
    twice = (piece, replace(piece, start=1.0, stop=2.0))
    assert distinct_share(kg.Synthesis(walk(2.0), twice, 0.0)) == pytest.approx(0.5, abs=0.05)


def test_the_configuration_for_partners_uses_two_beats_that_overlap() -> None:
    method = partner_control()
    assert (method.span, method.rate) == (2, 7.5)
    assert isinstance(method.control_points, PointsByRole)
