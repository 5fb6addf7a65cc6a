"""Why a piece is where it is, against searches that are made to have other pieces there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.errors import DataError, RequestError
from kinetograph.library import Facts, describe_takes
from kinetograph.methods.performance import PerformanceControl, PerformanceModel, Rule, next_best
from kinetograph.take import Annotation, Take
from walkers import walk


def _path(seconds: float = 2.4, turn: float = 0.3) -> kg.Signal:
    return kg.Signal(walk(seconds, turn_rate=turn).translation[:, None] * [1.0, 0.0, 1.0], ("path",), "m", 30.0)


def _model(folder: Path, **settings: object) -> PerformanceModel:
    library = kg.Library.create(folder / "small")
    for name, turn in (("straight", 0.0), ("left", 0.6), ("right", -0.5), ("back", 0.2)):
        cuts = tuple(Annotation("body", "cut", "", t, t) for t in (0.0, 0.8, 1.6, 2.4))
        take = Take(name, {"body": walk(2.4, turn_rate=turn, speed=1.0 + 0.1 * turn)}, cuts)
        library.add(take)
    describe_takes(library, {name: Facts(subject=name[0]) for name in library.names()})
    values = {"stretch": 0.2, "continuity": 0.01, "rate": 5.0, "reuse": 0.0, "stand": False, **settings}
    return PerformanceControl(**values).fit(library)  # type: ignore[arg-type]


@pytest.mark.parametrize("second", [0.0, 1.3, 2.4])
def test_margins_are_those_of_the_best_sequences_that_have_only_one_piece_there(tmp_path: Path, second: float) -> None:
    model, control = _model(tmp_path), _path()
    reasons = model.why(control, second)
    least = model.interpret(control).score
    assert reasons.optimum == pytest.approx(least, rel=1e-6)
    assert reasons.contenders[0].chosen
    assert len(reasons.contenders) == 10
    inside = min(second, 2.4 - 1e-4)
    for each in reasons.contenders:
        middle = 0.5 * (each.piece.source_start + each.piece.source_stop)
        pin = Rule(inside, inside + 1e-5, take=each.piece.take, source=middle)
        assert reasons.optimum + each.margin == pytest.approx(model.interpret(control, rules=[pin]).score, rel=1e-5)
        assert each.terms.total == pytest.approx(reasons.optimum + each.margin, rel=1e-5)
        assert each.piece.start <= second <= each.piece.stop
    margins = [each.margin for each in reasons.contenders]
    assert margins == sorted(margins)


def test_the_first_two_are_the_best_and_the_next_best(tmp_path: Path) -> None:
    model, control = _model(tmp_path), _path()
    ours = model.why(control, 1.3, count=2).contenders
    theirs = next_best(model.fitted, model.read(control), 1.3, 1)
    assert [(c.piece.take, c.piece.source_start) for c in ours] == [
        (c.piece.take, c.piece.source_start) for c in theirs
    ]
    assert ours[1].margin == pytest.approx(theirs[1].cost - theirs[0].cost, rel=1e-4)


def test_a_rule_that_decides_is_named_and_one_that_does_not_is_not(tmp_path: Path) -> None:
    model, control = _model(tmp_path), _path()
    there = model.why(control, 1.3).chosen.piece
    decisive = Rule(1.2, 1.4, take=there.take, forbid=True)
    idle = Rule(0.0, 0.1, take="right", forbid=True)
    reasons = model.why(control, 1.3, [idle, decisive])
    assert reasons.chosen.piece.take != there.take
    (reversal,) = reasons.reversals
    assert reversal.constraint == f"the rule that forbids {decisive}"
    assert reversal.piece.take == there.take
    lost = model.interpret(control, rules=[idle, decisive]).score - model.interpret(control, rules=[idle]).score
    assert reversal.saved == pytest.approx(lost, rel=1e-5)
    assert all(each.piece.take != there.take for each in reasons.contenders)


def test_costs_that_decide_are_named(tmp_path: Path) -> None:
    model, control = _model(tmp_path, change=0.5, reuse=20.0), _path(4.8, 0.1)
    free = replace(model.fitted.settings, reuse=0.0)
    reasons = [model.why(control, second) for second in np.arange(0.2, 4.8, 0.4)]
    constraints = {other.constraint for each in reasons for other in each.reversals}
    assert constraints >= {"the cost of reuse", "the cost of a change of person or style"}
    best = PerformanceModel(replace(model.fitted, settings=free)).interpret(control).score
    for each in reasons:
        assert each.optimum == pytest.approx(best, rel=1e-5)
        assert each.chosen.terms.total == pytest.approx(each.cost, rel=1e-5)
        named = {name for one in each.contenders for name in one.without if not one.chosen}
        assert {other.constraint for other in each.reversals} >= named


def test_what_cannot_be_asked_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model, control = _model(tmp_path), _path()
    with pytest.raises(RequestError, match=r"lasts 2\.40 s, found a time of 3\.00 s"):
        model.why(control, 3.0)
    everything = [Rule(0.0, 2.4, take=take, forbid=True) for take in ("straight", "left", "right", "back")]
    with pytest.raises(DataError, match="no sequence of segments covers"):
        model.why(control, 1.0, everything)
    monkeypatch.setattr("kinetograph.methods.performance.why.MOST", 1000)
    with pytest.raises(RequestError, match="takes more than 4 GB"):
        model.why(control, 1.0)
