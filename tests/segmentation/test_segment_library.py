"""Cutting the takes of a library: what is new, what cannot be cut, what a person has cut."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import walkers
from kinetograph.errors import RequestError
from kinetograph.library import Library, Selection, Shards, facts_of, full_names
from kinetograph.motion import Motion
from kinetograph.pipeline import CutSettings, segment_library, segmenting
from kinetograph.take import Annotation, Take
from kinetograph.work import Workers

WALK = walkers.walk(6.0)
STILL = Motion(WALK.skeleton, np.repeat(WALK.translation[:1], 90, 0), np.repeat(WALK.rotations[:1], 90, 0), 30.0)


@pytest.fixture
def library(tmp_path: Path) -> Library:
    made = Library.create(tmp_path / "library")
    for name, motion in (("a/idle", STILL), ("a/walk", WALK), ("b/walk", WALK)):
        made.add(Take(name, {"motion": motion}))
    return made


def cut_takes(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Gets the names of the takes that are looked at from now on."""
    seen: list[str] = []
    cut = segmenting.segment_take
    monkeypatch.setattr(segmenting, "segment_take", lambda take, *rest: seen.append(take.name) or cut(take, *rest))
    return seen


def test_only_what_is_new_is_looked_at(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    first = segment_library(library, "footplants")
    assert (set(first.cuts), first.uncut) == ({"a/walk", "b/walk"}, {"a/idle": "idle (nobody steps)"})
    seen = cut_takes(monkeypatch)
    library.add(Take("c/walk", {"motion": WALK}))
    second = segment_library(library, "footplants")
    assert seen == list(second.new) == ["c/walk"]
    assert second.uncut == first.uncut
    assert segment_library(library, "footplants").new == ()
    assert len(segment_library(library, "footplants", again=True).new) == 4


def test_other_cuts_take_the_place_of_those_there_are(library: Library) -> None:
    segment_library(library, "footplants")
    halves = segment_library(library, "fixed", CutSettings(length=0.5))
    assert halves.cuts["a/walk"] == 13
    assert segment_library(library, "fixed", CutSettings(length=0.5)).new == ()
    assert segment_library(library, "fixed", CutSettings(length=1.0)).cuts["a/walk"] == 7
    assert {note.label for note in library.take("a/walk").annotated("motion", "cut")} == {"fixed"}


def test_cuts_by_a_person_are_never_changed(library: Library) -> None:
    note = Annotation("motion", "cut", "tapped", 1.0, 1.0)
    library.annotate("a/walk", [note])
    for again in (False, True):
        done = segment_library(library, "footplants", again=again)
        assert done.by_hand == ("a/walk",)
        assert library.take("a/walk").annotations == (note,)


def test_a_selection_is_cut_and_nothing_else(library: Library) -> None:
    done = segment_library(library.only(Selection(("b/*",))), "footplants")
    assert set(done.cuts) == {"b/walk"}
    assert library.take("a/walk").annotations == ()


def test_processes_cut_alike(library: Library, tmp_path: Path) -> None:
    other = Library.create(tmp_path / "other")
    for name in library.names():
        other.add(library.take(name))
    assert segment_library(library, "footplants") == segment_library(other, "footplants", workers=Workers(2))
    for name in library.names():
        assert library.take(name).annotations == other.take(name).annotations
    assert facts_of(library) == facts_of(other)


def test_cuts_that_were_stored_before_it_was_noted_how_are_known(
    library: Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    library.annotate("a/walk", [Annotation("motion", "cut", "footplants", t, t) for t in (1.0, 2.0)])
    seen = cut_takes(monkeypatch)
    segment_library(library, "footplants")
    assert seen == ["a/idle", "b/walk"]


def test_shards_are_cut_each_by_itself(library: Library, tmp_path: Path) -> None:
    other = Library.create(tmp_path / "other")
    other.add(Take("a/walk", {"motion": WALK}))
    shards = Shards.of([library.path, other.path])
    done = segment_library(shards, "footplants")
    assert set(done.cuts) == {"library/a/walk", "other/a/walk", "b/walk"}
    assert other.take("a/walk").annotations == library.take("b/walk").annotations != ()
    assert full_names(shards, ["idle"]) == ("a/idle",)
    assert segment_library(shards, "footplants").new == ()


def test_a_library_without_anything_to_cut_is_an_error(tmp_path: Path) -> None:
    library = Library.create(tmp_path / "idle")
    for name in ("one", "two"):
        library.add(Take(name, {"motion": STILL}))
    for _ in range(2):
        with pytest.raises(RequestError, match=r"take 'one' cannot be cut: idle \(nobody steps\), nor can 1 others"):
            segment_library(library, "footplants")
