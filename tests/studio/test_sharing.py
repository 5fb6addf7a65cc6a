"""Motions in pages of their own and in notebooks, as text; `test_player` opens them in a browser."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path

import numpy as np
import pytest

import kinetograph.display
import kinetograph.studio.sharing
from bodies import blocks, person
from bodies import walk as person_walk
from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.formats.gltf import read
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.skeleton import Skeleton
from kinetograph.studio.floor import floor_of
from kinetograph.studio.sharing import CELL_BYTES, notebook_html, player_page
from kinetograph.synthesis import Piece, Synthesis
from kinetograph.take import Annotation, Take
from walkers import walk


def clips(page: str) -> list[dict]:
    """The clips of a player's page."""
    found = re.search(r'<script type="application/json" id="clips">(.*?)</script>', page, re.DOTALL)
    assert found
    return json.loads(found[1])["clips"]


@pytest.fixture
def small_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A page's folder with the sizes of a built one, and nothing in it."""
    folder = tmp_path / "page"
    folder.mkdir()
    files = {"player.js": "/* */" * 120_000, "style.css": "", "three.LICENSE.txt": "Permission is hereby granted"}
    for name, text in files.items():
        (folder / name).write_text(text)
    monkeypatch.setattr(kinetograph.studio.sharing, "page_folder", lambda: folder)
    return folder


def no_page() -> Path:
    raise RequestError("the studio's page is not built: run 'make studio'")


def test_a_page_holds_the_motion(small_page: Path, tmp_path: Path) -> None:
    motion = walk(2.0)
    (clip,) = clips(player_page(motion, "A walk"))
    (tmp_path / "clip.glb").write_bytes(base64.b64decode(clip["glb"]))
    held = read(tmp_path / "clip.glb").take.motion()
    assert held.skeleton.names == motion.skeleton.names
    np.testing.assert_allclose(held.translation, motion.translation, atol=1e-6)


def test_titles_and_names_are_text(small_page: Path) -> None:
    page = player_page({"</script><b>x": walk(1.0)}, "<i>A & B</i>")
    assert "<title>&lt;i&gt;A &amp; B&lt;/i&gt;</title>" in page
    assert clips(page)[0]["name"] == "</script><b>x"


def test_the_page_names_the_licence_of_what_it_carries(small_page: Path) -> None:
    assert "Permission is hereby granted" in player_page(walk(1.0))


def test_contacts_are_detected_unless_they_are_known(small_page: Path) -> None:
    motion = walk(2.0)
    (detected,) = clips(player_page(motion))
    assert [lane["name"] for lane in detected["lanes"]] == ["left foot", "right foot"]
    known = Take("walk", {"motion": motion}, (Annotation("motion", "contact", "left_toe", 0.25, 0.5),))
    (kept,) = clips(player_page(known))
    assert kept["lanes"][0]["spans"] == [{"start": 0.25, "stop": 0.5, "label": "left toe"}]
    (none,) = clips(player_page(motion, contacts=False))
    assert "lanes" not in none


def test_pieces_and_notes_of_a_synthesis_are_shown(small_page: Path) -> None:
    motion = walk(2.0)
    pieces = (Piece("a", "motion", 3.0, 4.0, 0.0, 1.0), Piece("b", "motion", 0.0, 1.0, 1.0, 2.0, mirrored=True))
    made = Synthesis(motion, pieces, 1.5, warnings=("said once",), edited=np.full(61, 0.02))
    (clip,) = clips(player_page(made))
    assert [(row["take"], row["source_start"]) for row in clip["pieces"]] == [("a", 3.0), ("b", 0.0)]
    assert clip["warnings"] == ["said once"]
    assert clip["lanes"][-1]["values"] == [2.0] * 61


def test_lanes_name_their_character(small_page: Path) -> None:
    take = Take(
        "duet", {"leader": walk(1.0), "follower": walk(1.0), "music": Signal(np.zeros((9, 1)), ("beat",), "", 9.0)}
    )
    (clip,) = clips(player_page(take))
    assert {lane["name"].split(":")[0] for lane in clip["lanes"]} == {"leader", "follower"}


def test_a_take_without_motion_is_refused(small_page: Path) -> None:
    with pytest.raises(RequestError, match="no motion to show, only the signals path"):
        player_page(Take("drawn", {"path": Signal(np.zeros((9, 1)), ("x",), "m", 9.0)}))


@pytest.mark.parametrize("floor", [0.0, 1.7, -3.0])
def test_the_ground_is_under_the_soles(floor: float) -> None:
    motion = person_walk(person(), floor)  # planted toe joints are 3 cm over the floor
    assert floor_of(motion, blocks(person(), 0.06)) == pytest.approx(floor, abs=0.005)
    assert floor_of(motion, blocks(person(), 0.02)) == pytest.approx(floor + 0.02, abs=0.005)


def test_the_ground_is_under_a_body_without_feet() -> None:
    rod = Skeleton(("root", "end"), np.array([-1, 0]), np.array([[0.0, 0, 0], [0, 0.5, 0]]))
    motion = Motion(rod, np.tile([0.0, 2.0, 0.0], (30, 1)), rot.identity(30, 2), 30.0)
    assert 1.8 < floor_of(motion) <= 2.0


# ---- notebooks ----


def test_a_cell_holds_a_player_that_is_shut_in(small_page: Path) -> None:
    shown = notebook_html(walk(2.0))
    assert shown.startswith('<iframe sandbox="allow-scripts"')
    assert len(shown) < CELL_BYTES + 1000


@pytest.mark.parametrize(("seconds", "fps"), [(120.0, 60.0), (900.0, 30.0)])
def test_long_motions_are_thinned_and_the_cell_says_so(small_page: Path, seconds: float, fps: float) -> None:
    shown = notebook_html(walk(seconds, fps=fps))
    assert 0.8 * CELL_BYTES < len(shown) < CELL_BYTES + 1000
    assert re.search(r"shown at \d+(\.\d+)? frames per second", shown)
    assert (f"of {seconds:.0f} s" in shown) == (seconds > 500)


def test_a_cell_is_text_where_the_page_is_not_built(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kinetograph.studio.sharing, "page_folder", no_page)
    assert (
        notebook_html(walk(2.0))
        == "<pre>Motion, 2.0 s\nthe studio&#x27;s page is not built: run &#x27;make studio&#x27;</pre>"
    )


def test_what_is_shown_in_a_notebook_is_found_by_its_entry_point(monkeypatch: pytest.MonkeyPatch) -> None:
    class Entry:
        def load(self):
            return lambda shown: f"<b>{type(shown).__name__}</b>"

    asked = []
    monkeypatch.setattr("importlib.metadata.entry_points", lambda **what: asked.append(what) or [Entry()])
    motion = walk(1.0)
    made = Synthesis(motion, (Piece("a", "motion", 0.0, 1.0, 0.0, 1.0),), 1.0)
    shown = [each._repr_html_() for each in (motion, Take("t", {"motion": motion}), made)]
    assert shown == ["<b>Motion</b>", "<b>Take</b>", "<b>Synthesis</b>"]
    assert asked[0] == {"group": "kinetograph.displays", "name": "html"}


def test_without_anything_that_draws_a_motion_is_a_line_of_text(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.metadata.entry_points", lambda **_: [])
    motion = walk(1.0)
    made = Synthesis(motion, (Piece("a", "motion", 0.0, 1.0, 0.0, 1.0),), 1.0)
    shown = [kinetograph.display.notebook_html(each) for each in (motion, Take("t", {"motion": motion}), made)]
    assert shown == ["<pre>Motion, 1.0 s</pre>", "<pre>Take, 1.0 s</pre>", "<pre>Synthesis, 1.0 s</pre>"]


# ---- commands ----


def test_the_demo_goes_on_without_a_page(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys) -> None:
    from kinetograph.cli.demo import write_page

    monkeypatch.setattr(kinetograph.studio.sharing, "page_folder", no_page)
    made = Synthesis(walk(1.0), (Piece("a", "motion", 0.0, 1.0, 0.0, 1.0),), 1.0)
    assert write_page(tmp_path, {"walk": made}) is None
    assert (
        capsys.readouterr().err == "without a page of the results: the studio's page is not built: run 'make studio'\n"
    )
    assert not list(tmp_path.iterdir())
