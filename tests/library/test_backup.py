"""Copies of a library: by `back_up` while others write, by hand while others write, and of what a damaged one has."""

from __future__ import annotations

import errno
import os
import shutil
import sqlite3
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from crash_writer import take_of
from test_crash import WRITER, found_in

from kinetograph.errors import KinetographError, LibraryError
from kinetograph.library import Library, back_up, backup, salvage


@pytest.fixture
def library(tmp_path: Path) -> Library:
    made = Library.create(tmp_path / "library")
    for name in ("a", "b", "c"):
        made.add(take_of(name, 1))
    return made


@contextmanager
def writer(library: Library, seed: int) -> Iterator[subprocess.Popen[bytes]]:
    """Another process that changes a library without end."""
    with subprocess.Popen([sys.executable, str(WRITER), str(library.path), str(seed)], stdout=subprocess.PIPE) as child:
        assert child.stdout is not None
        child.stdout.readline()
        try:
            yield child
        finally:
            child.kill()
            child.stdout.read()


def test_a_backup_is_the_library(library: Library, tmp_path: Path) -> None:
    library.remove("b")
    seen: list[tuple[int, int]] = []
    copy = back_up(library, tmp_path / "copy", progress=lambda done, total: seen.append((done, total)))
    assert found_in(copy) == found_in(library)
    assert copy.check().damaged == ()
    assert copy.check().mismatch == ""
    assert seen[-1][0] == seen[-1][1]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["copy", "library"]


def test_the_catalogue_of_a_backup_can_be_put_back(library: Library, tmp_path: Path) -> None:
    copy = back_up(library, tmp_path / "copy")
    (library.path / "catalogue.sqlite").write_bytes(b"damaged")
    shutil.copy(copy.path / "catalogue.sqlite", library.path)
    assert library.check().sound
    assert found_in(library).takes == {"a": 1, "b": 1, "c": 1}


def test_a_backup_takes_no_place_but_with_force_that_of_a_library(library: Library, tmp_path: Path) -> None:
    copy = back_up(library, tmp_path / "copy")
    library.add(take_of("d", 1))
    with pytest.raises(LibraryError, match="exists already; replace it with --force"):
        back_up(library, copy.path)
    assert len(copy.names()) == 3
    assert len(back_up(library, copy.path, force=True).names()) == 4
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "thesis.tex").touch()
    with pytest.raises(LibraryError, match="exists, and is not a library"):
        back_up(library, tmp_path / "thesis", force=True)
    assert (tmp_path / "thesis" / "thesis.tex").exists()


def test_backups_are_whole_while_another_process_writes(library: Library, tmp_path: Path) -> None:
    with writer(library, 5) as child:
        for number in range(8):
            copy = back_up(library, tmp_path / f"copy{number}")
            report = copy.check()
            assert (report.damaged, report.mismatch) == ((), "")
            found_in(copy)
        assert child.poll() is None
    assert len({tuple(found_in(Library.open(tmp_path / f"copy{n}")).takes.items()) for n in range(8)}) > 1


def test_copies_by_hand_while_another_process_writes_are_whole_or_say_so(library: Library, tmp_path: Path) -> None:
    sound = said = 0
    with writer(library, 6):
        for number in range(25):
            time.sleep(0.01)
            folder = tmp_path / f"copy{number}"
            try:
                shutil.copytree(library.path, folder)
                copy = Library.open(folder)
                report = copy.check()
            except (shutil.Error, KinetographError):  # a file that went, or a catalogue in pieces
                said += 1
                continue
            if report.damaged:
                said += 1
                continue
            found_in(copy)  # every take as it was written
            sound += report.sound
    print(f"25 copies, {sound} sound, {said} refused or damaged, the others not sound")


def test_a_repair_meanwhile_does_not_disturb_a_backup(
    library: Library, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library.remove("b")
    copy_catalogue, repairs = backup._copy_catalogue, []

    def then_repair(source: Path, target: Path) -> object:
        held = copy_catalogue(source, target)
        if not repairs:
            repairs.append(library.check(repair=True))
        return held

    monkeypatch.setattr(backup, "_copy_catalogue", then_repair)
    copy = back_up(library, tmp_path / "copy")
    assert repairs[0].freed > 0
    assert copy.check().sound
    assert found_in(copy).takes == {"a": 1, "c": 1}


def test_a_backup_without_room_leaves_nothing(
    library: Library, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "write", full)
    with pytest.raises(LibraryError, match="copy: cannot make a copy here: No space left on device"):
        back_up(library, tmp_path / "copy")
    assert [path.name for path in tmp_path.iterdir()] == ["library"]


def test_a_damaged_library_is_not_backed_up_but_salvaged(library: Library, tmp_path: Path) -> None:
    with (library.path / "frames-1.bin").open("r+b") as file:
        file.seek(100)
        file.write(b"\xff\xff")
    with pytest.raises(LibraryError, match=r"is damaged: take 'a', .*nothing was copied; .*backup --salvage"):
        back_up(library, tmp_path / "copy")
    assert [path.name for path in tmp_path.iterdir()] == ["library"]
    copy, left_out = salvage(library, tmp_path / "copy")
    assert copy.check().sound
    assert copy.names() == ("b", "c")
    assert_kept(copy, "b")
    assert list(left_out) == ["a"]
    assert "has changed since it was written" in left_out["a"]


def test_what_a_damaged_catalogue_still_has_is_salvaged(library: Library, tmp_path: Path) -> None:
    with sqlite3.connect(library.path / "catalogue.sqlite") as db:
        db.execute("DELETE FROM takes WHERE name = 'b'")
        db.execute("UPDATE tracks SET fps = fps + 1 WHERE take = 1")
    db.close()
    copy, left_out = salvage(library, tmp_path / "copy")
    assert copy.names() == ("c",)
    assert set(left_out) == {"", "a"}
    assert_kept(copy, "c")


def assert_kept(copy: Library, name: str) -> None:
    read, written = copy.take(name), take_of(name, 1)
    np.testing.assert_array_equal(read.motion().translation, written.motion().translation)
    np.testing.assert_array_equal(read.signal().values, written.signal().values)
    np.testing.assert_allclose(read.motion().rotations, written.motion().rotations, atol=2e-7)
    assert read.annotations == written.annotations
