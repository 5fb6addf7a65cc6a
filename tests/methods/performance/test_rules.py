"""Pinned and forbidden pieces, and what a control is seen to be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.errors import RequestError
from kinetograph.methods.performance import (
    PerformanceControl,
    PerformanceModel,
    Rule,
    at_rate,
    interpret,
    points_of,
)
from kinetograph.methods.performance.interpretation import alternatives, best_sequences
from kinetograph.take import Annotation, Take
from walkers import walk

_TURNS = {"straight": 0.0, "left": 0.7, "right": -0.7}


def _model(folder: Path, moves: bool = True, span: int = 1) -> PerformanceModel:
    library = kg.Library.create(folder / "library")
    for name, turn in _TURNS.items():
        motion = walk(6.0, turn_rate=turn)
        cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(13) / 2)
        named = (Annotation("body", "move", f"{name} step", 0.0, 6.0),) if moves else ()
        library.add(Take(name, {"body": motion}, (*cuts, *named)))
    return PerformanceControl(stretch=0.0, continuity=0.01, span=span).fit(library)


def _control() -> kg.Motion:
    times = np.arange(181) / 30
    return walk(6.0, turn_rate=np.where(times < 2, 0.0, np.where(times < 4, 0.7, -0.7)))


def test_moves_are_transcribed_with_their_times(tmp_path: Path) -> None:
    rows = _model(tmp_path).transcribe(_control())
    assert [row.move for row in rows] == ["straight step", "left step", "right step"]
    np.testing.assert_allclose([row.start for row in rows], [0.0, 2.0, 4.0], atol=0.3)
    assert rows[-1].stop == pytest.approx(6.0, abs=0.5)
    assert all(row.margin > 0 for row in rows)


def test_a_forbidden_take_gives_way_where_it_is_forbidden(tmp_path: Path) -> None:
    model = _model(tmp_path)
    free = model.synthesize(_control())
    bound = model.synthesize(_control(), rules=(Rule(2.0, 4.0, take="left", forbid=True),))
    assert any(p.take == "left" for p in free.pieces)
    assert not any(p.take == "left" and p.start < 4.0 and p.stop > 2.0 for p in bound.pieces)
    assert bound.cost > free.cost


def test_a_pinned_take_is_used_where_it_is_pinned(tmp_path: Path) -> None:
    bound = _model(tmp_path).synthesize(_control(), rules=(Rule(0.5, 1.5, take="right"), Rule(5.5, 6.5, take="left")))
    touched = [p.take for p in bound.pieces if p.start < 1.5 - 1e-6 and p.stop > 0.5 + 1e-6]
    assert set(touched) == {"right"}
    assert bound.pieces[-1].take == "left"


def test_a_second_of_a_take_can_be_asked_for(tmp_path: Path) -> None:
    bound = _model(tmp_path).synthesize(_control(), rules=(Rule(1.0, 1.2, take="straight", source=3.2),))
    piece = next(p for p in bound.pieces if p.start <= 1.0 < p.stop)
    assert piece.source_start <= 3.2 < piece.source_stop


def test_one_of_several_pieces_that_overlap_can_be_asked_for(tmp_path: Path) -> None:
    model = _model(tmp_path, span=3)
    holding = {
        (s.start, s.stop)
        for s in model.fitted.instances.segments
        if model.fitted.sources[s.source].take == "straight" and s.start <= 3.2 < s.stop
    }
    assert len(holding) > 1  # segments overlap
    for start, stop in holding:
        rule = Rule(1.0, 1.2, take="straight", source=(round(start, 4), round(stop, 4)))
        there = next(p for p in model.synthesize(_control(), rules=(rule,)).pieces if p.start <= 1.1 < p.stop)
        assert (there.take, there.source_start, there.source_stop) == ("straight", start, stop)
    with pytest.raises(RequestError, match=r"take 'straight', 3\.1 to 3\.3 s of it from 1 to 1\.2 s"):
        model.synthesize(_control(), rules=(Rule(1.0, 1.2, take="straight", source=(3.1, 3.3)),))


def test_rules_that_cannot_be_met(tmp_path: Path) -> None:
    model = _model(tmp_path, moves=False)
    with pytest.raises(RequestError, match="matches the rule take 'backwards' from 0 to 1 s; library info"):
        model.synthesize(_control(), rules=(Rule(0.0, 1.0, take="backwards"),))
    with pytest.raises(RequestError, match=r"from a start to a later stop, found 2\.0 and 1\.0"):
        Rule(2.0, 1.0)
    with pytest.raises(RequestError, match="the library names no moves; annotate some of kind 'move'"):
        model.transcribe(_control())


def test_alternatives_share_no_piece_and_come_cheapest_first(tmp_path: Path) -> None:
    model = _model(tmp_path)
    x = at_rate(points_of(model.method, _control()), 30.0, model.method.rate)
    found = alternatives(model.fitted, x, 3)
    scores = [path.score for path in found]
    assert len(found) == 3
    assert scores[0] == pytest.approx(interpret(model.fitted, x).score)
    assert scores == sorted(scores)
    shown = [
        {
            (int(model.fitted.instances.states[s, 0]), t)
            for s, a, b in zip(p.states, p.starts, p.stops, strict=True)
            for t in range(a, b)
        }
        for p in found
    ]
    assert not shown[0] & shown[1]
    assert not shown[2] & (shown[0] | shown[1])


def test_there_are_no_more_alternatives_than_recordings_allow(tmp_path: Path) -> None:
    model = _model(tmp_path)
    x = at_rate(points_of(model.method, _control()), 30.0, model.method.rate)
    only = Rule(0.0, 6.0, take="straight", source=3.2)
    assert len(alternatives(model.fitted, x[:9], 4, (only,))) == 1


def test_the_best_sequences_come_in_order_and_keep_the_rules(tmp_path: Path) -> None:
    model = _model(tmp_path)
    x = at_rate(points_of(model.method, _control()), 30.0, model.method.rate)
    rule = Rule(2.0, 4.0, take="left", forbid=True)
    for rules in ((), (rule,)):
        found = best_sequences(model.fitted, x, 5, rules)
        scores = np.array([p.score for p in found])
        assert scores[0] == pytest.approx(interpret(model.fitted, x, rules=rules).score, rel=1e-9)
        assert np.all(np.diff(scores) >= 0)
        assert len({(tuple(p.states), tuple(p.stops)) for p in found}) == 5
    segments = [model.fitted.instances.segments[i] for p in found for i in model.fitted.instances.states[p.states, 0]]
    starts = [t for p in found for t in zip(p.starts, p.stops, strict=True)]
    for segment, (start, stop) in zip(segments, starts, strict=True):
        inside = start < 4.0 * model.method.rate and stop > 2.0 * model.method.rate
        assert not (inside and model.fitted.sources[segment.source].take == "left")


def test_a_transcript_keeps_the_rules_that_the_motion_was_made_by(tmp_path: Path) -> None:
    model = _model(tmp_path)
    free = [row.move for row in model.transcribe(_control())]
    bound = model.transcribe(_control(), (Rule(2.0, 4.0, take="left", forbid=True),))
    made = model.synthesize(_control(), rules=(Rule(2.0, 4.0, take="left", forbid=True),))
    assert [row.move for row in bound] != free
    for row in bound:
        middle = 0.5 * (row.start + row.stop)
        moves = {n.label for n in made.annotations if n.kind == "move" and n.start - 0.2 <= middle <= n.stop + 0.2}
        assert row.move in moves
