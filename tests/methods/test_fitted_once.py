"""A method that is fitted once gives, the next time, the same results to the last bit, and is not fitted again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.keys import key_at
from kinetograph.library import Library, entries
from kinetograph.methods.keyframe import ClusterChain, KeyframeControl, TimedSearch
from kinetograph.methods.performance import PerformanceControl
from kinetograph.pipeline import fit_keyframe, fit_performance, winding_path
from kinetograph.post import PostSettings
from kinetograph.synthesis import Synthesis
from kinetograph.take import Annotation, Take
from walkers import walk


@pytest.fixture
def library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Library:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    monkeypatch.delenv("KINETOGRAPH_KEEP", raising=False)
    made = Library.create(tmp_path / "walks")
    for name, turn in (("straight", 0.0), ("left", 0.6), ("right", -0.6)):
        cuts = tuple(Annotation("motion", "cut", "", t, t) for t in np.arange(13) / 2)
        made.add(Take(name, {"motion": walk(6.0, turn_rate=turn)}, cuts))
    return made


def _same(a: Synthesis, b: Synthesis) -> bool:
    motions = ((a.motion.rotations, b.motion.rotations), (a.motion.translation, b.motion.translation))
    return a.cost == b.cost and a.pieces == b.pieces and all(np.array_equal(*pair) for pair in motions)


def _refuse(*_: Any, **__: Any) -> Any:
    raise AssertionError("fitted again")


def test_a_second_performance_is_the_first(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    method, path = PerformanceControl(mirror=True), winding_path()
    expected = method.fit(library).synthesize(path)
    first = fit_performance(method, library).synthesize(path)
    monkeypatch.setattr(PerformanceControl, "fit", _refuse)
    second = fit_performance(method, library)
    assert _same(expected, first)
    assert _same(expected, second.synthesize(path))
    assert second.notes == ()
    later = replace(method, post=PostSettings(footskate=False), beam=0.1, first_facing=1.0)
    assert fit_performance(later, library).method == later
    with pytest.raises(AssertionError, match="fitted again"):
        fit_performance(replace(method, stretch=0.1), library)
    with pytest.raises(AssertionError, match="fitted again"):
        fit_performance(method, library, exclude=["left"])


def test_a_fit_for_the_beam_is_that_of_the_beam(library: Library) -> None:
    method, path = PerformanceControl(beam=0.1, post=PostSettings(footskate=False)), winding_path()
    fit_performance(PerformanceControl(), library)
    assert len(entries(library)) == 1
    assert _same(method.fit(library).synthesize(path), fit_performance(method, library).synthesize(path))
    assert len(entries(library)) == 1


@pytest.mark.parametrize(
    "solver", [TimedSearch(), TimedSearch(moves=("left",)), TimedSearch(without=("left",), warp=0.1), ClusterChain(3)]
)
def test_a_second_motion_between_keys_is_the_first(
    library: Library, monkeypatch: pytest.MonkeyPatch, solver: Any
) -> None:
    method = KeyframeControl(solver=solver)
    clip = library.take("straight").motion()
    keys = (key_at(clip, 1.0, label="a"), key_at(library.take("right").motion(), 3.0, label="b"))
    expected = method.fit(library).synthesize(keys)
    first = fit_keyframe(method, library).synthesize(keys)
    monkeypatch.setattr(KeyframeControl, "fit", _refuse)
    second = fit_keyframe(method, library)
    assert second.method == method
    assert _same(expected, first)
    assert _same(expected, second.synthesize(keys))
    with pytest.raises(AssertionError, match="fitted again"):
        fit_keyframe(method, library, exclude=["left"])


def test_another_library_of_the_same_takes_is_fitted_by_itself(library: Library, tmp_path: Path) -> None:
    other = kg.Library.create(tmp_path / "other")
    for name in reversed(library.names()):
        other.add(library.take(name))
    fit_performance(PerformanceControl(), library)
    assert fit_performance(PerformanceControl(), other).fitted.sources[0].take == "right"
