"""Libraries on disk: what goes in comes out, and what goes wrong leaves them as they were."""

from __future__ import annotations

import errno
import multiprocessing
import multiprocessing.connection
import os
import pickle
import re
import resource
import shutil
import sqlite3
import tempfile
import threading
import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinetograph import rotations as rot
from kinetograph.errors import DataError, LibraryError, RequestError
from kinetograph.kinematics import joint_positions
from kinetograph.library import (
    Library,
    Report,
    annotations_of,
    catalogue,
    contents,
    digests,
    frame_files,
    headers,
    storage,
)
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.skeleton import ROLES, Landmark, Skeleton
from kinetograph.take import Annotation, Take

# a child forks while numerical libraries have threads of their own; it only reads, writes and ends
pytestmark = pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")

HEADER = headers.SIZE
STICK = Skeleton(("hips", "chest", "head"), np.array([-1, 0, 1]), np.array([[0, 1.0, 0], [0, 0.3, 0], [0, 0.2, 0]]))


def walk(frames: int = 30, skeleton: Skeleton = STICK, seed: int = 0) -> Motion:
    rng = np.random.default_rng(seed)
    rotations = rot.normalize(rng.normal(size=(frames, len(skeleton), 4)))
    return Motion(skeleton, rng.normal(size=(frames, 3)), rotations, 30.0)


def walk_take(name: str, frames: int = 30, *notes: Annotation) -> Take:
    return Take(name, {"motion": walk(frames)}, notes)


def cut(time: float, track: str = "motion") -> Annotation:
    return Annotation(track, "cut", "", time, time)


@pytest.fixture
def library(tmp_path: Path) -> Library:
    return Library.create(tmp_path / "library")


# round trips

NUMBERS = st.floats(-1e6, 1e6)
NAMES = st.text(min_size=1, max_size=8)


@st.composite
def skeletons(draw: st.DrawFn) -> Skeleton:
    names = draw(st.lists(NAMES, min_size=1, max_size=5, unique=True))
    joints = len(names)
    parents = [-1, *(draw(st.integers(0, i - 1)) for i in range(1, joints))]
    numbers = st.lists(NUMBERS, min_size=3, max_size=3)
    offsets = draw(st.lists(numbers, min_size=joints, max_size=joints))
    ends = draw(st.lists(st.tuples(st.integers(0, joints - 1), numbers), max_size=3))
    roles = draw(st.dictionaries(st.sampled_from(ROLES), st.tuples(st.integers(0, joints - 1), numbers), max_size=4))
    return Skeleton(
        tuple(names),
        np.array(parents),
        np.array(offsets),
        np.array([joint for joint, _ in ends], dtype=np.int64),
        np.array([offset for _, offset in ends], dtype=np.float64).reshape(-1, 3),
        {role: Landmark(joint, np.array(offset)) for role, (joint, offset) in roles.items()},
    )


@st.composite
def motions(draw: st.DrawFn) -> Motion:
    skeleton = draw(skeletons())
    frames = draw(st.integers(1, 4))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    rotations = rot.normalize(rng.normal(size=(frames, len(skeleton), 4)))
    bones = rng.normal(size=(frames, len(skeleton), 3)) if draw(st.booleans()) else None
    return Motion(skeleton, rng.normal(size=(frames, 3)) * 1e3, rotations, draw(st.floats(0.5, 1000)), bones)


@st.composite
def signals(draw: st.DrawFn) -> Signal:
    names = tuple(draw(st.lists(NAMES, max_size=3)))
    shape = (draw(st.integers(1, 4)), len(names))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    values = rng.normal(size=(*shape, 3) if draw(st.booleans()) else shape) * 1e3
    valid = rng.random(shape) < draw(st.sampled_from([0.5, 1.0]))
    return Signal(values, names, draw(st.text(max_size=5)), draw(st.floats(0.5, 1000)), valid)


@st.composite
def takes(draw: st.DrawFn) -> Take:
    tracks = draw(st.dictionaries(NAMES, motions() | signals(), min_size=1, max_size=3))
    times = st.floats(0, 1e6)
    note = st.tuples(st.sampled_from(sorted(tracks)), NAMES, st.text(max_size=8), times, times)
    notes = draw(st.lists(note, max_size=4))
    return Take(draw(st.text(max_size=8)), tracks, tuple(Annotation(*n[:3], *sorted(n[3:])) for n in notes))


def assert_same_skeleton(read: Skeleton, written: Skeleton) -> None:
    assert read.names == written.names
    for name in ("parents", "offsets", "end_parents", "end_offsets"):
        np.testing.assert_array_equal(getattr(read, name), getattr(written, name))
    assert list(read.roles) == list(written.roles)
    for role, landmark in written.roles.items():
        assert read.roles[role].joint == landmark.joint
        np.testing.assert_array_equal(read.roles[role].offset, landmark.offset)


def assert_same_track(read: Motion | Signal, written: Motion | Signal) -> None:
    assert type(read) is type(written)
    assert read.fps == written.fps
    if isinstance(read, Signal):
        assert isinstance(written, Signal)
        assert (read.names, read.units) == (written.names, written.units)
        np.testing.assert_array_equal(read.values, written.values)
        np.testing.assert_array_equal(read.valid, written.valid)
        return
    assert isinstance(written, Motion)
    assert_same_skeleton(read.skeleton, written.skeleton)
    np.testing.assert_array_equal(read.translation, written.translation)
    np.testing.assert_allclose(read.rotations, written.rotations, atol=1e-7)
    np.testing.assert_allclose(np.linalg.norm(read.rotations, axis=-1), 1, atol=1e-15)
    assert (read.bones is None) == (written.bones is None)
    if read.bones is not None:
        np.testing.assert_allclose(read.bones, written.bones, rtol=1e-7)


@given(takes())
@settings(max_examples=60)
def test_a_take_comes_back_as_it_was(take: Take) -> None:
    with tempfile.TemporaryDirectory() as folder:
        library = Library.create(Path(folder) / "library")
        library.add(take)
        read = Library.open(library.path).take(take.name)
        assert library.check() == Report(0, 0, ())
    assert (read.name, read.annotations) == (take.name, take.annotations)
    assert list(read.tracks) == list(take.tracks)
    for name, track in take.tracks.items():
        assert_same_track(read.tracks[name], track)


def test_joints_keep_within_ten_micrometres_in_a_room_a_hundred_metres_wide(library: Library) -> None:
    joints = 30
    arm = Skeleton(tuple(map(str, range(joints))), np.arange(joints) - 1, np.full((joints, 3), 0.1))
    motion = walk(500, arm)
    far = Motion(arm, motion.translation * 50, motion.rotations, 60.0)
    library.add(Take("far", {"motion": far}))
    error = joint_positions(library.take("far").motion()) - joint_positions(far)
    assert np.abs(error).max() < 1e-5


def test_arrays_read_are_the_readers_own(library: Library) -> None:
    library.add(walk_take("walk"))
    library.take("walk").motion().translation[:] = 7
    assert not (library.take("walk").motion().translation == 7).any()


# takes


def test_names_keep_the_order_of_adding_and_a_replaced_take_its_place(library: Library) -> None:
    for name in ("b", "a", "c"):
        library.add(walk_take(name))
    library.add(walk_take("b", 5, cut(0.1)), replace=True)
    assert library.names() == ("b", "a", "c")
    assert len(library.take("b").motion()) == 5
    assert library.take("b").annotations == (cut(0.1),)


def test_a_name_can_be_taken_once(library: Library) -> None:
    library.add(walk_take("walk"))
    with pytest.raises(RequestError, match="has a take 'walk' already; choose another name, or replace it"):
        library.add(walk_take("walk", 5))
    assert len(library.take("walk").motion()) == 30
    assert library.check() == Report(0, 0, ())


def test_an_unknown_take_names_its_neighbours(library: Library) -> None:
    with pytest.raises(RequestError, match="no take 'walk'; it has none: it is empty"):
        library.take("walk")
    for name in ("walk_1", "walk_2", "jump"):
        library.add(walk_take(name))
    with pytest.raises(RequestError, match=r"no take 'walk_3'; it has walk_[12], walk_[12]$"):
        library.take("walk_3")
    with pytest.raises(RequestError, match="no take 'walk_3'"):
        library.remove("walk_3")


def test_takes_of_one_character_share_a_skeleton(library: Library) -> None:
    other = Skeleton(STICK.names, STICK.parents, STICK.offsets * 1.01)
    for i, skeleton in enumerate((STICK, STICK, other, STICK)):
        library.add(Take(str(i), {"motion": walk(skeleton=skeleton)}))
    assert library.info().skeletons == 2
    assert library.take("0").motion().skeleton is library.take("3").motion().skeleton
    library.remove("2")
    assert library.info().skeletons == 1


def test_names_that_are_not_unicode_are_refused(library: Library) -> None:
    with pytest.raises(DataError, match=r"must be valid Unicode, found 'walk\\ud800'"):
        library.add(walk_take("walk\ud800"))
    assert library.check() == Report(0, 0, ())


# annotations


def test_annotations_replace_those_of_their_kind_and_track(library: Library) -> None:
    tracks = {"leader": walk(), "follower": walk()}
    move = Annotation("leader", "move", "turn", 0.0, 0.5)
    library.add(Take("dance", tracks, (cut(0.1, "leader"), cut(0.2, "follower"), move)))
    library.annotate("dance", [cut(0.3, "leader"), cut(0.4, "leader")])
    assert set(annotations_of(library, "dance")) == {cut(0.2, "follower"), move, cut(0.3, "leader"), cut(0.4, "leader")}
    library.annotate("dance", [], kind="cut", track="leader")
    assert set(annotations_of(library, "dance")) == {cut(0.2, "follower"), move}
    library.annotate("dance", [], kind="cut")
    assert library.take("dance").annotations == (move,)
    library.annotate("dance", [])
    assert library.take("dance").annotations == (move,)


def test_annotations_of_another_kind_or_track_are_refused(library: Library) -> None:
    library.add(walk_take("walk", 30, cut(0.5)))
    with pytest.raises(RequestError, match="no track 'left' in take 'walk'; it has motion"):
        library.annotate("walk", [cut(0.1, "left")])
    with pytest.raises(RequestError, match="expected annotations of kind 'move', found kind 'cut' on track 'motion'"):
        library.annotate("walk", [cut(0.1)], kind="move")
    assert library.take("walk").annotations == (cut(0.5),)


# what is in it


def test_info_counts(library: Library) -> None:
    path = Signal(np.zeros((11, 1, 3)), ("path",), "m", 10.0)
    library.add(Take("walk", {"motion": walk(16), "path": path}, (cut(0.1), cut(0.2))))
    library.add(walk_take("turn", 31, Annotation("motion", "move", "turn", 0, 1)))
    info = library.info()
    assert (info.takes, info.tracks, info.frames, info.skeletons) == (2, 3, 58, 1)
    assert info.seconds == pytest.approx(1.0 + 1.0)
    assert info.annotations == {"cut": 2, "move": 1}
    assert info.bytes == sum(path.stat().st_size for path in library.path.iterdir())
    rows = [(t.take, t.name, t.kind, t.frames, t.columns, t.duration) for t in contents(library)]
    assert rows == [
        ("walk", "motion", "motion", 16, 3, 0.5),
        ("walk", "path", "points", 11, 1, 1.0),
        ("turn", "motion", "motion", 31, 3, 1.0),
    ]


def test_ten_hours_are_opened_without_reading_them(library: Library) -> None:
    """A catalogue of 2,000 takes, each 18 s at 120 Hz, over a frames file of 4.6 GB that is a hole."""
    library.add(walk_take("first", 2160))
    joints, frames, count = 30, 2160, 2000
    with catalogue.writing(library.path) as db:
        skeleton = db.execute("SELECT id FROM skeletons").fetchone()[0]
        held, listing = storage.read(db), 0
        start = held.stop
        for i in range(count):
            take = db.execute("INSERT INTO takes (name) VALUES (?)", (f"take{i}",)).lastrowid
            track = db.execute(
                "INSERT INTO tracks (take, name, kind, fps, frames, skeleton) VALUES (?, 'm', 'motion', 120, ?, ?)",
                (take, frames, skeleton),
            ).lastrowid
            for name, dtype, width in (("translation", "<f8", 3), ("rotations", "<f4", joints * 4)):
                db.execute("INSERT INTO arrays VALUES (?, ?, ?, ?, ?, 0)", (track, name, dtype, width, start))
                start += frame_files.Span(name, dtype, width, frames, start, 0).size
            listing ^= digests.seal(db, take)
        storage.write(db, replace(held, stop=start, listing=held.listing ^ listing))
    os.truncate(library.path / "frames-1.bin", start)
    tracemalloc.start()
    try:
        again = Library.open(library.path)
        assert tracemalloc.get_traced_memory()[1] < 1e6
        first = again.take("first").motion()
        assert tracemalloc.get_traced_memory()[1] < 10 * (first.rotations.nbytes + first.translation.nbytes) + 1e6
    finally:
        tracemalloc.stop()
    assert again.info().seconds > 9.99 * 3600
    assert len(again.names()) == count + 1


# folders and versions


def test_a_library_needs_a_folder_of_its_own(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").touch()
    with pytest.raises(LibraryError, match=r"needs a folder of its own, found thesis\.tex in it"):
        Library.create(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_create_does_not_overwrite(library: Library) -> None:
    library.add(walk_take("walk"))
    before = {path.name: path.read_bytes() for path in library.path.iterdir()}
    with pytest.raises(LibraryError, match="already holds a library; open it, or choose another folder"):
        Library.create(library.path)
    assert {path.name: path.read_bytes() for path in library.path.iterdir()} == before


def test_create_goes_on_where_it_was_killed(tmp_path: Path) -> None:
    (tmp_path / "frames-1.bin").touch()
    (tmp_path / "catalogue.sqlite").touch()
    with pytest.raises(LibraryError, match=r"not a library: catalogue\.sqlite was not written by Kinetograph"):
        Library.open(tmp_path)
    assert Library.create(tmp_path).names() == ()


def test_what_is_no_library_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        LibraryError, match=r"not a library: no such folder; make one with `kinetograph library create`"
    ):
        Library.open(tmp_path / "missing")
    with pytest.raises(LibraryError, match=r"not a library: no catalogue\.sqlite in it"):
        Library.open(tmp_path)
    (tmp_path / "catalogue.sqlite").write_text("x" * 5000)
    with pytest.raises(LibraryError, match=r"catalogue\.sqlite is damaged .*restore it from a copy"):
        Library.open(tmp_path)
    with pytest.raises(LibraryError, match="cannot make a library here: File exists"):
        Library.create(tmp_path / "catalogue.sqlite")


def test_a_newer_format_is_refused(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    with catalogue.writing(library.path) as db:
        db.execute(f"PRAGMA user_version = {catalogue.VERSION + 1}")
    message = f"library format {catalogue.VERSION + 1} is newer than {catalogue.VERSION}, .* update Kinetograph"
    with pytest.raises(LibraryError, match=message):
        Library.open(library.path)


def test_an_older_format_is_migrated_once(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    def add_a_column(db: sqlite3.Connection) -> None:
        db.execute("ALTER TABLE takes ADD COLUMN recorded TEXT")

    library.add(walk_take("walk"))
    old = catalogue.VERSION
    monkeypatch.setattr(catalogue, "VERSION", old + 1)
    monkeypatch.setitem(catalogue.MIGRATIONS, old, add_a_column)
    for _ in range(2):
        assert Library.open(library.path).names() == ("walk",)
    with catalogue.reading(library.path) as db:
        assert db.execute("SELECT recorded FROM takes").fetchall() == [(None,)]
        assert db.execute("PRAGMA user_version").fetchone() == (old + 1,)


def test_a_migration_that_fails_changes_nothing(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail_halfway(db: sqlite3.Connection) -> None:
        db.execute("DROP TABLE annotations")
        raise KeyboardInterrupt

    library.add(walk_take("walk", 30, cut(0.1)))
    with monkeypatch.context() as newer:
        newer.setattr(catalogue, "VERSION", catalogue.VERSION + 1)
        newer.setitem(catalogue.MIGRATIONS, catalogue.VERSION - 1, fail_halfway)
        with pytest.raises(KeyboardInterrupt):
            Library.open(library.path)
    assert Library.open(library.path).take("walk").annotations == (cut(0.1),)


def test_a_read_only_folder_can_be_read(tmp_path: Path) -> None:
    # a folder that every user can reach: permissions do not bind root, so the child becomes someone else
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        library = Library.create(folder / "library")
        library.add(walk_take("walk", 30, cut(0.5)))
        for path in (*library.path.iterdir(), library.path, folder):
            path.chmod(0o555 if path.is_dir() else 0o444)
        try:
            outcome = in_child(_use_read_only, library.path)
        finally:
            for path in (folder, library.path):
                path.chmod(0o755)
    assert outcome == "(('walk',), 30, (Annotation(track='motion', kind='cut', label='', start=0.5, stop=0.5),), True)"


def _use_read_only(path: Path) -> object:
    if os.getuid() == 0:
        os.setuid(65534)
    library = Library.open(path)
    take = library.take("walk")
    with pytest.raises(LibraryError, match="it is read-only here; change its permissions, or copy it"):
        library.remove("walk")
    with pytest.raises(LibraryError, match="it is read-only here"):
        library.add(walk_take("other"))
    return library.names(), len(take.motion()), take.annotations, library.check().sound


def in_child(work: Callable[[Path], object], path: Path) -> str:
    """What ``work(path)`` gives, as text, in a process of its own, whose limits and user it may change."""
    context = multiprocessing.get_context("fork")
    receive, send = context.Pipe(duplex=False)
    child = context.Process(target=_report, args=(send, work, path))
    child.start()
    send.close()
    text: str = receive.recv()
    child.join()
    receive.close()
    child.close()
    return text


def _report(send: multiprocessing.connection.Connection, work: Callable[[Path], object], path: Path) -> None:
    try:
        send.send(repr(work(path)))
    except BaseException as error:
        send.send(f"{type(error).__name__}: {error}")
    os._exit(0)


# one writer, many readers


def test_a_second_writer_is_told_after_a_while(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(catalogue, "PATIENCE", 0.2)
    with catalogue.writing(library.path), pytest.raises(LibraryError, match="another process has been writing to it"):
        library.add(walk_take("walk"))
    library.add(walk_take("walk"))


def test_a_second_writer_waits(library: Library) -> None:
    with catalogue.writing(library.path):
        second = threading.Thread(target=library.add, args=(walk_take("walk"),))
        second.start()
        second.join(0.2)
        assert second.is_alive()
        assert library.names() == ()
    second.join(10)
    assert library.names() == ("walk",)


def test_readers_do_not_wait_for_a_writer(library: Library) -> None:
    library.add(walk_take("walk"))
    with catalogue.writing(library.path) as db:
        db.execute("INSERT INTO takes (name) VALUES ('begun')")
        assert Library.open(library.path).take("walk").name == "walk"  # one that waited would end in an error
        assert library.names() == ("walk",)


def test_a_reader_goes_on_while_a_repair_moves_the_frames(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("gone", "walk"):
        library.add(walk_take(name))
    library.remove("gone")
    read = frame_files.read

    def read_late(path: Path, span: frame_files.Span) -> frame_files.Array:
        monkeypatch.setattr(frame_files, "read", read)
        assert library.check(repair=True).freed > 0
        return read(path, span)

    monkeypatch.setattr(frame_files, "read", read_late)
    assert_same_track(library.take("walk").motion(), walk())


def test_a_take_under_a_reader_outlives_its_removal(library: Library) -> None:
    for name in ("walk", "other"):
        library.add(walk_take(name))
    with catalogue.reading(library.path) as db:
        start, width, frames, checksum = db.execute(
            "SELECT start, width, frames, checksum FROM arrays JOIN tracks ON tracks.id = arrays.track "
            "WHERE arrays.name = 'translation' ORDER BY start DESC LIMIT 1"
        ).fetchone()
    span = frame_files.Span("translation", "<f8", width, frames, start, checksum)
    shape = (span.frames, span.width)
    mapped = np.memmap(library.path / "frames-1.bin", dtype=span.dtype, mode="r", offset=span.start, shape=shape)
    library.remove("other")
    library.add(Take("third", {"motion": walk(300, seed=1)}))
    library.check(repair=True)
    np.testing.assert_array_equal(mapped, walk().translation)


# checks


def test_bytes_of_removed_takes_are_found_and_given_back(library: Library) -> None:
    for i in range(5):
        library.add(walk_take(str(i), 50 + i))
    before = library.info().bytes
    library.remove("2")
    library.add(walk_take("0", 10), replace=True)
    report = library.check()
    assert report.orphaned == sum(_stored(frames) for frames in (52, 50))
    assert not report.sound
    repaired = library.check(repair=True)
    assert repaired == Report(report.orphaned, report.orphaned, ())
    assert repaired.sound
    assert library.check() == Report(0, 0, ())
    assert library.info().bytes < before
    assert [len(library.take(name).motion()) for name in library.names()] == [10, 51, 53, 54]
    assert [path.name for path in sorted(library.path.glob("frames*"))] == ["frames-2.bin"]
    library.add(walk_take("after"))
    assert library.check() == Report(0, 0, ())


def _stored(frames: int) -> int:
    return frames * (3 * 8 + 3 * 4 * 4)


def test_stray_bytes_and_files_are_moved_aside(library: Library) -> None:
    library.add(walk_take("walk"))
    with (library.path / "frames-1.bin").open("ab") as file:
        file.write(b"half a take")
    (library.path / "frames-2.bin").write_bytes(b"half a repair")
    assert library.check() == Report(24, 0, ())
    moved = (f"lost/frames-1.bin@{HEADER + _stored(30)}", "lost/frames-2.bin")
    assert library.check(repair=True) == Report(24, 24, (), moved)
    assert [(library.path / name).read_bytes() for name in moved] == [b"half a take", b"half a repair"]
    assert library.check() == Report(0, 0, ())
    assert_same_track(library.take("walk").motion(), walk())


def test_damage_is_found_and_its_take_refused(library: Library) -> None:
    for name in ("sound", "altered", "short"):
        library.add(walk_take(name))
    with (library.path / "frames-1.bin").open("r+b") as file:
        file.seek(HEADER + _stored(30) + 5)
        file.write(b"\xff")
        file.truncate(HEADER + 3 * _stored(30) - 8)
    damaged = library.check(repair=True).damaged
    assert [re.sub(r"\d+", "N", line) for line in damaged] == [
        "take 'altered', track 'motion': translation has changed since it was written, at frames-N.bin byte N",
        "take 'short', track 'motion': rotations is cut short: expected frames-N.bin to reach byte N, found N",
    ]
    with pytest.raises(LibraryError, match="array 'translation' at byte 2224 has changed since it was written"):
        library.take("altered")
    with pytest.raises(LibraryError, match="array 'rotations' is cut short"):
        library.take("short")
    for name in ("altered", "short"):
        library.remove(name)
    assert library.check(repair=True).sound
    assert_same_track(library.take("sound").motion(), walk())
    library.add(walk_take("short"))
    assert_same_track(library.take("short").motion(), walk())


def test_frames_that_are_gone_are_reported(library: Library) -> None:
    library.add(walk_take("walk"))
    (library.path / "frames-1.bin").unlink()
    assert library.check().damaged == ("take 'walk', track 'motion': frames-1.bin is gone",) * 2
    with pytest.raises(LibraryError, match="the frames are gone; restore them from a copy"):
        library.take("walk")


# no room


def test_a_full_disk_leaves_the_library_unchanged(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    write, room = os.write, 1000

    def write_until_full(descriptor: int, data: memoryview) -> int:
        nonlocal room
        if room == 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written = write(descriptor, data[:room])
        room -= written
        return written

    library.add(walk_take("walk"))
    before = {path.name: path.read_bytes() for path in library.path.iterdir()}
    with monkeypatch.context() as full:
        full.setattr(os, "write", write_until_full)
        with pytest.raises(
            LibraryError, match=r"cannot write the 0\.0 MB of take 'run': No space left on device; free"
        ):
            library.add(walk_take("run"))
    assert {path.name: path.read_bytes() for path in library.path.iterdir()} == before
    library.add(walk_take("run"))
    assert library.names() == ("walk", "run")


@pytest.mark.parametrize(
    ("frames", "notes", "message"),
    [(20_000, 0, "MB of take 'large': File too large; free some space"), (1, 20_000, "is the disk full or failing?")],
    ids=["frames", "catalogue"],
)
def test_no_room_for_a_file_leaves_the_library_unchanged(
    library: Library, frames: int, notes: int, message: str
) -> None:
    library.add(walk_take("walk"))
    large = walk_take("large", frames, *(cut(i) for i in range(notes)))

    def add_with_little_room(path: Path) -> object:
        resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, resource.RLIM_INFINITY))
        library.add(large)
        return "added"

    before = {path.name: path.read_bytes() for path in library.path.iterdir()}
    outcome = in_child(add_with_little_room, library.path)
    assert outcome.startswith("LibraryError: ")
    assert message in outcome
    assert "the library is unchanged" in outcome
    assert library.names() == ("walk",)
    assert library.check(repair=True).sound
    assert {path.name: path.read_bytes() for path in library.path.iterdir()} == before
    library.add(large)
    assert len(library.take("large").annotations) == notes


def test_a_repair_without_room_changes_nothing(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("gone", "walk"):
        library.add(walk_take(name))
    library.remove("gone")

    def refuse(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as full:
        full.setattr(os, "fsync", refuse)
        with pytest.raises(
            LibraryError, match="could not be checked: No space left on device; every take is as before"
        ):
            library.check(repair=True)
    assert_same_track(library.take("walk").motion(), walk())
    assert library.check(repair=True).sound


def test_a_library_travels_to_another_process(library: Library) -> None:
    library.add(walk_take("walk"))
    library.take("walk")
    assert pickle.loads(pickle.dumps(library)).names() == ("walk",)


def test_a_folder_may_have_any_name(tmp_path: Path) -> None:
    library = Library.create(tmp_path / "100%25 öäü?mode=memory#1")
    library.add(walk_take("walk"))
    assert Library.open(library.path).names() == ("walk",)


def test_a_copy_of_the_folder_is_the_library(library: Library, tmp_path: Path) -> None:
    library.add(walk_take("walk"))
    shutil.copytree(library.path, tmp_path / "copy")
    assert_same_track(Library.open(tmp_path / "copy").take("walk").motion(), walk())
