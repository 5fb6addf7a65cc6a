"""Growing a segmentation: walkers whose steps are known, cut by hand in one take and by the search in another."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.errors import RequestError
from kinetograph.methods.performance import Grown, cuts_of, fit_examples, grow, grow_takes, growing, growing_control
from kinetograph.motion import Motion, cut, place
from kinetograph.pipeline import GrowingSettings, grow_library
from kinetograph.segmentation import compare_cuts, compare_labels
from kinetograph.take import Annotation, Take
from walkers import walk

_FPS = 30.0
_TURNS = {"straight": 0.0, "left": 0.8, "right": -0.8}


def _cuts(times: np.ndarray, *tracks: str) -> tuple[Annotation, ...]:
    return tuple(Annotation(track, "cut", "", t, t) for track in tracks for t in times)


def _walker(name: str, turn: float, *, late: int = 0, by_hand: bool = True, duration: float = 5.0) -> Take:
    """A walk with a step every half second, of which the first ``late`` frames are missing, cut at its steps or not."""
    motion = cut(walk(duration, turn_rate=turn, speed=1.0 + 0.1 * turn), late, round(duration * _FPS) + 1)
    steps = np.arange(1, 2 * duration) / 2 - late / _FPS
    return Take(name, {"body": motion}, _cuts(steps[steps >= 0], "body") if by_hand else ())


def _grown(examples: list[Take], take: Take, track: str = "body", span: int = 1) -> Grown:
    return grow(fit_examples(replace(growing_control(), span=span), examples, track), take)


def _times(grown: Grown) -> list[float]:
    return [note.start for note in grown.cuts]


@pytest.mark.parametrize("late", [0, 4, 11])
@pytest.mark.parametrize("span", [1, 2])
def test_steps_are_found_where_they_are(late: int, span: int) -> None:
    examples = [_walker("a", 0.3), _walker("b", -0.4)]
    grown = _grown(examples, _walker("new", 0.1, late=late, by_hand=False), span=span)
    expected = np.arange(0, 11) / 2 - late / _FPS
    found = [t for t in _times(grown) if 0.1 < t < 4.9 - late / _FPS]
    np.testing.assert_allclose(found, expected[(expected > 0.1) & (expected < 4.9 - late / _FPS)], atol=0.5 / _FPS)
    assert grown.distance < 0.1
    assert {(n.track, n.kind, n.label) for n in grown.cuts} == {("body", "cut", "grown")}


def test_where_the_take_stands_does_not_matter() -> None:
    take = _walker("new", 0.1, by_hand=False)
    elsewhere = Take("new", {"body": place(take.motion(), 2.0, (5.0, 0.0, 1.0))})
    one, other = (_grown([_walker("a", 0.1)], t) for t in (take, elsewhere))
    np.testing.assert_allclose(_times(one), _times(other), atol=1e-9)


def test_the_labels_of_segments_go_with_them() -> None:
    named = []
    for name, turn in _TURNS.items():
        take = _walker(name, turn)
        named.append(replace(take, annotations=(*take.annotations, Annotation("body", "move", name, 0.0, 5.0))))
    times = np.arange(181) / _FPS
    turns = np.where(times < 2, 0.0, np.where(times < 4, 0.8, -0.8))
    mixed = Take("mixed", {"body": walk(6.0, turn_rate=turns, speed=1.0 + 0.1 * turns)})
    grown = _grown(named, mixed)
    assert [note.label for note in grown.labels] == ["straight", "left", "right"]
    truth = [Annotation("body", "move", name, 2.0 * i, 2.0 * i + 2) for i, name in enumerate(_TURNS)]
    assert compare_labels(grown.labels, truth) > 0.95


def test_a_move_done_twice_is_named_twice() -> None:
    # of each two steps the first is quick and the second slow
    times = np.arange(151) / _FPS
    motion = walk(5.0, speed=1.0 + 0.3 * np.sin(2 * np.pi * times))
    pairs = tuple(Annotation("body", "move", "two steps", t, t + 1.0) for t in (0.0, 1.0, 2.0, 3.0, 4.0))
    known = Take("a", {"body": motion}, (*_cuts(np.arange(11) / 2, "body"), *pairs))
    grown = _grown([known], Take("b", {"body": cut(motion, 6, 151)}))
    expected = [(max(t - 0.2, 0.0), t + 0.8) for t in (0.0, 1.0, 2.0, 3.0, 4.0)]
    np.testing.assert_allclose([(note.start, note.stop) for note in grown.labels], expected, atol=1 / _FPS)


def test_a_take_that_was_cut_is_compared_and_not_used() -> None:
    (growth,) = grow_takes(growing_control(), [_walker("a", 0.2)], [_walker("b", 0.1)])
    assert growth.agreement is not None
    assert growth.agreement.f1 > 0.9
    wrong = replace(_walker("c", 0.1), annotations=_cuts(np.arange(1, 10) / 2 + 0.25, "body"))
    (growth,) = grow_takes(growing_control(), [_walker("a", 0.2)], [wrong])
    assert growth.agreement is not None
    assert growth.agreement.f1 == 0.0


def test_what_is_understood_best_joins_the_examples() -> None:
    # the step of "far" is like that of "near" turned further, and "near" is like the example
    takes = [_walker("far", 1.2), _walker("near", 0.6)]
    alone = {g.take: g for g in grow_takes(growing_control(), [_walker("a", 0.0)], takes)}
    joined = {g.take: g for g in grow_takes(growing_control(), [_walker("a", 0.0)], takes, join=True)}
    distances = [{k: g.tracks["body"].distance for k, g in found.items()} for found in (alone, joined)]
    assert distances[0]["near"] == distances[1]["near"]
    assert distances[1]["far"] < 0.7 * distances[0]["far"]


def _pair(name: str, turn: float, by_hand: bool) -> Take:
    leader = walk(4.0, turn_rate=turn)
    tracks = {"leader": leader, "follower": place(leader, 0.0, (1.0, 0.0, 0.3))}
    return Take(name, tracks, _cuts(np.arange(1, 8) / 2, "leader", "follower") if by_hand else ())


def test_a_library_is_cut_and_hand_made_cuts_stay(tmp_path: Path) -> None:
    library = kg.Library.create(tmp_path / "library")
    for take in (_pair("one", 0.3, True), _pair("two", -0.2, True), _pair("new", 0.1, False)):
        library.add(take)
    growths = grow_library(library)
    assert [g.take for g in growths] == ["new", "one", "two"]
    assert [g.agreement is None for g in growths] == [True, False, False]
    assert min(g.agreement.f1 for g in growths if g.agreement) > 0.9
    for name in ("one", "two"):
        assert cuts_of(library.take(name), "follower") == tuple(np.arange(1, 8) / 2)
    stored = library.take("new")
    for track in ("leader", "follower"):
        assert set(np.arange(1, 8) / 2) <= {round(2 * t) / 2 for t in cuts_of(stored, track)}
        assert stored.annotated(track, "contact")
    # what was grown is neither an example nor, unless asked for, grown again
    assert [g.take for g in grow_library(library, GrowingSettings(examples=("one",)))] == ["two"]
    assert [g.take for g in grow_library(library, GrowingSettings(examples=("one",), again=True))] == ["new", "two"]


def test_a_take_is_finished_by_its_own_beginning(tmp_path: Path) -> None:
    library = kg.Library.create(tmp_path / "library")
    whole = _walker("a", 0.2)
    begun = replace(whole, annotations=(*_cuts(np.arange(2, 5) / 2, "body"), Annotation("body", "move", "on", 1, 2)))
    library.add(begun)
    (growth,) = grow_library(library, GrowingSettings(rest=True))
    assert growth.rest
    assert compare_cuts(cuts_of(library.take("a"), "body"), cuts_of(whole, "body"), 0.05).f1 > 0.9
    kept = [note.start for note in library.take("a").annotated("body", "cut") if note.label != "grown"]
    assert kept == [1.0, 1.5, 2.0]
    assert library.take("a").annotated("body", "move") == (Annotation("body", "move", "on", 1, 2),)
    assert grow_library(library, GrowingSettings(rest=True)) == []
    assert len(grow_library(library, GrowingSettings(rest=True, again=True))) == 1
    assert [note.start for note in library.take("a").annotated("body", "cut") if note.label != "grown"] == kept


def test_names_that_a_person_gave_are_kept(tmp_path: Path) -> None:
    library = kg.Library.create(tmp_path / "library")
    example = _walker("a", 0.2)
    library.add(replace(example, annotations=(*example.annotations, Annotation("body", "move", "step", 0, 5))))
    mine = Annotation("body", "move", "mine", 1.0, 2.0)
    library.add(replace(_walker("b", 0.1, by_hand=False), annotations=(mine,)))
    grow_library(library)
    assert library.take("b").annotated("body", "move") == (mine,)
    assert library.take("b").annotated("body", "cut")


@pytest.mark.parametrize("join", [False, True])
def test_a_take_shorter_than_any_segment_is_left_uncut(join: bool) -> None:
    takes = [_walker("short", 0.1, by_hand=False, duration=0.2), _walker("new", 0.1, by_hand=False)]
    short, new = grow_takes(growing_control(), [_walker("a", 0.1)], takes, join=join)
    assert short.tracks["body"].cuts == ()
    assert short.tracks["body"].distance == np.inf
    assert len(new.tracks["body"].cuts) > 5


def test_what_there_is_nothing_to_grow_from() -> None:
    bare = _walker("b", 0.1, by_hand=False)
    with pytest.raises(RequestError, match="no take has cuts to grow from; cut a few by hand first"):
        grow_takes(growing_control(), [bare], [bare])
    other = Take("other", {"arm": walk(4.0)})
    with pytest.raises(RequestError, match="take 'other' has no motion 'body', which the examples have"):
        grow_takes(growing_control(), [_walker("a", 0.1)], [other])
    lone = kg.Skeleton(("root",), np.array([-1]), np.zeros((1, 3)))
    ball = Motion(lone, np.zeros((91, 3)), np.tile([1.0, 0, 0, 0], (91, 1, 1)), _FPS)
    with pytest.raises(RequestError, match="the examples' characters have none of the roles hips, chest"):
        fit_examples(growing_control(), [Take("ball", {"body": ball}, _cuts(np.arange(3.0), "body"))], "body")


@pytest.mark.parametrize(("cuts", "kept"), [((), 5), ((2.0,), 5), ((2.0, 4.0), 2), ((2.0, 3.0, 4.0), 3)])
def test_between_the_first_and_the_last_of_two_cuts_nothing_is_grown(cuts: tuple[float, ...], kept: int) -> None:
    found = tuple(Annotation("body", "cut", "grown", t, t) for t in (0.5, 1.2, 2.9, 3.4, 5.5))
    labels = (Annotation("body", "move", "a", 1.0, 5.0),)
    outside = growing._outside(Grown(found, labels, 0.0), cuts)
    assert len(outside.cuts) == kept
    if len(cuts) > 1:
        assert [(note.start, note.stop) for note in outside.labels] == [(1.0, 2.0), (4.0, 5.0)]
    else:
        assert outside.labels == labels
