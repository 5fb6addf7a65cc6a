from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from kinetograph import rotations as rot
from kinetograph.cli import app
from kinetograph.errors import RequestError
from kinetograph.evaluation import sensor_nested
from kinetograph.evaluation.intervals import interval
from kinetograph.evaluation.real_sensors import evaluate_recordings, neura
from kinetograph.evaluation.real_wrist import offsets, utd
from kinetograph.evaluation.sensor import evaluate, fitted_to, together
from kinetograph.evaluation.sensor_baselines import BASELINES, ridge, smoothed
from kinetograph.evaluation.sensor_calibrations import evaluate_calibrations
from kinetograph.evaluation.sensor_folds import HeldOut, blocks, folds, grouped, people_among
from kinetograph.evaluation.sensor_means import group_means
from kinetograph.evaluation.sensor_nested import candidates, choose, parts_of
from kinetograph.evaluation.sensor_scores import normalised_rms, pose_errors, score
from kinetograph.evaluation.sensor_sweep import spread_out, sweep
from kinetograph.formats import read_kinect, read_utd
from kinetograph.library import Library
from kinetograph.methods.sensor import (
    Continuity,
    Guided,
    Interpolation,
    LocalModelSettings,
    Optimisation,
    SensorControl,
    WindowSmoothing,
)
from kinetograph.motion import resample
from kinetograph.sensing import Device, Layout, Sensor, preset, simulate
from kinetograph.take import Take
from walkers import walk


@pytest.fixture
def library(tmp_path: Path) -> Library:
    made = Library.create(tmp_path / "lib")
    for name, speed in (("a", 0.8), ("b", 1.0), ("c", 1.2)):
        made.add(Take(name, {"motion": walk(3.0, speed=speed)}))
    return made


def test_a_known_rotation_is_a_known_error_and_headings_do_not_count():
    truth = walk(1.0)
    other = truth.rotations.copy()
    other[:, 3] = rot.multiply(other[:, 3], rot.about("z", np.radians(10.0)))
    other[:, 0] = rot.multiply(rot.about("y", 1.0), other[:, 0])
    errors = pose_errors(other, truth.rotations)
    np.testing.assert_allclose(errors[:, 3], 10.0, atol=1e-6)
    np.testing.assert_allclose(np.delete(errors, 3, axis=1), 0.0, atol=1e-5)
    row, joints = score("x", "all", other, truth)
    assert row.angle == pytest.approx(10.0 / len(truth.skeleton))
    assert joints[3] == pytest.approx(10.0)
    assert row.jitter == pytest.approx(1.0, abs=0.2)


def test_the_normalised_rms_is_that_of_the_equation_and_blind_to_signs():
    truth = walk(1.0).rotations
    assert normalised_rms(-truth, truth) == pytest.approx(0.0, abs=1e-12)
    other = rot.multiply(truth, rot.about("x", 0.2))
    expected = np.sqrt(np.mean((other[0] - truth[0]) ** 2))
    assert normalised_rms(other[:1], truth[:1]) == pytest.approx(expected, rel=0.05)


def test_ridge_without_a_penalty_is_least_squares():
    rng = np.random.default_rng(0)
    x, true = rng.normal(size=(100, 3)), rng.normal(size=(3, 2))
    np.testing.assert_allclose(ridge(x, x @ true + 4.0, x[:5], 0.0), x[:5] @ true + 4.0, atol=1e-9)


def test_blocks_leave_gaps_of_a_second():
    parts = blocks(("take", "motion"), walk(20.0), 4, 1.0)
    assert len(parts) == 4
    assert sum(m.duration for m in parts.values()) == pytest.approx(20.0 - 3.0, abs=0.3)


def test_every_method_is_tried_on_every_take(library: Library):
    syntheses = {"continuity": Continuity()}
    scores = together(list(evaluate(library, SensorControl(), syntheses=syntheses, held=HeldOut(groups={"a": "slow"}))))
    assert {(r.take, r.person) for r in scores.rows} == {(name, name) for name in "abc"}
    means = group_means(scores.rows)
    assert [m.group for m in means][:: len(means) // 3] == ["slow", "all", "every group"]
    named = {(m.group, m.method): m for m in means}
    assert {"mean pose", "8 nearest frames, smoothed", "linear ridge", "continuity"} <= {name for _, name in named}
    assert "mean pose, smoothed" not in {name for _, name in named}  # it is what it was
    best = named["every group", "continuity"]
    assert best.angle < named["every group", "mean pose"].angle
    assert best.takes == 3
    assert best.angle_low <= best.angle <= best.angle_high
    assert np.isnan(named["slow", "continuity"].angle_low)  # one take has no interval
    assert best.gain == pytest.approx(named["every group", best.best].angle - best.angle)
    assert all(np.isfinite(r.p99_ms) for r in scores.rows if r.method == "continuity")
    assert scores.joints["continuity"].shape == (3, len(walk(0.1).skeleton))


def test_smoothing_a_baseline_is_the_mean_over_the_window_and_shakes_less(library: Library):
    poses = np.random.default_rng(0).normal(size=(30, 2))
    window = WindowSmoothing(ahead=3, behind=4)
    expected = [poses[max(i - 4, 0) : i + 4].mean(axis=0) for i in range(30)]
    np.testing.assert_allclose(smoothed(poses, window), expected, atol=1e-12)
    (scores, *_) = evaluate(library, SensorControl(), syntheses={}, held=HeldOut(only=("b",)))
    jitter = {row.method: row.jitter for row in scores.rows}
    for name in BASELINES[1:]:
        assert jitter[name + ", smoothed"] < jitter[name]


def test_leaving_out_a_person_leaves_out_all_their_takes(library: Library):
    people = {"a": "ann", "b": "bob", "c": "ann"}
    held = HeldOut(people=people, leave="person")
    ann, bob = (build() for build in folds(library, SensorControl(), held))
    assert (ann.unit, list(ann.truths), ann.examples.people) == ("ann", ["a", "c"], ("bob",))
    assert (list(bob.truths), bob.examples.people) == (["b"], ("ann", "ann"))
    (some,) = (build() for build in folds(library, SensorControl(), replace(held, only=("a",))))
    assert list(some.truths) == ["a"]
    assert [take for take, _ in some.examples.takes] == ["b"]  # c is ann's too
    (alone,) = (build() for build in folds(library, SensorControl(), replace(held, only=("a",), leave="take")))
    assert [take for take, _ in alone.examples.takes] == ["b", "c"]
    assert alone.seeds["a"] == some.seeds["a"]
    with pytest.raises(RequestError, match=r"only 'ann' moves in all takes; name several people"):
        folds(library, SensorControl(), HeldOut(people=dict.fromkeys("abc", "ann"), leave="person"))
    with pytest.raises(RequestError, match="leave out a take or a person, found 'frame'"):
        HeldOut(leave="frame")


def test_people_are_named_by_patterns_or_the_library(library: Library):
    assert people_among(library) == {}
    assert people_among(library, ("ann=[ab]", "bob=*")) == {"a": "ann", "b": "ann", "c": "bob"}
    with pytest.raises(RequestError, match=r"ann=x\*: no take is called x\*; there are a, b, c"):
        people_among(library, ("ann=x*",))


def test_settings_are_chosen_on_what_is_not_left_out(library: Library):
    held = HeldOut(only=("b",))
    small = LocalModelSettings(runs=1, clusters=3, frames=150, centres=40)
    syntheses = {"guided": Guided(), "ahead": Optimisation(local=small)}
    (scores,) = evaluate(library, SensorControl(), syntheses=syntheses, held=held, nested=True)
    (line,) = scores.chosen
    assert re.fullmatch(r"b: ahead: ahead 0\.\d+ s, chosen on the others", line)
    assert {"ahead", "ahead, nested", "guided"} < {row.method for row in scores.rows}
    assert "guided, nested" not in {row.method for row in scores.rows}  # it chooses by itself
    fold = folds(library, SensorControl(), held)[0]()
    assert sorted(parts_of(fold.examples)) == [0, 1]
    among = {"mean of all": Continuity(temperature=1e9, paths=10**6), "path": Continuity()}
    with pytest.MonkeyPatch.context() as patched:  # each is fitted alone where settings of the fit differ
        patched.setattr(sensor_nested, "_error", lambda model, examples, take: model.method.synthesis.temperature)
        assert choose(SensorControl(), fold.examples, among) == "path"
    assert candidates(Continuity()) == {}
    assert Optimisation() in candidates(Optimisation()).values()


def test_intervals_hold_the_mean_and_units_are_drawn_whole():
    values = np.random.default_rng(1).normal(5.0, 1.0, size=40)
    wide, narrow = interval(list(values), ["a"] * 20 + ["b"] * 20), interval(list(values))
    assert interval(list(values)) == narrow  # the same draws
    assert narrow.low < values.mean() < narrow.high
    assert narrow.high - narrow.low == pytest.approx(2 * 1.96 * values.std() / np.sqrt(40), rel=0.15)
    halves = (values[:20].mean(), values[20:].mean())
    assert (wide.low, wide.high) == pytest.approx((min(halves), max(halves)))
    ratio = interval([1.0, 1.0], ["a", "b"], [2.0, 4.0])
    assert ratio.mean == pytest.approx(1 / 3)


def test_turned_sensors_are_found_by_calibration(library: Library):
    held = HeldOut(only=("c",))
    rows = {row.layout: row for row in evaluate_calibrations(library, SensorControl(), "a", held)}
    assert 37.0 <= rows["not calibrated"].wrong_least <= rows["not calibrated"].wrong_most <= 151.0
    assert rows["as they are turned"].wrong == pytest.approx(0.0, abs=1e-4)
    assert rows["calibrated on its motion"].wrong < 10.0
    assert rows["calibrated on its motion"].angle < rows["not calibrated"].angle
    with pytest.raises(RequestError, match="name takes to estimate other than a"):
        evaluate_calibrations(library, SensorControl(), "a", HeldOut())


def test_a_page_and_its_numbers_are_written_after_every_take(library: Library, tmp_path: Path):
    out = tmp_path / "out"
    command = ["evaluate", "sensor", "-l", str(library.path), "--synthesis", "continuity", "-o", str(out)]
    done = CliRunner().invoke(app, [*command, "--person", "ann=[ab]", "--person", "bob=c", "--leave", "person"])
    assert done.exit_code == 0, done.output
    numbers = json.loads((out / "results.json").read_text())
    assert numbers["left_out"] == "person"
    assert numbers["people"] == {"a": "ann", "b": "ann", "c": "bob"}
    assert {(row["take"], row["person"]) for row in numbers["takes"]} == {("a", "ann"), ("b", "ann"), ("c", "bob")}
    assert "continuity" in numbers["settings_chosen_on"]
    mean = next(row for row in numbers["means"] if row["method"] == "continuity")
    mine = [row["angle"] for row in numbers["takes"] if row["method"] == "continuity"]
    assert mean["angle"] == pytest.approx(np.mean(mine))
    assert "8 nearest frames, smoothed" in (out / "index.html").read_text()
    assert CliRunner().invoke(app, command).exit_code != 0  # a new folder for each


def test_a_library_of_one_take_is_cut_into_blocks(tmp_path: Path):
    single = Library.create(tmp_path / "one")
    single.add(Take("only", {"motion": walk(12.0)}))
    scores = together(list(evaluate(single, SensorControl(), syntheses={})))
    assert [row.take for row in scores.rows if row.method == "mean pose"] == [f"only[{i}]" for i in range(5)]


def test_a_sweep_begins_with_no_growth(library: Library):
    rows = sweep(library, SensorControl(), "loss", held=HeldOut(only=("b",)))
    assert [r.value for r in rows] == [0.0, 0.1, 0.2, 0.3]
    assert rows[0].growth == 0.0
    assert rows[0].jitter > 0.0
    fewer = sweep(library, SensorControl(), "sensors", held=HeldOut(only=("b",)))
    assert [int(r.value) for r in fewer] == [1, 2, 4, 6, 8]
    with pytest.raises(RequestError, match="no sweep 'rain'; expected one of loss, offset, span, sensors, ahead"):
        sweep(library, SensorControl(), "rain")
    with pytest.raises(RequestError, match="only optimisation looks ahead by seconds"):
        sweep(library, SensorControl(), "ahead")


def test_a_sweep_is_averaged_by_group(library: Library):
    held = HeldOut(only=("a", "b"), groups={"a": "slow", "b": "slow"})
    small = LocalModelSettings(runs=1, clusters=3, frames=150, centres=40)
    rows = sweep(library, SensorControl(synthesis=Optimisation(local=small)), "ahead", held=held)
    assert [(row.group, row.value) for row in rows] == [("slow", v) for v in (0.0, 0.05, 0.1, 0.15, 0.3)]
    assert rows[0].angle_low <= rows[0].angle <= rows[0].angle_high


def test_syntheses_with_the_same_local_settings_share_their_local_models(library: Library):
    small, other = (LocalModelSettings(runs=1, clusters=clusters, frames=150, centres=40) for clusters in (3, 4))
    syntheses = (Continuity(), Interpolation(small), Optimisation(local=small), Interpolation(other))
    method = SensorControl()
    fold = folds(library, method, HeldOut(only=("b",)))[0]()
    methods = {str(i): SensorControl(synthesis=made) for i, made in enumerate(syntheses)}
    local = [model.fitted.local for _, model in fitted_to(methods, fold.examples)]
    assert local[0] is None
    assert local[1] is local[2]
    assert local[3] is not local[1]


def test_few_sensors_are_spread_over_the_body():
    assert spread_out(preset("wii").names)[:2] == ["right_forearm", "left_shank"]
    assert sorted(spread_out(preset("wii").names)) == sorted(preset("wii").names)


def test_a_group_needs_a_pattern():
    with pytest.raises(RequestError, match=r"a group is name=pattern, as in golf=64_\*; found 'golf'"):
        grouped(["64_01"], ["golf"])


def test_a_folder_without_recordings_is_refused(tmp_path: Path, library: Library):
    with pytest.raises(RequestError, match=r"expected neura/, utd-mhad/ or qmt_full_body_16imu.mat, found none"):
        list(evaluate_recordings(tmp_path, library))


def test_real_sensors_of_a_walk_are_calibrated_and_beat_the_mean_pose(data_folder: Path):
    folder = data_folder / "sensors" / "neura"
    if not folder.is_dir():
        pytest.skip("no recordings of real sensors: sensors/neura is missing")
    rows = neura(folder, syntheses={"continuity": Continuity()})
    row = rows[-1]
    assert row.method == "continuity"
    assert row.gain > 0.3
    assert row.angle_low < row.angle < row.angle_high
    assert 0.0 <= row.clock_ms <= 40.0
    assert row.residual < 0.5 * row.uncalibrated
    assert row.accepted == 7


def test_a_clock_that_is_ahead_is_found_in_both_halves_and_not_otherwise():
    motion = resample(walk(6.0, fps=60.0), 20.0)
    layout = Layout("wrist", (Sensor("wrist", "right_elbow", "right_hand", 0.9),), Device(rate=50.0))
    waving = motion.rotations.copy()
    elbow = motion.skeleton.landmark("right_elbow").joint
    angle = np.sin(np.arange(len(motion)) / motion.fps * 5.0) + 0.3 * np.sin(np.arange(len(motion)) / 3.0)
    waving[:, elbow] = rot.multiply(waving[:, elbow], rot.exp(angle[:, None] * np.array([1.0, 0.0, 0.0])))
    motion = replace(motion, rotations=waving)
    readings = simulate(motion, layout, np.random.default_rng(0), angular=True)
    assert offsets(motion, readings) == pytest.approx((0.0, 0.0), abs=0.041)
    assert offsets(motion, replace(readings, times=readings.times + 0.3)) == pytest.approx((0.3, 0.3), abs=0.061)


def test_real_wrist_sensors_span_the_kinects_frames(data_folder: Path):
    folder = data_folder / "sensors" / "utd-mhad"
    if not folder.is_dir():
        pytest.skip("no recordings of real sensors: sensors/utd-mhad is missing")
    path = folder / "a7_s1_t1_skeleton.mat"
    rows = read_utd(folder / "a7_s1_t1_inertial.mat", "wrist")
    motion = read_kinect(path, seconds=rows.duration)
    assert motion.duration == pytest.approx(rows.duration)
    assert 14.0 < motion.fps < 21.0
    assert max(abs(offset) for offset in offsets(motion, rows)) <= 0.1
    rows_of = utd(folder, 7, syntheses={"continuity": Continuity()})
    named = {row.method: row for row in rows_of}
    assert (named["mean pose"].people, named["mean pose"].parts) == (4, 16)
    assert named["mean pose"].gain == 0.0
    assert named["continuity"].gain > 0.05
    assert named["mean pose"].residual < 10.0


def test_a_take_to_hold_out_that_is_not_there_is_refused(library: Library):
    with pytest.raises(RequestError, match="no take 'bb' to hold out; there are a, b, c"):
        folds(library, SensorControl(), HeldOut(only=("bb",)))
