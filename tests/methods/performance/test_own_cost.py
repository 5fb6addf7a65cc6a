"""What the library's segments cost each other, by brute force, and the warning that follows."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.methods.performance import PerformanceControl
from kinetograph.methods.performance.own_cost import NEAR, own_cost
from kinetograph.methods.performance.weights import weights
from kinetograph.take import Annotation, Take
from walkers import walk


@pytest.fixture
def library(tmp_path: Path) -> kg.Library:
    library = kg.Library.create(tmp_path / "library")
    for name, turn in (("straight", 0.0), ("left", 0.4), ("right", -0.3)):
        cuts = tuple(Annotation("motion", "cut", "", t, t) for t in np.arange(0.0, 6.1, 0.5))
        library.add(Take(name, {"motion": walk(6.0, turn_rate=turn)}, cuts))
    return library


def test_segments_are_explained_by_the_most_like_of_another_take(
    library: kg.Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.modules[own_cost.__module__], "NEAR", 0.0)
    fitted = PerformanceControl(stretch=0.1).fit(library).fitted
    instances, costs = fitted.instances, []
    states = [tuple(map(int, state)) for state in instances.states]
    samples = {steps: dict(zip(instances.states[instances.members(steps), 0], rows, strict=True))
               for steps, rows in instances.controls.items()}  # fmt: skip
    for index, segment in enumerate(instances.segments):
        if segment.held:
            continue
        steps = round(segment.duration * fitted.settings.rate)
        take = fitted.sources[segment.source].take
        others = [i for i, d in states if d == steps and fitted.sources[instances.segments[i].source].take != take]
        window, examples = samples[steps][index][None], np.stack([samples[steps][i] for i in others])
        cost, _ = fitted.settings.alignment.align(window, examples, weights(fitted.settings, steps + 1))
        costs.append(cost.min() * fitted.settings.rate / steps)
    assert own_cost(fitted.settings, fitted.sources, instances) == pytest.approx(np.mean(costs), rel=1e-6)


def test_takes_that_are_alike_cost_each_other_what_being_near_costs(tmp_path: Path) -> None:
    library = kg.Library.create(tmp_path / "twins")
    for name in ("one", "two"):
        cuts = tuple(Annotation("motion", "cut", "", t, t) for t in np.arange(0.0, 6.1, 0.5))
        library.add(Take(name, {"motion": walk(6.0)}, cuts))
    fitted = PerformanceControl(stretch=0.1).fit(library).fitted
    assert fitted.own_cost == pytest.approx(2.0 * NEAR**2)  # a path has two control points


def test_a_walk_of_the_library_is_no_stranger_and_a_walk_backwards_is_one(library: kg.Library) -> None:
    model = PerformanceControl(stretch=0.1).fit(library)
    assert not [w for w in model.synthesize(walk(5.0, turn_rate=0.2)).warnings if "nothing like" in w]
    (warning,) = [w for w in model.synthesize(walk(5.0, speed=-1.0)).warnings if "nothing like" in w]
    assert "times what the library's takes cost each other" in warning


def test_a_library_of_one_short_take_knows_nothing_of_itself(tmp_path: Path) -> None:
    library = kg.Library.create(tmp_path / "one")
    cuts = tuple(Annotation("motion", "cut", "", t, t) for t in (0.0, 0.5, 1.0, 1.5))
    library.add(Take("only", {"motion": walk(1.5)}, cuts))
    model = PerformanceControl().fit(library)
    assert model.fitted.own_cost is None
