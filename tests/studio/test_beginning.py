"""What is done once the page can be opened."""

from __future__ import annotations

import asyncio
import time
from pathlib import Path

import pytest

from kinetograph.errors import FetchError, RequestError
from kinetograph.progress import Progress
from kinetograph.studio import Desk, Project, begin, sample, with_libraries
from kinetograph.studio.desk import beginning
from kinetograph.studio.messages import Failed, Message, Said, State, Welcome, Working


class Page:
    """A page that keeps what it is sent."""

    def __init__(self) -> None:
        self.sent: list[Message | bytes] = []

    def post(self, frame: Message | bytes) -> None:
        """Keep it."""
        self.sent.append(frame)


def test_libraries_that_are_named_come_first_and_lie_within_the_project_s_folder(tmp_path: Path) -> None:
    project = Project(libraries={"walks": "/elsewhere/walks", "old": "kept"})
    base = tmp_path / "studio"
    found = with_libraries(project, {"walks": base / "walks", "dances": tmp_path / "dances"}, base)
    assert list(found.libraries.items()) == [
        ("walks", "walks"),
        ("dances", str(tmp_path / "dances")),
        ("old", "kept"),
    ]


def test_what_takes_long_is_said_and_what_fails_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def slow(project: Project, room: object) -> None:
        time.sleep(1.3)

    def failing(project: Project, room: object) -> None:
        raise RequestError("nobody walks\nin this library")

    async def run() -> list[Message | bytes]:
        desk, page = Desk(tmp_path / "project.json", Project(libraries={"walks": "none"})), Page()
        desk.join(page)
        page.sent.clear()
        await begin(desk)
        await desk.solver.rest()
        return page.sent

    monkeypatch.setattr(beginning.making, "PREPARE", (slow, failing))
    sent = [each for each in asyncio.run(run()) if isinstance(each, Working | Said)]
    working = [each for each in sent if isinstance(each, Working) and each.label == beginning.READYING]
    assert working[0].done < working[0].total
    assert working[-1].done == working[-1].total
    assert sent[-1] == Said("nobody walks in this library")


def test_the_sample_is_fetched_with_progress_and_what_was_drawn_meanwhile_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fetched(progress: Progress | None) -> dict[str, Path]:
        assert progress is not None
        for done in (10, 50, 100):
            progress(done, 100)
        return {"walks": tmp_path / "walks"}

    async def run() -> list[Message | bytes]:
        desk, page = Desk(tmp_path / "project.json", Project()), Page()
        desk.join(page)
        desk.history.edit(Project(character="human"), "wear human")
        await begin(desk)
        await desk.solver.rest()
        return page.sent

    monkeypatch.setattr(sample, "sample_libraries", fetched)
    monkeypatch.setattr(beginning.making, "PREPARE", ())
    sent = asyncio.run(run())
    shares = [each.done for each in sent if isinstance(each, Working) and each.label == beginning.FETCHING]
    assert shares == [10, 50, 100, 1]
    last = [each for each in sent if isinstance(each, State)][-1]
    assert (last.project.libraries, last.project.character, last.undo) == ({"walks": "walks"}, "human", "wear human")
    assert any(isinstance(each, Welcome) for each in sent[2:])


def test_a_sample_that_cannot_be_fetched_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(progress: Progress | None) -> dict[str, Path]:
        raise FetchError("no network\nhere")

    async def run() -> list[Message | bytes]:
        desk, page = Desk(tmp_path / "project.json", Project()), Page()
        desk.join(page)
        await begin(desk)
        return page.sent

    monkeypatch.setattr(sample, "sample_libraries", refused)
    monkeypatch.setattr(beginning.making, "PREPARE", ())
    assert Failed("the sample cannot be fetched: no network here") in asyncio.run(run())
