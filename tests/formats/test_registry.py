"""The table of formats, and outputs that appear whole or not at all."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats import READERS, WRITERS, Loaded, bvh, load, read, save
from kinetograph.formats.atomic import atomic_path
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton
from kinetograph.take import Take

STICK = Motion(
    Skeleton(("a", "b"), np.array([-1, 0]), np.array([[0, 0, 0], [0, 1.7, 0]])),
    np.zeros((3, 3)),
    rot.identity(3, 2),
    30,
)


@pytest.mark.parametrize("suffix", READERS)
def test_every_reader_reads(suffix: str) -> None:
    assert callable(importlib.import_module(f"kinetograph.formats.{READERS[suffix]}").read)


@pytest.mark.parametrize("suffix", WRITERS)
def test_every_writer_writes(suffix: str) -> None:
    assert callable(importlib.import_module(f"kinetograph.formats.{WRITERS[suffix]}").write)


def test_load_and_read_differ_by_the_notes(tmp_path: Path) -> None:
    save(STICK, tmp_path / "stick.BVH")
    loaded = read(tmp_path / "stick.BVH")
    assert isinstance(loaded, Loaded)
    assert loaded.take.name == "stick"
    assert loaded.notes == ()  # files of this package say what they mean
    take = load(str(tmp_path / "stick.BVH"), units="metre", up="y", fps=10)
    assert isinstance(take, Take)
    assert take.motion().fps == 10


def test_unknown_suffixes_name_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(RequestError, match=r"cannot read files of kind '\.xyz'; expected one of \.amc, \.asf, \.bvh"):
        load(tmp_path / "a.xyz")
    with pytest.raises(RequestError, match=r"cannot write files of kind ''; expected one of \.bvh, \.csv, \.fbx"):
        save(STICK, tmp_path / "a")
    save(STICK, tmp_path / "a.bvh")
    with pytest.raises(RequestError, match="unknown units 'parsec'"):
        load(tmp_path / "a.bvh", units="parsec")
    with pytest.raises(FormatError, match="cannot open it: No such file"):
        load(tmp_path / "none.csv")


def test_nothing_is_overwritten_without_force(tmp_path: Path) -> None:
    path = tmp_path / "a.bvh"
    path.write_text("precious")
    with pytest.raises(RequestError, match=r"a\.bvh: exists already; overwrite it with --force"):
        save(STICK, path, force=False)
    assert path.read_text() == "precious"
    save(STICK, path)
    assert path.read_text().startswith("HIERARCHY")


def test_a_failure_leaves_the_old_file_and_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.bvh"
    path.write_text("precious")

    def fail(what: object, draft: Path, options: object) -> None:
        draft.write_text("half")
        raise OSError("disk full")

    monkeypatch.setattr(bvh, "write", fail)
    with pytest.raises(OSError, match="disk full"):
        save(STICK, path)
    assert path.read_text() == "precious"
    assert list(tmp_path.iterdir()) == [path]


def test_a_new_file_has_usual_permissions_and_an_old_one_keeps_its_own(tmp_path: Path) -> None:
    usual = tmp_path / "usual"
    usual.touch()
    with atomic_path(tmp_path / "new.txt") as draft:
        draft.write_text("new")
    assert (tmp_path / "new.txt").stat().st_mode == usual.stat().st_mode
    usual.chmod(0o640)
    with atomic_path(usual) as draft:
        draft.write_text("again")
    assert usual.stat().st_mode & 0o777 == 0o640


def test_folders_that_cannot_take_the_file(tmp_path: Path) -> None:
    with pytest.raises(RequestError, match=r"cannot write here: No such file or directory"):
        save(STICK, tmp_path / "none" / "a.bvh")
    with pytest.raises(RequestError, match="expected the name of a file, found a folder"), atomic_path(tmp_path):
        pass
