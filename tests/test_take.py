from __future__ import annotations

import pickle

import numpy as np
import pytest

from kinetograph.errors import DataError, RequestError
from kinetograph.signal import Signal
from kinetograph.take import Annotation, Take
from walkers import walk


def _signal(duration: float = 1.0) -> Signal:
    return Signal(np.zeros((round(10 * duration) + 1, 1)), ("speed",), "m/s", 10.0)


def _take(**tracks: object) -> Take:
    return Take("day one", tracks or {"motion": walk(2.0), "speed": _signal(3.0)})  # type: ignore[arg-type]


def test_a_take_is_as_long_as_its_longest_track() -> None:
    assert _take().duration == pytest.approx(3.0)


def test_the_only_track_of_a_kind_needs_no_name() -> None:
    take = _take()
    assert take.motion() is take.tracks["motion"] is take.motion("motion")
    assert take.signal() is take.tracks["speed"] is take.signal("speed")


def test_a_motion_is_named_by_its_track() -> None:
    take = _take()
    assert take.named_motion() == ("motion", take.tracks["motion"])
    two = _take(leader=walk(1.0), follower=walk(1.0))
    assert two.named_motion("follower") == ("follower", two.tracks["follower"])
    with pytest.raises(RequestError, match=r"name one of its motions \(leader, follower\), found None"):
        two.named_motion()
    with pytest.raises(RequestError, match=r"name one of its motions \(motion\), found 'speed'"):
        take.named_motion("speed")


def test_one_motion_on_two_tracks_has_the_name_that_was_asked_for() -> None:
    same = walk(1.0)
    take = _take(first=same, second=same)
    assert [take.named_motion(name)[0] for name in ("first", "second")] == ["first", "second"]
    assert take.named_motion("second")[1] is same
    nameless = _take(**{"first": same, "": same})
    assert nameless.named_motion("")[0] == ""


def test_tracks_cannot_be_changed() -> None:
    with pytest.raises(TypeError):
        _take().tracks["other"] = _signal()  # type: ignore[index]


def test_a_track_is_asked_for_by_name() -> None:
    two = _take(leader=walk(1.0), follower=walk(1.0))
    with pytest.raises(RequestError, match=r"take 'day one': name one of its motions \(leader, follower\), found None"):
        two.motion()
    with pytest.raises(RequestError, match=r"name one of its motions \(motion\), found 'speed'"):
        _take().motion("speed")
    with pytest.raises(RequestError, match=r"name one of its signals \(none\), found None"):
        two.signal()
    with pytest.raises(RequestError, match=r"name one of its signals \(speed\), found 'motion'"):
        _take().signal("motion")


def test_annotations_of_a_kind_come_by_start() -> None:
    notes = [
        Annotation("motion", "contact", "right_toe", 1.0, 1.5),
        Annotation("motion", "contact", "left_toe", 1.0, 1.5),
        Annotation("motion", "contact", "left_toe", 0.0, 0.5),
        Annotation("motion", "cut", "", 0.5, 0.5),
        Annotation("speed", "contact", "left_toe", 0.2, 0.3),
    ]
    take = Take("t", _take().tracks, tuple(notes))
    assert take.annotated("motion", "contact") == (notes[2], notes[1], notes[0])
    assert take.annotated("motion", "move") == ()


def test_a_take_pickles() -> None:
    take = Take("t", _take().tracks, (Annotation("speed", "cut", "", 0.5, 0.5),))
    copy = pickle.loads(pickle.dumps(take))
    assert (copy.name, list(copy.tracks), copy.annotations) == (take.name, list(take.tracks), take.annotations)
    np.testing.assert_array_equal(copy.motion().rotations, take.motion().rotations)
    assert copy.motion().skeleton.roles.keys() == take.motion().skeleton.roles.keys()
    with pytest.raises(TypeError):
        copy.tracks["other"] = _signal()


def test_a_take_needs_a_track() -> None:
    with pytest.raises(DataError, match="take 'empty' needs at least one track, found none"):
        Take("empty", {})


def test_an_annotation_lies_on_a_track() -> None:
    with pytest.raises(DataError, match="annotation on track 'hands', but take 't' has motion, speed"):
        Take("t", _take().tracks, (Annotation("hands", "cut", "", 0, 0),))


@pytest.mark.parametrize(("start", "stop"), [(-0.1, 1.0), (2.0, 1.0), (np.nan, 1.0), (0.0, np.inf)])
def test_an_annotation_runs_forward(start: float, stop: float) -> None:
    with pytest.raises(DataError, match="an annotation runs from 0 <= start to stop >= start seconds, found"):
        Annotation("motion", "contact", "left_toe", start, stop)


def test_an_annotations_times_are_plain_numbers() -> None:
    note = Annotation("motion", "cut", "", np.float64(1), np.int64(2))  # type: ignore[arg-type]
    assert (type(note.start), type(note.stop)) == (float, float)
