"""The names that other programs find the page by, in every section, and that nothing serious bars anybody from it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from programs import Program, open_studio, running, wait_for_state

if TYPE_CHECKING:
    from playwright.sync_api import Page

NAMES = ("Draw", "Keys", "Duet", "Sensors", "Play", "Export", "Undo")
PATH = [[t / 10, 0, t / 10] for t in range(40)]


@pytest.fixture
def program(built_page: Path, clips_folder: Path, tmp_path: Path) -> Iterator[Program]:
    with running(tmp_path) as started:
        yield started


def _named(page: Page) -> dict[str, int]:
    return {name: page.get_by_role("button", name=name).count() for name in NAMES}


def test_each_name_is_that_of_one_button_in_every_section(page: Page, program: Program) -> None:
    open_studio(page, program)
    assert _named(page) == dict.fromkeys(NAMES, 1)
    for name in ("Keys", "Duet", "Sensors", "Draw"):
        page.get_by_role("button", name=name).click()
        page.wait_for_function("name => document.querySelector('[aria-pressed=true]').textContent === name", arg=name)
        assert _named(page) == dict.fromkeys(NAMES, 1), name
    page.evaluate("path => kinetograph.studio.connection.edit('walk', {path}, {label: 'draw'})", PATH)
    wait_for_state(page, "ready")
    assert _named(page) == dict.fromkeys(NAMES, 1)
    page.get_by_role("button", name="Play").click()
    assert _named(page) == dict.fromkeys(NAMES, 1)


@pytest.mark.parametrize("theme", ["dark", "light"])
def test_every_section_is_open_to_everybody(page: Page, program: Program, theme: str) -> None:
    axe = Path(__file__).parents[2] / "src/kinetograph/studio/client/node_modules/axe-core/axe.min.js"
    if not axe.exists():
        pytest.skip("axe-core is not installed: make page")
    page.emulate_media(color_scheme=theme)  # type: ignore[arg-type]
    open_studio(page, program)
    page.evaluate(axe.read_text())
    for name in ("Draw", "Keys", "Duet", "Sensors", "Library"):
        page.get_by_role("button", name=name, exact=True).click()
        page.wait_for_timeout(300)
        found = page.evaluate("async () => (await axe.run()).violations")
        serious = [each["id"] for each in found if each["impact"] in ("serious", "critical")]
        assert serious == [], name
