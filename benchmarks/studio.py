"""The studio's page in a browser: from a drawn path to a walk that moves, and from a pose that is sent to its frame.

Both in Debian's chromium without a graphics card. The walk is measured from the release of the pointer to the second
frame after the page is ready; the server is a process of its own, and its model is fitted. A pose is measured from
before it is sent until its frame is drawn to the last pixel.
"""

from __future__ import annotations

import asyncio
import contextlib
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from kinetograph.errors import KinetographError

if TYPE_CHECKING:
    from playwright.sync_api import Page

COUNT, SECONDS = 20, 17.0
POSES, RATE = 300, 30.0
SIZE = (640, 400)
FLAGS = (
    *("--headless", "--no-sandbox", "--disable-dev-shm-usage", "--no-first-run"),
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
)
WAIT = 180_000  # milliseconds
DRAW = """async rows => {
  const { stage, store } = window.kinetograph.studio;
  const before = store.made?.key;
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
  await new Promise((resolve) => setTimeout(resolve, 300)); // what was sent of the stroke is done with
  const released = performance.now();
  fire("pointerup", rows[rows.length - 1], 0);
  const made = () => document.body.dataset.state === "ready" && store.made?.key !== before;
  while (!made()) await new Promise((resolve) => setTimeout(resolve, 1));
  for (let i = 0; i < 2; i++) await new Promise(requestAnimationFrame);
  return performance.now() - released;
}"""
WATCH = """() => {
  const { stage, connection, panels } = window.kinetograph.studio;
  const gl = stage.renderer.getContext();
  const render = stage.renderer.render.bind(stage.renderer);
  const pixel = new Uint8Array(4);
  window.seen = [];
  let sent = null;
  connection.on("pose", (values) => (sent = values[0]));
  stage.renderer.render = (scene, camera) => {
    render(scene, camera);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    if (sent !== null) window.seen.push([sent, performance.timeOrigin + performance.now()]);
    sent = null;
  };
  panels.walk.follower.start({ rows: [], now: [] });
}"""


def main() -> None:
    chromium = shutil.which("chromium")
    if chromium is None:
        print("no chromium: apt-get install chromium")
        return
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        print("no playwright: pip install playwright")
        return
    try:
        from kinetograph.studio.page import page_folder
        from kinetograph.studio.sample import sample_libraries

        page_folder()
        walks = sample_libraries()["walks"]
    except KinetographError as error:
        print(error)
        return
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        with _studio(walks) as address:
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            _walks(page, address)
            page.close()  # it would go on to play what it was shown
        with _streaming(walks) as (address, begun):
            _poses(browser.new_page(viewport={"width": 940, "height": 560}), address, begun)
        browser.close()


def _walks(page: Page, address: str) -> None:
    """From the release to a character that moves."""
    page.goto(address)
    page.locator(".speed p", has_text="The library has").wait_for(timeout=WAIT)
    took = []
    for number in range(COUNT):
        page.get_by_role("button", name="Draw", exact=True).click()
        took.append(page.evaluate(DRAW, _path(1.5 + 0.05 * number)))
    low, high, most = (np.quantile(took, q) for q in (0.5, 0.95, 1.0))
    print(f"drawn path of {SECONDS:.0f} s, released, to a walk that moves; {COUNT} paths, ms")
    print(f"  p50 {low:6.0f}   p95 {high:6.0f}   most {most:6.0f}   first {took[0]:6.0f}")


def _path(size: float) -> list[list[float]]:
    """An eight on the ground, as a mouse's events at 60 Hz."""
    times = np.arange(int(60 * SECONDS) + 1) / 60
    angle = 2 * np.pi * times / SECONDS
    rows = np.column_stack([times, size * np.sin(angle), size * np.sin(angle) * np.cos(angle)])
    return [[float(value) for value in row] for row in rows]


def _poses(page: Page, address: str, begun: float) -> None:
    """From a pose that is sent to its frame."""
    page.goto(address)
    page.locator(".speed p", has_text="The library has").wait_for(timeout=WAIT)
    for _ in range(3):  # until the canvas has the size that is wanted
        box = page.evaluate(
            "(({ clientWidth, clientHeight }) => [clientWidth, clientHeight])(window.kinetograph.studio.stage.canvas)"
        )
        view = page.viewport_size or {"width": 0, "height": 0}
        page.set_viewport_size({"width": view["width"] + SIZE[0] - box[0], "height": view["height"] + SIZE[1] - box[1]})
        page.wait_for_timeout(300)
    page.evaluate(WATCH)
    while page.evaluate("window.seen.length ? window.seen[window.seen.length - 1][0] : 0") < (POSES - 2) / RATE:
        page.wait_for_timeout(500)
    seen = np.array(page.evaluate("window.seen"))
    late = seen[:, 1] - 1000 * (begun + _Clock.start + seen[:, 0])
    rate = (len(seen) - 1) / (seen[-1, 1] - seen[0, 1]) * 1000
    box = page.evaluate(
        "(({ clientWidth, clientHeight }) => [clientWidth, clientHeight])(window.kinetograph.studio.stage.canvas)"
    )
    low, high, most = (np.quantile(late, q) for q in (0.5, 0.95, 1.0))
    print(
        f"live pose, sent {RATE:.0f} times a second, to its frame of {box[0]} x {box[1]} pixels; "
        f"{len(seen)} of {POSES} drawn, ms"
    )
    print(f"  p50 {low:6.1f}   p95 {high:6.1f}   most {most:6.1f}   frames a second {rate:.1f}")


class _Clock:
    """When the first pose was sent, in seconds after the server's start."""

    start = 0.0


@contextlib.contextmanager
def _studio(walks: Path) -> Iterator[str]:
    """The command, in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "kinetograph", "studio", str(walks), "--no-browser"]
        command += ["--project", str(Path(folder) / "project.json")]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
            assert process.stdout is not None
            yield process.stdout.readline().removeprefix("studio: ").strip()
            process.terminate()


@contextlib.contextmanager
def _streaming(walks: Path) -> Iterator[tuple[str, float]]:
    """A server that sends the poses of a walk at an even rate to who asks for a live walk; and when it began."""
    from kinetograph.studio import registry as making
    from kinetograph.studio.desk.desk import Desk
    from kinetograph.studio.messages import LiveHeader, WalkLive, blob, pose_frame
    from kinetograph.studio.project import Project, Walk
    from kinetograph.studio.room import Room
    from kinetograph.studio.serving.server import Server
    from kinetograph.studio.walk.live import ready
    from kinetograph.studio.walk.making import make

    begun = time.time()

    async def stream(room: Room, project: Project, message: Any, inbox: Any, send: Any) -> None:
        path = tuple((t, x, z) for t, x, z in _path(2.0))
        drawn = Project(libraries=project.libraries, walk=Walk(path=path))
        made = await asyncio.to_thread(make, drawn, room, lambda done, total: None)
        _, body = await asyncio.to_thread(ready, project, room)
        assert made is not None
        motion = made.synthesis.motion
        send(blob(LiveHeader("walk"), body))
        await asyncio.sleep(1.0)
        _Clock.start = time.time() - begun
        for number in range(POSES):
            await asyncio.sleep(max(begun + _Clock.start + number / RATE - time.time(), 0.0))
            frame = number % len(motion)
            now = time.time() - begun - _Clock.start
            send(pose_frame(now, motion.translation[frame], motion.rotations[frame], None))

    with tempfile.TemporaryDirectory() as folder:
        kept = making.RUNS
        making.RUNS = {**kept, WalkLive: stream}
        loop, stop, serving = asyncio.new_event_loop(), asyncio.Event(), threading.Event()
        addresses: list[str] = []

        async def serve() -> None:
            desk = Desk(Path(folder) / "project.json", Project(libraries={"walks": str(walks)}))
            async with Server(desk).running() as server:
                addresses.append(server.address)
                serving.set()
                await stop.wait()

        thread = threading.Thread(target=lambda: loop.run_until_complete(serve()))
        thread.start()
        serving.wait(30)
        try:
            yield addresses[0], begun
        finally:
            loop.call_soon_threadsafe(stop.set)
            thread.join(20)
            making.RUNS = kept


if __name__ == "__main__":
    main()
