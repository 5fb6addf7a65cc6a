"""A control performed through keys: the search against enumeration, keys to a millimetre, refusals."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.keys import Key, PartFromRoot, key_at
from kinetograph.kinematics import joint_positions
from kinetograph.learn import Arrivals
from kinetograph.library import Facts, describe_takes
from kinetograph.methods.performance import (
    Demand,
    Fitted,
    Moment,
    PerformanceControl,
    PerformanceModel,
    Rule,
    arrivals,
    at_rate,
    distances_to,
    left_early,
)
from kinetograph.methods.performance.fitted import with_settings
from kinetograph.methods.performance.interpretation import settle
from kinetograph.methods.performance.moves import called
from kinetograph.methods.together import (
    Asked,
    AskedKey,
    Several,
    Span,
    explained,
    performed,
    performed_several,
    pose_errors,
)
from kinetograph.motion import Motion, heading_at
from kinetograph.take import Annotation, Take
from walkers import walk

SETTINGS = {"continuity": 0.1, "reuse": 0.0, "change": 0.0, "unusual": 0.0, "stand": False}


def waving(motion: Motion, second: float) -> Motion:
    """A walk whose left arm is raised for a while around a second."""
    times = np.arange(len(motion)) / motion.fps
    angle = 2.5 * np.exp(-(((times - second) / 0.3) ** 2))
    rotations = motion.rotations.copy()
    joint = motion.skeleton.names.index("left_shoulder")
    rotations[:, joint] = rot.multiply(rot.about("z", angle), rotations[:, joint])
    return replace(motion, rotations=rotations)


def made(folder: Path, **settings: object) -> PerformanceModel:
    """A model of a straight walk, a left and a right one, and one in which the arm is raised at 3 s."""
    library = kg.Library.create(folder / "library")
    takes = {"straight": walk(6.0), "left": walk(6.0, turn_rate=0.6), "right": walk(6.0, turn_rate=-0.6)}
    takes["wave"] = waving(walk(6.0), 3.1)
    for name, motion in takes.items():
        cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(13) / 2)
        plants = tuple(
            Annotation("body", "contact", f"{side}_foot", float(t), float(t) + 0.6)
            for side, offset in (("left", 0.0), ("right", 0.5))
            for t in np.arange(6) + offset
        )
        library.add(Take(name, {"body": motion}, (*cuts, *plants)))
    describe_takes(library, {name: Facts(tags=frozenset({"turning"})) for name in ("left", "right")})
    return PerformanceControl(**{**SETTINGS, **settings}).fit(library)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> PerformanceModel:
    return made(tmp_path_factory.mktemp("together"))


def straight(seconds: float, speed: float = 1.0) -> kg.Signal:
    """A straight path along z."""
    times = np.arange(round(seconds * 30) + 1) / 30
    return kg.Signal(np.stack([0 * times, 0 * times, speed * times], axis=1)[:, None], ("path",), "m", 30.0)


def raised(time: float | tuple[float, float], **more: object) -> AskedKey:
    window = (time, time) if isinstance(time, float) else time
    return AskedKey(key_at(waving(walk(6.0), 3.1), 3.1, time=window, label="wave", **more))  # type: ignore[arg-type]


def test_a_key_is_named_where_it_decides_what_is_there(model: PerformanceModel) -> None:
    asked = Asked((raised(2.0),), (Rule(3.5, 4.5, called="turning", weight=5.0),))
    made = performed(model, straight(5.0), asked)
    reasons = explained(model, straight(5.0), asked, 2.0)
    assert reasons.chosen.piece.take == made.piece_at(60).take == "wave"
    assert [other.constraint for other in reasons.reversals] == ["the demand for wave"]
    free = explained(model, straight(5.0), replace(asked, keys=()), 2.0)
    assert reasons.reversals[0].saved == pytest.approx(reasons.cost - free.cost, rel=1e-3)
    others = [each for each in reasons.contenders if each.piece.take != "wave"]
    assert all(each.terms.keys > reasons.chosen.terms.keys for each in others)
    assert all(each.terms.rules == 0 for each in reasons.contenders)
    later = explained(model, straight(5.0), asked, 4.0)
    assert later.chosen.terms.total == pytest.approx(later.cost, rel=1e-5)
    assert any("the rule that asks for" in other.constraint for other in later.reversals)
    breaking = [each.terms.rules for each in later.contenders if each.piece.take in ("straight", "wave")]
    assert all(rules > 0.01 for rules in breaking)
    assert all(each.terms.keys == 0 for each in later.contenders)


@pytest.mark.parametrize("window", [2.0, (1.5, 2.5)])
def test_alternatives_share_no_piece_and_meet_the_same_keys(
    model: PerformanceModel, window: float | tuple[float, float]
) -> None:
    asked = Asked((raised(window),), (Rule(3.5, 4.5, called="turning", weight=0.01),))
    found = performed_several(model, straight(5.0), asked, Several(3))
    assert len(found) == 3
    alone = performed(model, straight(5.0), asked)
    assert np.array_equal(found[0].motion.rotations, alone.motion.rotations)
    assert [made.cost for made in found] == sorted(made.cost for made in found)
    for made in found:
        assert max(pose_errors(model, made, asked.keys)) < 1e-3
    for one, other in itertools.combinations(found, 2):
        for piece in one.pieces:
            middle = 0.5 * (piece.source_start + piece.source_stop)
            for there in other.pieces:
                shared = min(piece.stop, there.stop) - max(piece.start, there.start)
                same = there.take == piece.take and there.source_start <= middle < there.source_stop
                assert not same or shared < 0.1 + 1e-6  # a border moves by less than a step of the search


def test_alternatives_that_are_alike_are_the_best_of_all(model: PerformanceModel) -> None:
    asked = Asked((raised(2.0),))
    best, *others = performed_several(model, straight(5.0), asked, Several(4, alike=True))
    distinct = performed_several(model, straight(5.0), asked, Several(2))
    costs = [best.cost, *(made.cost for made in others)]
    assert costs == sorted(costs)
    assert len({tuple((p.take, p.source_start, p.start) for p in made.pieces) for made in (best, *others)}) == 4
    assert costs[-1] <= distinct[1].cost + 1e-9
    assert all(max(pose_errors(model, made, asked.keys)) < 1e-3 for made in (best, *others))


def test_alternatives_end_where_nothing_else_meets_what_is_asked(model: PerformanceModel) -> None:
    asked = Asked((raised(2.0),), (Rule(0.0, 5.0, take="straight"),))
    found = performed_several(model, straight(5.0), asked, Several(50))
    assert 1 <= len(found) < 50


# ---- the search ----


def enumerated(fitted: Fitted, x: np.ndarray, demands: list[Demand]) -> tuple[float, list[tuple[int, int]]]:
    """The least score over all sequences, one after another, and what it is of."""
    steps, states = len(x) - 1, fitted.instances.states
    every: list[Arrivals] = list(arrivals(fitted, x))
    early = left_early(fitted, x)
    k = fitted.settings.continuity
    best: tuple[float, list[tuple[int, int]]] = (np.inf, [])

    def asked(state: int, start: int, stop: int, last: bool) -> list[tuple[int, float]]:
        """The times of each window that a state shows, and what they cost; and what it costs to break rules."""
        found = []
        segment, duration = fitted.segment_of(state), int(states[state, 1])
        for number, demand in enumerate(demands):
            if isinstance(demand, Rule):
                is_named = fitted.sources[segment.source].take in (demand.called or "").split(",")
                overlap = min(stop, demand.stop * 10) - max(start, demand.start * 10, 0)
                if overlap > 1e-9 and is_named == demand.forbid:
                    found.append((number, np.inf if demand.weight is None else demand.weight * overlap / 10))
                continue
            for time in demand.times(fitted.settings.rate, steps):
                if start <= time < stop or (last and time == stop):
                    second = segment.start + segment.duration * (time - start) / duration
                    frame = round(second * fitted.sources[segment.source].motion.fps)
                    cost = float(demand.costs[segment.source][frame])
                    found.append((number, cost if cost <= demand.limit else np.inf))
        return found

    def go(start: int, score: float, tail: np.ndarray | None, sequence: list[tuple[int, int]],
           met: dict[int, float]) -> None:  # fmt: skip
        nonlocal best
        if score >= best[0]:
            return
        if start == steps:
            total = score + sum(met.get(n, np.inf) for n, d in enumerate(demands) if isinstance(d, Moment))
            if total < best[0]:
                best = (total, sequence)
            return
        for state in range(len(states)):
            duration = int(states[state, 1])
            begins = [start] if sequence else range(-duration + 1, 1)
            for begin in begins:
                stop, used = begin + duration, min(begin + duration, steps) - max(begin, 0)
                if begin < 0 and stop > steps:
                    continue
                arrival = early[used] if stop > steps else every[stop - 1]
                cost = float(arrival.costs[state])
                gap = 0.0 if tail is None else k * float(np.sum((arrival.heads[state].astype(float) - tail) ** 2))
                now, more = dict(met), 0.0
                for number, price in asked(state, begin, min(stop, steps), stop >= steps):
                    if isinstance(demands[number], Rule):
                        more += price
                    else:
                        now[number] = min(now.get(number, np.inf), price)
                go(min(stop, steps), score + cost + gap + more, arrival.tails[state].astype(float),
                   [*sequence, (state, min(stop, steps))], now)  # fmt: skip

    go(0, 0.0, None, [], {})
    return best


@pytest.mark.parametrize("seed", range(6))
def test_the_search_finds_what_enumeration_finds(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(seed)
    library = kg.Library.create(tmp_path / "library")
    for name, turn in (("a", 0.0), ("b", 0.8)):
        cuts = tuple(Annotation("body", "cut", "", t, t) for t in (0.0, 0.3, 0.7, 1.2))
        library.add(Take(name, {"body": waving(walk(1.5, turn_rate=turn), rng.uniform(0, 1.2))}, cuts))
    fitted = PerformanceControl(**{**SETTINGS, "stretch": 0.1, "fine_rate": None}).fit(library).fitted
    path = kg.Signal(np.cumsum(rng.normal(0.03, 0.02, (28, 1, 3)) * [1, 0, 1], axis=0), ("path",), "m", 30.0)
    x = at_rate(fitted.settings.control_points.points(path), 30.0, 10.0)
    key = key_at(waving(walk(1.5), 0.6), 0.6)
    costs = tuple(rng.uniform(0.5, 2.0) * each**2 for each in distances_to(fitted, key))
    low = rng.uniform(0.1, 0.25)
    windows = [(low, low), (low, low + 0.3), (low, low + 0.5)][seed % 3]
    demands: list[Demand] = [Moment(windows, costs)]
    if seed >= 3:
        later = tuple(np.sqrt(each) for each in costs)
        demands += [Moment((0.85, 0.9), later), Rule(0.2, 0.7, called="a", weight=0.3), Rule(0.0, 0.1, called="b")]
    path_found, settled = settle(fitted, x, None, demands)
    score, sequence = enumerated(fitted, x, demands)
    assert path_found.score == pytest.approx(score, rel=1e-4)
    assert [(s, min(int(e), len(x) - 1)) for s, e in zip(path_found.states, path_found.stops, strict=True)] == sequence
    assert all(m.window[0] == m.window[1] for m in settled if isinstance(m, Moment))


# ---- keys ----


def pose_error(motion: Motion, second: float, key: Key) -> float:
    """The furthest joint of a frame from a key's pose, as seen from the root."""
    frame = round(second * motion.fps)
    seen = []
    for body, at in ((motion, frame), (key.clip, key.frame)):
        joints = joint_positions(body)[at] - body.translation[at] * [1, 0, 1]
        seen.append(rot.rotate(rot.about("y", -heading_at(body, at)), joints))
    return float(np.linalg.norm(seen[0] - seen[1], axis=-1).max())


def test_a_key_is_met_by_the_take_that_has_it(model: PerformanceModel) -> None:
    asked = raised(2.4)
    result = performed(model, straight(5.0), Asked((asked,)))
    piece = next(p for p in result.pieces if p.start <= 2.4 < p.stop)
    assert piece.take == "wave"
    assert pose_error(result.motion, 2.4, asked.key) < 1e-3
    assert result.met == (2.4,)
    assert not any(p.take == "wave" and p.source_stop > 2.5 for p in model.synthesize(straight(5.0)).pieces)


def test_without_keys_nothing_changes(model: PerformanceModel) -> None:
    plain, asked = model.synthesize(straight(4.0)), performed(model, straight(4.0), Asked())
    np.testing.assert_array_equal(plain.motion.rotations, asked.motion.rotations)
    assert plain.costs == asked.costs


def test_a_window_is_met_at_its_best_time(model: PerformanceModel) -> None:
    scores = {}
    for time in np.arange(20, 33) / 10:
        scores[time] = performed(model, straight(5.0), Asked((raised(float(time)),))).cost
    result = performed(model, straight(5.0), Asked((raised((2.0, 3.2)),)))
    assert result.cost == pytest.approx(min(scores.values()), rel=1e-6)


def test_a_time_is_chosen_with_reuse_free_whatever_was_made_before(tmp_path: Path) -> None:
    fitted = made(tmp_path, reuse=0.5).fitted
    assert fitted.reuse is not None
    free = with_settings(fitted, replace(fitted.settings, reuse=0.0, unusual=1.0))
    assert free.reuse is None
    assert free.search.reuse is None
    assert fitted.search.reuse is fitted.reuse


def test_places_along_the_path_are_times(model: PerformanceModel) -> None:
    for more in ({"along": 2.5}, {"near": (0.3, 2.5)}):
        asked = replace(raised(1.0), **more, key=replace(raised(1.0).key, time=None))  # type: ignore[arg-type]
        result = performed(model, straight(5.0), Asked((asked,)))
        assert result.met[0] == pytest.approx(2.5, abs=0.05)


def test_a_place_off_the_path_is_met_and_left_again(model: PerformanceModel) -> None:
    asked = raised(2.5, position=(0.25, 2.5))
    result = performed(model, straight(5.0), Asked((asked,)))
    x, _, z = result.motion.translation[75]
    assert np.hypot(x - 0.25, z - 2.5) < 1e-3
    assert pose_error(result.motion, 2.5, asked.key) < 1e-3
    assert abs(result.motion.translation[[0, 20, 130], 0]).max() < 0.12


def test_a_heading_is_met(model: PerformanceModel) -> None:
    asked = raised(2.5, heading=0.3)
    result = performed(model, straight(5.0), Asked((asked,)))
    assert heading_at(result.motion, 75) == pytest.approx(0.3, abs=1e-3)


def test_parts_are_met(model: PerformanceModel) -> None:
    parts = (PartFromRoot("left_hand", (0.35, 1.3, 0.1)),)
    key = key_at(walk(6.0), 3.0, time=(2.0, 2.0), roles=("left_hand",), parts=parts, label="reach")
    result = performed(model, straight(4.0), Asked((AskedKey(key),)))
    hand = joint_positions(result.motion)[60, result.motion.skeleton.names.index("left_hand")]
    seen = rot.rotate(rot.about("y", -heading_at(result.motion, 60)), hand - result.motion.translation[60] * [1, 0, 1])
    np.testing.assert_allclose(seen, (0.35, 1.3, 0.1), atol=1e-3)


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ((raised(9.0),), r"wave: 9 s is outside the control, which lasts from 0 to 5\.00 s"),
        ((raised(3.0), raised(2.0)), r"keys are out of order: wave is at 2 s, but wave before it at 3 s"),
        ((raised(2.0, position=(6.0, 2.0)),), r"cannot be reached in time.*the nearest place then is \(.*at 2\.0. s"),
        ((replace(raised(1.0), along=70.0, key=replace(raised(1.0).key, time=None)),), r"70 m along the path is out"),
        (
            (AskedKey(key_at(walk(2.0), 1.0, time=(2.0, 2.0), label="still")), raised(2.1)),
            r"wave is 0\.10 s after still, and their poses take 0\.\d\d s: put it at 2\.\d\d s or later",
        ),
    ],
)
def test_what_cannot_be_met_is_refused(model: PerformanceModel, asked: tuple[AskedKey, ...], says: str) -> None:
    with pytest.raises(RequestError, match=says):
        performed(model, straight(5.0), Asked(asked))


def test_a_key_on_a_path_has_one_time_or_place() -> None:
    with pytest.raises(RequestError, match=r"wave: on a path a key has a time, or a place along it .*found 2"):
        replace(raised(1.0), along=2.0)


# ---- moves ----


def test_a_move_is_used_all_through_its_span(model: PerformanceModel) -> None:
    result = performed(model, straight(5.0), Asked(rules=(Rule(1.0, 2.5, called="turning"),)))
    touched = {p.take for p in result.pieces if p.start < 2.5 - 1e-6 and p.stop > 1.0 + 1e-6}
    assert touched <= {"left", "right"}
    weighted = performed(model, straight(5.0), Asked(rules=(Rule(1.0, 2.5, called="turning", weight=1e-9),)))
    assert "straight" in {p.take for p in weighted.pieces if p.start < 2.5 - 1e-6 and p.stop > 1.0 + 1e-6} | {
        "straight" if p.take == "wave" else p.take for p in weighted.pieces
    }


def test_an_unknown_move_is_refused_with_what_there_is(model: PerformanceModel) -> None:
    with pytest.raises(RequestError, match="called 'run'; there are turning, left, right, straight, wave"):
        performed(model, straight(5.0), Asked(rules=(Rule(1.0, 2.5, called="run"),)))


def test_mirrored_recordings_are_called_by_the_other_side(tmp_path: Path) -> None:
    library = kg.Library.create(tmp_path / "library")
    for name, rate in (("straight", 0.0), ("turn_left_1", 0.6)):
        cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(13) / 2)
        library.add(Take(name, {"body": walk(6.0, turn_rate=rate)}, cuts))
    describe_takes(library, {"turn_left_1": Facts(tags=frozenset({"going left", "curves"}))})
    with pytest.raises(RequestError, match="called 'right'; there are curves, going left, straight, turn_left_1"):
        called(PerformanceControl(**SETTINGS).fit(library).fitted, "right")  # type: ignore[arg-type]
    fitted = PerformanceControl(**SETTINGS, mirror=True).fit(library).fitted  # type: ignore[arg-type]
    turning = np.array([fitted.sources[each.source].take == "turn_left_1" for each in fitted.instances.segments])
    mirrored = np.array([fitted.sources[each.source].mirrored for each in fitted.instances.segments])
    assert (turning & mirrored).any()
    for right in ("turn right", "turn_right_1", "going right", "right"):
        np.testing.assert_array_equal(called(fitted, right), turning & mirrored)
    np.testing.assert_array_equal(called(fitted, "left"), turning & ~mirrored)
    np.testing.assert_array_equal(called(fitted, "curves"), turning)


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_span_begins_with_the_foot_that_is_asked_for(model: PerformanceModel, side: str) -> None:
    for field in ("first", "last"):
        span = Span(1.3, 3.3, **{field: side})
        result = performed(model, straight(5.0), Asked(feet=(span,)))
        plants = sorted((n.start, n.label) for n in result.annotations if n.kind == "contact")
        if field == "first":
            label = next(label for start, label in plants if start >= 1.3 - 0.05)
        else:
            label = [label for start, label in plants if start <= 3.3 + 0.05][-1]
        assert label.startswith(side), (field, plants)


def test_a_foot_that_is_to_stay_stays_longer(model: PerformanceModel) -> None:
    free = model.synthesize(straight(4.0))
    until = next(n.stop for n in free.annotations if n.label == "left_foot" and 1.0 < n.stop < 3.0)
    contact = Annotation("motion", "contact", "left_foot", until - 0.2, until + 0.2)
    bound = performed(model, straight(4.0), Asked(contacts=(contact,)))
    moved = []
    for result in (free, bound):
        foot = joint_positions(result.motion)[:, result.motion.skeleton.names.index("left_foot")]
        span = foot[round((until - 0.2) * 30) : round((until + 0.2) * 30), [0, 2]]
        moved.append(np.linalg.norm(span - span[0], axis=1).max())
    assert moved[1] < min(0.5 * moved[0], 0.05)
