"""Folds of sensor control: what takes give to examples is simulated once, and shared work gives the same rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinetograph.evaluation import HeldOut, evaluate, together
from kinetograph.evaluation.sensor_folds import folds
from kinetograph.library import Library
from kinetograph.methods.sensor import SYNTHESES, SensorControl, build_examples, example_motions
from kinetograph.sensing import faultless, simulate_kinds
from kinetograph.take import Take
from kinetograph.work import Workers
from walkers import walk


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Library:
    made = Library.create(tmp_path_factory.mktemp("sensed") / "walks")
    for number in range(4):
        made.add(Take(f"walk_{number}", {"motion": walk(3.0, turn_rate=0.3 * number - 0.4)}))
    return made


def test_a_fold_has_the_examples_that_are_built_of_the_others(library: Library) -> None:
    method, motions = SensorControl(), example_motions(library)
    rng = np.random.default_rng(method.seed)
    kinds = method.setup.kinds
    rows = {key: simulate_kinds(motion, faultless(method.layout), kinds, rng) for key, motion in motions.items()}
    for build, left in zip(folds(library, method, HeldOut()), motions, strict=True):
        others = [(key, motion) for key, motion in motions.items() if key != left]
        expected, made = build_examples(others, method.setup, np.random.default_rng(9), rows), build().examples
        for name in ("poses", "root_features", "readings", "scale", "starts"):
            assert np.array_equal(getattr(made, name), getattr(expected, name))
        assert made.takes == expected.takes


def test_processes_give_the_same_rows(library: Library) -> None:
    syntheses = {"continuity": SYNTHESES["continuity"]}
    here = together(list(evaluate(library, SensorControl(), syntheses=syntheses)))
    there = together(list(evaluate(library, SensorControl(), syntheses=syntheses, workers=Workers(2))))
    untimed = [[repr(replace(row, p50_ms=0.0, p99_ms=0.0)) for row in one.rows] for one in (here, there)]
    assert untimed[0] == untimed[1]
    assert len({row.take for row in here.rows}) == 4
    assert np.array_equal(here.joints["continuity"], there.joints["continuity"])
