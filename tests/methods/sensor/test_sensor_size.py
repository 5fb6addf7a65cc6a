"""Sensor control of large libraries: what is bounded, and that it changes nothing on small ones."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from kinetograph.evaluation.sensor_scores import pose_errors
from kinetograph.learn import NeighbourLists
from kinetograph.library import Library
from kinetograph.methods.sensor import (
    Continuity,
    Interpolation,
    LocalModelSettings,
    Optimisation,
    SensorControl,
    build_examples,
    local_models,
    trust,
)
from kinetograph.methods.sensor.fitted import averages_of
from kinetograph.methods.sensor.root import fit_root_model, root_features
from kinetograph.motion import resample
from kinetograph.pipeline import fit_sensor
from kinetograph.sensing import preset, simulate
from kinetograph.take import Take
from walkers import walk

WALKS = {
    (f"{i:02d}", "motion"): walk(4.0, speed=0.7 + 0.06 * i, period=1.35 - 0.05 * i, turn_rate=0.1 * (i % 3))
    for i in range(12)
}
QUERY = simulate(walk(4.0, speed=1.02, period=1.07), preset("wii"), np.random.default_rng(7))
LOCAL = LocalModelSettings(runs=1, clusters=10, frames=600, centres=60)


def examples_of_walks():
    method = SensorControl()
    return build_examples(WALKS.items(), method.setup, np.random.default_rng(0))


def test_examples_are_those_of_double_precision_to_a_rounding():
    examples = examples_of_walks()
    at_rate = [resample(motion, 60.0) for motion in WALKS.values()]
    poses = np.concatenate([examples.space.encode(motion) for motion in at_rate])
    root = fit_root_model(at_rate)
    features = np.concatenate([root_features(motion, root) for motion in at_rate])
    for stored, exact in ((examples.poses, poses), (examples.root_features, features)):
        assert stored.dtype == np.float32
        np.testing.assert_allclose(stored, exact, atol=1e-6)
    assert examples.root.level == pytest.approx(root.level, abs=1e-9)
    angles = pose_errors(examples.space.decode(examples.poses.astype(float)), examples.space.decode(poses))
    assert angles.max() < 1e-3  # degrees


def test_motions_are_asked_for_one_at_a_time():
    alive: list[str] = []

    def stream():
        for (name, track), motion in WALKS.items():
            alive.append(name)
            yield (name, track), motion

    made: list[int] = []
    build_examples(
        stream(),
        SensorControl().setup,
        np.random.default_rng(0),
        count=12,
        progress=lambda d, _: made.append(len(alive)),
    )
    assert made == list(range(1, 13))


@pytest.mark.parametrize("sensors", [slice(0, 8), slice(0, 3)])
def test_retrieval_estimates_what_a_scan_does(sensors):
    names = preset("wii").names[sensors]
    readings = replace(QUERY)
    chosen = np.isin(readings.sensors, [QUERY.names.index(name) for name in names])
    part = replace(QUERY, times=QUERY.times[chosen], sensors=QUERY.sensors[chosen], force=QUERY.force[chosen])
    scan = SensorControl(synthesis=Continuity()).fit_motions(WALKS)
    near = SensorControl(synthesis=Continuity(scanned=0)).fit_motions(WALKS)
    assert isinstance(near.fitted.search, NeighbourLists)
    one, other = (model.synthesize(part).motion.rotations for model in (scan, near))
    assert pose_errors(one, other).mean() < 0.2  # degrees
    np.testing.assert_allclose(near.fitted.strengths, scan.fitted.strengths, atol=0.5)


def test_shrinkage_is_learnt_from_a_fixed_number_of_frames_and_a_fold_is_prepared_once(monkeypatch):
    monkeypatch.setattr(trust, "FRAMES", 300)
    examples, steps, prepared = examples_of_walks(), [], []
    synthesis = Continuity()
    fit = synthesis.learn(examples, np.random.default_rng(0))

    class Counting:
        def __init__(self, inner):
            self.inner, self.lag = inner, inner.lag

        def step(self, readings, valid):
            steps.append(1)
            return self.inner.step(readings, valid)

    def of_takes(kept):
        prepared.append(kept)
        return lambda: Counting(synthesis.estimator(replace(fit, strengths=None)))

    calls: list[tuple[int, int]] = []
    trust.learn_shrinkage(examples, averages_of(examples), of_takes, lambda done, total: calls.append((done, total)))
    assert len(prepared) == 3
    assert [int(kept.sum()) for kept in prepared] == [8, 8, 8]
    assert len(steps) == 5 * (60 + 3)  # 300 frames of five takes, and the lag of each
    assert calls == [(done, 5) for done in range(1, 6)]


@pytest.mark.parametrize("synthesis", [Interpolation(LOCAL), Optimisation(local=LOCAL)])
def test_local_models_are_learnt_from_some_frames_and_say_so(synthesis, monkeypatch):
    method = SensorControl(synthesis=synthesis)
    whole = method.fit_motions(WALKS)
    assert "learnt from" not in whole.fitted.local.notes[0]
    monkeypatch.setattr(local_models, "MOST", 1500)
    some = method.fit_motions(WALKS)
    frames = len(some.fitted.examples)
    assert f"learnt from 1500 of {frames} frames" in some.fitted.local.notes[0]
    assert max(int(cluster.centres.max()) for cluster in some.fitted.local.clusters) > 1500
    one, other = (model.synthesize(QUERY).motion.rotations for model in (whole, some))
    assert pose_errors(one, other).mean() < 3.0


def test_a_second_fit_is_read_and_gives_the_same(tmp_path: Path, monkeypatch):
    monkeypatch.delenv("KINETOGRAPH_KEEP", raising=False)
    library = Library.create(tmp_path / "walks")
    for (name, _), motion in list(WALKS.items())[:9]:
        library.add(Take(name, {"motion": motion}))
    library.add(Take("blink", {"motion": walk(0.3)}))
    method = SensorControl(synthesis=Continuity(scanned=100))
    first = fit_sensor(method, library)
    calls: list[int] = []
    second = fit_sensor(replace(method, clean_feet=False), library, progress=lambda done, total: calls.append(done))
    assert calls == []
    assert not second.method.clean_feet
    assert second.notes == first.notes == ("1 take left out: shorter than 0.5 s (blink)",)
    for field in fields(first.fitted.examples):
        if isinstance(value := getattr(first.fitted.examples, field.name), np.ndarray):
            np.testing.assert_array_equal(value, getattr(second.fitted.examples, field.name))
    one, other = (model.start() for model in (first, second))
    for live in (one, other):
        live.step(QUERY)
    np.testing.assert_array_equal(one.finish().uncertainty, other.finish().uncertainty)
