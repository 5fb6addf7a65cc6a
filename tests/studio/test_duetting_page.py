"""A duet in a browser, on real dances: a leader is chosen, and everything that answers is looked at."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from programs import Program, open_studio, running, wait_for_state

import kinetograph as kg
from kinetograph.formats import ReadOptions
from kinetograph.kinematics import joint_positions
from kinetograph.methods.performance import partner_control
from kinetograph.motion import resample, sample
from kinetograph.pipeline import label_partners, open_library, perform_with, read_take, segment_library
from kinetograph.take import Take

if TYPE_CHECKING:
    from playwright.sync_api import Page

NAMES = ("Easy_01", "Medium_01", "Medium_02")
LEADER = "Medium_01"


@pytest.fixture(scope="module")
def folder(data_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with dances of 14 s, and two files to drop."""
    recordings = data_folder / "salsa"
    if not recordings.is_dir():
        pytest.skip("no dances: the folder of recordings has no salsa/")
    folder = tmp_path_factory.mktemp("dances")
    library = kg.Library.create(folder / "dances")
    options = ReadOptions("inch", "z")
    for name in NAMES:
        pair = {t: read_take(recordings / f"{name}_{t}.bvh", options)[0].motion() for t in ("leader", "follower")}
        tracks = {track: kg.motion.cut(resample(motion, 30.0), 0, 421) for track, motion in pair.items()}
        library.add(Take(name, tracks))
    segment_library(library, "beats")
    label_partners(library)
    lines = (recordings / "move_02_02_leader.bvh").read_text().splitlines(keepends=True)
    at = next(i for i, line in enumerate(lines) if line.startswith("Frames:"))
    head = [*lines[:at], "Frames: 601\n", lines[at + 1]]
    (folder / "dropped.bvh").write_text("".join([*head, *lines[at + 2 : at + 603]]))
    return folder


def _shot(page: Page, folder: Path, name: str) -> None:
    page.screenshot(path=folder / f"{name}.png")


def _options(page: Page, label: str) -> list[str]:
    return page.get_by_role("combobox", name=label, exact=True).locator("option").all_inner_texts()


def _duet(page: Page, program: Program) -> None:
    open_studio(page, program)
    page.get_by_role("button", name="Duet", exact=True).click()
    page.wait_for_function("document.querySelectorAll('.duet option[value^=\"take:\"]').length > 0")


def test_a_duet_from_its_leader_to_its_rehearsal(page: Page, built_page: Path, folder: Path, tmp_path: Path) -> None:
    with running(tmp_path, str(folder / "dances")) as program:
        _duet(page, program)
        assert [text.split()[0] for text in _options(page, "Leader")[1:]] == list(NAMES)
        page.get_by_role("combobox", name="Leader", exact=True).select_option(f"take:{LEADER}")
        wait_for_state(page, "ready", 180)
        page.wait_for_function("document.querySelectorAll('.moves-list li').length > 0", timeout=120_000)
        _shot(page, tmp_path, "made")
        _positions_are_pythons(page, folder)
        _lanes_and_figures(page)
        _moves_jump(page)
        _truth_and_lines(page, tmp_path)
        _pieces(page, tmp_path)
        _rehearsed(page, tmp_path)
        _dropped(page, folder, tmp_path)


def _positions_are_pythons(page: Page, folder: Path) -> None:
    library = open_library(folder / "dances")
    take = library.take(LEADER)
    model = partner_control().fit(library, exclude=(LEADER,), track="follower")
    wanted = {
        "motion": perform_with(model, take.motion("leader")).motion,
        "leader": take.motion("leader"),
        "truth": take.motion("follower"),
    }
    for second in np.linspace(0.0, 14.0, 10):
        shown = page.evaluate(f"window.kinetograph.pose({second})")
        for body, motion in wanted.items():
            there = joint_positions(sample(motion, [second], motion.fps))[0]
            names = [f"{body}/{name}" for name in motion.skeleton.names]
            np.testing.assert_allclose([shown[name] for name in names], there, atol=1e-3)


def _lanes_and_figures(page: Page) -> None:
    lanes = page.locator(".lane-name").all_inner_texts()
    assert {"moves", "pieces", "left hand", "right hand", "left foot", "right foot", "error, cm"} <= set(lanes)
    figures = page.locator("dl.figures dt").all_inner_texts()
    assert {"from the recording", "facing right", "handholds", "hands met"} <= set(figures)


def _moves_jump(page: Page) -> None:
    rows = page.locator(".moves-list li")
    last = rows.nth(rows.count() - 1)
    last.get_by_role("button").click()
    start = float(last.get_attribute("data-start") or "nan")
    assert page.evaluate("window.kinetograph.studio.transport.time") == pytest.approx(start)
    assert last.get_by_role("button").get_attribute("aria-current") == "true"
    assert rows.count() > 2
    page.locator(".lane.moves .span").nth(1).click()
    assert 0 < page.evaluate("window.kinetograph.studio.transport.time") < start


def _truth_and_lines(page: Page, tmp_path: Path) -> None:
    seen = "window.kinetograph.studio.clip.figures[2].object.visible"
    assert page.evaluate(seen)
    page.get_by_label("Recorded follower, as a ghost").uncheck()
    assert not page.evaluate(seen)
    page.get_by_label("Recorded follower, as a ghost").check()
    page.get_by_label("Lines to where it was recorded").check()
    _shot(page, tmp_path, "lines")
    assert "cm from the recording" in page.locator(".duet").inner_text()


def _pieces(page: Page, tmp_path: Path) -> None:
    page.locator(".lane.pieces .span").nth(3).click()
    page.locator(".candidate-table").wait_for(timeout=60_000)
    _shot(page, tmp_path, "pieces")
    taken = page.locator(".candidate-table tbody tr").first.locator("td").first.inner_text().split(",")[0]
    page.get_by_role("button", name="Forbid").click()
    page.wait_for_function("document.body.dataset.state === 'solving'")
    wait_for_state(page, "ready", 180)
    assert f"not {taken}" in page.locator(".duet [aria-label='Pinned and forbidden pieces']").inner_text()
    page.get_by_role("button", name="Undo").click()
    wait_for_state(page, "solving")
    wait_for_state(page, "ready", 180)


def _rehearsed(page: Page, tmp_path: Path) -> None:
    page.get_by_role("button", name="Rehearse live").click()
    page.wait_for_function("document.querySelector('.duet').innerText.includes('behind the leader')", timeout=180_000)
    page.wait_for_function("window.kinetograph.studio.transport.time > 2.5", timeout=180_000)
    _shot(page, tmp_path, "live")
    assert "0.60 s behind the leader" in page.locator(".duet").inner_text()
    page.get_by_role("button", name="Stop rehearsing").click()
    page.get_by_role("button", name="Rehearse live").wait_for()
    assert page.evaluate("window.kinetograph.studio.clip.object.parent !== null")


def _dropped(page: Page, folder: Path, tmp_path: Path) -> None:
    page.get_by_label("A motion file to lead").set_input_files(folder / "dropped.bvh")
    page.wait_for_function("document.querySelector('.duet .notes li') !== null", timeout=60_000)
    wait_for_state(page, "ready", 180)
    _shot(page, tmp_path, "guessed")
    page.get_by_label("Units").select_option("inch")
    wait_for_state(page, "ready", 180)
    page.get_by_label("Upward axis").select_option("z")
    wait_for_state(page, "ready", 180)
    shown = page.evaluate("window.kinetograph.pose(1.0)")
    heads = [place for name, place in shown.items() if name.startswith("leader/") and "head" in name.lower()]
    assert 1.3 < max(place[1] for place in heads) < 2.1
    assert page.evaluate("window.kinetograph.studio.clip.characters") == ["motion", "leader"]
    _shot(page, tmp_path, "dropped")


def test_a_search_is_stopped_within_a_second(page: Page, built_page: Path, folder: Path, tmp_path: Path) -> None:
    with running(tmp_path, str(folder / "dances")) as program:
        _duet(page, program)
        page.get_by_role("combobox", name="Leader", exact=True).select_option(f"take:{LEADER}")
        stop = page.locator(".duet").get_by_role("button", name="Stop", exact=True)
        stop.wait_for()
        began = time.monotonic()
        stop.click()
        wait_for_state(page, "idle", 1.0)
        assert time.monotonic() - began < 1.0
        page.locator(".duet").get_by_role("button", name="Answer the leader").click()
        wait_for_state(page, "ready", 180)


def test_without_partners_the_page_says_what_to_do(page: Page, built_page: Path, folder: Path, tmp_path: Path) -> None:
    alone = kg.Library.create(tmp_path / "alone")
    alone.add(Take("someone", {"body": open_library(folder / "dances").take(LEADER).motion("leader")}))
    with running(tmp_path, str(tmp_path / "alone")) as program:
        open_studio(page, program)
        page.get_by_role("button", name="Duet", exact=True).click()
        advice = page.locator(".duet [role=note]")
        advice.wait_for()
        assert "library add DANCES --take NAME leader=FILE follower=FILE" in advice.inner_text()
        _shot(page, tmp_path, "alone")
