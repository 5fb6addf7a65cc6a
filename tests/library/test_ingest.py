"""Libraries filled from files as people have them: folders in folders, names twice, damaged files, interruptions."""

from __future__ import annotations

import os
import resource
import shutil
import signal
import sqlite3
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.errors import LibraryError, RequestError
from kinetograph.formats import ReadOptions, save
from kinetograph.library import Annotated, Facts, Library, annotate_takes, describe_takes, facts_of, full_names
from kinetograph.motion import Motion
from kinetograph.pipeline import (
    Ingested,
    IngestSettings,
    ReadRecordings,
    disagreements,
    find_recordings,
    ingest,
    ingesting,
    open_or_create,
)
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation, Take
from kinetograph.work import Workers

STICK = Skeleton(("hips", "chest", "head"), np.array([-1, 0, 1]), np.array([[0, 1.0, 0], [0, 0.3, 0], [0, 0.2, 0]]))
CUT = Annotation("motion", "cut", "tapped", 0.1, 0.1)


def motion_of(seed: int, frames: int = 10) -> Motion:
    rotations = rot.normalize(np.random.default_rng(seed).normal(size=(frames, 3, 4)))
    return Motion(STICK, np.zeros((frames, 3)), rotations, 30.0)


def write(folder: Path, *names: str, seed: int = 0, frames: int = 10) -> Path:
    """A folder with a file of another motion for every name."""
    for number, name in enumerate(names):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        save(motion_of(seed + number, frames), folder / name)
    return folder


def fill(library: Library, *paths: Path, **settings: Any) -> Ingested:
    return ingest(library, find_recordings(paths).recordings, settings=IngestSettings(**settings))


def content(library: Library) -> list[Any]:
    """All that a library says of its takes, digests of the frames included."""
    with sqlite3.connect(library.path / "catalogue.sqlite") as db:
        rows = db.execute("SELECT id, name, digest, notes FROM takes ORDER BY id").fetchall()
    db.close()
    return rows


@pytest.fixture
def library(tmp_path: Path) -> Library:
    return Library.create(tmp_path / "library")


# ---- which files, and what their takes are called ----


def test_folders_are_entered_and_takes_are_named_by_their_path(library: Library, tmp_path: Path) -> None:
    files = write(tmp_path / "files", "b/18_01.npz", "a/18_01.npz", "a/deep/er/x.npz", "top.npz")
    (files / "a" / ".hidden.npz").write_bytes(b"")
    (files / ".git").mkdir()
    shutil.copy(files / "top.npz", files / ".git" / "y.npz")
    (files / "a" / "table.csv").write_text("t,x\n0,1\n")
    done = fill(library, files)
    assert library.names() == ("a/18_01", "a/deep/er/x", "b/18_01", "top")
    assert done.added == list(library.names())
    facts = facts_of(library)["a/deep/er/x"]
    assert (facts.subject, facts.source, facts.folder) == ("a/deep/er", "a/deep/er/x.npz", str(files.resolve()))
    assert facts_of(library)["top"].subject == "files"


def test_a_file_by_itself_keeps_its_stem(library: Library, tmp_path: Path) -> None:
    files = write(tmp_path / "files", "a/walk.npz")
    fill(library, files / "a" / "walk.npz")
    assert library.names() == ("walk",)
    assert facts_of(library)["walk"].subject == ""


def test_names_that_are_taken_are_told_apart_and_named(library: Library, tmp_path: Path) -> None:
    one = write(tmp_path / "one", "walk.npz", "walk.glb", "Walk.npz")
    two = write(tmp_path / "two", "walk.npz", seed=7)
    done = fill(library, one, two)
    assert library.names() == ("Walk", "walk", "walk.npz", "two/walk")
    assert done.renamed == {str(one / "walk.npz"): "walk.npz", str(two / "walk.npz"): "two/walk"}
    before = content(library)
    again = fill(library, two, one)  # in another order
    assert (again.unchanged, again.added, content(library)) == (4, [], before)


def test_links_in_a_circle_are_skipped_with_a_note(tmp_path: Path) -> None:
    files = write(tmp_path / "files", "a/x.npz", "b/y.npz")
    (files / "a" / "up").symlink_to(files)
    (files / "0").symlink_to(files / "b")  # sorts before what it is a link to
    (files / "gone").symlink_to(tmp_path / "nowhere")
    elsewhere = write(tmp_path / "elsewhere", "z.npz")
    (files / "linked").symlink_to(elsewhere)
    found = find_recordings([files])
    assert [one.source for one in found.recordings] == ["a/x.npz", "b/y.npz", "linked/z.npz"]
    assert sorted(Path(path).name for path in found.skipped) == ["0", "up"]
    assert all("which has been entered" in why for why in found.skipped.values())


def test_a_folder_without_recordings_and_a_library_within(tmp_path: Path) -> None:
    (tmp_path / "empty" / "inner").mkdir(parents=True)
    with pytest.raises(RequestError, match=r"no motion file found in .*empty; expected one of \.amc, "):
        find_recordings([tmp_path / "empty"])
    Library.create(tmp_path / "empty" / "library")
    with pytest.raises(RequestError, match="a library, not a folder of recordings"):
        find_recordings([tmp_path / "empty"])


# ---- short names ----


def test_short_names_work_where_they_are_unique(library: Library) -> None:
    for name in ("a/18_01", "b/18_01", "b/18_02", "18_03", "c/18_03", "b/clip:Walk"):
        library.add(Take(name, {"motion": motion_of(len(name))}))
    assert library.take("18_02").name == "b/18_02"
    assert library.take("clip:Walk").name == "b/clip:Walk"
    assert library.take("18_03").name == "18_03"
    assert full_names(library, ["18_02", "a/18_01"]) == ("b/18_02", "a/18_01")
    with pytest.raises(RequestError, match=r"2 takes are called '18_01': a/18_01, b/18_01; give more of the name"):
        library.take("18_01")
    for name in ("02", "8_02", "", "/18_02", "B/18_02", "%2"):
        with pytest.raises(RequestError, match="no take"):
            library.take(name)
    library.annotate("18_02", [CUT])
    assert library.take("b/18_02").annotations == (CUT,)
    library.remove("18_02")
    assert "b/18_02" not in library.names()


# ---- what is new, changed, gone, damaged ----


def test_only_what_is_new_or_changed_is_read(library: Library, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = write(tmp_path / "files", "a/x.npz", "a/y.npz")
    fill(library, files)
    read: list[str] = []
    takes = ReadRecordings.takes
    monkeypatch.setattr(ReadRecordings, "takes", lambda self, path: read.append(path.name) or takes(self, path))
    os.utime(files / "a" / "x.npz", (1, 1))
    save(motion_of(9), files / "a" / "y.npz")
    write(files, "b/z.npz")
    done = fill(library, files)
    assert read == ["y.npz", "z.npz"]
    assert (done.unchanged, done.replaced, done.added) == (1, ["a/y"], ["b/z"])
    np.testing.assert_allclose(library.take("y").motion().rotations, motion_of(9).rotations, atol=1e-6)
    assert library.names() == ("a/x", "a/y", "b/z")


def test_other_options_read_a_file_anew(library: Library, tmp_path: Path) -> None:
    recordings = find_recordings([write(tmp_path / "files", "x.npz")]).recordings
    ingest(library, recordings)
    assert ingest(library, recordings, ReadRecordings(ReadOptions(up="z"))).replaced == ["x"]
    assert ingest(library, recordings, ReadRecordings(ReadOptions(up="z"))).unchanged == 1


def test_annotations_stay_with_the_same_motion_and_go_with_another(library: Library, tmp_path: Path) -> None:
    files = write(tmp_path / "files", "x.npz", "y.npz")
    fill(library, files)
    known = {name: Facts(frozenset({"calm"}), "he walks", "Ann", f.source, f.content, f.folder, "footplants")
             for name, f in facts_of(library).items()}  # fmt: skip
    describe_takes(library, known)
    for name in ("x", "y"):
        library.annotate(name, [CUT])
    np.savez(files / "x.npz", **np.load(files / "x.npz"), another=np.zeros(3))  # other bytes, the same motion
    save(motion_of(9), files / "y.npz")
    done = fill(library, files)
    assert (sorted(done.replaced), done.dropped) == (["x", "y"], {"y": 1})
    assert (library.take("x").annotations, library.take("y").annotations) == ((CUT,), ())
    facts = facts_of(library)
    assert (facts["x"].segmented, facts["y"].segmented) == ("footplants", "")
    assert all((f.tags, f.text, f.subject) == ({"calm"}, "he walks", "Ann") for f in facts.values())
    assert facts["x"].content != known["x"].content


def test_files_that_are_gone_are_named_and_their_takes_kept(library: Library, tmp_path: Path) -> None:
    files = write(tmp_path / "files", "x.npz", "y.npz")
    fill(library, files)
    (files / "x.npz").unlink()
    assert fill(library, files).gone == ["x"]
    assert fill(library, files / "y.npz").gone == []  # nobody asked for the rest of the folder
    assert library.names() == ("x", "y")


def test_takes_from_elsewhere_are_not_harmed(library: Library, tmp_path: Path) -> None:
    library.add(Take("x", {"motion": motion_of(50)}))  # from no file
    one, two = write(tmp_path / "one", "x.npz", "y.npz"), write(tmp_path / "two", "y.npz", seed=7)
    done = fill(library, one)
    assert done.added == ["y"]
    assert list(done.skipped.values()) == ["the library has a take of this name, and does not know from which file"]
    before = content(library)
    assert fill(library, two).added == ["two/y"]
    assert content(library)[:2] == before
    shutil.copytree(one, tmp_path / "three")
    assert fill(library, tmp_path / "three" / "y.npz").unchanged == 1  # the same file at the same place


def test_a_folder_that_has_moved_is_known_again(library: Library, tmp_path: Path) -> None:
    fill(library, write(tmp_path / "old", "x.npz", "y.npz"))
    (tmp_path / "old").rename(tmp_path / "new")
    save(motion_of(9), tmp_path / "new" / "y.npz")
    done = fill(library, tmp_path / "new")
    assert (done.unchanged, done.replaced, library.names()) == (1, ["y"], ("x", "y"))


def test_what_cannot_be_read_is_named_and_the_rest_is_kept(
    library: Library, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = write(tmp_path / "files", "a.npz", "b.npz", "c.npz", "d.npz")
    (files / "b.npz").write_bytes(b"damaged")
    (files / "e.bvh").symlink_to(files / "nothing.bvh")
    takes = ReadRecordings.takes

    def fail(self: ReadRecordings, path: Path) -> Any:
        if path.name == "c.npz":
            raise KeyError("a fault of the reader")
        return takes(self, path)

    monkeypatch.setattr(ReadRecordings, "takes", fail)
    done = fill(library, files)
    assert library.names() == ("a", "d")
    assert {Path(path).name: why.split(":")[0] for path, why in done.skipped.items()} == {
        "b.npz": "expected a NumPy archive", "c.npz": "the reader failed", "e.bvh": "cannot open it",
    }  # fmt: skip
    with pytest.raises(RequestError, match=r"b\.npz: expected a NumPy archive.*; nothing was added"):
        fill(Library.create(tmp_path / "strict"), files, strict=True)
    assert Library.open(tmp_path / "strict").names() == ()
    assert Library.open(tmp_path / "strict").check().sound


def test_strict_adds_all(library: Library, tmp_path: Path) -> None:
    files = write(tmp_path / "files", "a.npz", "b.npz")
    assert fill(library, files, strict=True).added == ["a", "b"]
    other = Library.create(tmp_path / "other")
    fill(other, files)
    assert content(other) == content(library)


def test_axes_that_were_guessed_differently_are_pointed_out() -> None:
    text = "units not given: guessed {}, as it is tall; up axis not given: guessed {}, from the floor"
    notes = {text.format("metre", "z"): ["a", "b"], text.format("metre", "x"): ["c"]}
    assert disagreements(notes) == ("up axis: guessed z in 2 files, x in 1 (c); where all are alike, say so with --up",)
    assert disagreements({text.format("metre", "z"): ["a", "b"]}) == ()


def test_a_long_file_that_has_changed_is_replaced_in_blocks(
    library: Library, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ingesting, "LONG", 100)
    files = write(tmp_path / "files", "a.bvh", "b.bvh")
    assert fill(library, files).added == ["a", "b"]
    library.annotate("a", [CUT])
    save(motion_of(9, 20), files / "a.bvh")
    done = fill(library, files)
    assert (done.replaced, done.unchanged, done.dropped) == (["a"], 1, {"a": 1})
    assert len(library.take("a").motion()) == 20
    (files / "a.bvh").write_text((files / "a.bvh").read_text().replace("Frames: 20", "Frames: 90"))
    assert "a.bvh" in next(iter(fill(library, files).skipped))
    assert len(library.take("a").motion()) == 20


# ---- groups, processes, kills, full disks ----


def test_groups_and_processes_make_the_same_library(tmp_path: Path) -> None:
    files = write(tmp_path / "files", *(f"{n % 3}/take{n}.npz" for n in range(9)))
    made = [Library.create(tmp_path / name) for name in ("one", "groups", "processes")]
    fill(made[0], files)
    fill(made[1], files, seconds=0.0)
    fill(made[2], files, workers=Workers(2), bytes=1)
    assert content(made[0]) == content(made[1]) == content(made[2])
    assert [library.check().sound for library in made] == [True] * 3


def test_a_group_waits_for_the_disk_once(library: Library, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = write(tmp_path / "files", *(f"take{n}.npz" for n in range(12)))
    flushed: list[int] = []
    monkeypatch.setattr("kinetograph.library.frame_files.os.fsync", flushed.append)
    fill(library, files, seconds=60.0)
    assert len(flushed) == 1


_LOOK = os.WEXITED | os.WNOHANG | os.WNOWAIT


def killed(folder: Path, files: Path, delay: float) -> bool:
    """Fill a library in a process that is killed some seconds after it first wrote; whether it was still at work."""
    frames = folder / "frames-1.bin"
    before = frames.stat().st_size if frames.exists() else 0
    child = os.fork()
    if child == 0:
        try:
            fill(open_or_create(folder), files, seconds=0.0, bytes=2000)
        finally:
            os._exit(0)
    while not (frames.exists() and frames.stat().st_size > before) and os.waitid(os.P_PID, child, _LOOK) is None:
        time.sleep(0.001)
    time.sleep(delay)
    os.kill(child, signal.SIGKILL)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL


@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_killed_again_and_again_it_ends_with_the_same_library(tmp_path: Path) -> None:
    files = write(tmp_path / "files", *(f"{n % 7}/take{n}.npz" for n in range(60)))
    whole, folder = Library.create(tmp_path / "whole"), tmp_path / "library"
    fill(whole, files)
    rng, kills, lengths, longest = np.random.default_rng(5), 0, {0}, 0.02
    for _ in range(20):
        kills += killed(folder, files, float(rng.uniform(0.0, longest)))
        library = open_or_create(folder)
        assert not library.check().damaged
        if len(library.names()) in lengths:
            longest *= 1.5  # a commit takes longer on a machine that is busy
        lengths.add(len(library.names()))
    assert kills > 5
    assert len(lengths) > 3, "the writers were idle when killed: the test shows nothing"
    fill(library, files)
    assert content(library) == content(whole)
    library.check(repair=True)
    assert library.check().sound


def test_a_disk_that_fills_keeps_what_was_committed(library: Library, tmp_path: Path) -> None:
    files = write(tmp_path / "files", *(f"take{n}.npz" for n in range(40)), frames=200)
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, limit[1]))
        with pytest.raises(LibraryError) as caught:
            fill(library, files, seconds=0.0)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
        signal.signal(signal.SIGXFSZ, handler)
    assert "\n" not in str(caught.value)
    assert "the library is unchanged" in str(caught.value)
    assert 0 < len(library.names()) < 40
    assert library.check().sound
    kept = library.names()
    assert (*kept, *fill(library, files).added) == library.names()
    assert len(library.names()) == 40


# ---- many annotations at once ----


def test_annotations_of_takes_are_put_all_or_none(library: Library) -> None:
    for name in ("x", "y"):
        library.add(Take(name, {"motion": motion_of(1)}, (CUT,)))
    new = Annotation("motion", "cut", "footplants", 0.2, 0.2)
    places = frozenset({("motion", "cut")})
    annotate_takes(library, [Annotated(name, (new,), places, "footplants") for name in ("x", "y")])
    assert [library.take(name).annotations for name in ("x", "y")] == [(new,), (new,)]
    assert facts_of(library)["y"].segmented == "footplants"
    other = Annotation("motion", "move", "step", 0.0, 0.1)
    with pytest.raises(RequestError, match="found an annotation of kind 'move' on 'motion'"):
        annotate_takes(library, [Annotated("x", (), places), Annotated("y", (other,), places)])
    with pytest.raises(RequestError, match="no track 'other' in take 'x'"):
        annotate_takes(library, [Annotated("x", (), frozenset({("other", "cut")}))])
    assert library.take("x").annotations == (new,)
