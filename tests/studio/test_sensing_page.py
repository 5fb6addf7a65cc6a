"""The page's sensors in a browser: readings of the sample's clips, a live body, and calibration."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

pytest.importorskip("websockets", reason="the extra 'studio' is not installed")

from rooms import served

from kinetograph import rotations as rot
from kinetograph.formats.readings import write_readings
from kinetograph.kinematics import joint_positions
from kinetograph.library import Library
from kinetograph.methods.performance import PerformanceControl
from kinetograph.motion import Motion
from kinetograph.pipeline import perform, winding_path
from kinetograph.sensing import Layout, preset, simulate
from kinetograph.studio.project import Project
from kinetograph.studio.registry import SECTIONS
from kinetograph.studio.room import FILES
from kinetograph.studio.sample import sample_libraries
from kinetograph.studio.sensors import live as sensor_live
from kinetograph.studio.serving.server import Server

if TYPE_CHECKING:
    from playwright.sync_api import Page

HELD = "humanoid3d_walk"


def askew(layout: Layout, seed: int) -> Layout:
    """Each sensor rotated on its bone."""
    vectors = np.random.default_rng(seed).normal(scale=0.5, size=(len(layout.sensors), 3))
    sensors = [
        replace(s, rotation=rot.multiply(s.rotation, rot.exp(v))) for s, v in zip(layout.sensors, vectors, strict=True)
    ]
    return replace(layout, sensors=tuple(sensors))


def misplaced(layout: Layout) -> Layout:
    """The sensor of the left forearm on the left thigh."""
    by_name = {sensor.name: sensor for sensor in layout.sensors}
    there = replace(by_name["left_thigh"], name="left_forearm", rotation=by_name["left_forearm"].rotation)
    return replace(layout, sensors=tuple(there if s.name == "left_forearm" else s for s in layout.sensors))


def stand_then(motion: Motion, seconds: float) -> Motion:
    """The motion after standing still, arms hanging."""
    count = round(seconds * motion.fps)
    return replace(
        motion,
        translation=np.concatenate([np.repeat(motion.translation[:1], count, axis=0), motion.translation]),
        rotations=np.concatenate([rot.identity(count, len(motion.skeleton)), motion.rotations]),
    )


@pytest.fixture(scope="module")
def server(clips_folder: Path, tmp_path_factory: pytest.TempPathFactory, built_page: Path) -> Iterator[Server]:
    folder = tmp_path_factory.mktemp("sensors") / "studio"
    files = folder / FILES
    files.mkdir(parents=True)
    walks = sample_libraries()["walks"]
    walked = perform(winding_path(0.95), Library.open(walks), PerformanceControl(mirror=True)).motion
    performed = stand_then(walked, 3.0)
    write_readings(simulate(walked, preset("wii")), files / "readings.csv")
    write_readings(simulate(performed, askew(preset("wii"), 0)), files / "worn.csv")
    write_readings(simulate(performed, misplaced(askew(preset("wii"), 0))), files / "wrong.csv")
    with served(folder, Project(mode="sensors", libraries={"walks": str(walks)}), SECTIONS) as running:
        yield running


@pytest.fixture
def studio(server: Server, page: Page) -> Page:
    page.goto(server.address)
    page.wait_for_selector("[aria-label='Readings'] option[value^='take:']", state="attached")
    return page


def ready(page: Page) -> None:
    page.wait_for_function("['ready', 'error'].includes(document.body.dataset.state)", timeout=120_000)
    assert page.evaluate("document.body.dataset.state") == "ready", page.inner_text(".status")


def choose(page: Page, readings: str, layout: str = "wii") -> None:
    page.get_by_label("Layout", exact=True).select_option(layout)
    page.locator("section[aria-label='Readings'] select").first.select_option(readings)
    ready(page)


def test_readings_of_a_clip_that_is_held_out_give_a_body_its_truth_and_lanes(studio: Page, server: Server) -> None:
    choose(studio, f"take:{HELD}")
    made = server.desk.room.latest["sensors"]
    lanes = studio.locator(".lane-name").all_inner_texts()
    assert {"error, °", "uncertainty, °", "left forearm"} <= set(lanes)
    figures = studio.inner_text("section[aria-label='Figures']")
    assert made.figures[0].value in figures
    for name, motion in (("motion", made.synthesis.motion), ("truth", made.others["truth"])):
        for seconds in np.linspace(0.0, motion.duration, 5):
            frame = round(seconds * motion.fps)
            shown = studio.evaluate("t => kinetograph.pose(t)", frame / motion.fps)
            places = np.array([shown[f"{name}/{joint}"] for joint in motion.skeleton.names])
            np.testing.assert_allclose(places, joint_positions(motion)[frame], atol=1e-3)
    # where it is uncertain the body has another colour
    studio.wait_for_function("document.querySelector('.sensors').innerText.includes('Most uncertain')")
    colours = """() => { const g = kinetograph.studio.clip.figures[0].body.geometry.getAttribute('color');
                         return Array.from(g.array.slice(0, 3000)); }"""
    coloured = studio.evaluate(colours)
    studio.get_by_label("Colour by uncertainty").uncheck()
    assert np.abs(np.array(coloured) - studio.evaluate(colours)).max() > 0.05
    studio.get_by_label("Colour by uncertainty").check()
    studio.get_by_label("Show the recorded body").uncheck()
    assert studio.evaluate("kinetograph.studio.clip.figures[1].object.visible") is False


def test_a_file_that_has_no_readings_is_refused_in_words(studio: Page, server: Server, tmp_path: Path) -> None:
    path = tmp_path / "list.csv"
    path.write_text("milk,2\neggs,6\n")
    studio.get_by_label("A readings file or a layout").set_input_files(path)
    studio.wait_for_function("document.querySelector('.status').innerText.includes('list.csv is not kept as readings')")
    good = tmp_path / "again.csv"
    good.write_bytes((server.desk.room.folder / FILES / "readings.csv").read_bytes())
    studio.get_by_label("A readings file or a layout").set_input_files(good)
    studio.wait_for_function("kinetograph.studio.store.project.sensors?.readings === 'again.csv'")
    ready(studio)
    assert not server.desk.room.latest["sensors"].others  # no truth is known


def test_a_replay_is_drawn_as_it_comes(studio: Page, server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    sent: dict[float, float] = {}
    pack = sensor_live.pose_frame

    def timed(at: float, *rest: Any) -> bytes:
        sent[float(np.float32(at))] = 1000 * time.time()
        return pack(at, *rest)

    monkeypatch.setattr(sensor_live, "pose_frame", timed)
    studio.set_viewport_size({"width": 940, "height": 640})
    live = studio.locator("section[aria-label='Live']")
    live.get_by_label("From").select_option("replay")
    live.get_by_label("File").select_option("readings.csv")
    live.get_by_role("button", name="Start listening").click()
    studio.wait_for_function("kinetograph.studio.panels.sensors.live.drawn.length > 100", timeout=120_000)
    assert "left forearm" in live.inner_text()
    first = studio.evaluate("kinetograph.pose(0)")
    studio.wait_for_function("kinetograph.studio.panels.sensors.live.drawn.length > 150", timeout=60_000)
    moved = studio.evaluate("kinetograph.pose(0)")
    root = next(iter(first))
    assert np.linalg.norm(np.subtract(first[root], moved[root])) > 0.02
    assert len(moved) == 15  # one body, in metres
    assert 0.6 < moved[root][1] < 1.1
    drawn = studio.evaluate("kinetograph.studio.panels.sensors.live.drawn")
    assert np.all(np.diff([each["pose"] for each in drawn]) > 0)  # no older pose after a newer one
    lags = [
        each["drawn"] - sent[float(np.float32(each["pose"]))]
        for each in drawn
        if float(np.float32(each["pose"])) in sent
    ]
    assert len(lags) > 100
    assert min(lags) > -5
    live.get_by_role("button", name="Stop listening").click()
    assert live.get_by_role("button", name="Start listening").is_visible()
    assert studio.evaluate("kinetograph.studio.panels.sensors.live.body") is None


def calibrated(page: Page, readings: str) -> dict[str, str]:
    """Calibrate on a file; the words by sensor."""
    choose(page, readings)
    part = page.locator("section[aria-label='Calibration']")
    part.get_by_label("From", exact=True).select_option("file")
    part.get_by_label("until").fill("2.8")
    part.get_by_role("button", name="Calibrate").click()
    page.wait_for_selector(".calibrated table", timeout=180_000)
    return dict(
        zip(
            part.locator(".calibrated th").all_inner_texts(),
            part.locator(".calibrated td").all_inner_texts(),
            strict=True,
        )
    )


def test_sensors_that_are_worn_askew_are_calibrated_and_one_on_another_limb_is_found(
    studio: Page, server: Server
) -> None:
    words = calibrated(studio, "worn.csv")
    assert len(words) == 8
    assert set(words.values()) == {"good"}
    ready(studio)
    assert studio.evaluate("kinetograph.studio.store.project.sensors.layout") == "worn.toml"
    assert server.desk.history.project.sensors.layout == "worn.toml"
    studio.get_by_role("button", name="Undo").click()
    ready(studio)
    words = calibrated(studio, "wrong.csv")
    assert words["left forearm"] == "put it on again"
    assert "left thigh" in studio.inner_text(".calibrated")
    assert sum(word == "put it on again" for word in words.values()) == 1


def test_live_sense_shows_its_body_on_a_page(page: Page, server: Server, clips_folder: Path, tmp_path: Path) -> None:
    folder = server.desk.room.folder
    library = server.desk.history.project.libraries["walks"]
    command = [sys.executable, "-m", "kinetograph", "live", "sense", "-l", library, "--to", "studio"]
    command += ["--from", f"replay:{folder / FILES / 'readings.csv'}"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            found = re.fullmatch(r"studio: (http://127\.0\.0\.1:\d+/\?token=\S+)\n", process.stdout.readline())
            assert found
            page.goto(found[1])
            page.wait_for_function("kinetograph.studio.panels.sensors.live.drawn.length > 30", timeout=120_000)
            shown = page.evaluate("kinetograph.pose(0)")
            assert 0.6 < next(iter(shown.values()))[1] < 1.1
            page.wait_for_function("document.querySelector('.sensors').innerText.includes('Most uncertain')")
        finally:
            process.send_signal(signal.SIGINT)
        out, said = process.communicate(timeout=60)
    assert process.returncode == 0, said
    assert int(out.split("frames")[1].split()[0]) > 30
