"""Damaged, torn and older libraries: what has changed is refused, said, and never made worse by a repair."""

from __future__ import annotations

import json
import shutil
import sqlite3
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.errors import LibraryError
from kinetograph.library import (
    Library,
    Report,
    annotations_of,
    catalogue,
    contents,
    frame_files,
    headers,
    schema,
    storage,
)
from kinetograph.library import check as checks
from kinetograph.library.headers import Header
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation, Take

STICK = Skeleton(("hips", "chest", "head"), np.array([-1, 0, 1]), np.array([[0, 1.0, 0], [0, 0.3, 0], [0, 0.2, 0]]))
CHANGED = "catalogue.sqlite is damaged .*have changed since they were written.*; restore it from a copy"


def take_of(name: str, frames: int = 30) -> Take:
    rng = np.random.default_rng(frames)
    rotations = rot.normalize(rng.normal(size=(frames, 3, 4)))
    motion = Motion(STICK, rng.normal(size=(frames, 3)), rotations, 30.0)
    return Take(name, {"motion": motion}, (Annotation("motion", "cut", "", 0.1, 0.1),))


@pytest.fixture
def library(tmp_path: Path) -> Library:
    made = Library.create(tmp_path / "library")
    for number, name in enumerate(("walk", "run", "jump")):
        made.add(take_of(name, 30 + number))
    return made


def edit(library: Library, statement: str, *values: object) -> None:
    db = sqlite3.connect(library.path / "catalogue.sqlite")
    with db:
        assert db.execute(statement, values).rowcount > 0
    db.close()


def stored(frames: int) -> int:
    return frames * (3 * 8 + 3 * 4 * 4)


# ---- rows ----


def test_one_digit_of_a_skeletons_offsets_is_refused(library: Library) -> None:
    edit(library, "UPDATE skeletons SET body = replace(body, '0.3', '0.4')")
    with pytest.raises(LibraryError, match="a skeleton has changed since it was written"):
        Library.open(library.path).take("walk")
    assert library.check().damaged == ("catalogue.sqlite: skeleton 1 has changed since it was written",)


def test_adding_a_take_puts_right_the_skeleton_that_it_shares(library: Library) -> None:
    edit(library, "UPDATE skeletons SET body = replace(body, '0.3', '0.4')")
    library.add(take_of("more"))
    np.testing.assert_array_equal(Library.open(library.path).take("walk").motion().skeleton.offsets, STICK.offsets)
    assert library.check().sound


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE tracks SET fps = 31.0 WHERE id = 1",
        "UPDATE tracks SET frames = 29 WHERE id = 1",
        "UPDATE tracks SET name = 'other' WHERE id = 1",
        "UPDATE arrays SET width = 2 WHERE track = 1 AND name = 'translation'",
        "UPDATE takes SET id = 9 WHERE id = 1",
        "UPDATE takes SET digest = '' WHERE id = 1",
        "DELETE FROM arrays WHERE track = 1 AND name = 'rotations'",
        "DELETE FROM tracks WHERE id = 1",
    ],
)
def test_a_take_whose_rows_have_changed_is_refused(library: Library, statement: str) -> None:
    edit(library, statement)
    with pytest.raises(LibraryError, match=CHANGED):
        library.take("walk")
    assert not library.check().sound
    assert len(library.take("run").motion()) == 31


@pytest.mark.parametrize(
    "statement",
    [
        "UPDATE annotations SET start = 0.2, stop = 0.2 WHERE id = 1",
        "UPDATE annotations SET label = 'x' WHERE id = 1",
        "UPDATE annotations SET track = 2 WHERE id = 1",
        "DELETE FROM annotations WHERE id = 1",
    ],
)
def test_annotations_that_have_changed_are_refused_and_not_made_right(library: Library, statement: str) -> None:
    edit(library, statement)
    changed = "the annotations of take 'walk' have changed since they were written"
    with pytest.raises(LibraryError, match=changed):
        library.take("walk")
    with pytest.raises(LibraryError, match=changed):
        annotations_of(library, "walk")
    with pytest.raises(LibraryError, match=changed):
        library.annotate("walk", [Annotation("motion", "move", "turn", 0.0, 0.5)])


def test_a_take_that_is_gone_is_missed(library: Library) -> None:
    edit(library, "DELETE FROM takes WHERE id = 2")
    with pytest.raises(LibraryError, match="the list of takes has changed since it was written: some are gone"):
        library.names()
    assert any("the list of takes has changed" in line for line in library.check().damaged)


def test_takes_that_changed_names_are_refused(library: Library) -> None:
    for old, new in (("walk", "x"), ("run", "walk"), ("x", "run")):
        edit(library, "UPDATE takes SET name = ? WHERE name = ?", new, old)
    for name in ("walk", "run"):
        with pytest.raises(LibraryError, match=CHANGED):
            library.take(name)


def test_numbers_that_became_text_are_refused_where_tracks_are_listed(library: Library) -> None:
    edit(library, "UPDATE tracks SET fps = 'fast' WHERE id = 1")
    with pytest.raises(LibraryError, match=CHANGED):
        contents(library)


def test_where_the_frames_are_is_checked(library: Library) -> None:
    edit(library, "UPDATE storage SET file = '../frames-1.bin'")
    with pytest.raises(LibraryError, match="where the frames are has changed since it was written"):
        library.take("walk")


def test_an_array_that_lies_at_a_word_is_refused_and_nothing_is_moved(library: Library) -> None:
    edit(library, "UPDATE arrays SET start = 'here' WHERE track = 1 AND name = 'translation'")
    with pytest.raises(LibraryError, match="where the arrays of track 'motion' lie has changed"):
        library.take("walk")
    assert len(library.take("run").motion()) == 31
    before = (library.path / "frames-1.bin").read_bytes()
    with pytest.raises(LibraryError, match="lies has changed since it was written"):
        library.check(repair=True)
    assert (library.path / "frames-1.bin").read_bytes() == before


def test_other_tables_are_not_a_librarys(library: Library) -> None:
    with catalogue.writing(library.path) as db:
        db.execute("CREATE TRIGGER forget AFTER INSERT ON takes BEGIN DELETE FROM annotations; END")
    assert library.check().damaged == ("catalogue.sqlite: its tables are not those of a library",)


# ---- a damaged catalogue, and repairs ----


def spoil_page(path: Path, page: int) -> None:
    data = bytearray(path.read_bytes())
    data[page * 4096 : page * 4096 + 2048] = bytes(2048)
    path.write_bytes(data)


def test_a_repair_with_a_damaged_catalogue_touches_no_frames(library: Library, tmp_path: Path) -> None:
    good = shutil.copy(library.path / "catalogue.sqlite", tmp_path / "good.sqlite")
    frames = (library.path / "frames-1.bin").read_bytes()
    pages = (library.path / "catalogue.sqlite").stat().st_size // 4096
    refused = 0
    for page in range(1, pages):  # not the first, without which no library is opened
        shutil.copy(good, library.path / "catalogue.sqlite")
        spoil_page(library.path / "catalogue.sqlite", page)
        report = library.check(repair=True)
        assert (library.path / "frames-1.bin").read_bytes() == frames
        assert report.sound == (not report.damaged)
        refused += not report.sound
    assert refused > pages // 2
    shutil.copy(good, library.path / "catalogue.sqlite")
    assert [len(library.take(name).motion()) for name in library.names()] == [30, 31, 32]
    assert library.check() == Report(0, 0, ())


def test_what_is_moved_aside_is_found_again_for_the_newer_catalogue(library: Library, tmp_path: Path) -> None:
    older = shutil.copy(library.path / "catalogue.sqlite", tmp_path / "older.sqlite")
    library.add(take_of("late", 40))
    newer = shutil.copy(library.path / "catalogue.sqlite", tmp_path / "newer.sqlite")
    shutil.copy(older, library.path / "catalogue.sqlite")
    report = library.check()
    assert "the catalogue is an older copy, and takes added since are missing" in report.mismatch
    assert (report.sound, report.orphaned) == (False, stored(40))
    repaired = library.check(repair=True)
    assert repaired.moved == (f"lost/frames-1.bin@{headers.SIZE + stored(30 + 31 + 32)}",)
    assert repaired.sound
    library.add(take_of("another", 50))
    shutil.copy(newer, library.path / "catalogue.sqlite")
    with pytest.raises(LibraryError, match="has changed since it was written"):
        library.take("late")
    found = library.check(repair=True)
    assert found.restored == tuple(f"take 'late', track 'motion': {a}" for a in ("translation", "rotations"))
    np.testing.assert_array_equal(library.take("late").motion().translation, take_of("late", 40).motion().translation)


def test_an_older_catalogue_finds_its_takes_in_frames_that_were_copied(library: Library, tmp_path: Path) -> None:
    older = shutil.copy(library.path / "catalogue.sqlite", tmp_path / "older.sqlite")
    library.remove("run")
    assert library.check(repair=True) == Report(stored(31), stored(31), ())
    assert not (library.path / "lost").exists()  # what was removed is deleted, since nothing else can be meant
    shutil.copy(older, library.path / "catalogue.sqlite")
    report = library.check(repair=True)
    assert len(report.restored) == 4
    assert [line.partition(":")[0] for line in report.damaged] == ["take 'run', track 'motion'"] * 2
    assert [len(library.take(name).motion()) for name in ("walk", "jump")] == [30, 32]
    with pytest.raises(LibraryError):
        library.take("run")


def test_frames_under_another_name_are_found(library: Library) -> None:
    (library.path / "frames-1.bin").rename(library.path / "frames-7.bin")
    with pytest.raises(LibraryError, match="the frames are gone; restore them from a copy"):
        library.take("walk")
    report = library.check(repair=True)
    assert (report.damaged, len(report.restored), report.moved) == ((), 6, ("lost/frames-7.bin",))
    assert [len(library.take(name).motion()) for name in library.names()] == [30, 31, 32]


def test_frames_of_another_library_are_named_and_not_written_to(library: Library, tmp_path: Path) -> None:
    other = Library.create(tmp_path / "other")
    other.add(take_of("walk", 30))
    frames = (other.path / "frames-1.bin").read_bytes()
    shutil.copy(other.path / "frames-1.bin", library.path)
    assert "frames-1.bin: these are the frames of another library" in library.check().damaged
    with pytest.raises(LibraryError, match="these are not this library's frames"):
        library.add(take_of("more"))
    library.check(repair=True)
    kept = [path.read_bytes() for path in (*library.path.glob("frames-*"), *library.path.glob("lost/*"))]
    assert frames in kept


def test_bytes_after_the_last_take_are_never_written_over(library: Library) -> None:
    path = library.path / "frames-1.bin"
    end = path.stat().st_size
    with path.open("ab") as file:
        file.write(b"of a newer catalogue")
    library.add(take_of("more"))
    assert path.read_bytes()[end:].startswith(b"of a newer catalogue")
    assert library.check().damaged == ()
    assert len(library.take("more").motion()) == 30


# ---- numbers of changes ----


def test_catalogue_and_frames_count_changes_together(library: Library) -> None:
    def numbers() -> tuple[int, int]:
        with catalogue.reading(library.path) as db:
            held = storage.read(db)
        header = headers.read(library.path / held.file)
        assert header is not None
        return held.sequence, header.sequence

    assert numbers() == (3, 3)
    library.annotate("walk", [Annotation("motion", "move", "turn", 0.0, 0.5)])
    library.remove("run")
    assert numbers() == (5, 5)
    with pytest.raises(Exception, match="no take 'run'"):
        library.remove("run")
    assert numbers() == (5, 5)
    library.check(repair=True)
    assert numbers() == (6, 6)


def test_an_older_copy_of_the_frames_is_said(library: Library, tmp_path: Path) -> None:
    older = shutil.copy(library.path / "frames-1.bin", tmp_path / "older.bin")
    library.remove("jump")
    shutil.copy(older, library.path / "frames-1.bin")
    report = library.check()
    assert report.mismatch == "change 4 in catalogue.sqlite, 3 in frames-1.bin: the frames are an older copy"
    assert not report.sound


def test_a_header_is_read_as_written_and_not_if_a_bit_has_changed(tmp_path: Path) -> None:
    header = Header("0123456789abcdef" * 2, 7, 40)
    path = tmp_path / "frames-1.bin"
    for bit in range(8 * headers.SIZE):
        data = bytearray(headers.pack(header))
        path.write_bytes(data)
        assert headers.read(path) == header
        data[bit // 8] ^= 1 << bit % 8
        path.write_bytes(data)
        assert headers.read(path) is None


# ---- older versions ----


def of_version_1(folder: Path, library: Library) -> Path:
    """The same library as version 1 wrote it: no digests, and no header."""
    folder.mkdir()
    frames = (library.path / "frames-1.bin").read_bytes()[headers.SIZE :]
    (folder / "frames-1.bin").write_bytes(frames)
    db = sqlite3.connect(folder / "catalogue.sqlite")
    schema.create_first_version(db, "frames-1.bin")
    db.execute(f"PRAGMA application_id = {catalogue.APPLICATION_ID}")
    db.execute("PRAGMA user_version = 1")
    db.execute("ATTACH ? AS new", (str(library.path / "catalogue.sqlite"),))
    db.execute("INSERT INTO takes (id, name) SELECT id, name FROM new.takes")
    for table in ("skeletons", "tracks", "annotations"):
        db.execute(f"INSERT INTO {table} SELECT * FROM new.{table}")
    db.execute(f"INSERT INTO arrays SELECT track, name, dtype, width, start - {headers.SIZE}, checksum FROM new.arrays")
    db.execute("UPDATE storage SET stop = ?", (len(frames),))
    db.commit()
    db.close()
    return folder


def test_a_library_of_version_1_is_brought_up_to_date(library: Library, tmp_path: Path) -> None:
    old = Library.open(of_version_1(tmp_path / "old", library))
    assert old.names() == library.names()
    for name in old.names():
        np.testing.assert_array_equal(old.take(name).motion().translation, library.take(name).motion().translation)
        assert old.take(name).annotations == library.take(name).annotations
    assert old.check() == Report(0, 0, ())
    edit(old, "UPDATE tracks SET fps = 31.0 WHERE id = 1")
    with pytest.raises(LibraryError, match=CHANGED):
        old.take("walk")


def test_a_library_of_version_1_keeps_its_frames_at_the_first_repair(library: Library, tmp_path: Path) -> None:
    old = Library.open(of_version_1(tmp_path / "old", library))
    old.remove("run")
    report = old.check(repair=True)
    assert (report.moved, report.damaged) == (("lost/frames-1.bin",), ())
    assert headers.read(old.path / "frames-2.bin") is not None
    assert [len(old.take(name).motion()) for name in old.names()] == [30, 32]
    old.add(take_of("run"))
    assert old.check() == Report(0, 0, ())


def test_damage_is_not_made_right_by_a_new_version(library: Library, tmp_path: Path) -> None:
    folder = of_version_1(tmp_path / "old", library)
    edit(Library(folder), "UPDATE skeletons SET body = replace(body, '0.3', '0.4')")
    with pytest.raises(LibraryError, match=r"catalogue\.sqlite is damaged \(skeleton 1 has changed\)"):
        Library.open(folder)
    assert sqlite3.connect(folder / "catalogue.sqlite").execute("PRAGMA user_version").fetchone() == (1,)


# ---- the digests themselves ----


def test_a_digest_is_the_same_in_every_process(library: Library) -> None:
    script = (
        "import json, sys; from kinetograph.library import digests\nprint(digests.of_rows(json.loads(sys.argv[1])))"
    )
    rows = [[1, "wälk\u2028", None, 0.1, 1e300, [30.0]]]
    for seed in ("1", "2"):
        said = subprocess.run(
            [sys.executable, "-c", script, json.dumps(rows)],
            env={"PYTHONPATH": ":".join(sys.path), "PYTHONHASHSEED": seed},
            capture_output=True,
            check=True,
            text=True,
        ).stdout
        assert said == "f9c8a5e4769b53dbff335613edb914e3\n"


def test_a_file_that_is_cut_while_it_is_read_is_refused(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    within = frame_files._within

    def cut(file: frame_files.FileIO, span: frame_files.Span) -> bool:
        there = within(file, span)
        (library.path / "frames-1.bin").write_bytes(b"")
        return there

    monkeypatch.setattr(frame_files, "_within", cut)
    with pytest.raises(LibraryError, match="has changed since it was written"):
        library.take("walk")


def test_the_checks_find_nothing_in_a_sound_catalogue(library: Library) -> None:
    with catalogue.reading(library.path) as db:
        assert checks.catalogue_faults(db) == ()


# ---- writing to a damaged catalogue ----


def test_a_catalogue_with_other_tables_is_not_written_to(library: Library) -> None:
    with catalogue.writing(library.path) as db:
        db.execute("CREATE TRIGGER forget AFTER INSERT ON takes BEGIN DELETE FROM annotations; END")
    with pytest.raises(LibraryError, match="its tables are not those of a library"):
        library.add(take_of("more"))
    assert len(library.take("walk").annotations) == 1


def test_rows_that_damage_left_do_not_become_a_new_takes(library: Library) -> None:
    edit(library, "INSERT INTO annotations (track, kind, label, start, stop) VALUES (4, 'move', 'old', 0.0, 0.1)")
    with pytest.raises(LibraryError, match="what was written does not come back"):
        library.add(take_of("more"))
    assert library.path.joinpath("frames-1.bin").stat().st_size == headers.SIZE + stored(30 + 31 + 32)


def test_a_catalogue_with_exchanged_pages_is_not_written_to(library: Library) -> None:
    for number in range(40):
        library.add(take_of(f"more {number}"))
    path = library.path / "catalogue.sqlite"
    good = path.read_bytes()
    size = int.from_bytes(good[16:18], "big")
    for page in range(2, len(good) // size - 1):
        first, second = (slice(k * size, (k + 1) * size) for k in (page, page + 1))
        path.write_bytes(good[: first.start] + good[second] + good[first] + good[second.stop :])
        with pytest.raises(LibraryError):
            library.add(take_of("last"))
    path.write_bytes(good)
    assert len(library.take("more 39").motion()) == len(take_of("more").motion())
