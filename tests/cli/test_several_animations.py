"""Files of several animations on the command line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from command_line import answer, invoke

from gltf_files import animated, spun, written
from kinetograph import rotations as rot
from kinetograph.formats import read, save
from kinetograph.library import Library
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton

NODES = [{"name": "a", "children": [1]}, {"name": "b", "translation": [0, 1, 0]}]
STICK = Motion(Skeleton(("a",), np.array([-1]), np.zeros((1, 3))), np.zeros((5, 3)), rot.identity(5, 1), 30.0)


@pytest.fixture
def three(tmp_path: Path) -> Path:
    animations = [("Idle", [spun(0)]), ("Turn", [spun(90)]), ("Turn", [spun(45)]), (None, [spun(10)])]
    return written(tmp_path / "three.gltf", animated(NODES, animations))


def test_convert_keeps_the_name_through_editing_and_formats(three: Path, tmp_path: Path) -> None:
    pytest.importorskip("pxr", reason="usd-core is not installed")
    answer("convert", three, tmp_path / "a.usdc", "--animation", "Turn", "--start", 0.5)
    answer("convert", tmp_path / "a.usdc", tmp_path / "b.glb")
    loaded = read(tmp_path / "b.glb")
    assert loaded.take.animation == "Turn"
    assert len(loaded.take.motion()) == 16


def test_info_lists_them(three: Path) -> None:
    said = answer("info", three)
    assert "read 'Idle', not 'Turn', 'Turn_2', '4'" in said.stderr
    said = answer("info", three, "--animation", "Turn")
    assert "its animations are 'Idle', 'Turn', 'Turn_2', '4'" in said.stderr
    assert '"animations": ["Idle", "Turn", "Turn_2", "4"]' in answer("info", three, "--json").stdout


def test_a_library_takes_all_of_them(three: Path, tmp_path: Path) -> None:
    save(STICK, tmp_path / "walk.bvh")
    answer("library", "create", tmp_path / "all", three, tmp_path / "walk.bvh")
    assert Library.open(tmp_path / "all").names() == ("three:Idle", "three:Turn", "three:Turn_2", "three:4", "walk")
    answer("library", "create", tmp_path / "one", three, "--animation", "Turn")
    library = Library.open(tmp_path / "one")
    assert library.names() == ("three:Turn",)
    assert np.degrees(rot.twist(library.take("three:Turn").motion().rotations[-1, 0], "y")) == pytest.approx(
        90, abs=1e-3
    )


def test_library_add_takes_all_or_the_one_chosen(three: Path, tmp_path: Path) -> None:
    answer("library", "create", tmp_path / "library")
    answer("library", "add", tmp_path / "library", "--take", "x", f"a={three}", f"b={three}")
    answer("library", "add", tmp_path / "library", "--take", "y", f"motion={three}", "--animation", "Turn")
    library = Library.open(tmp_path / "library")
    assert library.names() == ("x:Idle", "x:Turn", "x:Turn_2", "x:4", "y")
    assert list(library.take("x:Turn").tracks) == ["a", "b"]
    save(STICK, tmp_path / "walk.bvh")
    failed = invoke("library", "add", tmp_path / "library", "--take", "z", f"a={tmp_path / 'walk.bvh'}", f"b={three}")
    assert "b has the animations Idle, Turn, Turn_2, 4: choose one with --animation" in str(failed.exception)
