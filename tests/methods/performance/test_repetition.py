"""Repetition: steps that fit about as well are used in turn, on either side, and what that gives up is known."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.methods.performance import (
    PerformanceControl,
    PerformanceModel,
    most_used,
    partner_control,
    times_running,
)
from kinetograph.signal import Signal
from kinetograph.synthesis import Piece
from kinetograph.take import Annotation, Take
from walkers import walk

_FPS = 30.0


def _library(folder: Path) -> kg.Library:
    """Twelve steps of slightly different speeds."""
    times = np.arange(round(6 * _FPS) + 1) / _FPS
    motion = walk(6.0, speed=1.0 + 0.04 * np.sin(2.3 * times))
    cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(13) * 0.5)
    library = kg.Library.create(folder / "library")
    library.add(Take("walk", {"body": motion}, cuts))
    return library


def _circle(seconds: float) -> Signal:
    """A circle of 4 m, which nobody has walked: all steps miss it by about as much."""
    angle = np.arange(round(seconds * _FPS) + 1) / _FPS / 4.0
    places = 4.0 * np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)], axis=-1)
    return Signal(places[:, None], ("path",), "m", _FPS)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> kg.Library:
    return _library(tmp_path_factory.mktemp("repetition"))


@pytest.mark.parametrize("mirror", [False, True])
def test_a_circle_is_walked_with_all_steps_in_turn(library: kg.Library, mirror: bool) -> None:
    method = PerformanceControl(mirror=mirror)
    varied = method.fit(library).synthesize(_circle(60.0))
    free = replace(method, reuse=0.0).fit(library).synthesize(_circle(60.0))
    assert most_used(free.pieces) > 0.25
    assert most_used(varied.pieces) < 0.12  # an even share would be 1 / 12
    assert times_running(varied.pieces) == 1 < times_running(free.pieces)
    assert varied.statistics["most_used"] == most_used(varied.pieces)
    assert varied.cost > free.cost


def test_what_reuse_gives_up_is_the_cost_above_the_optimum(library: kg.Library) -> None:
    method, path = PerformanceControl(fine_rate=None), _circle(20.0)
    model = method.fit(library)
    optimum = replace(method, reuse=0.0).fit(library)
    found, best = model.interpret(path), optimum.interpret(path)
    assert best.proved
    assert not found.proved
    assert model.gap(path) == pytest.approx((found.score - found.reuse) / best.score - 1.0)
    assert model.gap(path) > 0.0
    assert optimum.gap(path) == 0.0
    result = model.synthesize(path)
    assert sum(piece.cost + piece.seam for piece in result.pieces) == pytest.approx(found.score - found.reuse, rel=1e-4)
    assert result.costs["reuse"] == found.reuse


def test_what_was_recorded_is_still_performed_as_it_was(library: kg.Library) -> None:
    recorded = library.take("walk").motion()
    result = PerformanceControl(stretch=0.0).fit(library).synthesize(recorded)
    assert [piece.source_start for piece in result.pieces] == pytest.approx([piece.start for piece in result.pieces])


def test_live_varies_as_offline(library: kg.Library) -> None:
    model, path = PerformanceControl().fit(library), _circle(20.0)
    live = model.start(_FPS)
    for frame in model.method.control_points.points(path):
        live.step(frame)
    np.testing.assert_array_equal(live.path().states, model.interpret(path).states)


def test_partners_reuse_for_nothing() -> None:
    assert partner_control().reuse == 0.0


def test_counts_whatever_the_side_and_the_stretch() -> None:
    def piece(start: float, at: float, *, mirrored: bool = False, stretch: float = 1.0) -> Piece:
        return Piece("walk", "body", start, start + 0.5, at, at + 0.5 * stretch, mirrored=mirrored)

    same = [piece(0.0, 0.0), piece(0.0, 0.5, mirrored=True), piece(0.0, 1.0, stretch=1.4)]
    assert (most_used(same), times_running(same)) == (1.0, 3)
    strides = [piece(0.5 * (i % 2), 0.5 * i) for i in range(8)]
    assert (most_used(strides), times_running(strides)) == (0.5, 4)
    various = [piece(0.5 * i, 0.5 * i) for i in range(5)]
    assert (most_used(various), times_running(various)) == (0.2, 1)
    assert (most_used([]), times_running([])) == (0.0, 1)


def test_a_model_of_fitted_data_keeps_its_cost(library: kg.Library) -> None:
    fitted = PerformanceControl().fit(library).fitted
    reuse = PerformanceModel(fitted).fitted.reuse
    assert reuse is not None
    assert reuse.weights[0] == pytest.approx(0.8)
    assert reuse.weights[2] == pytest.approx(0.5 * 38 / 40)
    assert len(reuse.weights) == 40
