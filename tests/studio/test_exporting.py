"""Exports: the files are those of the command line, whole or not there, and read back as the same motion."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.errors import RequestError
from kinetograph.formats import capsule_character
from kinetograph.kinematics import joint_positions
from kinetograph.post import retarget
from kinetograph.studio import exporting
from kinetograph.studio.exporting import Wanted, export
from kinetograph.studio.made import Made
from kinetograph.studio.messages import Export, Exported, Failed, Message, Working
from kinetograph.studio.project import Project
from kinetograph.studio.room import Room
from made_walks import quiet, stood
from walkers import stick_figure, walk


@pytest.mark.parametrize("suffix", [".bvh", ".glb", ".fbx", ".usda", ".npz"])
@pytest.mark.parametrize("worn", [False, True])
def test_what_is_read_back_is_the_motion_that_is_shown(tmp_path: Path, suffix: str, worn: bool) -> None:
    made = stood()
    character = capsule_character(stick_figure(1.2)) if worn else None
    (path,) = export(made, character, tmp_path, Wanted((suffix,), "walk"), quiet)
    shown = retarget(made.synthesis.motion, character).motion if character else made.synthesis.motion
    read = kg.load(path).motion()
    assert len(read) == len(shown)
    by_name = [read.skeleton.names.index(name) for name in shown.skeleton.names]
    np.testing.assert_allclose(joint_positions(read)[:, by_name], joint_positions(shown), atol=5e-4)


def test_nothing_is_overwritten_and_the_files_of_an_export_share_a_number(tmp_path: Path) -> None:
    (tmp_path / "walk.glb").write_text("mine")
    names = [
        [path.name for path in export(stood(), None, tmp_path, Wanted((".bvh", ".glb"), "walk"), quiet)] for _ in "ab"
    ]
    assert names == [["walk_2.bvh", "walk_2.glb"], ["walk_3.bvh", "walk_3.glb"]]
    assert (tmp_path / "walk.glb").read_text() == "mine"
    assert export(stood(), None, tmp_path, Wanted((".glb",), "walk", force=True), quiet)[0].name == "walk.glb"


@pytest.mark.parametrize("name", ["", "..", "../walk", "a/b", "a\\b", ".walk", "walk\n", "C:walk", "x" * 300])
def test_a_name_that_leads_elsewhere_is_refused(name: str) -> None:
    with pytest.raises(RequestError, match="expected the name of a file without a folder"):
        Wanted((".bvh",), name)


def test_what_cannot_be_written_is_refused_before_any_work(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(RequestError, match=r"choose a format: \.bvh"):
        Wanted((), "walk")
    with pytest.raises(RequestError, match=r"cannot write files of kind '\.exe'"):
        Wanted((".exe",), "walk")
    monkeypatch.setattr("kinetograph.drawing.video.find_ffmpeg", lambda: None)
    monkeypatch.setattr("kinetograph.drawing.find_ffmpeg", lambda: None, raising=False)
    assert exporting.films() == (".gif",)
    with pytest.raises(RequestError, match=r"an \.mp4 film needs ffmpeg"):
        Wanted((".mp4",), "walk")


def test_bodies_shown_together_are_written_together_where_they_can_be(tmp_path: Path) -> None:
    made = Made(stood().syntheses, others={"leader": walk(1.0, speed=0.5)})
    alone = export(made, None, tmp_path, Wanted((".glb", ".bvh"), "alone"), quiet)
    both = export(made, None, tmp_path, Wanted((".glb", ".bvh"), "both", together=True), quiet)
    assert [len(kg.load(path).tracks) for path in (*alone, *both)] == [1, 1, 2, 1]
    assert set(kg.load(both[0]).tracks) == {"motion", "leader"}


# ---- stopping ----


def test_a_film_that_is_stopped_is_not_there_and_what_was_whole_stays(tmp_path: Path) -> None:
    said: list[tuple[float, float]] = []

    def stop(done: float, total: float) -> None:
        said.append((done, total))
        if len(said) > 8:
            raise RequestError("stopped")

    with pytest.raises(RequestError, match="stopped"):
        export(stood(2.0), None, tmp_path, Wanted((".bvh", ".gif"), "walk"), stop)
    assert [path.name for path in tmp_path.iterdir()] == ["walk.bvh"]
    assert said == sorted(said)
    assert len({total for _, total in said}) == 1


def test_a_process_that_is_killed_leaves_no_file_by_its_name_and_its_draft_is_swept(tmp_path: Path) -> None:
    code = f"""
        import sys
        sys.path.insert(0, {str(Path(__file__).parents[1])!r})
        from pathlib import Path
        from kinetograph.studio.exporting import Wanted, export
        from made_walks import stood
        said = lambda done, total: print(done, flush=True)
        export(stood(60.0), None, Path({str(tmp_path)!r}), Wanted((".gif",), "walk"), said)
    """
    with subprocess.Popen([sys.executable, "-c", textwrap.dedent(code)], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        while int(process.stdout.readline()) < 20:
            pass
        process.send_signal(signal.SIGKILL)
    assert [path.suffix for path in tmp_path.iterdir() if not path.name.startswith(".")] == []
    for draft in tmp_path.iterdir():
        old = time.time() - 7200
        os.utime(draft, (old, old))
    export(stood(), None, tmp_path, Wanted((".bvh",), "walk"), quiet)
    assert [path.name for path in tmp_path.iterdir()] == ["walk.bvh"]


def _run(room: Room, message: Export, cancel_after: int | None = None) -> list[Message | bytes]:
    sent: list[Message | bytes] = []

    async def run() -> None:
        task = asyncio.create_task(exporting.run(room, Project(), message, asyncio.Queue(), sent.append))
        while cancel_after is not None and len(sent) < cancel_after:
            await asyncio.sleep(0.01)
        if cancel_after is not None:
            task.cancel()
        await asyncio.gather(task, return_exceptions=True)

    asyncio.run(run())
    return sent


def test_the_page_is_told_of_progress_and_of_the_files(tmp_path: Path) -> None:
    room = Room(tmp_path)
    assert _run(room, Export(1, (".bvh",), "walk"))[0] == Failed("there is nothing to export yet", 1)
    room.latest["walk"] = stood()
    sent = _run(room, Export(2, (".bvh", ".json"), "walk & run"))
    files = (("walk & run.bvh", "/exports/walk%20%26%20run.bvh"), ("walk & run.json", "/exports/walk%20%26%20run.json"))
    assert Exported(2, files) in sent
    works = [each for each in sent if isinstance(each, Working)]
    assert works[-1].done == works[-1].total
    assert all(each.done < each.total for each in works[:-1])
    assert json.loads((tmp_path / "exports" / "walk & run.json").read_text())["cost"] == 1.0


def test_the_page_can_stop_a_long_film(tmp_path: Path) -> None:
    room = Room(tmp_path)
    room.latest["walk"] = stood(60.0)
    sent = _run(room, Export(3, (".gif",), "long"), cancel_after=3)
    assert Failed("the export was stopped", 3) in sent
    assert list((tmp_path / "exports").iterdir()) == []
