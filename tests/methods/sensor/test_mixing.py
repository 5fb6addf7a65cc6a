"""What guided estimates are mixed of: near movement, far movement, sensors that are missing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinetograph.evaluation.sensor_scores import pose_errors
from kinetograph.learn import Gate
from kinetograph.methods.sensor import Continuity, Examples, Guided, SensorControl, SensorModel
from kinetograph.methods.sensor.estimators import Estimate
from kinetograph.methods.sensor.guided import Regressed, mixture_of, shares_of_some
from kinetograph.methods.sensor.nearest import AROUND, NEAREST, NearestExamples
from kinetograph.methods.sensor.ridge import Blend, share_kept
from kinetograph.motion import resample
from kinetograph.sensing import preset, simulate
from walkers import walk

EIGHT = preset("wii")
# two takes each of six people
WALKS = {
    (f"{person}_{i}", "motion"): walk(3.0, speed=0.5 + 0.15 * person + 0.02 * i, period=1.4 - 0.1 * person)
    for person in range(6)
    for i in range(2)
}
PEOPLE = {key: key[0].split("_")[0] for key in WALKS}


@pytest.fixture(scope="module")
def model() -> SensorModel:
    return SensorControl(clean_feet=False).fit_motions(WALKS, people=PEOPLE)


@pytest.fixture(scope="module")
def examples(model: SensorModel) -> Examples:
    return model.fitted.examples


def blend_of(model: SensorModel) -> Blend:
    assert model.fitted.blend is not None
    return model.fitted.blend


def test_a_take_whose_like_is_in_the_library_is_estimated_as_well_as_by_the_nearest(model: SensorModel):
    motion = walk(3.0, speed=0.5 + 0.15 * 2 + 0.01, period=1.2)
    made = model.synthesize(simulate(motion, EIGHT, np.random.default_rng(3))).motion.rotations
    wanted = resample(motion, 60.0).rotations
    frames = min(len(made), len(wanted))
    assert pose_errors(made[:frames], wanted[:frames]).mean() < 3.0


def test_a_few_takes_of_one_person_teach_nothing_and_are_followed():
    some = dict(list(WALKS.items())[:3])
    few = SensorControl().fit_motions(some, people=dict.fromkeys(some, "one"))
    blend = blend_of(few)
    assert not blend.guided
    assert blend.strengths is None
    shares = blend.gate.shares(np.zeros((1, 2)))[0]
    assert shares[1] < 0.2
    assert shares[3] == pytest.approx(0.0, abs=1e-6)


def test_without_caution_there_is_nothing_of_the_mean_pose():
    synthesis = Guided(path=Continuity(lag=0.0, cautious=False))
    bold = SensorControl(synthesis=synthesis).fit_motions(WALKS, people=PEOPLE)
    shares = blend_of(bold).gate.shares(np.random.default_rng(0).normal(size=(20, 2)))
    np.testing.assert_allclose(shares[:, 3], 0.0, atol=1e-6)
    assert blend_of(bold).strengths is None


def test_a_share_that_is_given_is_used_everywhere():
    half = SensorControl(synthesis=Guided(share=0.3)).fit_motions(WALKS, people=PEOPLE)
    np.testing.assert_allclose(blend_of(half).gate.shares(np.full((1, 2), 9.0))[0], [0.7, 0.3, 0.0, 0.0], atol=1e-6)


def estimate(pose: float, variance: float) -> Estimate:
    return Estimate(np.full(3, pose), np.full(2, pose), np.full(3, variance), 7, 0.5)


def test_the_variance_of_a_mixture_is_that_of_drawing_from_all():
    made = mixture_of((estimate(0.0, 1.0), estimate(4.0, 3.0)), np.array([0.25, 0.75]))
    np.testing.assert_allclose(made.pose, 3.0)
    np.testing.assert_allclose(made.root, 3.0)
    rng = np.random.default_rng(0)
    which = rng.random(200_000) < 0.25
    drawn = np.where(which, rng.normal(0.0, 1.0, 200_000), rng.normal(4.0, np.sqrt(3.0), 200_000))
    np.testing.assert_allclose(made.variance, drawn.var(), rtol=0.02)


@pytest.mark.parametrize(("there", "kept"), [(1, 0.6), (5, 1.0), (8, 0.2)])
def test_fewer_sensors_leave_more_to_their_own_regression(there: int, kept: float):
    valid = np.repeat(np.arange(8) < there, 3)
    own = Regressed(estimate(0.0, 1.0), np.zeros(24), valid, sensors=8, kept=kept)
    all_of_them = np.array([0.4, 0.2, 0.3, 0.1])
    shares = shares_of_some(all_of_them, own)
    assert shares.sum() == pytest.approx(1.0)
    if there == 1:
        np.testing.assert_allclose(shares, [0.0, kept, 0.0, 1.0 - kept])
    if there == 8:
        np.testing.assert_allclose(shares, all_of_them)


def test_as_much_is_kept_as_makes_nobody_worse_than_the_mean_pose():
    rng = np.random.default_rng(1)
    still = rng.normal(size=(200, 4))
    good = 0.1 * still
    assert share_kept([(still, good), (still, good)]) == 1.0
    assert share_kept([(still, good), (still, 3.0 * rng.normal(size=(200, 4)))]) < 0.4
    assert share_kept([(still, good), (still, 10.0 * rng.normal(size=(200, 4)))]) == 0.0


def test_the_mean_of_the_nearest_does_not_jump_and_passes_through_what_is_there(examples: Examples, model: SensorModel):
    nearest = NearestExamples(examples, np.ascontiguousarray(examples.readings.T))
    every = np.ones(24, dtype=np.bool_)
    at = nearest.of(examples.readings[300].astype(np.float64), every)
    assert at.estimate.example == 300
    assert at.estimate.cost == pytest.approx(0.0, abs=1e-5)
    squares = ((examples.readings - examples.readings[300]) ** 2).mean(axis=1)
    assert at.distance == pytest.approx(np.sqrt(np.sort(squares)[:NEAREST]).mean(), abs=1e-3)
    ends = examples.readings[300].astype(np.float64), examples.readings[420].astype(np.float64)
    for count in (200, 2000):
        between = [nearest.of((1 - u) * ends[0] + u * ends[1], every).estimate.pose for u in np.linspace(0, 1, count)]
        steps = np.abs(np.diff(between, axis=0)).max()
    assert steps < 0.02  # of 2,000; a mean of equal weights jumps by the distance of its furthest over their number
    assert AROUND > NEAREST


def test_some_sensors_are_compared_by_these_alone(examples: Examples):
    nearest = NearestExamples(examples, np.ascontiguousarray(examples.readings.T))
    valid = np.repeat([True] * 4 + [False] * 4, 3)
    query = np.where(valid, examples.readings[100].astype(np.float64), 50.0)
    assert nearest.of(query, valid).estimate.example == 100


def test_shares_say_where_the_estimate_is(model: SensorModel):
    """With all shares on one estimate the mixture is that one."""
    readings = simulate(walk(2.0, speed=0.9, period=1.1), EIGHT, np.random.default_rng(4))
    found = {}
    for name, shares in (("ridge", [0.0, 1.0, 0.0, 0.0]), ("mean", [0.0, 0.0, 0.0, 1.0])):
        blend = Blend(Gate.constant(np.array(shares), 2))
        fitted = replace(model.fitted, blend=blend)
        found[name] = replace(model, fitted=fitted).synthesize(readings).motion.rotations
    mean = model.fitted.examples.space.decode(model.fitted.averages.pose[None])
    assert pose_errors(found["mean"], np.repeat(mean, len(found["mean"]), axis=0)).max() < 0.1
    assert pose_errors(found["ridge"], found["mean"]).mean() > 1.0
