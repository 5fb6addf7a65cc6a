"""Interrupts and closed pipes: all outputs or none, no drafts, no traceback, and the status says what happened."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from command_line import run

import kinetograph as kg
from kinetograph.library import Library
from kinetograph.take import Annotation, Take
from walkers import walk

STRIKE = """
import os, signal, sys
from kinetograph import __main__

def strike(number):
    os.kill(os.getpid(), number)

number, where, *arguments = sys.argv[1:]
number = int(number)
if where.startswith("import "):
    class Finder:
        def find_spec(self, name, path, target=None):
            if name == where.split()[1]:
                sys.meta_path.remove(self)
                strike(number)
    sys.meta_path.insert(0, Finder())
else:
    import importlib
    module, _, function = where.rpartition(".")
    module = importlib.import_module(module)
    before = getattr(module, function)
    def struck(*args, **kwargs):
        setattr(module, function, before)
        result = before(*args, **kwargs)
        strike(number)
        return result
    setattr(module, function, struck)
sys.argv = ["kinetograph", *arguments]
__main__.main()
"""
"""Runs a command that signals itself: at the import of a module, or at the end of a function of one."""


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("interrupts")
    library = Library.create(folder / "lib")
    cuts = tuple(Annotation("motion", "cut", "", t, t) for t in np.arange(7) / 2)
    for name, turn in (("a", 0.0), ("b", 0.5)):
        library.add(Take(name, {"motion": walk(3.0, turn_rate=turn)}, cuts))
    kg.save(walk(2.0), folder / "walk.bvh")
    (folder / "path.csv").write_text("t,x,z\n" + "".join(f"{i / 10},0,{i / 10}\n" for i in range(21)))
    return folder


def struck(folder: Path, number: int, where: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", STRIKE, str(int(number)), where, *map(str, arguments)]
    return subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False, cwd=folder)


PERFORM = ("perform", "path.csv", "-l", "lib", "-o", "out.bvh", "-o", "out.glb", "--report", "out.json",
           "--picture", "out.png")  # fmt: skip

CONVERT = ("convert", "walk.bvh", "out.glb")
MOMENTS = (
    (signal.SIGINT, "import typer", CONVERT),
    (signal.SIGTERM, "import numpy", CONVERT),
    (signal.SIGTERM, "os.open", CONVERT),
    (signal.SIGINT, "kinetograph.formats.gltf.write", CONVERT),
    (signal.SIGTERM, "kinetograph.formats.gltf.write", CONVERT),
    (signal.SIGTERM, "kinetograph.formats.bvh.write", PERFORM),
    (signal.SIGINT, "kinetograph.drawing.draw_synthesis", PERFORM),
)


@pytest.mark.parametrize(
    ("number", "where", "arguments"), MOMENTS, ids=[f"{n.name} at {w} of {a[0]}" for n, w, a in MOMENTS]
)
def test_an_interrupted_command_leaves_all_outputs_or_none(
    inputs: Path, number: signal.Signals, where: str, arguments: tuple[str, ...]
) -> None:
    before = sorted(path.name for path in inputs.iterdir())
    done = struck(inputs, number, where, *arguments)
    left = sorted(path.name for path in inputs.iterdir() if path.name not in before)
    for name in left:
        (inputs / name).unlink()
    assert done.returncode == 128 + number, done.stderr
    assert "Traceback" not in done.stderr
    assert left == []


def test_a_command_that_is_not_interrupted_leaves_all(inputs: Path) -> None:
    done = run(*PERFORM, cwd=inputs)
    assert done.returncode == 0, done.stderr
    for name in ("out.bvh", "out.glb", "out.json", "out.png"):
        (inputs / name).unlink()


def piped(folder: Path, *arguments: object, merge: bool = False) -> tuple[int, str]:
    """The status and what is said on stderr by a command whose standard output nobody reads."""
    reader, writer = os.pipe()
    os.close(reader)
    try:
        done = subprocess.run(
            [sys.executable, "-m", "kinetograph", *map(str, arguments)],
            stdin=subprocess.DEVNULL,
            stdout=writer,
            stderr=writer if merge else subprocess.PIPE,
            check=False,
            cwd=folder,
        )
    finally:
        os.close(writer)
    return done.returncode, "" if merge else done.stderr.decode()


@pytest.mark.parametrize(
    "arguments",
    [
        ("info", "walk.bvh"),
        ("perform", "--help"),
        ("library", "info", "lib"),
        ("convert", "walk.bvh", "out.glb", "--force"),
    ],
    ids=" ".join,
)
def test_a_closed_pipe_ends_a_command_quietly(inputs: Path, arguments: tuple[str, ...]) -> None:
    status, said = piped(inputs, *arguments)
    assert status in (0, 1)
    assert not [word for word in ("Traceback", "BrokenPipe", "Exception ignored") if word in said], said


def test_a_closed_pipe_for_both_ends_a_command_quietly(inputs: Path) -> None:
    assert piped(inputs, "info", "walk.bvh", merge=True)[0] in (0, 1)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_a_full_disk_is_one_line(inputs: Path) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "kinetograph", "info", "walk.bvh", "--json"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
            cwd=inputs,
        )
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == "kinetograph: No space left on device"
    assert "Exception ignored" not in done.stderr


def test_a_closed_output_is_no_traceback(inputs: Path) -> None:
    command = f"{sys.executable} -m kinetograph info walk.bvh >&-"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False, cwd=inputs)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
