"""Readings of worn sensors as tracks of takes, in libraries new and old."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kinetograph.errors import DataError, RequestError
from kinetograph.formats import save
from kinetograph.library import Facts, Library, back_up, catalogue, contents, describe_takes, facts_of, salvage, schema
from kinetograph.pipeline import find_recordings, ingest
from kinetograph.sensing import Readings, keep_sensors, mounting_of, preset, select_sensors, simulate
from kinetograph.take import Annotation, Take
from walkers import walk

LAYOUT = keep_sensors(preset("imu"), preset("imu").names[:5])
WORN = simulate(walk(2.0), LAYOUT, angular=True, tilt=True)
NOTE = Annotation("motion", "move", "walk", 0.0, 1.0)


def take(name: str = "walk", readings: Readings = WORN) -> Take:
    return Take(name, {"motion": walk(2.0), "readings": readings}, (NOTE,))


def assert_same(found: Readings, given: Readings) -> None:
    assert found.names == given.names
    np.testing.assert_array_equal(found.times, given.times)
    np.testing.assert_array_equal(found.sensors, given.sensors)
    for name in ("force", "angular", "orientation"):
        a, b = getattr(found, name), getattr(given, name)
        assert (a is None) == (b is None)
        if b is not None:
            np.testing.assert_array_equal(a, b.astype(np.float32))


@pytest.mark.parametrize("less", [{}, {"angular": None}, {"orientation": None}, {"angular": None, "orientation": None}])
def test_readings_come_back_as_they_were_added(tmp_path: Path, less: dict[str, None]) -> None:
    library = Library.create(tmp_path / "library")
    given = replace(WORN, **less, mounting=mounting_of(LAYOUT, WORN.names))
    library.add(take(readings=given))
    found = Library.open(library.path).take("walk").readings()
    assert_same(found, given)
    assert found.mounting is not None
    assert given.mounting is not None
    assert found.mounting.layout == "imu"
    np.testing.assert_array_equal(found.mounting.rotations, given.mounting.rotations)
    np.testing.assert_array_equal(found.mounting.biases, given.mounting.biases)
    assert_same(pickle.loads(pickle.dumps(library.take("walk"))).readings(), given)
    assert library.check().sound


def test_what_a_library_holds_counts_frames_and_rows_apart(tmp_path: Path) -> None:
    library = Library.create(tmp_path / "library")
    library.add(take())
    library.add(Take("bare", {"motion": walk(1.0)}))
    info = library.info()
    assert (info.takes, info.tracks, info.captured) == (2, 3, 1)
    assert info.frames == len(walk(2.0)) + len(walk(1.0))
    rows = {track.name: track for track in contents(library) if track.take == "walk"}
    assert (rows["readings"].kind, rows["readings"].frames, rows["readings"].columns) == ("readings", len(WORN), 5)
    assert rows["readings"].duration == pytest.approx(WORN.duration)
    assert rows["readings"].each == pytest.approx(100.0, rel=0.02)
    assert info.seconds == pytest.approx(max(WORN.duration, walk(2.0).duration) + 1.0, abs=0.02)


def test_copies_salvage_and_repair_keep_readings(tmp_path: Path) -> None:
    library = Library.create(tmp_path / "library")
    library.add(Take("gone", {"motion": walk(1.0)}))
    library.add(take())
    library.remove("gone")
    library.check(repair=True)
    copies = (library, back_up(library, tmp_path / "copy"), salvage(library, tmp_path / "saved")[0])
    for each in copies:
        assert_same(each.take("walk").readings(), WORN)
        assert each.check().sound


def test_readings_belong_to_a_motion(tmp_path: Path) -> None:
    left = select_sensors(WORN, ("left_forearm",))
    one = Take("one", {"motion": walk(1.0), "worn": left})
    assert one.readings_of("motion") is left
    two = Take("two", {"leader": walk(1.0), "follower": walk(1.0), "leader.readings": left})
    assert two.readings_of("leader") is left
    assert two.readings_of("follower") is None
    assert Take("bare", {"motion": walk(1.0)}).readings_of("motion") is None
    with pytest.raises(RequestError, match=r"name one of its readings \(none\)"):
        Take("bare", {"motion": walk(1.0)}).readings()
    empty = Readings(("a",), np.zeros(0), np.zeros(0), np.zeros((0, 3)))
    with pytest.raises(DataError, match="expected rows in the readings of track 'worn', found none"):
        Take("empty", {"motion": walk(1.0), "worn": empty})


def old_library(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Library:
    """A library of version 3 with a take."""
    with monkeypatch.context() as before:
        before.setattr(schema, "create", schema.create_third_version)
        before.setattr(catalogue, "VERSION", 3)
        library = Library.create(folder)
        library.add(Take("walk", {"motion": walk(2.0)}, (NOTE,)))
        describe_takes(library, {"walk": Facts(subject="Ann", tags=frozenset({"slow"}))})
    return library


def version(library: Library) -> int:
    with catalogue.reading(library.path) as db:
        return int(db.execute("PRAGMA user_version").fetchone()[0])


def test_a_library_of_version_3_opens_and_takes_readings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    old = old_library(tmp_path / "library", monkeypatch)
    assert version(old) == 3
    before = old.take("walk")
    library = Library.open(old.path)
    assert version(library) == catalogue.VERSION
    assert library.check().sound
    np.testing.assert_array_equal(library.take("walk").motion().rotations, before.motion().rotations)
    assert library.take("walk").annotations == (NOTE,)
    assert facts_of(library)["walk"].subject == "Ann"
    library.add(take("worn"))
    assert_same(library.take("worn").readings(), WORN)
    assert Library.open(library.path).check().sound


def test_a_library_of_version_3_that_cannot_be_changed_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    old = old_library(tmp_path / "library", monkeypatch)

    def refuse(db: object) -> None:
        raise schema.digests.Damaged("a page is not as it was")

    monkeypatch.setitem(schema.MIGRATIONS, 3, refuse)
    library = Library.open(old.path)
    assert version(library) == 3
    assert library.take("walk").annotations == (NOTE,)
    assert library.check().sound
    library.annotate("walk", [])


def test_a_take_that_is_read_again_keeps_its_readings(tmp_path: Path) -> None:
    library, files = Library.create(tmp_path / "library"), tmp_path / "files"
    files.mkdir()
    save(walk(2.0), files / "walk.bvh")
    ingest(library, find_recordings([files]).recordings)
    from kinetograph.pipeline import add_readings

    added, said = add_readings(library, "walk", {"readings": WORN}, LAYOUT)
    assert said == ()
    again = ingest(library, find_recordings([files]).recordings)
    assert again.unchanged == 1
    save(walk(2.0, speed=1.3), files / "walk.bvh")
    again = ingest(library, find_recordings([files]).recordings)
    assert again.replaced == ["walk"]
    found = library.take("walk")
    assert_same(found.readings(), WORN)
    assert not np.array_equal(found.motion().translation, added.motion().translation)


def test_readings_are_added_to_a_take_that_is_there(tmp_path: Path) -> None:
    from kinetograph.pipeline import add_readings

    library = Library.create(tmp_path / "library")
    library.add(Take("walk", {"motion": walk(2.0)}, (NOTE,)))
    describe_takes(library, {"walk": Facts(subject="Ann", source="a.bvh")})
    add_readings(library, "walk", {"readings": WORN})
    assert library.take("walk").annotations == (NOTE,)
    assert facts_of(library)["walk"] == Facts(subject="Ann", source="a.bvh")
    with pytest.raises(RequestError, match="has a track 'readings' already; replace it"):
        add_readings(library, "walk", {"readings": WORN})
    with pytest.raises(RequestError, match="has a track 'motion' already; choose another name"):
        add_readings(library, "walk", {"motion": WORN}, replace=True)
    add_readings(library, "walk", {"readings": select_sensors(WORN, ("pelvis",))}, replace=True)
    assert library.take("walk").readings().names == ("pelvis",)
    with pytest.raises(RequestError, match=r"no take 'run'.*for a new take, give its motion with the readings"):
        add_readings(library, "run", {"readings": WORN})


def test_what_is_odd_about_readings_is_said(tmp_path: Path) -> None:
    from kinetograph.pipeline import with_readings
    from kinetograph.sensing import shifted

    motion = walk(6.0, turn_rate=0.3)
    worn = simulate(motion, preset("ideal"))
    bare = Take("walk", {"motion": motion})
    assert with_readings(bare, {"readings": worn}, preset("ideal"))[1] == ()
    late = with_readings(bare, {"readings": shifted(worn, 0.2)}, preset("ideal"))[1]
    assert any("0.20 s late against the motion" in line and "add -0.20 to --clock" in line for line in late)
    brief = with_readings(bare, {"readings": simulate(walk(2.0), preset("ideal"))})[1]
    assert brief == ("motion: readings are of 0.0 to 2.0 s of the motion's 6.0 s: the rest is simulated",)
    long = with_readings(Take("w", {"motion": walk(2.0)}), {"readings": worn})[1]
    assert "those outside the motion's 0 to 2.0 s are not used" in long[0]
    couple = Take("dance", {"leader": walk(2.0), "follower": walk(2.0)})
    with pytest.raises(RequestError, match="readings 'worn' go with no motion; there are leader, follower"):
        with_readings(couple, {"worn": worn})
