"""The commands of libraries: what they say of damage, copies, interrupted work, and takes that do not fit."""

from __future__ import annotations

import json
import shutil
import sqlite3
from pathlib import Path

import numpy as np
import pytest
from command_line import run

from kinetograph import rotations as rot
from kinetograph.formats import save
from kinetograph.library import Library, kept
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton
from kinetograph.take import Take

STICK = Skeleton(("hips", "chest", "head"), np.array([-1, 0, 1]), np.array([[0, 1.0, 0], [0, 0.3, 0], [0, 0.2, 0]]))


def motion_of(skeleton: Skeleton = STICK, frames: int = 10) -> Motion:
    rotations = rot.normalize(np.random.default_rng(1).normal(size=(frames, len(skeleton), 4)))
    return Motion(skeleton, np.zeros((frames, 3)), rotations, 30.0)


@pytest.fixture
def files(tmp_path: Path) -> Path:
    folder = tmp_path / "files"
    folder.mkdir()
    for name in ("a", "b", "c"):
        save(motion_of(), folder / f"{name}.npz")
    return folder


@pytest.fixture
def library(tmp_path: Path) -> Library:
    made = Library.create(tmp_path / "library")
    for name in ("a", "b"):
        made.add(Take(name, {"motion": motion_of()}))
    return made


# ---- create ----


def test_create_keeps_what_can_be_read_and_goes_on_with_the_rest(files: Path, tmp_path: Path) -> None:
    good = (files / "b.npz").read_bytes()
    (files / "b.npz").write_bytes(b"damaged")
    first = run("library", "create", tmp_path / "made", files)
    assert first.returncode == 0, first.stderr
    assert "1 skipped: expected a NumPy archive" in first.stderr
    strict = run("library", "create", tmp_path / "strict", files, "--strict")
    assert (strict.returncode, Library.open(tmp_path / "strict").names()) == (1, ())
    assert "b.npz: expected a NumPy archive" in strict.stderr
    assert "goes on from there" not in strict.stderr
    (files / "b.npz").write_bytes(good)
    again = run("library", "create", tmp_path / "made", files, "--json")
    said = json.loads(again.stdout)
    assert (again.returncode, said["takes"], said["added"], said["unchanged_files"]) == (0, 3, 1, 2)
    assert sorted(p.name for p in (tmp_path / "made").iterdir()) == ["catalogue.sqlite", "frames-1.bin"]
    refused = run("library", "create", tmp_path / "made")
    assert (refused.returncode, "already holds a library; name files" in refused.stderr) == (1, True)


def test_create_of_nothing_that_can_be_read_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("not a motion")
    made = run("library", "create", tmp_path / "made", tmp_path / "notes.txt", tmp_path / "gone.bvh")
    assert (made.returncode, "none of the 2 files could be read" in made.stderr) == (1, True)
    assert "1 skipped: cannot open it: No such file or directory: " in made.stderr


def test_info_counts_and_lists_where_takes_are_few(files: Path, tmp_path: Path) -> None:
    for number in range(20):
        shutil.copy(files / "a.npz", files / f"more{number}.npz")
    run("library", "create", tmp_path / "made", files)
    few, every = run("library", "info", tmp_path / "made"), run("library", "info", tmp_path / "made", "--all")
    assert "more7" not in few.stdout
    assert "subjects     1: files (23)" in few.stdout
    assert "23 tracks: list them with --all" in few.stderr
    assert "more7" in every.stdout


def test_add_points_to_create_for_folders(files: Path, library: Library) -> None:
    for given in (str(files), f"motion={files}"):
        refused = run("library", "add", library.path, "--take", "x", given)
        assert (refused.returncode, refused.stderr.count("\n")) == (1, 1)
        assert f"library create {library.path} {files}" in refused.stderr


def test_takes_of_other_joints_are_named_at_once(files: Path, tmp_path: Path) -> None:
    other = Skeleton(("hips", "chest"), STICK.parents[:2], STICK.offsets[:2])
    save(motion_of(other), files / "d.npz")
    created = run("library", "create", tmp_path / "made", files)
    assert created.returncode == 0
    said = "(motion) have different joints: 3 joints in a, b, c; 2 joints in d; methods use those of most seconds"
    assert said in created.stderr
    added = run("library", "add", tmp_path / "made", "--take", "e", f"motion={files / 'a.npz'}")
    assert "3 joints in a, b, c and 1 more; 2 joints in d" in added.stderr


def test_takes_of_other_bone_lengths_are_not_named(files: Path, tmp_path: Path) -> None:
    save(motion_of(Skeleton(STICK.names, STICK.parents, STICK.offsets * 1.1)), files / "d.npz")
    assert "different joints" not in run("library", "create", tmp_path / "made", files).stderr


# ---- check, backup ----


def test_check_says_what_was_moved_and_where(library: Library) -> None:
    (library.path / "frames-9.bin").write_bytes(b"of someone else")
    checked = run("library", "check", library.path, "--repair")
    assert checked.returncode == 0
    assert "moved           lost/frames-9.bin" in checked.stdout
    assert "lost: what no take of this catalogue uses; delete it when all takes are there" in checked.stderr


def test_check_of_a_damaged_catalogue_fails_in_one_line_each(library: Library) -> None:
    with sqlite3.connect(library.path / "catalogue.sqlite") as db:
        db.execute("UPDATE skeletons SET body = replace(body, '0.3', '0.4')")
    db.close()
    for repair in ((), ("--repair",)):
        checked = run("library", "check", library.path, "--json", *repair)
        assert checked.returncode == 1
        report = json.loads(checked.stdout)
        assert report["damaged"] == ["catalogue.sqlite: skeleton 1 has changed since it was written"]
        assert (report["sound"], report["freed"]) == (False, 0)


def test_backup_copies_and_salvages(library: Library, tmp_path: Path) -> None:
    copied = run("library", "backup", library.path, tmp_path / "copy", "--json")
    assert json.loads(copied.stdout)["takes"] == 2
    refused = run("library", "backup", library.path, tmp_path / "copy")
    assert (refused.returncode, refused.stderr.count("\n")) == (1, 1)
    with sqlite3.connect(library.path / "catalogue.sqlite") as db:
        db.execute("UPDATE tracks SET fps = 31 WHERE id = 1")
    db.close()
    refused = run("library", "backup", library.path, tmp_path / "other")
    assert (refused.returncode, "the rows of take 'a' have changed" in refused.stderr) == (1, True)
    saved = run("library", "backup", library.path, tmp_path / "other", "--salvage", "--json")
    assert saved.returncode == 1
    assert "take 'a' left out: " in saved.stderr
    assert json.loads(saved.stdout)["takes"] == 1


# ---- segment ----


def test_a_take_that_cannot_be_cut_is_named_and_the_others_are_cut(tmp_path: Path) -> None:
    import walkers

    walk = walkers.walk(6.0)
    still = Motion(walk.skeleton, np.repeat(walk.translation[:1], 60, 0), np.repeat(walk.rotations[:1], 60, 0), 30.0)
    library = Library.create(tmp_path / "library")
    library.add(Take("idle", {"motion": still}))
    library.add(Take("walk", {"motion": walk}))
    cut = run("library", "segment", library.path, "--json")
    assert cut.returncode == 0, cut.stderr
    rows = {row["take"]: row["cuts"] for row in json.loads(cut.stdout)}
    assert rows["idle"] == 0 < 8 <= rows["walk"]
    assert {row["take"]: row["why"] for row in json.loads(cut.stdout)} == {"idle": "idle, nobody steps", "walk": None}
    again = run("library", "segment", library.path)
    assert "1 not cut, as found before; try again with --again: idle" in again.stderr
    assert "looked at now  0" in again.stdout
    library.remove("walk")
    alone = run("library", "segment", library.path, "--takes", "i*")
    assert (alone.returncode, "take 'idle' cannot be cut: idle, nobody steps" in alone.stderr) == (1, True)


def test_what_is_kept_is_listed_bounded_and_cleared(library: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(library.path.parent / "data"))
    assert json.loads(run("library", "cache", library.path, "--json").stdout)["kept"] == []
    kept(library, "thing", ("this", 2), lambda: np.zeros(1000))
    shown = run("library", "cache", library.path)
    assert "thing" in shown.stdout
    assert "('this', 2)" in shown.stdout
    answer = json.loads(run("library", "cache", library.path, "--limit", 0.001, "--json").stdout)
    assert [one["kept"] for one in answer["kept"]] == ["thing"]
    assert answer["limit"] == 1_000_000
    assert answer["bytes"] > 8000
    assert json.loads(run("library", "cache", library.path, "--clear", "--json").stdout)["freed"] == answer["bytes"]
    assert json.loads(run("library", "cache", library.path, "--json").stdout)["bytes"] == 0
