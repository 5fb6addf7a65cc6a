from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.evaluation.sensor_scores import pose_errors
from kinetograph.methods.sensor import (
    Continuity,
    Examples,
    Guided,
    KernelRidge,
    ReadingWindow,
    SensorControl,
    SensorModel,
    build_examples,
)
from kinetograph.methods.sensor.expected import expected_errors
from kinetograph.methods.sensor.result import warnings_of
from kinetograph.methods.sensor.ridge import fit_ridge, groups_of
from kinetograph.methods.sensor.window import WindowBuffer, WindowFeatures
from kinetograph.motion import Motion, resample
from kinetograph.sensing import Readings, keep_sensors, preset, select_rows, select_sensors, simulate
from walkers import walk

EIGHT = preset("wii")
WALKS = {
    (f"{person}_{i}", "motion"): walk(4.0, speed=speed + 0.1 * i, period=period - 0.04 * i)
    for person, speed, period in (("slow", 0.6, 1.35), ("usual", 0.9, 1.1), ("fast", 1.2, 0.85))
    for i in range(2)
}
PEOPLE = {key: key[0].split("_")[0] for key in WALKS}


@pytest.fixture(scope="module")
def model() -> SensorModel:
    return SensorControl().fit_motions(WALKS, people=PEOPLE)


@pytest.fixture(scope="module")
def examples(model: SensorModel) -> Examples:
    return model.fitted.examples


@pytest.fixture(scope="module")
def readings() -> Readings:
    return simulate(truth(), EIGHT, np.random.default_rng(7))


def truth() -> Motion:
    return walk(4.0, speed=0.8, period=1.2)


def error(model: SensorModel, readings: Readings) -> float:
    made = model.synthesize(readings).motion.rotations
    real = resample(truth(), 60.0).rotations[: len(made)]
    return float(pose_errors(made[: len(real)], real).mean())


def error_of_mean(model: SensorModel) -> float:
    real = resample(truth(), 60.0).rotations
    mean = model.fitted.examples.space.decode(model.fitted.averages.pose[None])
    return float(pose_errors(np.repeat(mean, len(real), axis=0), real).mean())


# ---- windows ----


def test_a_windows_means_are_gaussian_and_centred_where_they_say():
    weights, after = ReadingWindow(((0.0, 0.05), (-0.3, 0.1))).weights(60.0)
    times = (np.arange(weights.shape[1]) - (weights.shape[1] - 1 - after)) / 60.0
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    np.testing.assert_allclose(weights @ times, [0.0, -0.3], atol=1e-9)
    assert after == 6


def test_looking_less_far_ahead_leaves_out_later_means_only():
    window = ReadingWindow()
    assert window.within(0.25) == window
    assert all(t + 2 * s <= 0.15 + 1e-9 or t <= 0 for t, s in window.within(0.15).means)
    assert window.within(0.15).weights(60.0)[1] == 9
    assert window.within(0.0).means == tuple(m for m in window.means if m[0] <= 0)
    assert KernelRidge(ahead=0.15).lag_frames(60.0) == 9


def test_features_of_frames_that_arrive_are_those_of_the_whole(examples: Examples):
    weights, after = ReadingWindow().weights(60.0)
    features = WindowFeatures(weights, after, len(examples.names))
    start, stop = int(examples.starts[2]), int(examples.starts[3])
    whole = features.at(examples.readings, examples.starts, np.arange(start, stop))
    buffer = WindowBuffer(features, examples.readings.shape[1], 60.0)
    every, none = np.ones(24, dtype=np.bool_), np.zeros(24, dtype=np.bool_)
    made = []
    for row in examples.readings[start:stop]:
        buffer.add(row.astype(np.float64), every)
        made.append(buffer.of(features))
    for _ in range(after):
        buffer.add(np.zeros(24), none)
        made.append(buffer.of(features))
    np.testing.assert_allclose(np.array(made[after:]), whole, atol=1e-4)


def test_a_sensor_counts_while_it_was_there_for_half_of_the_time_about_a_frame():
    weights, after = ReadingWindow().weights(60.0)
    buffer = WindowBuffer(WindowFeatures(weights, after, 2), 6, 60.0)
    both, one = np.ones(6, dtype=np.bool_), np.repeat([True, False], 3)
    for _ in range(60):
        buffer.add(np.ones(6), both)
    gone = []
    for frame in range(40):
        buffer.add(np.full(6, 2.0), one)
        if not buffer.sensors[1]:
            gone.append(frame + 1 - after)
    assert buffer.sensors[0]
    assert abs(gone[0]) <= 1  # at the frame from which on it is missing


# ---- people, and what is chosen by leaving them out ----


def test_people_are_left_out_else_takes_else_parts_of_a_take(examples: Examples):
    rows = np.arange(0, len(examples), 6)
    assert len(groups_of(examples, rows)) == 3
    alone = replace(examples, people=("one",) * 6)
    assert len(groups_of(alone, rows)) == 6
    single = replace(alone, takes=alone.takes[:1], people=("one",), starts=np.array([0, len(examples)]))
    parts = groups_of(single, rows)
    assert len(parts) == 5
    assert all(np.diff(part).max() == 1 for part in parts)


def test_a_take_whose_person_is_not_known_is_a_person_of_its_own():
    some = dict(list(WALKS.items())[:3])
    made = build_examples(
        some.items(), SensorControl().setup, np.random.default_rng(0), people={("slow_0", "motion"): "a"}
    )
    assert made.people == ("a", "slow_1", "usual_0")


def test_the_error_to_expect_is_that_of_people_left_out_and_grows_with_the_distance(examples: Examples):
    fit = fit_ridge(examples, KernelRidge().settings)
    expected = fit.expected
    assert (np.diff(expected.distances) >= 0).all()
    assert (np.diff(expected.degrees) >= 0).all()
    assert expected.degrees[0] <= expected.usual <= expected.degrees[-1]
    assert expected.trust(0.0) == 1.0
    assert expected.trust(10.0 * expected.distances[-1]) == 0.0


def test_far_away_the_error_to_expect_is_the_mean_poses(examples: Examples):
    poses = examples.poses[::20].astype(np.float64)
    found = expected_errors(examples.space, np.linspace(1.0, 2.0, len(poses)), poses, poses)
    assert found.at(1.0)[0] == pytest.approx(0.0, abs=1e-5)
    mean = examples.space.decode(poses.mean(axis=0, keepdims=True))
    still = rot.angle_between(mean, examples.space.decode(poses))[:, examples.space.joints].mean()
    assert found.at(100.0)[0] == pytest.approx(np.degrees(still), rel=1e-6)


def test_nobody_to_leave_out_is_no_obstacle(readings: Readings):
    alone = SensorControl().fit_motions({("only", "motion"): walk(1.0, speed=0.9)})
    assert np.isfinite(alone.synthesize(readings).motion.rotations).all()


# ---- estimates ----


def test_somebody_who_is_not_in_the_library_is_estimated_better_than_by_continuity(data_folder: Path):
    names = ("06_15", "124_03", "124_04", "144_07", "64_01", "64_05")
    files = [data_folder / "sports" / f"{name}_amass30.bvh" for name in names]
    if not all(file.exists() for file in files):
        pytest.skip("no recordings of several people: sports is missing")
    stranger, *others = (kg.load(file).motion() for file in files)
    people = {(name, "motion"): name.split("_")[0] for name in names[1:]}
    wanted, readings = resample(stranger, 60.0).rotations, simulate(stranger, EIGHT, np.random.default_rng(1))
    errors = {}
    for synthesis in (Guided(), Continuity()):
        method = SensorControl(synthesis=synthesis, clean_feet=False)
        known = method.fit_motions(dict(zip(people, others, strict=True)), people=people)
        made = known.synthesize(readings).motion.rotations
        errors[type(synthesis)] = pose_errors(made[: len(wanted)], wanted[: len(made)]).mean()
    assert errors[Guided] < errors[Continuity]


@pytest.mark.parametrize("name", EIGHT.names)
def test_one_sensor_left_is_not_worse_than_the_mean_pose(model: SensorModel, readings: Readings, name: str):
    assert error(model, select_sensors(readings, (name,))) < error_of_mean(model)


@pytest.mark.parametrize("count", [1, 2, 4])
def test_layouts_of_few_sensors_are_not_worse_than_the_mean_pose(readings: Readings, count: int):
    layout = keep_sensors(EIGHT, EIGHT.names[:count])
    few = SensorControl(layout=layout).fit_motions(WALKS, people=PEOPLE)
    assert error(few, select_sensors(readings, layout.names)) < error_of_mean(few)


def test_a_sensor_that_falls_silent_is_done_without(model: SensorModel, readings: Readings):
    dead = readings.names.index("right_shank")
    part = select_rows(readings, ~((readings.sensors == dead) & (readings.times > 1.5)))
    assert error(model, part) < 1.5 * error(model, readings)
    assert len(model.fitted.ridge.of_some) > 0
    live = model.start()
    for low in np.arange(0.0, part.duration + 0.3, 0.3):
        live.step(select_rows(part, (part.times >= low) & (part.times < low + 0.3)))
    np.testing.assert_allclose(live.finish().motion.rotations, model.synthesize(part).motion.rotations, atol=1e-6)


def test_a_gap_is_held_where_it_is_though_answers_look_back(model: SensorModel, readings: Readings):
    gap = select_rows(readings, (readings.times < 1.5) | (readings.times > 2.5))
    made = model.synthesize(gap).motion.rotations
    whole = model.synthesize(readings).motion.rotations
    before = pose_errors(made[:60], whole[:60]).mean()
    after = pose_errors(made[190:220], whole[190:220]).mean()
    assert before < 1.0
    assert after < 3.0  # degrees; poses are not late by the gap


def test_settings_that_cannot_be_are_refused():
    for make, message in (
        (lambda: Guided(share=1.5), "share must be from 0 to 1, found 1.5"),
        (lambda: Guided(weight=-1.0), "weight must be 0 or more, found -1"),
        (lambda: KernelRidge(ahead=-0.1), "ahead must be 0 or more seconds, found -0.1"),
        (lambda: KernelRidge(every=0.0), "every must be a positive number, found 0"),
    ):
        with pytest.raises(RequestError, match=message):
            make()


def test_a_fit_of_another_synthesis_is_refused(model: SensorModel):
    other = SensorControl(synthesis=Continuity()).fit_motions(WALKS)
    for synthesis, message in ((Guided(), "no regression"), (KernelRidge(), "no regression")):
        with pytest.raises(RequestError, match=message):
            replace(other, method=SensorControl(synthesis=synthesis)).estimator()


def test_readings_far_from_the_librarys_are_warned_of_in_degrees():
    statistics = {"held": 0.0, "missing": 0.0, "far": 0.5, "expected": 20.0, "usual": 10.0}
    (line,) = warnings_of(statistics, ("a", "b"), {"a", "b"})
    assert "expect errors of about 20 degrees a joint" in line
    assert "have 10" in line
    assert warnings_of({**statistics, "expected": 11.0}, ("a", "b"), {"a", "b"}) == ()
