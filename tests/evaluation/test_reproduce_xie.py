from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.evaluation.reproduce.xie2009 import METHODS, reproduce, run
from kinetograph.evaluation.reproduce.xie2009.strokes import Strokes, cut_strokes, find_strokes, wide_layout
from kinetograph.library import Library
from kinetograph.methods.sensor import LocalModelSettings
from kinetograph.motion import Motion
from kinetograph.sensing import PRESETS
from kinetograph.take import Take
from walkers import walk


def test_the_page_has_a_row_for_each_method_and_its_pictures(tmp_path: Path):
    library = Library.create(tmp_path / "lib")
    for name, speed in (("a", 0.8), ("b", 1.0), ("c", 1.2)):
        library.add(Take(name, {"motion": walk(2.0, speed=speed)}))
    small = LocalModelSettings(runs=1, clusters=4, frames=150, centres=40)
    rows = reproduce(tmp_path / "out", library, takes=("b",), local=small)
    assert [row.method for row in rows] == list(METHODS)
    page = (tmp_path / "out" / "index.html").read_text()
    for heading in ("Table 7.1", "Table 7.2", "Section 7.3", "Figure 7.5", "Figure 7.6", "Not comparable"):
        assert f"<h2>{heading}" in page
    assert "<td>thesis<td>tennis forehand<td>256<td>0.21<td>4.9" in page
    assert "<td>thesis<td>tennis backhand<td>206<td>0.057" in page
    assert all(f"{row.rms:.3f}" in page for row in rows)
    numbers = json.loads((tmp_path / "out" / "numbers.json").read_text())
    assert [row["angle"] for row in numbers["takes"]] == [row.angle for row in rows]
    assert all(row.least == row.angle == row.most for row in rows)  # of one seed
    assert "Tennis is left out: no folder" in page
    for picture in ("b_rms.png", "b_interpolation.png", "b_optimisation.png", "b_optimisation_ahead.png"):
        assert picture in page
        assert (tmp_path / "out" / picture).stat().st_size > 5000
    with pytest.raises(RequestError, match="is not empty; name a new folder"):
        reproduce(tmp_path / "out", library)


def swings(at: tuple[float, ...], seconds: float) -> Motion:
    """A body that stands, and swings its left arm round at some times."""
    still = walk(seconds, fps=50.0)
    rotations = np.zeros_like(still.rotations)
    rotations[..., 0] = 1.0
    times = np.arange(len(still)) / still.fps
    angle = sum((np.pi * (1 + np.tanh((times - t) / 0.1)) for t in at), np.zeros(len(times)))
    arm = still.skeleton.names.index("left_shoulder")
    rotations[:, arm] = rot.exp(angle[:, None] * np.array([0.0, 0.0, 1.0]))
    return Motion(still.skeleton, still.translation, rotations, still.fps)


def test_strokes_are_cut_about_the_fastest_hand_and_whole() -> None:
    cut = cut_strokes(swings((1.0, 4.0, 8.0), 12.0))
    assert [len(stroke) for stroke in cut] == [150, 150]  # the first begins before the recording
    assert cut_strokes(swings((), 6.0)) == []


def test_the_wide_device_differs_in_its_range_alone() -> None:
    near, far = PRESETS["wii"].device, wide_layout().device
    assert near.bits is not None
    assert far.bits is not None
    assert far.span / 2**far.bits == pytest.approx(near.span / 2**near.bits)
    assert far.span == 8 * near.span


def test_what_is_no_stroke_is_named(tmp_path: Path) -> None:
    assert "expected C3D files of markers, found none" in find_strokes(tmp_path / "nowhere").notes[0]
    (tmp_path / "bad.c3d").write_bytes(b"no C3D file")
    strokes = find_strokes(tmp_path)
    assert not strokes.takes
    assert strokes.notes[0].startswith("bad.c3d is left out: ")


def test_strokes_are_a_library_of_their_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    library = Library.create(tmp_path / "lib")
    for name, speed in (("a", 0.8), ("b", 1.0)):
        library.add(Take(name, {"motion": walk(1.5, speed=speed)}))
    motions = {(f"serve_{i}", "motion"): walk(1.5, speed=0.9 + 0.2 * i) for i in (1, 2)}
    monkeypatch.setattr(run, "find_strokes", lambda folder: Strokes({"serve": motions}, ("x.c3d is left out: y",)))
    small = LocalModelSettings(runs=1, clusters=2, frames=100, centres=30)
    rows = reproduce(tmp_path / "out", library, takes=("b",), serves=tmp_path, local=small, seeds=2)
    assert all(row.least <= row.angle <= row.most for row in rows)
    assert [row.take for row in rows[:: len(METHODS)]] == ["b", "serve_1", "serve_2"]
    page = (tmp_path / "out" / "index.html").read_text()
    assert "x.c3d is left out: y" in page
    assert "<td>here<td>serve_1<td>" in page
    assert "<td>strokes<td>PCA, interpolation<td>2" in page
    assert "degrees, 24 g" in page
    assert (tmp_path / "out" / "serve_2_rms.png").exists()


def test_real_serves(data_folder: Path) -> None:
    strokes = find_strokes(data_folder / "c3d")
    serves = strokes.takes["kinematics_tennis_serve"]
    assert len(serves) == 5
    assert len({serve.skeleton for serve in serves.values()}) == 1
    assert sum("is left out: no five markers of any known set" in note for note in strokes.notes) == 4


def test_a_run_that_is_stopped_keeps_what_it_has(tmp_path: Path) -> None:
    library = Library.create(tmp_path / "lib")
    for name, speed in (("a", 0.8), ("b", 1.0)):
        library.add(Take(name, {"motion": walk(1.5, speed=speed)}))

    def report(text: str) -> None:
        if text.startswith("b:"):
            raise KeyboardInterrupt

    small = LocalModelSettings(runs=1, clusters=2, frames=100, centres=30)
    with pytest.raises(KeyboardInterrupt):
        reproduce(tmp_path / "out", library, takes=("a", "b"), local=small, report=report)
    numbers = json.loads((tmp_path / "out" / "numbers.json").read_text())
    assert {row["take"] for row in numbers["takes"]} == {"a"}
    assert "<td>here<td>a<td>" in (tmp_path / "out" / "index.html").read_text()
