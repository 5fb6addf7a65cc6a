"""library label: dances whose units are known, named, edited, carried and transcribed."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import answer

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.evaluation import Observer, near_repeats, repeat_distances
from kinetograph.motion import Motion
from kinetograph.take import Annotation, Take
from walkers import walk

_BEATS = np.arange(17) * 0.5


def _dancer(beats_turned: list[int], place: float, heading: float) -> Motion:
    """Steps on the spot, and half a turn to the left in each of some beats."""
    motion = walk(8.0, speed=0.3)
    rates = np.zeros(17)
    rates[1:] = [np.pi * (beat in beats_turned) for beat in range(16)]
    turned = heading + np.interp(np.arange(len(motion)) / motion.fps, _BEATS, np.cumsum(rates))
    translation, rotations = motion.translation.copy(), motion.rotations.copy()
    translation[:, [0, 2]], rotations[:, 0] = [0.0, place], rot.about("y", turned)
    return replace(motion, translation=translation, rotations=rotations)


def _dances(folder: Path) -> kg.Library:
    library = kg.Library.create(folder / "dances")
    for name, turned in (("one", [4, 5]), ("two", [8, 9]), ("three", [4, 5, 10, 11])):
        tracks = {"leader": _dancer([], 0.0, 0.0), "follower": _dancer(turned, 0.9, np.pi)}
        cuts = tuple(Annotation("follower", "cut", "", t, t) for t in _BEATS)
        library.add(Take(name, tracks, cuts))
    return library


def _moves(library: kg.Library, take: str) -> list[str]:
    return [note.label for note in library.take(take).annotated("follower", "move")]


def test_units_are_named_and_counted(tmp_path: Path) -> None:
    library = _dances(tmp_path)
    library.add(Take("alone", {"leader": walk(4.0)}))
    result = answer("library", "label", library.path, "--rotation", "120", "--json")
    assert "'alone': expected 'follower' and a partner, found leader" in result.stderr
    said = json.loads(result.stdout)
    assert said["thresholds"]["rotation_deg"] == pytest.approx(120)
    assert _moves(library, "one") == ["open step open"] * 2 + ["open inside turn open"] + ["open step open"] * 5
    assert said["takes"]["three"] == _moves(library, "three")
    assert said["takes"]["three"].count("open inside turn open") == 2
    line = answer("library", "label", library.path, "--force").stdout.splitlines()[1:4]
    assert [row.split()[:4] for row in line] == [
        ["one", "8", "7", "1"],
        ["two", "8", "7", "1"],
        ["three", "8", "6", "2"],
    ]


def test_names_that_are_there_are_kept(tmp_path: Path) -> None:
    library = _dances(tmp_path)
    answer("library", "label", library.path)
    with pytest.raises(RequestError, match="take 'one' has 8 moves on 'follower'; keep a copy"):
        answer("library", "label", library.path)
    with pytest.raises(RequestError, match="label by partner, found 'music'"):
        answer("library", "label", library.path, "--by", "music")
    with pytest.raises(RequestError, match="no take can be named: take 'one': expected 'lady' and a partner"):
        answer("library", "label", library.path, "--target", "lady")


def test_names_go_with_the_segments_and_into_the_transcript(tmp_path: Path) -> None:
    library = _dances(tmp_path)
    answer("library", "label", library.path)
    kg.save(library.take("one").motion("leader"), tmp_path / "leader.bvh")
    points = [text for role in ("left_toe", "right_toe") for text in ("--control-point", role, "--target-point", role)]
    moves = tmp_path / "moves.csv"
    answer(
        *("perform", tmp_path / "leader.bvh", "-l", library.path, "--target", "follower", "--no-handholds"),
        *("-o", tmp_path / "out.bvh", "--transcript", moves, *points),
    )
    with moves.open(encoding="utf-8", newline="") as lines:
        rows = list(csv.DictReader(lines))
    assert {row["move"] for row in rows} <= {"open step open", "open inside turn open"}
    assert {row["notation"] for row in rows} <= {"o\u0305 \u2192 o\u0305", "o\u0305 \u21b7 o\u0305"}


def test_an_observer_sees_what_was_danced(tmp_path: Path) -> None:
    library = _dances(tmp_path)
    observer = Observer.of(library, "follower", 2)
    assert observer is not None
    one, two = library.take("one"), library.take("two")
    same = observer.made(one, one.motion("leader"), one.motion("follower"))
    errors = observer.compare(one, same)
    assert (errors.names.wrong, errors.names.segments, errors.names.patterns) == (0, 8, 2)
    errors = observer.compare(one, observer.made(one, one.motion("leader"), two.motion("follower")))
    assert (errors.names.wrong, errors.names.wrong_patterns, errors.transitions.wrong) == (2, 2, 2)
    errors = observer.compare(one, observer.commonest(library, one))
    assert (errors.names.wrong, errors.names.wrong_patterns) == (1, 1)


def test_near_repeats_are_found(tmp_path: Path) -> None:
    library = _dances(tmp_path)
    library.add(Take("again", {"follower": library.take("three").motion("follower")}))
    library.add(Take("walk", {"follower": walk(6.0, speed=1.2, turn_rate=0.7)}))
    distances = repeat_distances(library, "follower")
    assert distances["again"] == pytest.approx(0.0, abs=1e-6)
    assert distances["walk"] > 0.05
    assert "walk" not in near_repeats(distances)
    assert {"again", "three"} <= set(near_repeats(distances))
    assert near_repeats({"a": 0.01, "b": 0.02}) == ()


def test_every_second_beat_is_a_cut(tmp_path: Path) -> None:
    library = kg.Library.create(tmp_path / "library")
    library.add(Take("a", {"body": walk(10.0, period=0.9)}))
    cuts = {}
    for phase in ("0", "1", None):
        asked = ("--phase", phase) if phase else ()
        answer("library", "segment", library.path, "--by", "beats", "--every", "2", *asked)
        cuts[phase] = [note.start for note in library.take("a").annotated("body", "cut")]
    answer("library", "segment", library.path, "--by", "beats")
    beats = [note.start for note in library.take("a").annotated("body", "cut")]
    assert (cuts["0"], cuts["1"]) == (beats[::2], beats[1::2])
    assert cuts[None] in (beats[::2], beats[1::2])
    with pytest.raises(RequestError, match="every 1st beat or more is a cut"):
        answer("library", "segment", library.path, "--by", "beats", "--every", "2", "--phase", "2")
    with pytest.raises(RequestError, match="beats are divided or left out, not both"):
        answer("library", "segment", library.path, "--by", "beats", "--every", "2", "--parts", "2")
