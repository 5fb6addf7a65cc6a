from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.evaluation.real_sensors import evaluate_recordings, neura
from kinetograph.evaluation.sensor import evaluate, fitted_to, together
from kinetograph.evaluation.sensor_folds import HeldOut, blocks, folds, grouped
from kinetograph.evaluation.sensor_baselines import ridge
from kinetograph.evaluation.sensor_scores import averaged, normalised_rms, pose_errors, score
from kinetograph.evaluation.sensor_sweep import spread_out, sweep
from kinetograph.library import Library
from kinetograph.methods.sensor import Continuity, Interpolation, LocalModelSettings, Optimisation, SensorControl
from kinetograph.sensing import preset
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
    rows, joints = evaluate(
        library, SensorControl(), syntheses={"continuity": Continuity()}, held=HeldOut(groups={"a": "slow"})
    )
    assert {(r.group, r.method) for r in rows} >= {("slow", "mean pose"), ("slow", "continuity"), ("all", "ridge")}
    best = {r.method: r.angle for r in rows if r.group == "all"}
    assert best["continuity"] < best["mean pose"]
    assert all(np.isfinite(r.p99_ms) for r in rows if r.method == "continuity")
    assert joints["continuity"].shape == (len(walk(0.1).skeleton),)
    assert len(averaged(rows)) == len(rows)


def test_a_library_of_one_take_is_cut_into_blocks(tmp_path: Path):
    single = Library.create(tmp_path / "one")
    single.add(Take("only", {"motion": walk(12.0)}))
    rows, _ = evaluate(single, SensorControl(), syntheses={})
    assert rows[0].takes == 5


def test_a_sweep_begins_with_no_growth(library: Library):
    rows = sweep(library, SensorControl(), "loss", held=HeldOut(only=("b",)))
    assert [r.value for r in rows] == [0.0, 0.1, 0.2, 0.3]
    assert rows[0].growth == 0.0
    fewer = sweep(library, SensorControl(), "sensors", held=HeldOut(only=("b",)))
    assert [int(r.value) for r in fewer] == [1, 2, 4, 6, 8]
    with pytest.raises(RequestError, match="no sweep 'rain'; expected one of loss, offset, span, sensors"):
        sweep(library, SensorControl(), "rain")


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
        evaluate_recordings(tmp_path, library)


def test_real_sensors_of_a_walk_are_calibrated_and_beat_the_mean_pose(data_folder: Path):
    folder = data_folder / "sensors" / "neura"
    if not folder.is_dir():
        pytest.skip("no recordings of real sensors: sensors/neura is missing")
    (row,) = neura(folder)
    assert row.angle < 0.7 * row.mean_pose
    assert 0.0 <= row.clock_ms <= 40.0
    assert row.residual < 0.5 * row.uncalibrated
    assert row.accepted == 7


def test_a_take_to_hold_out_that_is_not_there_is_refused(library: Library):
    with pytest.raises(RequestError, match="no take 'bb' to hold out; there are a, b, c"):
        folds(library, SensorControl(), HeldOut(only=("bb",)))
