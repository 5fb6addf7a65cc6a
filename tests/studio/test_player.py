"""The stand-alone player in a browser, opened from files."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from bodies import person
from bodies import walk as person_walk
from kinetograph import rotations as rot
from kinetograph.formats import ReadOptions
from kinetograph.keys import key_at
from kinetograph.kinematics import joint_positions
from kinetograph.library import Library
from kinetograph.motion import Motion, place, sample
from kinetograph.pipeline import inbetween, read_take
from kinetograph.skeleton import Skeleton
from kinetograph.studio.sharing import Shown, notebook_html, player_page
from kinetograph.synthesis import Piece, Synthesis
from kinetograph.take import Take
from walkers import walk

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

AXE = Path(__file__).parents[2] / "src/kinetograph/studio/client/node_modules/axe-core/axe.min.js"
READY = "document.body.dataset.state === 'ready'"

Opener = Callable[..., "Page"]


@pytest.fixture
def opened(built_page: Path, page: Page, tmp_path: Path) -> Opener:
    """Opens motions in the player."""

    def opened(shown: Shown | Mapping[str, Shown], title: str = "Shown") -> Page:
        (tmp_path / "page.html").write_text(player_page(shown, title), encoding="utf-8")
        page.goto((tmp_path / "page.html").as_uri())
        page.wait_for_function(READY)
        return page

    return opened


def posed(page: Page, seconds: float) -> dict[str, list[float]]:
    return page.evaluate("seconds => window.kinetograph.pose(seconds)", seconds)


def assert_shown(page: Page, motion: Motion, track: str = "") -> None:
    """What is shown is the motion, at and between its frames."""
    times = np.linspace(0.0, motion.duration, 10)
    expected = joint_positions(sample(motion, times, motion.fps))
    for time, positions in zip(times.tolist(), expected, strict=True):
        shown = posed(page, time)
        names = [f"{track}{name}" for name in motion.skeleton.names]
        assert set(names) <= set(shown)
        assert np.abs(np.array([shown[name] for name in names]) - positions).max() < 1e-3


def clock(page: Page) -> float:
    """Seconds that are shown."""
    minutes, seconds = page.locator(".clock").inner_text().split(" / ")[0].split(":")
    return 60 * int(minutes) + float(seconds)


def test_a_page_asks_nothing_of_anyone(opened: Opener, page: Page) -> None:
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    opened(walk(2.0))
    page.keyboard.press("Space")
    page.wait_for_function("document.querySelector('.clock').textContent > '0:00.2'")
    assert asked == [page.url]
    assert page.url.startswith("file://")


@pytest.mark.parametrize("name", ["humanoid3d_walk", "humanoid3d_getup_facedown", "humanoid3d_backflip"])
def test_a_recording_is_shown_as_it_is(opened: Opener, clips_folder: Path, name: str) -> None:
    take, _ = read_take(clips_folder / f"{name}.txt", ReadOptions())
    assert_shown(opened(take), take.motion())


def test_a_recording_of_another_source_is_shown_as_it_is(opened: Opener, data_folder: Path) -> None:
    take, _ = read_take(data_folder / "walks" / "15_03.bvh", ReadOptions())
    assert_shown(opened(take), take.motion())


def test_a_synthesis_is_shown_with_where_it_is_from(opened: Opener, clips_folder: Path, tmp_path: Path) -> None:
    library = Library.create(tmp_path / "clips")
    names = ("humanoid3d_getup_facedown", "humanoid3d_walk", "humanoid3d_run")
    for name in names:
        library.add(read_take(clips_folder / f"{name}.txt", ReadOptions())[0])
    lying, running = (library.take(name).motion() for name in (names[0], names[-1]))
    (made,) = inbetween((key_at(lying, 0.0), key_at(running, 0.4)), library)
    page = opened(made)
    assert_shown(page, made.motion)
    pieces = page.locator(".pieces [role=option]")
    assert pieces.count() == len(made.pieces)
    last = made.pieces[-1]
    pieces.last.focus()
    page.keyboard.press("Enter")
    assert clock(page) == pytest.approx(last.start, abs=0.006)
    assert page.locator(".overlay").get_by_text(f"{last.take}, {last.source_start:.2f} s").count() == 1


def test_bones_that_are_not_rigid_are_shown(opened: Opener) -> None:
    motion = walk(1.0)
    bones = np.repeat(motion.skeleton.offsets[None], len(motion), axis=0)
    bones[:, 2] *= np.linspace(1.0, 1.4, len(motion))[:, None]
    assert_shown(opened(replace(motion, bones=bones)), replace(motion, bones=bones))


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_the_shortest_motions_are_shown(opened: Opener, frames: int) -> None:
    motion = Motion(person(), np.tile([0.0, 0.95, 0.0], (frames, 1)), rot.identity(frames, len(person())), 30.0)
    assert_shown(opened(motion), motion)


AWKWARD = (
    "mixamorig:Hips",
    "Left.Foot",
    "Left Foot",
    "LeftFoot",
    "Left[0]/Foot",
    "left_foot",
    'Ünder: "quoted" </b>',
    "__proto__x",
)


def test_names_are_those_of_the_file(opened: Opener) -> None:
    parents = np.arange(len(AWKWARD)) - 1
    offsets = np.tile([0.0, 0.2, 0.05], (len(AWKWARD), 1))
    rng = np.random.default_rng(0)
    turns = rot.exp(rng.normal(scale=0.4, size=(20, len(AWKWARD), 3)))
    motion = Motion(Skeleton(AWKWARD, parents, offsets), rng.normal(size=(20, 3)), turns, 30.0)
    page = opened(motion)
    assert list(posed(page, 0.1)) == list(AWKWARD)
    assert_shown(page, motion)


def test_several_characters_are_shown_together(opened: Opener) -> None:
    leader, follower = walk(2.0), place(person_walk(person()), np.pi, (0.5, 0.0, 1.0))
    page = opened(Take("duet", {"leader": leader, "follower": follower}))
    assert_shown(page, leader, "leader/")
    assert_shown(page, follower, "follower/")
    assert page.locator(".lane-name").all_inner_texts()[:2] == ["leader: left foot", "leader: right foot"]


def test_clips_are_chosen_by_name(opened: Opener) -> None:
    slow, quick = walk(2.0, speed=0.5), walk(3.0, speed=1.2)
    page = opened({"slow": slow, "quick": quick})
    assert_shown(page, slow)
    page.keyboard.press("End")
    page.get_by_label("Clip").select_option("quick")
    page.wait_for_function("document.querySelector('.clock').textContent.endsWith('0:03.00')")
    assert_shown(page, quick)
    assert clock(page) == 0


# ---- time ----


def test_keys_go_through_time(opened: Opener) -> None:
    page = opened(walk(4.0))
    for key, seconds in (
        ("ArrowRight", 1 / 30), ("ArrowRight", 2 / 30), ("ArrowLeft", 1 / 30), ("Shift+ArrowRight", 31 / 30),
        ("End", 4.0), ("ArrowRight", 4.0), ("Shift+ArrowLeft", 3.0), ("Home", 0.0), ("ArrowLeft", 0.0),
    ):  # fmt: skip
        page.keyboard.press(key)
        assert clock(page) == pytest.approx(seconds, abs=0.006), key


def test_space_plays_and_pauses(opened: Opener) -> None:
    page = opened(walk(4.0))
    page.keyboard.press("Space")
    page.get_by_role("button", name="Play", pressed=True).wait_for()
    page.wait_for_function("document.querySelector('.clock').textContent > '0:00.1'")
    page.keyboard.press("Space")
    page.get_by_role("button", name="Play", pressed=False).wait_for()
    held = clock(page)
    assert 0 < held < 4
    page.get_by_label("Speed").focus()
    page.keyboard.press("ArrowDown")  # a field has the keys
    page.keyboard.press("ArrowRight")
    assert clock(page) == held


def test_without_looping_it_stops_at_the_end(opened: Opener) -> None:
    page = opened(walk(0.4))
    page.get_by_role("button", name="Loop").click()
    page.get_by_role("button", name="Play").click()
    page.get_by_role("button", name="Play", pressed=False).wait_for()
    page.wait_for_function("document.querySelector('.clock').textContent.startsWith('0:00.40')")
    page.get_by_role("button", name="Play").click()  # from the start again
    page.get_by_role("button", name="Play", pressed=True).wait_for()


def test_the_timeline_is_scrubbed(opened: Opener) -> None:
    page = opened(walk(4.0))
    ruler = page.locator(".ruler").bounding_box()
    assert ruler
    page.mouse.move(ruler["x"] + 0.25 * ruler["width"], ruler["y"] + 5)
    page.mouse.down()
    assert clock(page) == pytest.approx(1.0, abs=0.02)
    page.mouse.move(ruler["x"] + 0.75 * ruler["width"], ruler["y"] + 5)
    assert clock(page) == pytest.approx(3.0, abs=0.02)
    page.mouse.move(ruler["x"] + 5 * ruler["width"], ruler["y"] + 5)
    assert clock(page) == 4.0
    page.mouse.up()
    page.mouse.move(ruler["x"], ruler["y"])
    assert clock(page) == 4.0


def test_spans_are_walked_with_the_keyboard(opened: Opener) -> None:
    page = opened(walk(4.0))
    page.locator(".timeline-scroller").focus()
    names = []
    for _ in range(3):
        page.keyboard.press("ArrowDown")
        names.append(page.evaluate("document.activeElement.getAttribute('aria-label')"))
    assert len(set(names)) == 3
    assert all(name.startswith("left ") for name in names)
    page.keyboard.press("Space")  # plays, whatever has the focus
    page.get_by_role("button", name="Play", pressed=True).wait_for()


def test_zooming_keeps_the_playhead_in_view(opened: Opener) -> None:
    page = opened(walk(20.0))
    page.keyboard.press("End")
    for _ in range(4):
        page.get_by_role("button", name="Zoom in").click()
    head, lanes = page.locator(".playhead").bounding_box(), page.locator(".timeline-scroller").bounding_box()
    assert head
    assert lanes
    assert lanes["x"] < head["x"] < lanes["x"] + lanes["width"]
    assert page.locator(".timeline-content").bounding_box()["width"] > 4 * lanes["width"]


# ---- what is seen ----


def test_the_body_is_drawn_where_it_is(opened: Opener) -> None:
    page = opened(walk(2.0, speed=0.0))
    page.wait_for_function("window.kinetograph.still()")
    picture = _picture(page)
    blue = (picture[..., 2].astype(int) - picture[..., 0]) > 60
    red = (picture[..., 0].astype(int) - picture[..., 2]) > 60
    assert blue.sum() > 500
    assert red.sum() > 500
    # someone who faces the camera has the left side on the right of the picture
    page.get_by_role("button", name="Front").click()
    page.wait_for_function("window.kinetograph.still()")
    picture = _picture(page)
    blue = np.nonzero((picture[..., 2].astype(int) - picture[..., 0]) > 60)[1].mean()
    red = np.nonzero((picture[..., 0].astype(int) - picture[..., 2]) > 60)[1].mean()
    assert blue > red + 20


def test_the_camera_goes_by_keys(opened: Opener) -> None:
    page = opened(walk(2.0, speed=0.0))
    page.locator("canvas").focus()
    width = []
    for keys in ([], ["-"] * 8, ["+"] * 16):
        for key in keys:
            page.keyboard.press(key)
        page.wait_for_function("window.kinetograph.still()")
        picture = _picture(page)
        width.append(int(np.ptp(np.nonzero((picture[..., 2].astype(int) - picture[..., 0]) > 60)[0])))
    assert width[1] < 0.5 * width[0] < width[2]
    before = _picture(page)
    page.keyboard.press("Control+ArrowLeft")
    page.wait_for_function("window.kinetograph.still()")
    assert np.abs(_picture(page).astype(int) - before).mean() > 0.5
    assert clock(page) == 0


def _picture(page: Page) -> np.ndarray:
    import io

    from PIL import Image

    clip = page.locator("main").bounding_box()
    assert clip
    clip = {  # without the buttons, and the frame of the focus
        "x": clip["x"] + 8,
        "y": clip["y"] + 60,
        "width": clip["width"] - 16,
        "height": clip["height"] - 68,
    }
    return np.asarray(Image.open(io.BytesIO(page.screenshot(clip=clip))).convert("RGB"))


def test_frames_are_drawn_only_where_something_changes(opened: Opener) -> None:
    page = opened(walk(2.0))
    page.wait_for_function("window.kinetograph.still()")
    drawn = page.evaluate("window.kinetograph.drawn()")
    page.evaluate(
        """new Promise((done) => {
          let frames = 0;
          const next = () => (++frames > 20 ? done() : requestAnimationFrame(next));
          next();
        })"""
    )
    assert page.evaluate("window.kinetograph.drawn()") == drawn
    page.keyboard.press("ArrowRight")
    page.wait_for_function("drawn => window.kinetograph.drawn() > drawn", arg=drawn)


@pytest.mark.parametrize("scheme", ["dark", "light"])
def test_both_themes_have_no_serious_finding(opened: Opener, page: Page, scheme: Any) -> None:
    if not AXE.is_file():
        pytest.skip("axe-core is missing: npm ci in src/kinetograph/studio/client")
    page.emulate_media(color_scheme=scheme)
    made = Synthesis(
        walk(2.0),
        (Piece("first", "motion", 0.0, 1.0, 0.0, 1.0), Piece("second", "motion", 1.0, 2.0, 1.0, 2.0)),
        0.5,
        edited=np.linspace(0, 0.1, 61),
        warnings=("one", "two"),
    )
    opened({"made": made, "walk": walk(1.0)})
    dark = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert (sum(int(value) for value in dark[4:-1].split(",")) < 200) == (scheme == "dark")
    page.evaluate(AXE.read_text(encoding="utf-8"))
    found = page.evaluate(
        """axe.run().then((result) =>
          result.violations.map(({id, impact, nodes}) => [id, impact, nodes.map((node) => node.html)]))"""
    )
    assert [finding for finding in found if finding[1] in ("serious", "critical")] == [], json.dumps(found, indent=1)


def test_the_button_changes_the_theme(opened: Opener) -> None:
    page = opened(walk(1.0))
    page.emulate_media(color_scheme="light")
    page.wait_for_function("window.kinetograph.still()")
    light = _picture(page).mean()
    page.get_by_role("button", name="Dark or light").click()
    page.wait_for_function("window.kinetograph.still()")
    assert _picture(page).mean() < light - 80


@pytest.mark.parametrize("size", [(1280, 800), (640, 400), (360, 640)])
def test_nothing_is_cut_off(opened: Opener, page: Page, size: tuple[int, int]) -> None:
    page.set_viewport_size({"width": size[0], "height": size[1]})
    opened({"a walk": walk(4.0), "another": walk(1.0)}, "A title that is rather long for a narrow window")
    outside = page.evaluate(
        """() => [...document.querySelectorAll("button, select, h1")].filter((each) => {
          const box = each.getBoundingClientRect();
          return box.left < 0 || box.top < 0 || box.right > innerWidth + 0.5 || box.bottom > innerHeight + 0.5;
        }).map((each) => each.outerHTML)"""
    )
    assert outside == []
    assert page.locator("canvas").bounding_box()["height"] > 100


@pytest.fixture
def notebook(browser: Browser, built_page: Path, tmp_path: Path) -> Iterator[Page]:
    """A page with a cell that shows a walk."""
    motion = walk(3.0)
    (tmp_path / "notebook.html").write_text(f"<!doctype html><title>n</title>{notebook_html(motion)}", encoding="utf-8")
    context = browser.new_context(viewport={"width": 900, "height": 600})
    page = context.new_page()
    page.goto((tmp_path / "notebook.html").as_uri())
    yield page
    context.close()


def test_a_cell_of_a_notebook_plays(notebook: Page) -> None:
    cell = notebook.frames[1]
    cell.wait_for_function(READY)
    shown = cell.evaluate("window.kinetograph.pose(1.5)")
    expected = joint_positions(sample(walk(3.0), [1.5], 30.0))[0]
    np.testing.assert_allclose(list(shown.values()), expected, atol=1e-3)
    cell.get_by_role("button", name="Play").click()
    cell.wait_for_function("document.querySelector('.clock').textContent > '0:00.1'")
    assert (
        cell.evaluate("(() => { try { return Boolean(parent.document.title); } catch { return false; } })()") is False
    )
