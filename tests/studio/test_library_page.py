"""The library browser and the export dialog in a real browser, on real recordings."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import urljoin

import numpy as np
import pytest
from rooms import served

import kinetograph as kg
from kinetograph.formats import ReadOptions
from kinetograph.kinematics import joint_positions
from kinetograph.pipeline import read_take
from kinetograph.studio.project import Project, Walk, read_project
from kinetograph.studio.serving.server import Server

if TYPE_CHECKING:
    from playwright.sync_api import Page

AXE = Path(__file__).parents[2] / "src/kinetograph/studio/client/node_modules/axe-core/axe.min.js"
PATH = ((0.0, 0.0, 0.0), (1.0, 0.5, 0.5))


@pytest.fixture(scope="module")
def clips(clips_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A library of the sample's clips."""
    library = kg.Library.create(tmp_path_factory.mktemp("library") / "moves")
    for path in sorted(clips_folder.glob("*.txt")):
        library.add(read_take(path, ReadOptions())[0])
    return library.path


@pytest.fixture
def server(clips: Path, tmp_path: Path, built_page: Path) -> Iterator[Server]:
    project = Project(libraries={"moves": str(clips)}, walk=Walk(path=PATH))
    with served(tmp_path, project) as running:
        yield running


@pytest.fixture
def studio(page: Page, server: Server) -> Page:
    page.goto(server.address)
    page.wait_for_selector("body[data-state=ready]")
    return page


def _browse(studio: Page) -> None:
    studio.get_by_role("button", name="Library").click()
    studio.wait_for_selector(".card canvas")


_SEEN = """async () => {
  const canvas = document.querySelector(".card canvas");
  const seen = new Set();
  for (let i = 0; i < 8; i++) {
    await new Promise(requestAnimationFrame);
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    if (data.some((value) => value > 0)) seen.add(data.join());
  }
  return seen.size;
}"""
"""How many different pictures the first thumbnail shows one after another; 0 before it is drawn."""


def test_takes_are_found_shown_and_keyed_with_the_keyboard(studio: Page, clips: Path) -> None:
    studio.evaluate("window.kinetograph.studio.keys = {add: (...what) => (window.added = what)}")
    _browse(studio)
    assert studio.locator(".found p").inner_text() == "20 takes"
    studio.get_by_role("searchbox", name="Search").fill("turn_left*")
    studio.wait_for_function("document.querySelector('.found p').textContent === '2 of 20 takes'")
    studio.keyboard.press("Tab")
    studio.keyboard.press("ArrowRight")
    studio.keyboard.press("Enter")
    studio.wait_for_function("document.querySelector('.status').textContent.startsWith('turn_left1')")
    motion = kg.Library.open(clips).take("turn_left1").motion()
    for _ in range(5):
        studio.keyboard.press("Tab")
    for frame in (0, 9, len(motion) - 1):
        shown = studio.evaluate("(seconds) => window.kinetograph.pose(seconds)", frame / motion.fps)
        expected = dict(zip(motion.skeleton.names, joint_positions(motion)[frame], strict=True))
        assert set(shown) == set(expected)
        assert max(np.linalg.norm(np.subtract(shown[name], expected[name])) for name in shown) < 1e-3
    studio.get_by_role("listbox", name="Takes").focus()
    studio.evaluate("window.kinetograph.studio.transport.seek(0.5)")
    studio.keyboard.press("k")
    assert studio.evaluate("window.added") == ["turn_left1", 0.5, "moves"]
    studio.get_by_role("button", name="Draw").click()
    assert set(studio.evaluate("window.kinetograph.pose(0)")) == set(motion.skeleton.names)
    root = studio.evaluate("window.kinetograph.pose(0).root")
    assert root == pytest.approx([0.5, 0.9, 0.0], abs=1e-3)  # what was made is shown again


def test_thumbnails_move_under_the_pointer_only(studio: Page) -> None:
    _browse(studio)
    studio.wait_for_function(f"({_SEEN})().then((count) => count === 1)")
    studio.locator(".card").first.hover()
    studio.wait_for_function(f"({_SEEN})().then((count) => count > 3)")
    studio.mouse.move(200, 300)
    studio.wait_for_function(f"({_SEEN})().then((count) => count === 1)")
    studio.emulate_media(reduced_motion="reduce")
    studio.locator(".card").first.hover()
    assert studio.evaluate(_SEEN) == 1


def test_what_is_like_a_part_of_a_take_is_found_and_shown_there(studio: Page) -> None:
    _browse(studio)
    studio.get_by_role("searchbox", name="Search").fill("*_walk")
    studio.wait_for_function("document.querySelector('.found p').textContent === '1 of 20 takes'")
    studio.get_by_role("option", name="humanoid3d_walk").click()
    studio.wait_for_function("document.querySelector('.status').textContent.startsWith('humanoid3d_walk')")
    studio.get_by_role("button", name="More like this").click()
    studio.wait_for_selector(".found button:visible")
    names = studio.locator(".card .card-name").all_inner_texts()
    assert "humanoid3d_walk" not in names
    assert names[0] in ("0walk_forward", "turn_left0", "turn_left1", "turn_right0", "turn_right1")
    studio.locator(".card").nth(1).click()
    studio.wait_for_function("(name) => document.querySelector('.status').textContent.startsWith(name)", arg=names[1])
    assert studio.locator(".lane.moves .span").count() == 1
    studio.get_by_role("button", name="All takes").click()
    studio.wait_for_function("document.querySelector('.found p').textContent === '1 of 20 takes'")


def _drop(studio: Page, *files: Path) -> None:
    studio.get_by_label("Recordings from files").set_input_files(files)


def test_a_recording_is_added_and_what_is_none_is_refused_in_words(
    studio: Page, server: Server, clips: Path, tmp_path: Path
) -> None:
    _browse(studio)
    source, wrong = tmp_path / "spin.bvh", tmp_path / "wrong.bvh"
    kg.save(kg.Library.open(clips).take("humanoid3d_spin").motion(), source)
    wrong.write_text("no motion at all")
    _drop(studio, wrong)
    studio.wait_for_function("document.querySelector('.status').dataset.kind === 'error'")
    assert "wrong.bvh is not kept as a recording" in studio.locator(".status").inner_text()
    _drop(studio, source)
    studio.wait_for_function("document.querySelector('.library select').value === 'recordings'")
    studio.wait_for_function("document.querySelector('.found p').textContent === '1 takes'")
    assert read_project(server.desk.path).libraries["recordings"] == "recordings"
    assert kg.Library.open(server.desk.room.folder / "recordings").names() == ("spin",)


def test_a_body_with_a_motion_is_worn_or_added_as_the_person_says(studio: Page, server: Server, tmp_path: Path) -> None:
    path = tmp_path / "stroll.glb"
    kg.save(server.desk.room.latest["walk"].synthesis.motion, path)
    data = list(path.read_bytes())
    drop = """(data) => {
      const files = new DataTransfer();
      files.items.add(new File([new Uint8Array(data)], "stroll.glb"));
      dispatchEvent(new DragEvent("drop", {dataTransfer: files, cancelable: true}));
    }"""
    studio.evaluate(drop, data)
    studio.get_by_role("button", name="Wear the body").click()
    studio.wait_for_function("window.kinetograph.studio.store.project.character === 'stroll.glb'")
    studio.evaluate(drop, data)
    studio.get_by_role("button", name="Add the motion to the library").click()
    studio.wait_for_function("'recordings' in (window.kinetograph.studio.store.project.libraries ?? {})")


def test_files_are_exported_fetched_and_named_anew(studio: Page, server: Server) -> None:
    studio.get_by_role("button", name="Export").click()
    dialog = studio.get_by_role("dialog", name="Export")
    for _ in range(40):  # the focus stays within the dialog, or goes to the browser's own buttons
        studio.keyboard.press("Tab")
        assert studio.evaluate("document.activeElement === document.body || !!document.activeElement.closest('dialog')")
    dialog.get_by_label("Name").fill("first walk")
    dialog.get_by_label("Report, JSON").check()
    dialog.get_by_label("Name").press("Enter")
    studio.wait_for_selector(".files a")
    links = dialog.locator(".files a")
    assert links.all_inner_texts() == ["first walk.bvh", "first walk.glb", "first walk.json"]
    for link in links.all():
        answer = studio.request.get(urljoin(server.address, link.get_attribute("href")))
        assert answer.body() == (server.desk.room.folder / "exports" / link.inner_text()).read_bytes()
    dialog.get_by_role("button", name="Write files").click()
    studio.wait_for_function("document.querySelector('.files a')?.textContent === 'first walk_2.bvh'")
    dialog.get_by_label("Name").fill("../walk")
    dialog.get_by_role("button", name="Write files").click()
    studio.wait_for_selector(".export .bad")
    assert "expected the name of a file without a folder" in dialog.locator(".bad").inner_text()
    studio.keyboard.press("Escape")
    assert studio.evaluate("document.activeElement.textContent") == "Export"


def test_a_film_is_stopped(studio: Page, server: Server) -> None:
    studio.evaluate("window.kinetograph.studio.connection.edit('walk', {path: [[0, 0, 0], [60, 1, 0]]})")
    studio.wait_for_function("window.kinetograph.studio.clip?.duration > 50 && document.body.dataset.state === 'ready'")
    studio.get_by_role("button", name="Export").click()
    dialog = studio.get_by_role("dialog", name="Export")
    dialog.get_by_label("GIF").check()
    dialog.get_by_label("Name").press("Enter")
    studio.wait_for_function("document.querySelector('.export progress').value > 0.05")
    dialog.get_by_role("button", name="Stop").click()
    studio.wait_for_selector(".export .bad")
    assert dialog.locator(".bad").inner_text() == "the export was stopped"
    names = sorted(path.name for path in (server.desk.room.folder / "exports").iterdir())
    assert [name for name in names if not name.startswith(".")] == ["walk.bvh", "walk.glb"]


def _serious(studio: Page) -> list[Any]:
    if not AXE.exists():
        pytest.skip("axe-core is missing: npm ci in src/kinetograph/studio/client")
    studio.evaluate(AXE.read_text())
    found = studio.evaluate("axe.run().then((result) => result.violations)")
    return [
        (each["id"], [node["html"] for node in each["nodes"]])
        for each in found
        if each["impact"] in ("serious", "critical")
    ]


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_nothing_serious_stands_in_the_way_of_anybody(studio: Page, scheme: Any) -> None:
    studio.emulate_media(color_scheme=scheme)
    _browse(studio)
    studio.locator(".card").first.click()
    studio.wait_for_function("document.querySelector('.status').textContent.includes('scrub')")
    assert _serious(studio) == []
    studio.get_by_role("button", name="Export").click()
    assert _serious(studio) == []
