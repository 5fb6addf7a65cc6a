"""Keys on the page, in a real browser on real recordings: by keyboard alone, by mouse, on the stage."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from programs import wait_for_state
from rooms import served

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.kinematics import joint_positions
from kinetograph.post import ends_of
from kinetograph.studio import registry as making
from kinetograph.studio.keys.making import solve
from kinetograph.studio.project import KeyRow, Keys, Project
from kinetograph.studio.serving.server import Server

if TYPE_CHECKING:
    from playwright.sync_api import Locator, Page

TAKES = ("walk", "run", "kick", "punch", "jump")
ROWS = (KeyRow("take:walk@0.4"), KeyRow("take:kick@0.6"), KeyRow("take:punch@0.5"))
AXE = Path(making.__file__).parent / "client" / "node_modules" / "axe-core" / "axe.min.js"


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory, clips_folder: Path) -> Path:
    folder = tmp_path_factory.mktemp("keys") / "moves"
    made = kg.Library.create(folder)
    for name in TAKES:
        made.add(replace(kg.load(clips_folder / f"humanoid3d_{name}.txt"), name=name))
    return folder


def project_of(library: Path, *rows: KeyRow, **fields: Any) -> Project:
    return Project(mode="keys", libraries={"moves": str(library)}, keys=Keys(rows=rows, **fields))


@pytest.fixture
def empty(library: Path, tmp_path: Path, built_page: Path) -> Iterator[Server]:
    with served(tmp_path, project_of(library), making.SECTIONS) as server:
        yield server


@pytest.fixture
def three(library: Path, tmp_path: Path, built_page: Path) -> Iterator[Server]:
    with served(tmp_path, project_of(library, *ROWS), making.SECTIONS) as server:
        yield server


def opened(page: Page, server: Server) -> None:
    page.goto(server.address)
    page.wait_for_function("document.querySelectorAll('.keys-panel option[value=walk]').length > 0")


def solved(page: Page, server: Server) -> None:
    """Open the page, and wait until its keys are solved and it is known where they are met."""
    opened(page, server)
    settled(page)


def settled(page: Page) -> None:
    wait_for_state(page, "ready")
    page.wait_for_function(
        "kinetograph.studio.panel.element.querySelectorAll('.key-row').length === kinetograph.studio.panel.rows.length"
    )
    page.wait_for_function("document.querySelectorAll('.lane.keys .span').length > 1")


def rows_of(page: Page) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = page.evaluate("kinetograph.studio.store.project.keys.rows ?? []")
    return rows


def key_on_timeline(page: Page, name: str) -> Locator:
    return page.locator(".lane.keys [role=option]", has_text=name)


def tab_to(page: Page, name: str, backwards: bool = False) -> None:
    """Go on with Tab until what has the focus is called so."""
    for _ in range(60):
        page.keyboard.press("Shift+Tab" if backwards else "Tab")
        if page.evaluate(
            "n => [a => a.ariaLabel, a => a.labels?.[0]?.textContent, a => a.textContent]"
            ".some(f => f(document.activeElement) === n)",
            name,
        ):
            return
    raise AssertionError(f"Tab leads nowhere that is called {name!r}")


def shown_pose(page: Page, second: float) -> np.ndarray:
    pose: dict[str, list[float]] = page.evaluate("s => kinetograph.pose(s)", second)
    return np.array(list(pose.values()))


def server_pose(server: Server, second: float) -> np.ndarray:
    motion = server.desk.room.latest["keys"].synthesis.motion
    return np.asarray(joint_positions(motion)[round(second * motion.fps)])


# ---- by the keyboard alone ----


def test_keys_are_set_retimed_and_solved_with_the_keyboard_alone(page: Page, empty: Server) -> None:
    opened(page, empty)
    for take, steps in (("walk", 12), ("kick", 18), ("punch", 15)):
        tab_to(page, "Take", backwards=take != "walk")
        page.keyboard.type(take)
        tab_to(page, "Second")
        for _ in range(steps):
            page.keyboard.press("ArrowRight")
        page.keyboard.press("k")
    assert [row["pose"] for row in rows_of(page)] == ["take:walk@0.4", "take:kick@0.6", "take:punch@0.5"]
    settled(page)
    page.wait_for_function("document.querySelector('.key-list').textContent.includes('free')")
    tab_to(page, "Timeline")
    for _ in range(3):
        page.keyboard.press("ArrowDown")
    assert "key 3" in page.evaluate("document.activeElement.ariaLabel")
    before = float(page.evaluate("document.activeElement.ariaLabel.match(/, ([0-9.]+)/)[1]"))
    page.keyboard.press("ArrowRight")
    assert rows_of(page)[2]["time"] == pytest.approx(before + 1 / 30, abs=6e-3)
    page.keyboard.press("Shift+ArrowRight")
    assert rows_of(page)[2]["time"] == pytest.approx(before + 1 + 1 / 30, abs=6e-3)
    assert "key 3" in page.evaluate("document.activeElement.ariaLabel")
    page.keyboard.press("w")
    low, high = rows_of(page)[2]["time"]
    assert high - low == pytest.approx(0.5, abs=0.04)
    page.keyboard.press("Enter")
    settled(page)
    spans = empty.desk.room.latest["keys"].lanes[0].spans
    assert low - 1e-6 <= spans[2].start <= high + 1e-6
    page.keyboard.press("Delete")
    settled(page)
    assert len(rows_of(page)) == 2
    page.keyboard.press("Control+z")
    page.wait_for_function("kinetograph.studio.store.project.keys.rows.length === 3")


def test_a_key_of_the_result_at_the_playhead(page: Page, three: Server) -> None:
    solved(page, three)
    page.evaluate("kinetograph.studio.transport.seek(1)")
    page.locator("body").press("k")
    settled(page)
    rows = rows_of(page)
    assert len(rows) == 4
    assert rows[1]["pose"].startswith("take:walk@")
    assert rows[1]["time"] == pytest.approx(1.0, abs=0.02)


# ---- by mouse ----


def test_keys_are_dragged_on_the_timeline(page: Page, three: Server) -> None:
    solved(page, three)
    page.wait_for_function("kinetograph.studio.panel.element.textContent.includes('s, free')")
    box = key_on_timeline(page, "key 3").bounding_box()
    assert box
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    second = page.evaluate("x => kinetograph.studio.timeline.timeAt({clientX: x})", x + 80)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 40, y, steps=4)
    page.mouse.move(x + 80, y, steps=4)
    page.mouse.up()
    settled(page)
    time = rows_of(page)[2]["time"]
    assert time == pytest.approx(second, abs=0.04)
    assert three.desk.room.latest["keys"].lanes[0].spans[2].start == pytest.approx(time, abs=1e-3)
    for at in (0.0, time / 2, time):
        at = round(at * 30) / 30
        assert np.abs(shown_pose(page, at) - server_pose(three, at)).max() < 1e-3
    box = key_on_timeline(page, "key 3").bounding_box()
    assert box
    page.keyboard.down("Control")
    page.mouse.move(box["x"] + box["width"] / 2, y)
    page.mouse.down()
    page.mouse.move(box["x"] + 40, y, steps=5)
    page.mouse.up()
    page.keyboard.up("Control")
    settled(page)
    low, high = rows_of(page)[2]["time"]
    assert low < time < high
    assert low <= three.desk.room.latest["keys"].lanes[0].spans[2].start <= high


def test_a_key_that_comes_too_soon_is_put_off(page: Page, library: Path, tmp_path: Path, built_page: Path) -> None:
    rows = (ROWS[0], KeyRow("take:punch@0.5", time=0.2))
    with served(tmp_path, project_of(library, *rows), making.SECTIONS) as server:
        opened(page, server)
        wait_for_state(page, "error")
        trouble = page.locator(".key-list li", has_text="key 2").get_by_role("alert")
        trouble.wait_for()
        assert "the least duration that is met" in (trouble.text_content() or "")
        trouble.get_by_role("button", name="s more").click()
        settled(page)
        assert rows_of(page)[1]["time"] > 0.2
        assert page.get_by_role("alert").count() == 0


def test_a_timing_that_is_too_quick_is_forced_only_when_asked(
    page: Page, library: Path, tmp_path: Path, built_page: Path
) -> None:
    rows = (ROWS[0], KeyRow("take:kick@0.6", time=0.8))
    with served(tmp_path, project_of(library, *rows), making.SECTIONS) as server:
        opened(page, server)
        wait_for_state(page, "error")
        trouble = page.locator(".key-list li", has_text="key 2").get_by_role("alert")
        trouble.get_by_role("button", name="s more").wait_for()
        trouble.get_by_role("button", name="Make it all the same").click()
        settled(page)
        assert page.evaluate("kinetograph.studio.store.project.keys.force")
        assert rows_of(page)[1]["time"] == 0.8
        force = page.get_by_label("Force timings that are too quick")
        assert force.is_checked()
        force.uncheck()
        wait_for_state(page, "error")
        trouble.get_by_role("button", name="s more").click()
        settled(page)
        assert rows_of(page)[1]["time"] > 0.8
        assert not page.evaluate("kinetograph.studio.store.project.keys.force")


def test_parts_are_put_elsewhere_in_the_panel(page: Page, three: Server) -> None:
    solved(page, three)
    page.locator(".key-row", has_text="key 2").click()
    page.locator("summary", has_text="Parts elsewhere").click()
    page.get_by_label("Part to put elsewhere").select_option("left_hand")
    page.get_by_role("button", name="Add part").click()
    parts = page.get_by_role("list", name="Parts elsewhere")
    page.wait_for_function("kinetograph.studio.store.project.keys.rows[1].parts?.length === 1")
    (part,) = rows_of(page)[1]["parts"]
    assert (part["role"], part["in"]) == ("left_hand", "root")
    up = parts.get_by_label("left hand: up, metres")
    up.fill(f"{part['position'][1] + 0.05:.3f}")
    up.press("Tab")
    page.wait_for_function("kinetograph.studio.store.project.keys.rows[1].parts[0].position[1] > 0", timeout=5000)
    assert rows_of(page)[1]["parts"][0]["position"][1] == pytest.approx(part["position"][1] + 0.05, abs=1e-3)
    parts.get_by_label("left hand: seen from").select_option("world")
    page.wait_for_function("kinetograph.studio.store.project.keys.rows[1].parts[0].in === 'world'")
    parts.get_by_label("Rotation").check()
    page.wait_for_function("kinetograph.studio.store.project.keys.rows[1].parts[0].orientation")
    quaternion = rows_of(page)[1]["parts"][0]["orientation"]
    assert np.linalg.norm(quaternion) == pytest.approx(1.0, abs=1e-6)
    parts.get_by_label("left hand: turn, degrees").press("ArrowUp")
    page.wait_for_function(
        "q => kinetograph.studio.store.project.keys.rows[1].parts[0].orientation[0] !== q", arg=quaternion[0]
    )
    turned = rows_of(page)[1]["parts"][0]["orientation"]
    assert np.degrees(rot.angle_between(np.array(turned), np.array(quaternion))) == pytest.approx(5.0, abs=0.2)
    parts.get_by_role("button", name="Remove: left hand").click()
    page.wait_for_function("!kinetograph.studio.store.project.keys.rows[1].parts")


def test_alternatives_are_chosen_by_their_ghosts(page: Page, three: Server) -> None:
    solved(page, three)
    page.get_by_label("How many").select_option("4")
    settled(page)
    page.wait_for_function("kinetograph.studio.store.made.costs.length > 1")
    page.wait_for_function(
        "kinetograph.studio.panel.stage.others.length === kinetograph.studio.store.made.costs.length - 1"
    )
    page.evaluate("kinetograph.studio.transport.seek(1)")
    at = page.evaluate(
        """() => {
          const { stage, panel, transport } = kinetograph.studio;
          const { clip, number } = panel.stage.others.at(-1);
          const [x, y, z] = clip.root(transport.time);
          const { x: dx, z: dz } = clip.object.position;
          return { number, ...stage.screenPoint(x + dx, y, z + dz) };
        }"""
    )
    page.mouse.click(at["clientX"], at["clientY"])
    settled(page)
    page.wait_for_function("n => kinetograph.studio.store.made.chosen === n", arg=at["number"])
    settled(page)
    made = three.desk.room.latest["keys"]
    assert made.chosen == at["number"]
    assert np.abs(shown_pose(page, 1.0) - server_pose(three, 1.0)).max() < 1e-3
    page.get_by_role("radio").first.check()
    page.wait_for_function("(kinetograph.studio.store.made.chosen ?? 0) === 0")


def drag(page: Page, start: dict[str, float], by: tuple[float, float]) -> None:
    page.mouse.move(start["clientX"], start["clientY"])
    page.mouse.down()
    page.mouse.move(start["clientX"] + by[0] / 2, start["clientY"] + by[1] / 2, steps=3)
    page.mouse.move(start["clientX"] + by[0], start["clientY"] + by[1], steps=3)
    page.mouse.up()


def test_place_heading_and_hands_on_the_stage(page: Page, three: Server) -> None:
    solved(page, three)
    page.get_by_label("Force timings that are too quick").check()  # anywhere it is dragged to
    settled(page)
    page.locator(".key-row", has_text="key 2").click()
    page.wait_for_function("kinetograph.studio.panel.stage.handles.children.length === 4")
    where = "part => kinetograph.studio.stage.screenPoint(...kinetograph.studio.panel.stage.pointOf(part))"
    hand = page.evaluate(where, "left_hand")
    drag(page, hand, (-20, -30))
    settled(page)
    moved = rows_of(page)[1]["moved"]["left_hand"]
    made = three.desk.room.latest["keys"]
    motion = made.synthesis.motion
    frame = round(made.lanes[0].spans[1].start * motion.fps)
    assert np.linalg.norm(ends_of(motion, frame)["left_hand"] - moved) < 1e-3
    page.evaluate("kinetograph.studio.stage.view('top')")
    disc = page.evaluate(where, "position")
    expected = page.evaluate(
        "p => kinetograph.studio.stage.groundPoint({clientX: p.clientX + 60, clientY: p.clientY + 10})", disc
    )
    drag(page, disc, (60, 10))
    settled(page)
    x, z = rows_of(page)[1]["position"]
    assert (x, z) == pytest.approx((expected["x"], expected["z"]), abs=0.02)
    page.evaluate("kinetograph.studio.stage.view('top')")
    nose = page.evaluate(where, "heading")
    drag(page, nose, (40, 0))
    settled(page)
    row = rows_of(page)[1]
    assert "heading" in row
    made = three.desk.room.latest["keys"]
    motion = made.synthesis.motion
    frame = round(made.lanes[0].spans[1].start * motion.fps)
    assert motion.translation[frame, [0, 2]] == pytest.approx((x, z), abs=1e-3)
    heading = np.degrees(kg.rotations.heading(motion.rotations[frame, 0]))
    assert (heading - row["heading"] + 180) % 360 - 180 == pytest.approx(0, abs=0.1)


def test_a_part_is_kept_and_the_rest_made_anew(page: Page, three: Server) -> None:
    solved(page, three)
    before = [shown_pose(page, frame / 30) for frame in range(20)]
    page.get_by_label("Keep from, s").fill("0")
    page.get_by_label("Keep to, s").fill("0.6")
    page.get_by_role("button", name="Lock", exact=True).click()
    settled(page)
    page.get_by_label("Leave out").fill("run")
    page.get_by_label("Leave out").press("Enter")
    settled(page)
    lock = page.evaluate("kinetograph.studio.store.project.keys.lock")
    assert lock["span"] == [0, 0.6]
    after = [shown_pose(page, frame / 30) for frame in range(19)]
    assert max(np.abs(a - b).max() for a, b in zip(after, before, strict=False)) < 1e-6
    page.get_by_role("button", name="Unlock").click()
    settled(page)
    assert not page.evaluate("kinetograph.studio.store.project.keys.lock")


def test_nothing_serious_stands_in_anyones_way(page: Page, three: Server) -> None:
    if not AXE.is_file():
        pytest.skip("axe-core is missing: npm ci in src/kinetograph/studio/client")
    solved(page, three)
    page.get_by_label("How many").select_option("3")
    settled(page)
    page.locator("summary", has_text="Parts that count").click()
    page.get_by_label("The whole body").uncheck()
    settled(page)
    page.evaluate(AXE.read_text())
    found: list[dict[str, Any]] = page.evaluate("axe.run().then(r => r.violations)")
    serious = [(v["id"], [n["html"] for n in v["nodes"]]) for v in found if v["impact"] in ("serious", "critical")]
    assert not serious


def test_what_was_solved_is_what_the_project_says(three: Server, page: Page) -> None:
    solved(page, three)
    project = three.desk.history.project
    expected = solve(project.keys, project, three.desk.room, lambda done, total: None).syntheses[0].motion
    middle = len(expected) // 2
    assert np.abs(shown_pose(page, middle / 30) - joint_positions(expected)[middle]).max() < 1e-3
