"""No command overwrites a file unasked: the file is kept, the status is 2 and the message says --force."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from command_line import invoke, run

import kinetograph as kg
from kinetograph.cli import app
from kinetograph.errors import ExistsError
from kinetograph.formats.readings import write_readings
from kinetograph.library import Library
from kinetograph.sensing import preset, simulate
from kinetograph.studio.project import Project, Walk, write_project
from kinetograph.take import Annotation, Take
from walkers import walk

OLD = "an edited table, or hours of work\n"
WRITERS: dict[str, tuple[str, str]] = {
    "convert": ("convert walk.bvh OUT", "out.glb"),
    "view": ("view walk.bvh -o OUT", "out.png"),
    "view, film": ("view walk.bvh -o OUT", "out.gif"),
    "view, page": ("view walk.bvh -o OUT", "out.html"),
    "library annotate": ("library annotate lib --export OUT", "moves.csv"),
    "library tap, picture": ("library tap lib uncut --from beats.txt --picture OUT", "sheet.png"),
    "perform": ("perform path.csv -l lib -o OUT", "out.bvh"),
    "perform, second output": ("perform path.csv -l lib -o new.bvh -o OUT", "out.glb"),
    "perform, picture": ("perform path.csv -l lib -o new.bvh --picture OUT", "out.png"),
    "perform, report": ("perform path.csv -l lib -o new.bvh --report OUT", "out.json"),
    "perform, transcript": ("perform path.csv -l lib -o new.bvh --transcript OUT", "out.csv"),
    "perform, an alternative": ("perform path.csv -l lib -o new.bvh --alternatives 2", "new_2.bvh"),
    "inbetween": ("inbetween --from walk.bvh@0 --to walk.bvh@0.5 -l lib -o OUT", "out.bvh"),
    "inbetween, report": ("inbetween --from walk.bvh@0 --to walk.bvh@0.5 -l lib -o new.bvh --report OUT", "out.json"),
    "sense": ("sense r.csv -l lib -o OUT", "out.bvh"),
    "sense, picture": ("sense r.csv -l lib -o new.bvh --picture OUT", "out.png"),
    "simulate": ("simulate walk.bvh -o OUT", "out.csv"),
    "calibrate": ("calibrate r.csv -l lib -o OUT", "mine.toml"),
    "render, a request": ("render request.json -o OUT", "out.bvh"),
    "render, picture": ("render request.json -o new.bvh --picture OUT", "out.png"),
    "render, report": ("render request.json -o new.bvh --report OUT", "out.json"),
    "render": ("render project.json -o exports", "exports/walk.bvh"),
    "render, as a request": ("render project.json --request OUT", "out.json"),
    "live sense": ("live sense -l lib --from replay:r.csv@9 --to OUT", "out.bvh"),
    "live perform": ("live perform -l lib --from replay:walk.bvh@9 --to OUT", "out.bvh"),
    "record": ("record --from replay:r.csv@9 -o OUT", "out.csv"),
}
WRITE_NOTHING = {"info", "data", "devices", "evaluate", "serve", "studio"}
"""Commands without outputs, or whose exports are numbered."""
FOLDERS = {"demo", "reproduce"}
"""Commands that say in their help that they write into a folder in place of an earlier run."""


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("writers")
    library = Library.create(folder / "lib")
    cuts = tuple(Annotation("motion", "cut", "", t, t) for t in np.arange(7) / 2)
    for name, turn in (("a", 0.0), ("b", 0.5)):
        library.add(Take(name, {"motion": walk(3.0, turn_rate=turn)}, cuts))
    library.add(Take("uncut", {"motion": walk(2.0)}))
    kg.save(walk(2.0), folder / "walk.bvh")
    (folder / "path.csv").write_text("t,x,z\n" + "".join(f"{i / 10},0,{i / 10}\n" for i in range(21)))
    (folder / "beats.txt").write_text("0.5\n1.0\n1.5\n")
    write_readings(simulate(walk(2.0), preset("wii"), np.random.default_rng(0)), folder / "r.csv")
    write_project(Project(libraries={"lib": "lib"}, walk=Walk(path=((0.0, 0.0, 0.0), (1.0, 0.0, 1.0)))),
                  folder / "project.json")  # fmt: skip
    (folder / "request.json").write_text('{"path": "path.csv", "library": "lib"}')
    (folder / "exports").mkdir()
    return folder


@pytest.mark.parametrize("command", WRITERS)
def test_a_file_that_exists_is_kept(inputs: Path, monkeypatch: pytest.MonkeyPatch, command: str) -> None:
    text, name = WRITERS[command]
    monkeypatch.chdir(inputs)
    Path(name).write_text(OLD)
    before = sorted(path.name for path in inputs.rglob("*"))
    result = invoke(*(name if word == "OUT" else word for word in text.split()))
    try:
        assert isinstance(result.exception, ExistsError), result.output
        assert "--force" in str(result.exception)
        assert name in str(result.exception)
        assert Path(name).read_text() == OLD
        assert sorted(path.name for path in inputs.rglob("*")) == before
    finally:
        Path(name).unlink()


def test_every_command_is_a_writer_or_known_to_write_nothing() -> None:
    from typer.main import get_command

    names = set(get_command(app).commands)  # type: ignore[attr-defined]
    writers = {command.partition(",")[0].split()[0] for command in WRITERS}
    assert names == writers | WRITE_NOTHING | FOLDERS


def test_what_exists_is_refused_in_one_line(inputs: Path) -> None:
    (inputs / "moves.csv").write_text(OLD)
    done = run("library", "annotate", "lib", "--export", "moves.csv", cwd=inputs)
    assert done.returncode == 1
    assert done.stderr == "kinetograph: moves.csv exists; give --force to overwrite it, or another name\n"
    assert (inputs / "moves.csv").read_text() == OLD
    done = run("library", "annotate", "lib", "--export", "moves.csv", "--force", cwd=inputs)
    assert done.returncode == 0, done.stderr
    assert (inputs / "moves.csv").read_text().startswith("take,track,kind,label,start,stop")
    (inputs / "moves.csv").unlink()
