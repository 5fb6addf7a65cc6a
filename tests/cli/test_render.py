"""The command render, and exports of the studio: the same files, byte by byte, however they are asked for."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import msgspec
import pytest
from command_line import answer, invoke, run
from PIL import Image

from kinetograph.errors import FormatError, RequestError
from kinetograph.formats import read_request
from kinetograph.formats.request_json import MoveRow
from kinetograph.studio.exporting import Wanted, export
from kinetograph.studio.project import KeyRow, Keys, Project, Walk, write_project
from kinetograph.studio.requests import request_of
from made_walks import PATH, quiet, stood, walked


def test_the_files_are_those_of_the_command_line(tmp_path: Path) -> None:
    made, _ = walked(tmp_path)
    suffixes = (".bvh", ".glb", ".fbx", ".usda", ".usdc", ".npz", ".csv")
    (tmp_path / "path.csv").write_text("t,x,z\n" + "".join(f"{t!r},{x!r},{z!r}\n" for t, x, z in PATH))
    outputs = [part for suffix in suffixes for part in ("-o", tmp_path / f"walk{suffix}")]
    answer(
        "perform",
        tmp_path / "path.csv",
        "-l",
        tmp_path / "walks",
        "--mirror",
        *outputs,
        "--report",
        tmp_path / "walk.json",
    )
    paths = export(made, None, tmp_path / "exports", Wanted((*suffixes, ".json"), "walk"), quiet)
    for path in paths:
        assert path.read_bytes() == (tmp_path / path.name).read_bytes(), path.name


def test_a_film_and_a_sheet_are_those_of_the_command_line(tmp_path: Path) -> None:
    made = stood(0.3)
    gif, glb = export(made, None, tmp_path / "exports", Wanted((".gif", ".npz"), "walk"), quiet)
    answer("view", glb, "-o", tmp_path / "walk.gif")
    assert gif.read_bytes() == (tmp_path / "walk.gif").read_bytes()
    (png,) = export(made, None, tmp_path / "exports", Wanted((".png",), "sheet"), quiet)
    with Image.open(png) as picture:
        assert picture.width > 1000


def test_render_writes_the_bytes_of_the_studio(tmp_path: Path) -> None:
    made, project = walked(tmp_path)
    write_project(project, tmp_path / "project.json")
    kinds = (".bvh", ".glb", ".usda", ".png", ".json")
    shown = export(made, None, tmp_path / "studio", Wanted(kinds, "walk"), quiet)
    to = ("-o", tmp_path / "out", "--to", "bvh,.glb, .usda,.png,.json", "--json")
    said = answer("render", tmp_path / "project.json", *to)
    assert json.loads(said.stdout)["wrote"] == [str(tmp_path / "out" / f"walk{kind}") for kind in kinds]
    for path in shown:
        assert path.read_bytes() == (tmp_path / "out" / path.name).read_bytes(), path.name


def test_render_overwrites_only_by_force_and_writes_beside_the_project(tmp_path: Path) -> None:
    _, project = walked(tmp_path)
    write_project(project, tmp_path / "project.json")
    answer("render", tmp_path / "project.json")
    assert [path.name for path in (tmp_path / "exports").iterdir()] == ["walk.bvh"]
    with pytest.raises(RequestError, match=r"walk\.bvh exists; give --force"):
        answer("render", tmp_path / "project.json")
    answer("render", tmp_path / "project.json", "--force")


def test_a_library_that_was_moved_is_pointed_at(tmp_path: Path) -> None:
    _, project = walked(tmp_path)
    write_project(project, tmp_path / "project.json")
    shutil.move(tmp_path / "walks", tmp_path / "elsewhere")
    failed = run("render", tmp_path / "project.json")
    assert failed.returncode == 1
    assert failed.stderr.splitlines()[-1].startswith("walk: ")
    assert "Traceback" not in failed.stderr
    answer("render", tmp_path / "project.json", "-l", f"walks={tmp_path / 'elsewhere'}")
    for place, said in (("walks", "expected NAME=PATH"), ("dances=x", "no library 'dances'; it has walks")):
        with pytest.raises(RequestError, match=said):
            answer("render", tmp_path / "project.json", "-l", place, "--force")


def test_what_asks_for_nothing_and_what_is_no_project_is_said_in_one_line(tmp_path: Path) -> None:
    project = tmp_path / "project.json"
    write_project(Project(), project)
    with pytest.raises(RequestError, match="the project asks for nothing yet"):
        answer("render", project)
    with pytest.raises(RequestError, match="section 'keys' asks for nothing yet"):
        answer("render", project, "--section", "keys")
    with pytest.raises(RequestError, match="unknown section 'dance'; expected walk, keys, duet, sensors"):
        answer("render", project, "--section", "dance")
    with pytest.raises(RequestError, match=r"cannot write files of kind '\.doc'"):
        answer("render", project, "--to", ".doc")
    project.write_text('{"version": 1, "dance": {}}')
    with pytest.raises(FormatError, match="expected a request"):
        answer("render", project)
    with pytest.raises(FormatError, match="cannot open it"):
        answer("render", tmp_path / "nothing.json")


def test_a_section_that_cannot_be_made_does_not_stop_the_others(tmp_path: Path) -> None:
    _, project = walked(tmp_path)
    rows = (KeyRow("take:nobody@0"), KeyRow("take:straight@1"))
    wrong = msgspec.structs.replace(project, keys=Keys(rows=rows))
    write_project(wrong, tmp_path / "project.json")
    result = invoke("render", tmp_path / "project.json")
    assert result.exit_code == 1
    assert "keys: " in result.stderr
    assert [path.name for path in (tmp_path / "exports").iterdir()] == ["walk.bvh"]


def test_the_command_writes_a_section_as_a_request(tmp_path: Path) -> None:
    folder = tmp_path / "project"
    walked(folder)
    project = Project(libraries={"walks": "walks"}, walk=Walk(path=PATH, moves=(MoveRow(1.0, 2.0, "right"),)))
    write_project(project, folder / "project.json")
    answer("render", folder / "project.json", "--request", folder / "walk.json", "--force")
    assert read_request(folder / "walk.json") == request_of(project)
    answer("render", folder / "walk.json", "-o", tmp_path / "asked.bvh")
    answer("render", folder / "project.json", "-o", tmp_path / "out")
    assert (tmp_path / "asked.bvh").read_bytes() == (tmp_path / "out" / "walk.bvh").read_bytes()
    for more, says in (
        (("--request", tmp_path / "walk.json"), "a request names files from its folder"),
        (("--request", folder / "walk.json"), "exists"),
        (("--request", folder / "new.json", "--section", "duet"), "the section duet cannot be written"),
    ):
        assert says in str(invoke("render", folder / "project.json", *more).exception)
    write_project(msgspec.structs.replace(project, walk=Walk(path=PATH)), tmp_path / "mine.json")
    result = invoke("studio", "--project", tmp_path / "mine.json", "--request", folder / "walk.json", "--no-browser")
    assert "the project has walk already; name a new project with --project" in str(result.exception)
