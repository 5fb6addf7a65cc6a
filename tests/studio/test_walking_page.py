"""A walk is drawn on the page, by a mouse; what is shown there is what Python makes of the project."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from rooms import served

from kinetograph.kinematics import joint_positions
from kinetograph.motion import sample
from kinetograph.studio.project import Project, read_project
from kinetograph.studio.registry import SECTIONS
from kinetograph.studio.room import Room
from kinetograph.studio.sample import WALKS
from kinetograph.studio.walk.making import make

if TYPE_CHECKING:
    from playwright.sync_api import Page

    from kinetograph.studio.serving.server import Server

Rows = list[tuple[float, float, float]]

WAIT = 60_000  # milliseconds
AXE = Path(__file__).parents[2] / "src/kinetograph/studio/client/node_modules/axe-core/axe.min.js"


@pytest.fixture(scope="module")
def walks(tmp_path_factory: pytest.TempPathFactory, clips_folder: Path) -> Path:
    """A library of the sample's clips that walk."""
    from kinetograph.formats import ReadOptions
    from kinetograph.library import Library
    from kinetograph.pipeline import read_take

    library = Library.create(tmp_path_factory.mktemp("page") / "walks")
    for name in WALKS:
        library.add(read_take(clips_folder / f"{name}.txt", ReadOptions())[0])
    return library.path


@pytest.fixture
def server(tmp_path: Path, walks: Path, built_page: Path) -> Iterator[Server]:
    """A studio with these walks."""
    with served(tmp_path, Project(libraries={"walks": str(walks)}), SECTIONS) as server:
        yield server


def eight(seconds: float = 17.0, rate: float = 30.0, size: float = 2.0) -> Rows:
    """An eight on the ground, in the middle of the view."""
    times = np.arange(round(seconds * rate) + 1) / rate
    round_ = 2 * np.pi * times / seconds
    return [
        (float(t), float(size * np.sin(a)), float(size * np.sin(a) * np.cos(a)))
        for t, a in zip(times, round_, strict=True)
    ]


class Walking:
    """A page on which somebody walks."""

    def __init__(self, page: Page, server: Server) -> None:
        self.page, self.server = page, server
        page.goto(server.address)
        page.locator(".speed p", has_text="The library has").wait_for(timeout=WAIT)

    @property
    def project(self) -> Project:
        """The project as it is saved."""
        return read_project(self.server.desk.path)

    def studio(self, expression: str) -> Any:
        """Something of the page."""
        return self.page.evaluate(f"window.kinetograph.studio.{expression}")

    @contextlib.contextmanager
    def made(self) -> Iterator[None]:
        """Wait until what is done within has been made and is shown."""
        before = self.studio("store.made?.key ?? null")
        yield
        self.page.wait_for_timeout(50)
        for _ in range(WAIT // 100):
            if self.page.locator("body[data-state=ready]").count() and self.studio("store.made?.key") != before:
                return
            self.page.wait_for_timeout(100)
        raise AssertionError(f"nothing new was made; the page says: {self.page.locator('.status').inner_text()}")

    def choose(self, name: str) -> None:
        """Press a button."""
        self.page.get_by_role("button", name=name, exact=True).click()

    def stroke(self, rows: Rows) -> None:
        """A stroke of a mouse over the ground, whose events have the times of the rows."""
        self.page.evaluate(
            """rows => {
              const { stage } = window.kinetograph.studio;
              const begun = performance.now();
              const fire = (type, [time, x, z], buttons) => {
                const at = stage.screenPoint(x, stage.floor, z);
                const button = type === "pointermove" ? -1 : 0;
                const how = { pointerId: 1, pointerType: "mouse", isPrimary: true, button, buttons };
                const event = new PointerEvent(type, { bubbles: true, cancelable: true, ...how, ...at });
                Object.defineProperty(event, "timeStamp", { value: begun + 1000 * time });
                stage.canvas.dispatchEvent(event);
              };
              fire("pointerdown", rows[0], 1);
              for (const row of rows.slice(1)) fire("pointermove", row, 1);
              fire("pointerup", rows[rows.length - 1], 0);
            }""",
            rows,
        )

    def mouse(self, rows: Rows) -> None:
        """The same by the browser's own mouse, one event after another."""
        points = self.page.evaluate(
            """rows => rows.map(([, x, z]) => {
              const { stage } = window.kinetograph.studio;
              const { clientX, clientY } = stage.screenPoint(x, stage.floor, z);
              return [clientX, clientY];
            })""",
            rows,
        )
        tools, begun = self.page.context.new_cdp_session(self.page), time.time()

        def send(kind: str, at: float, point: list[float], buttons: int) -> None:
            event = {"type": kind, "x": point[0], "y": point[1], "timestamp": begun + at}
            event |= {"button": "left", "buttons": buttons, "clickCount": 1}
            tools.send("Input.dispatchMouseEvent", event)

        send("mousePressed", rows[0][0], points[0], 1)
        for (at, _, _), point in zip(rows[1:], points[1:], strict=True):
            send("mouseMoved", at, point, 1)
        send("mouseReleased", rows[-1][0], points[-1], 0)

    def draw(self, rows: Rows) -> None:
        """Draw a path, and see it walked."""
        self.choose("Draw")
        with self.made():
            self.stroke(rows)

    def stop_at(self, second: float) -> None:
        """Show a moment: what was drawn is played."""
        self.studio("transport.pause()")
        self.studio(f"transport.seek({second})")

    def wait_for(self, expression: str) -> None:
        """Wait until something of the page is true."""
        for _ in range(WAIT // 50):
            if self.studio(expression):
                return
            self.page.wait_for_timeout(50)
        raise AssertionError(f"never: {expression}")

    @property
    def said(self) -> str:
        """What the speed bar says."""
        return self.page.locator(".speed p").inner_text()


@pytest.fixture
def walking(page: Page, server: Server) -> Walking:
    """An open page, whose model is fitted."""
    return Walking(page, server)


def _quiet(done: int, total: int) -> None:
    """Nobody watches."""


def test_a_drawn_path_is_walked_as_python_walks_it(walking: Walking, tmp_path: Path) -> None:
    rows = eight()
    walking.choose("Draw")
    assert walking.page.locator("[data-mode=walk][data-active]").count() == 1
    with walking.made():
        walking.stroke(rows)
    project = walking.project
    drawn = np.array(project.walk.path)
    assert drawn[-1, 0] == pytest.approx(17.0, abs=0.02)
    wanted = np.array(rows)
    on_time = np.column_stack([np.interp(drawn[:, 0], wanted[:, 0], wanted[:, i]) for i in (1, 2)])
    assert np.abs(drawn[:, 1:] - on_time).max() < 0.02  # a pixel and its time
    made = make(project, Room(tmp_path), _quiet)
    assert made is not None
    motion = made.synthesis.motion
    times = np.linspace(0.0, motion.duration, 10)
    expected = joint_positions(sample(motion, times, motion.fps))
    for at, places in zip(times, expected, strict=True):
        shown = walking.page.evaluate("at => window.kinetograph.pose(at)", float(at))
        assert set(shown) == set(motion.skeleton.names)
        gaps = np.array([shown[name] for name in motion.skeleton.names]) - places
        assert np.linalg.norm(gaps, axis=1).max() < 1e-3
    assert walking.page.get_by_label("Figures").inner_text().startswith("Figures\npath error")
    assert walking.page.get_by_role("option").count() >= len(made.synthesis.pieces)


def test_a_mouse_draws_by_the_times_of_its_events(walking: Walking) -> None:
    rows = [(t, 0.5 * t, 0.2 * t * t) for t in (np.arange(31) / 15).tolist()]
    walking.choose("Draw")
    with walking.made():
        walking.mouse(rows)
    drawn = np.array(walking.project.walk.path)
    assert drawn[-1, 0] == pytest.approx(2.0, abs=0.01)
    wanted = np.array(rows)
    on_time = np.column_stack([np.interp(drawn[:, 0], wanted[:, 0], wanted[:, i]) for i in (1, 2)])
    assert np.abs(drawn[:, 1:] - on_time).max() < 0.03


def test_what_is_too_fast_is_red_and_said(walking: Walking) -> None:
    walking.draw(eight(17.0))
    assert walking.said.startswith("The library has 0.00 to")
    walking.draw(eight(4.0, 60.0))
    assert walking.said.startswith("Too fast at 0.0 to")
    assert "bad" in (walking.page.locator(".speed p").get_attribute("class") or "")
    red, _, blue = walking.page.evaluate(
        "Array.from(window.kinetograph.studio.panels.walk.view.ribbon.geometry.getAttribute('color').array.slice(0, 3))"
    )
    assert red > 1.5 * blue  # at the beginning
    assert "faster than the library's people can hurry" in walking.page.get_by_label("Figures").inner_text()


def test_a_piece_is_opened_pinned_forbidden_and_let_free(walking: Walking) -> None:
    walking.draw(eight(8.0, size=1.4))
    page = walking.page
    piece = page.locator(".pieces .span").nth(4)
    walking.stop_at(1.0)
    shown = walking.server.desk.room.latest["walk"].synthesis.pieces[4]
    source = f"{shown.source_start:.2f} to {shown.source_stop:.2f} s"
    for _ in range(50):  # lanes may be shown anew meanwhile
        page.mouse.move(500, 200)
        piece.hover()
        page.wait_for_timeout(200)
        if source in page.locator(".status").inner_text():
            break
    assert source in page.locator(".status").inner_text()
    piece.click()
    page.locator(".candidate").nth(1).wait_for(timeout=WAIT)
    assert page.locator(".candidate").count() == 5
    costs = [float(text) for text in page.locator(".candidate td:nth-child(3)").all_inner_texts()]
    assert costs[1:] == sorted(costs[1:])
    wanted = page.locator(".candidate td:nth-child(2)").nth(1).inner_text()
    with walking.made():
        page.get_by_role("button", name="Use next best 1").click()
    (rule,) = walking.project.walk.rules
    there = next(p for p in walking.server.desk.room.latest["walk"].synthesis.pieces if p.start <= rule.start < p.stop)
    assert not rule.forbid
    assert wanted.startswith(there.take)
    assert f"{there.source_start:.2f} to {there.source_stop:.2f} s" in wanted
    assert page.get_by_label("Pinned and forbidden pieces").inner_text().startswith(f"pinned {there.take}")
    with walking.made():
        walking.choose("Undo")
    assert walking.project.walk.rules == ()
    page.locator(".pieces .span").nth(4).click()
    with walking.made():
        walking.choose("Forbid")
    assert walking.project.walk.rules[0].forbid
    with walking.made():
        page.get_by_role("button", name="Remove: not").click()
    assert walking.project.walk.rules == ()


def test_why_a_piece_is_there_and_another_pinned_in_its_place(walking: Walking) -> None:
    walking.draw(eight(8.0, size=1.4))
    page = walking.page
    walking.stop_at(2.0)
    page.locator(".pieces .span").nth(4).click()
    page.get_by_role("button", name="Why?").click()
    table = page.get_by_role("table", name="Pieces at")
    table.wait_for(timeout=WAIT)
    shown = walking.server.desk.room.latest["walk"].synthesis.pieces[4]
    row = table.get_by_role("row", name="Shown")
    assert f"{shown.source_start:.2f} to {shown.source_stop:.2f} s" in row.inner_text()
    margins = [float(text) for text in table.locator("tbody td:nth-child(3)").all_inner_texts()]
    assert len(margins) >= 10
    assert margins[:10] == sorted(margins[:10])
    if AXE.is_file():
        page.evaluate(AXE.read_text())
        assert page.evaluate("axe.run('.candidates').then(r => r.violations.map(v => v.id))") == []
    pin = table.get_by_role("button", name="Pin").first
    wanted = (pin.get_attribute("aria-label") or "").removeprefix("Pin ")
    with walking.made():
        pin.click()
    (rule,) = walking.project.walk.rules
    there = next(p for p in walking.server.desk.room.latest["walk"].synthesis.pieces if p.start <= rule.start < p.stop)
    assert not rule.forbid
    assert wanted.startswith(there.take)
    assert f"{there.source_start:.2f} to {there.source_stop:.2f} s" in wanted
    page.locator(".pieces .span").nth(4).click()
    page.get_by_role("button", name="Why?").click()
    reasons = page.get_by_role("list", name="What would have to go")
    reasons.wait_for(timeout=WAIT)
    assert "Without the rule that pins" in reasons.inner_text()


def test_a_take_drives_the_arms_of_a_walk(walking: Walking) -> None:
    walking.draw(eight(8.0, size=1.4))
    page = walking.page
    plain = walking.server.desk.room.latest["walk"].synthesis.motion
    walking.stop_at(2.0)
    page.get_by_label("Driven by").select_option(label="turn_left1")
    page.get_by_label("Part", exact=True).select_option("left arm")
    with walking.made():
        page.get_by_role("button", name="Add layer").click()
    (row,) = walking.project.walk.layers
    assert (row.parts, row.source, row.start) == (("left arm",), "take:turn_left1", pytest.approx(2.0, abs=0.04))
    made = walking.server.desk.room.latest["walk"].synthesis
    assert made.layers[0].joints[-1] == "left_wrist"
    leg = plain.skeleton.index("left_knee")
    np.testing.assert_allclose(np.abs(made.motion.rotations[:, leg]), np.abs(plain.rotations[:, leg]), atol=2e-2)
    page.locator(".lane", has_text="layers").locator(".span").wait_for()
    with walking.made():
        page.get_by_label("left arm by turn_left1: from, seconds").fill("1")
        page.get_by_label("left arm by turn_left1: from, seconds").press("Tab")
    assert walking.project.walk.layers[0].start == 1.0
    with walking.made():
        page.get_by_role("button", name="Remove: left arm by turn_left1").click()
    assert walking.project.walk.layers == ()


def test_a_walk_meets_a_pose_and_a_move(walking: Walking) -> None:
    walking.draw(eight(8.0, size=1.4))
    page = walking.page
    walking.stop_at(2.0)
    page.get_by_label("Pose of").select_option("turn_left1")
    page.get_by_label("at its second").fill("0.5")
    with walking.made():
        page.get_by_role("button", name="Add pose now").click()
    (key,) = walking.project.walk.keys
    assert (key.pose, key.time) == ("take:turn_left1@0.5", pytest.approx(2.0, abs=0.04))
    made = walking.server.desk.room.latest["walk"].synthesis
    assert made.met == (pytest.approx(key.time, abs=0.02),)
    page.locator(".lane", has_text="keys").locator(".span").wait_for()
    page.get_by_label("Move", exact=True).fill("turn_left1")
    page.get_by_label("Begins at, s").fill("4")
    page.get_by_label("Ends at, s").fill("5")
    with walking.made():
        page.get_by_role("button", name="Rule it out").click()
    (move,) = walking.project.walk.moves
    assert (move.name, move.start, move.stop, move.forbid) == ("turn_left1", 4.0, 5.0, True)
    made = walking.server.desk.room.latest["walk"].synthesis
    assert not any(p.take == "turn_left1" and p.start < 5 and p.stop > 4 and not p.mirrored for p in made.pieces)
    with walking.made():
        page.get_by_label("Play the recordings of poses").check()
    assert walking.project.walk.fill
    with walking.made():
        page.get_by_role("button", name="Remove: turn_left1@0.5").click()
    with walking.made():
        page.get_by_role("button", name="Remove: no turn_left1, 4 to 5 s").click()
    assert (walking.project.walk.keys, walking.project.walk.moves) == ((), ())


def test_a_walk_meets_a_pose_at_a_place(walking: Walking) -> None:
    walking.draw(eight(8.0, size=1.4))
    page = walking.page
    page.get_by_label("Pose of").select_option("turn_left1")
    page.get_by_label("at its second").fill("0.5")
    places = []
    for second in (5.0, 3.0):  # in order of the path, whichever is asked for first
        walking.stop_at(second)
        walked = np.array(walking.server.desk.room.latest["walk"].path)
        places.append([np.interp(second, walked[:, 0], walked[:, axis]) for axis in (1, 2)])
        with walking.made():
            page.get_by_role("button", name="Add pose here").click()
    for key, (x, z) in zip(walking.project.walk.keys, reversed(places), strict=True):
        assert key.time is None
        assert key.near == (pytest.approx(x, abs=0.05), pytest.approx(z, abs=0.05))
    assert walking.project.walk.fill is None
    assert len(walking.server.desk.room.latest["walk"].synthesis.met) == 2


def test_a_path_is_bent_timed_again_stopped_and_smoothed(walking: Walking) -> None:
    walking.draw(eight(8.0, size=1.4))
    page, before = walking.page, np.array(walking.project.walk.path)
    middle = before[len(before) // 4]
    to = (0.2, float(middle[1]), float(middle[2]) + 0.5)
    with walking.made():  # by the mouse
        walking.stroke([(0.0, float(middle[1]), float(middle[2])), (0.1, to[1], to[2] - 0.2), to])
    bent = np.array(walking.project.walk.path)
    moved = np.linalg.norm(bent[:, 1:] - before[:, 1:], axis=1)
    assert moved[len(before) // 4] == pytest.approx(0.5, abs=0.05)
    assert moved[-1] == 0.0
    np.testing.assert_array_equal(bent[:, 0], before[:, 0])

    walking.choose("Time it again")
    with walking.made():  # the same path at half of its pace
        walking.stroke([(2.0 * t, x, z) for t, x, z in bent[::3].tolist()])
    timed = np.array(walking.project.walk.path)
    assert timed[-1, 0] == pytest.approx(16.0, abs=0.2)
    far = [np.linalg.norm(bent[:, 1:] - row[1:], axis=1).min() for row in timed]
    assert max(far) < 0.03  # the same shape

    walking.stop_at(4.0)
    with walking.made():
        walking.choose("Wait")
    stopped = np.array(walking.project.walk.path)
    assert stopped[-1, 0] == pytest.approx(timed[-1, 0] + 1.0, abs=1e-3)
    still = stopped[(stopped[:, 0] >= 3.9999) & (stopped[:, 0] <= 5.0001)]
    assert np.ptp(still[:, 1:], axis=0).max() < 1e-3

    with walking.made():
        page.get_by_label("Smooth in space").fill("0.5")
    assert walking.project.walk.smooth_space == 0.5
    with walking.made():
        page.get_by_label("Start facing").check()
    assert walking.project.walk.facing is not None


def test_a_path_is_made_changed_and_undone_by_the_keyboard(walking: Walking) -> None:
    page = walking.page
    page.get_by_text("By numbers").focus()
    page.keyboard.press("Enter")
    add = page.get_by_role("button", name="Add point")

    def put(x: float, z: float) -> None:
        page.get_by_label("x, m", exact=True).fill(str(x))
        page.get_by_label("z, m", exact=True).fill(str(z))
        add.focus()
        page.keyboard.press("Enter")

    put(0, 0)
    with walking.made():
        put(0, 2)
    with walking.made():
        put(1, 3.5)
    assert walking.project.walk.path == ((0.0, 0.0, 0.0), (2.0, 0.0, 2.0), (4.0, 1.0, 3.5))
    walking.stop_at(0.0)
    with walking.made():
        page.get_by_role("button", name="Bend", exact=True).focus()
        page.keyboard.press("Enter")
    assert walking.project.walk.path[0][1] == 0.5
    with walking.made():
        page.get_by_role("button", name="Set the pace").focus()
        page.keyboard.press("Enter")
    assert walking.project.walk.path[-1][0] > 4.0
    with walking.made():
        page.get_by_role("button", name="Undo").focus()
        page.keyboard.press("Enter")
    assert walking.project.walk.path[-1][0] == 4.0


def test_a_take_is_played_over_the_ground(walking: Walking) -> None:
    walking.choose("Show its pace")
    walking.wait_for("panels.walk.view.mover.visible")
    first = walking.studio("panels.walk.view.mover.position.z")
    walking.wait_for(f"panels.walk.view.mover.position.z !== {first!r}")
    walking.choose("Show its pace")
    assert walking.studio("panels.walk.view.mover.visible") is False
