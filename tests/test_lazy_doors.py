"""Doors that import their rooms on first use: every name is there, and opening one loads nothing heavy."""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

DOORS = ("kinetograph.learn", "kinetograph.evaluation", "kinetograph.pipeline")


@pytest.mark.parametrize("name", DOORS)
def test_every_name_is_that_of_its_room(name: str) -> None:
    door = importlib.import_module(name)
    tree = ast.parse(Path(str(door.__file__)).read_text())
    rooms = {a.name: n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) for a in n.names if n.module}
    listed = {key: room for key, room in rooms.items() if room.startswith(f"{name}.")}
    assert sorted(listed) == sorted(door.__all__) == dir(door)
    for key, room in listed.items():
        assert getattr(door, key) is getattr(importlib.import_module(room), key)


@pytest.mark.parametrize("name", DOORS)
def test_no_name_is_also_a_room(name: str) -> None:
    door = importlib.import_module(name)
    rooms = {path.stem for path in Path(str(door.__file__)).parent.iterdir()}
    assert not rooms & set(door.__all__), "once the room is imported, the door would give it in place of the name"


@pytest.mark.parametrize("name", DOORS)
def test_a_name_that_is_not_there_is_an_error(name: str) -> None:
    with pytest.raises(AttributeError, match=f"module '{name}' has no attribute 'Nothing'"):
        importlib.import_module(name).Nothing  # noqa: B018


@pytest.mark.parametrize("name", DOORS)
def test_opening_a_door_loads_nothing_heavy(name: str) -> None:
    code = f"import sys, {name}; print(*{{m.split('.')[0] for m in sys.modules}})"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "kinetograph" in loaded
    assert not {"numba", "scipy", "matplotlib", "numpy"} & set(loaded)
