"""What of the Blender extension needs no Blender: its zip, its axes, and how it talks to kinetograph."""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import os
import signal
import stat
import sys
import time
import tomllib
import zipfile
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.service import METHODS, PROTOCOL

EXTENSION = Path(__file__).resolve().parents[2] / "blender"


def module(name: str) -> ModuleType:
    """A module of the extension that imports nothing of Blender."""
    sys.path.insert(0, str(EXTENSION))
    try:
        spec = importlib.util.spec_from_file_location(f"extension_{name}", EXTENSION / f"{name}.py")
        assert spec is not None
        assert spec.loader is not None
        loaded = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(loaded)
    finally:
        sys.path.remove(str(EXTENSION))
    return loaded


link, axes, build = module("link"), module("axes"), module("build")


def answer(ticket: Any, of: Any, seconds: float = 60.0) -> Any:
    end = time.monotonic() + seconds
    while not ticket.done and time.monotonic() < end:
        of.pump()
        time.sleep(0.005)
    return ticket


def program(folder: Path, text: str) -> str:
    path = folder / "stand-in"
    path.write_text(f"#!{sys.executable}\n{text}")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


STAND_IN = """
import json, sys
for line in sys.stdin:
    asked = json.loads(line)
    if asked["method"] == "hello":
        print(json.dumps({"id": asked["id"], "result": {"protocol": 1, "version": "9"}}), flush=True)
    THEN
"""


def test_the_zip_is_the_same_whenever_it_is_built(tmp_path: Path) -> None:
    one, other = build.build(tmp_path / "a"), build.build(tmp_path / "b")
    assert hashlib.sha256(one.read_bytes()).digest() == hashlib.sha256(other.read_bytes()).digest()
    assert one.stat().st_size < 80_000
    with zipfile.ZipFile(one) as archive:
        names = archive.namelist()
        assert names == sorted(names)
        assert {"__init__.py", "blender_manifest.toml", "LICENSE"} <= set(names)
        assert "build.py" not in names
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    assert manifest["schema_version"] == "1.0.0"
    assert manifest["license"] == ["SPDX:GPL-3.0-or-later"]
    assert set(manifest["permissions"]) == {"files", "network"}


@pytest.mark.parametrize("path", sorted(EXTENSION.glob("*.py")), ids=lambda path: path.name)
def test_the_extension_imports_nothing_of_kinetograph(path: Path) -> None:
    assert path.read_text().startswith("# SPDX-License-Identifier: GPL-3.0-or-later\n")
    for node in ast.walk(ast.parse(path.read_text())):
        names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
        names += [node.module or ""] if isinstance(node, ast.ImportFrom) and not node.level else []
        assert not any(name.split(".")[0] == "kinetograph" for name in names)


def test_every_request_of_the_extension_is_known() -> None:
    asked = {
        node.value.elts[0].value
        for path in EXTENSION.glob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Yield)
        and isinstance(node.value, ast.Tuple)
        and isinstance(node.value.elts[0], ast.Constant)
    }
    assert {"walk", "inbetween", "roles"} <= asked <= set(METHODS)
    assert link.PROTOCOL == PROTOCOL


def test_axes_are_exchanged_as_rotations_do() -> None:
    rng = np.random.default_rng(0)
    points, turns = rng.normal(size=(50, 3)), rot.normalize(rng.normal(size=(50, 4)))
    assert np.allclose(axes.to_z_up(axes.to_y_up(points)), points)
    assert np.allclose(axes.to_y_up([0.0, 0.0, 1.0]), [0.0, 1.0, 0.0])
    expected = axes.to_y_up(axes.rotate(turns, points))
    assert np.allclose(axes.rotate(axes.turned_to_y_up(turns), axes.to_y_up(points)), expected)
    assert np.allclose(axes.turned_to_z_up(axes.turned_to_y_up(turns)), turns)


def test_rotations_are_those_of_the_library() -> None:
    rng = np.random.default_rng(1)
    one, other, points = rot.normalize(rng.normal(size=(2, 60, 4))), rot.normalize(rng.normal(size=(60, 4))), None
    del points
    assert np.allclose(axes.multiply(one[0], other), rot.multiply(one[0], other))
    vectors = rng.normal(size=(60, 3))
    assert np.allclose(axes.rotate(one[0], vectors), rot.rotate(one[0], vectors))
    back = axes.quaternions(axes.matrices(one))
    assert np.allclose(np.abs((back * one).sum(axis=-1)), 1.0)
    half_turns = np.array([[0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.0, 0.6, 0.8, 0.0]])
    assert np.allclose(np.abs((axes.quaternions(axes.matrices(half_turns)) * half_turns).sum(axis=-1)), 1.0)


def test_a_request_is_answered_by_kinetograph_itself(tmp_path: Path) -> None:
    wrapper = program(
        tmp_path,
        f"import os, sys\nos.execv({sys.executable!r}, [{sys.executable!r}, '-m', 'kinetograph', *sys.argv[1:]])",
    )
    talking = link.Link([wrapper])
    try:
        ticket = answer(talking.ask("look", {"library": str(tmp_path / "none")}), talking)
        assert "not a library" in ticket.error
        assert talking.version
        again = answer(talking.ask("look", {"library": str(tmp_path)}), talking)
        assert "not a library" in again.error or "catalogue" in again.error
    finally:
        talking.close()


def test_progress_and_notes_arrive_before_the_end(tmp_path: Path) -> None:
    then = """else:
        for more in ({"progress": [1, 4]}, {"note": "slow"}, {"result": {"a": 1}}):
            print(json.dumps({"id": asked["id"], **more}), flush=True)"""
    talking = link.Link([program(tmp_path, STAND_IN.replace("THEN", then))])
    ticket = answer(talking.ask("walk", {}), talking)
    assert (ticket.progress, ticket.notes, ticket.result) == ((1, 4), ["slow"], {"a": 1})
    talking.close()


def test_a_request_that_is_not_given_up_in_time_ends_the_process(tmp_path: Path) -> None:
    talking = link.Link([program(tmp_path, STAND_IN.replace("THEN", "else:\n        pass"))])
    ticket = talking.ask("walk", {})
    talking.cancel(ticket)
    assert ticket.error == "cancelled"
    assert not talking.alive


def test_a_process_that_dies_is_started_again(tmp_path: Path) -> None:
    then = """elif asked["method"] == "walk":
        sys.exit(7)
    else:
        print(json.dumps({"id": asked["id"], "result": {"a": 1}}), flush=True)"""
    talking = link.Link([program(tmp_path, STAND_IN.replace("THEN", then))])
    assert "ended unexpectedly (status 7)" in answer(talking.ask("walk", {}), talking).error
    assert answer(talking.ask("look", {}), talking).result == {"a": 1}
    os.kill(talking._process.pid, signal.SIGKILL)
    time.sleep(0.2)
    assert answer(talking.ask("look", {}), talking).result == {"a": 1}
    talking.close()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("import sys; sys.stderr.write(\"No such command 'serve'.\"); sys.exit(2)", "is an older kinetograph"),
        ("raise ImportError('numba')", "is not a kinetograph that works: .*numba"),
        ("print('hello')", "did not answer as kinetograph does"),
    ],
)
def test_what_is_no_kinetograph_is_said_in_words(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(link.Trouble, match=words):
        link.Link([program(tmp_path, text)]).ask("walk", {})


def test_a_program_that_is_not_there_is_named() -> None:
    with pytest.raises(link.Trouble, match="/nowhere/kinetograph cannot be started"):
        link.Link(["/nowhere/kinetograph"]).ask("walk", {})


def test_kinetograph_is_found_where_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    finding = module("finding")
    monkeypatch.setenv("PATH", str(tmp_path / "none"))
    with pytest.raises(Exception, match="not installed: press Install"):
        finding.command("", str(tmp_path / "managed"))
    made = finding.in_environment(tmp_path / "managed")
    made.parent.mkdir(parents=True)
    made.write_text("")
    assert finding.command("", str(tmp_path / "managed")) == [str(made)]
    assert finding.command(str(tmp_path / "managed"), "") == [str(made)]
    with pytest.raises(Exception, match="there is no kinetograph"):
        finding.command(str(tmp_path / "elsewhere"), str(tmp_path / "managed"))


def test_an_environment_is_made_with_its_progress_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    finding = module("finding")
    text = (
        "import shutil, sys\n"
        "print('working on it', flush=True)\n"
        "if sys.argv[2] == 'venv':\n"
        "    import os; os.makedirs(sys.argv[3] + '/bin'); shutil.copy(__file__, sys.argv[3] + '/bin/python')\n"
        "sys.exit('--fail' in sys.argv[-1])"
    )
    done = finding.Installing(tmp_path / "env", "--fail", python=program(tmp_path, text))
    done.wait()
    assert done.done
    assert "could not be installed: working on it" in done.error
