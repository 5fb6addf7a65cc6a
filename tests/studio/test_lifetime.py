"""Two pages, a page that is loaded again, and a server that is killed: nothing is lost."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from programs import Program, open_studio, running, wait_for_state

from kinetograph.library import Library
from kinetograph.studio import read_project

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

CIRCLE = [[t / 10, 2 * math.sin(t / 20), 2 - 2 * math.cos(t / 20)] for t in range(80)]
LINE = [[t / 10, 0, t / 10] for t in range(60)]


@pytest.fixture(scope="module")
def walks(clips_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    from kinetograph.formats import ReadOptions
    from kinetograph.pipeline import read_take

    library = Library.create(tmp_path_factory.mktemp("walks") / "walks")
    for name in ("humanoid3d_walk", "turn_left0", "turn_right0"):
        library.add(read_take(clips_folder / f"{name}.txt", ReadOptions())[0])
    return library.path


@pytest.fixture
def program(built_page: Path, walks: Path, tmp_path: Path) -> Iterator[Program]:
    with running(tmp_path, str(walks)) as started:
        yield started


def _walk(page: Page, path: list[list[float]], label: str = "draw") -> str:
    """Walk a path, as the page does after it was drawn; the state that the page has then."""
    state: str = page.evaluate(
        "([path, label]) => { const {connection, store} = kinetograph.studio;"
        " connection.edit('walk', {...store.project.walk, path}, {label}); return document.body.dataset.state; }",
        [path, label],
    )
    return state


def _pose(page: Page, seconds: float = 2.0) -> dict[str, Any]:
    pose: dict[str, Any] = page.evaluate("seconds => kinetograph.pose(seconds)", seconds)
    return pose


def test_two_pages_show_the_same_and_either_can_undo(browser: Browser, page: Page, program: Program) -> None:
    other = browser.new_context().new_page()
    open_studio(page, program)
    open_studio(other, program)
    _walk(page, CIRCLE)
    wait_for_state(page, "ready")
    wait_for_state(other, "ready")
    other.wait_for_function("kinetograph.studio.clip !== null")
    assert _pose(page) == _pose(other)
    circle = _pose(page)
    _walk(other, LINE, "draw again")
    wait_for_state(other, "ready")
    page.wait_for_function("kinetograph.studio.store.project.walk.path.length === 60")
    wait_for_state(page, "ready")
    assert _pose(page) == _pose(other) != circle
    page.get_by_role("button", name="Undo").click()
    other.wait_for_function("kinetograph.studio.store.project.walk.path.length === 80")
    for each in (page, other):
        each.wait_for_function(
            "root => Math.abs(kinetograph.pose(2)[Object.keys(kinetograph.pose(2))[0]][0] - root) < 1e-6",
            arg=next(iter(circle.values()))[0],
        )
        assert _pose(each) == circle
    other.context.close()


def test_a_page_loaded_again_while_something_is_made_shows_it(page: Page, program: Program) -> None:
    open_studio(page, program)
    assert _walk(page, CIRCLE) == "solving"
    page.reload()
    wait_for_state(page, "ready")
    assert page.evaluate("kinetograph.studio.store.project.walk.path.length") == 80
    assert len(_pose(page)) == 15


def test_a_killed_server_loses_nothing(page: Page, program: Program, walks: Path, tmp_path: Path) -> None:
    open_studio(page, program)
    _walk(page, LINE)
    wait_for_state(page, "ready")
    before = _pose(page)
    _walk(page, CIRCLE, "draw again")
    page.wait_for_function("kinetograph.studio.store.undo === 'draw again'")
    program.kill()
    page.wait_for_function("document.querySelector('.status').textContent.includes('trying again')")
    assert len(read_project(tmp_path / "studio" / "project.json").walk.path) == 80
    with running(tmp_path, "--port", str(program.port)) as again:
        page.wait_for_function(
            "document.querySelector('.status').textContent.includes('open the address')", timeout=20_000
        )
        open_studio(page, again)
        wait_for_state(page, "ready")
        assert page.evaluate("kinetograph.studio.store.project.walk.path.length") == 80
        assert _pose(page) != before
        assert len(_pose(page)) == 15


def test_what_is_edited_without_a_server_is_sent_when_it_is_back(page: Page, program: Program) -> None:
    open_studio(page, program)
    page.evaluate("kinetograph.studio.connection.drop()")
    _walk(page, LINE)
    page.wait_for_function("kinetograph.studio.store.project.walk.path.length === 60")
    wait_for_state(page, "ready")
    assert (
        json.loads((Path(program.log.name).parent / "studio" / "project.json").read_text())["walk"]["path"][-1][2] > 5
    )
