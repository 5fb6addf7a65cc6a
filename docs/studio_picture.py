"""The picture of the studio in the README: a walk along a drawn path, made of free recordings.

``make pictures`` writes ``docs/images/studio.png``; it needs playwright and Debian's chromium.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

from kinetograph.pipeline import winding_path
from kinetograph.studio import Project, write_project
from kinetograph.studio.project import Walk

IMAGE = Path(__file__).parent / "images" / "studio.png"
SIZE = {"width": 1280, "height": 800}
SECOND = 6.2  # of the walk
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-dev-shm-usage",
)


def main() -> None:
    """Make the picture."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "project.json"
        write_project(project(), path)
        command = [sys.executable, "-m", "kinetograph", "studio", "--no-browser", "--project", str(path)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as studio:
            assert studio.stdout is not None
            photograph(studio.stdout.readline().removeprefix("studio: ").strip())
            studio.terminate()
    sys.stdout.write(f"{IMAGE}: {IMAGE.stat().st_size / 1e6:.2f} MB\n")


def project() -> Project:
    """The winding path of the demo, walked by a human body."""
    drawn = winding_path()
    path = tuple((frame / drawn.fps, float(x), float(z)) for frame, (x, _, z) in enumerate(drawn.values[:, 0]))
    return Project(character="human", walk=Walk(path=path))


def photograph(address: str) -> None:
    """Take the picture of a page."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        page = browser.new_page(viewport=SIZE, color_scheme="dark")  # type: ignore[arg-type]
        page.goto(address)
        page.wait_for_function("document.body.dataset.state === 'ready' && kinetograph.studio.clip", timeout=300_000)
        page.evaluate(
            """second => {
              const { stage, transport, clip } = kinetograph.studio;
              transport.seek(second);
              const [x, y, z] = clip.root(second);
              stage.controls.target.set(x + 0.4, 0.75, z - 0.6);
              stage.camera.position.set(x + 3.6, 2.6, z + 4.2);
              stage.controls.update();
              stage.render();
            }""",
            SECOND,
        )
        page.wait_for_timeout(1500)  # what stands still is drawn once more, with all its pixels
        page.screenshot(path=str(IMAGE))
        browser.close()


if __name__ == "__main__":
    main()
