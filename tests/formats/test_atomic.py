"""Outputs appear whole or not at all, and leave nothing behind."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from kinetograph.errors import ExistsError
from kinetograph.formats import atomic_path, together


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def write(path: Path, text: str) -> None:
    with atomic_path(path) as draft:
        draft.write_text(text)


def write_both(folder: Path, error: BaseException | None = None) -> None:
    with together():
        write(folder / "a.txt", "new")
        write(folder / "b.txt", "b")
        if error is not None:
            raise error


def test_outputs_written_together_appear_together(tmp_path: Path) -> None:
    with together():
        write(tmp_path / "a.txt", "a")
        write(tmp_path / "b.txt", "b")
        assert not [name for name in names(tmp_path) if not name.startswith(".")]
    assert names(tmp_path) == ["a.txt", "b.txt"]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit])
def test_after_an_error_none_of_them_does_and_old_ones_stay(tmp_path: Path, error: type[BaseException]) -> None:
    write(tmp_path / "a.txt", "old")
    with pytest.raises(error):
        write_both(tmp_path, error())
    assert names(tmp_path) == ["a.txt"]
    assert (tmp_path / "a.txt").read_text() == "old"


def test_blocks_within_blocks_end_with_the_outer_one(tmp_path: Path) -> None:
    with together():
        write_both(tmp_path)
        assert "a.txt" not in names(tmp_path)
        with pytest.raises(ValueError, match="late"):
            write_both(tmp_path, ValueError("late"))
    assert names(tmp_path) == ["a.txt", "b.txt"]


def test_one_output_within_another(tmp_path: Path) -> None:
    with together(), atomic_path(tmp_path / "a.txt") as draft:
        write(draft, "inner")
    assert names(tmp_path) == ["a.txt"]
    assert (tmp_path / "a.txt").read_text() == "inner"


def test_an_interrupt_during_the_moves_waits_for_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    replace = os.replace

    def interrupted(source: Path, target: Path) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        replace(source, target)

    monkeypatch.setattr(os, "replace", interrupted)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # processes in the background ignore it
    try:
        with pytest.raises(KeyboardInterrupt):
            write_both(tmp_path)
    finally:
        signal.signal(signal.SIGINT, before)
    assert names(tmp_path) == ["a.txt", "b.txt"]


def test_a_draft_of_a_killed_process_is_removed_by_the_next(tmp_path: Path) -> None:
    child = os.fork()
    if child == 0:
        with atomic_path(tmp_path / "walk.bvh") as draft:
            draft.write_text("half")
            os.kill(os.getpid(), signal.SIGKILL)
    os.waitpid(child, 0)
    (tmp_path / ".walk.bvh").write_text("a person's")
    (tmp_path / ".walk.0123456789ab.glb").write_text("another output's")
    assert len(names(tmp_path)) == 3
    write(tmp_path / "walk.bvh", "whole")
    assert names(tmp_path) == [".walk.0123456789ab.glb", ".walk.bvh", "walk.bvh"]


def test_a_draft_that_is_being_written_is_left_alone(tmp_path: Path) -> None:
    with atomic_path(tmp_path / "a.txt") as draft:
        draft.write_text("first")
        write(tmp_path / "a.txt", "second")
    assert names(tmp_path) == ["a.txt"]
    assert (tmp_path / "a.txt").read_text() == "first"


def test_what_exists_is_kept(tmp_path: Path) -> None:
    write(tmp_path / "a.txt", "old")
    with pytest.raises(ExistsError, match="exists already; overwrite it with --force"):
        atomic_path(tmp_path / "a.txt", force=False).__enter__()
    assert (tmp_path / "a.txt").read_text() == "old"
