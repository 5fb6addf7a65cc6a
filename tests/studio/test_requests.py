"""A section of a project is a request: the same document, the same motion, bit by bit."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

import kinetograph as kg
from kinetograph.errors import RequestError
from kinetograph.formats import KeySources, read_request, write_request
from kinetograph.formats.readings import write_readings
from kinetograph.formats.request_json import ContactRow, MoveRow, OnPathRow, Request
from kinetograph.motion import Motion
from kinetograph.pipeline import render_request
from kinetograph.sensing import preset, simulate
from kinetograph.studio.keys.making import make as make_keys
from kinetograph.studio.messages import AskWhy, NextBest
from kinetograph.studio.project import (
    KeyRow,
    Keys,
    LayerRow,
    Lock,
    PartRow,
    Project,
    RuleRow,
    Sensors,
    Walk,
)
from kinetograph.studio.requests import Taken, request_of, with_request
from kinetograph.studio.room import FILES, Room
from kinetograph.studio.walk.making import ANSWERS, make
from made_walks import PATH, quiet, walked


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project's folder, with a library, a motion and readings."""
    root = tmp_path_factory.mktemp("asked")
    walked(root)
    left = kg.Library.open(root / "walks").take("left").motion()
    (root / FILES).mkdir()
    kg.save(left, root / FILES / "pose.bvh")
    write_readings(simulate(left, preset("wii"), np.random.default_rng(0)), root / FILES / "readings.csv")
    return root


WALKS = [
    Walk(),
    Walk(mirror=False, keep_time=True, smooth_time=0.1, smooth_space=0.2, facing=30.0),
    Walk(rules=(RuleRow(1.0, 2.0, "right"), RuleRow(2.0, 3.0, "left", forbid=True))),
    Walk(
        layers=(
            LayerRow(("left arm",), "take:left", start=0.5, second=1.0, seconds=1.5),
            LayerRow(("right arm",), "readings.csv", start=1.0, ease=0.1),
            LayerRow(("right_hand",), "pose.bvh", "walks", hold=True),
        )
    ),
    Walk(
        keys=(OnPathRow("take:left@2", 1.5, weight=3.0), OnPathRow("pose.bvh@3", along=3.0, position=(0.6, 3.0))),
        moves=(MoveRow(0.2, 0.8, "straight"), MoveRow(2.0, 2.8, "right", weight=0.2, first="left")),
        contacts=(ContactRow("left_foot", 2.2, 2.4),),
        fill=True,
    ),
]


def as_command(request: Request, folder: Path, tmp_path: Path) -> Motion:
    """What ``kinetograph render`` makes of a request that was written."""
    write_request(request, folder / "request.json")
    written = read_request(folder / "request.json")
    assert written == request
    library = kg.Library.open(folder / str(written.library))
    return render_request(written, library, KeySources(library, folder=folder)).synthesis.motion


def back(request: Request, folder: Path, base: Path) -> Project:
    """A request as a section of a project somewhere else."""
    base.mkdir()
    return with_request(Project(), Taken(request, folder, base))


@pytest.mark.parametrize("walk", WALKS)
def test_a_walk_and_its_request_are_the_same_to_the_bit(folder: Path, tmp_path: Path, walk: Walk) -> None:
    project = Project(libraries={"walks": "walks"}, walk=msgspec.structs.replace(walk, path=PATH))
    made = make(project, Room(folder), quiet)
    assert made is not None
    alone = as_command(request_of(project), folder, tmp_path)
    assert np.array_equal(made.synthesis.motion.rotations, alone.rotations)
    assert np.array_equal(made.synthesis.motion.translation, alone.translation)
    again = back(request_of(project), folder, tmp_path / "other")
    assert msgspec.structs.replace(again.walk, library="", layers=()) == msgspec.structs.replace(
        project.walk, layers=()
    )
    there = make(again, Room(tmp_path / "other"), quiet)
    assert there is not None
    assert np.array_equal(there.synthesis.motion.rotations, alone.rotations)
    names = [lane.name for lane in made.lanes]
    assert ("keys" in names, "layers" in names) == (bool(walk.keys), bool(walk.layers))


def test_keys_and_their_request_are_the_same_to_the_bit(folder: Path, tmp_path: Path) -> None:
    parts = (PartRow("left_hand", "root", (0.2, 1.0, 0.3)),)
    rows = (KeyRow("take:left@1"), KeyRow("pose.bvh@3", (1.0, 3.0), parts=parts), KeyRow("take:right@4"))
    keys = Keys(rows=rows, mirror=True, moves=("right",), filler=True, force=True)
    project = Project(mode="keys", libraries={"walks": "walks"}, keys=keys)
    made = make_keys(project, Room(folder), quiet)
    assert made is not None
    alone = as_command(request_of(project), folder, tmp_path)
    again = back(request_of(project), folder, tmp_path / "other")
    assert msgspec.structs.replace(again.keys, library="") == keys
    assert np.array_equal(made.synthesis.motion.rotations, alone.rotations)
    assert np.array_equal(made.synthesis.motion.translation, alone.translation)


def test_questions_about_a_walk_know_its_keys_and_moves(folder: Path) -> None:
    walk = Walk(
        path=PATH,
        keys=(OnPathRow("take:left@2.2", 1.5, weight=50.0, name="lean"),),
        moves=(MoveRow(2.5, 3.5, "right"),),
        layers=(LayerRow(("left arm",), "take:left"),),
        mirror=False,
    )
    project, room = Project(libraries={"walks": "walks"}, walk=walk), Room(folder)
    room.latest["walk"] = make(project, room, quiet)  # type: ignore[assignment]
    why = ANSWERS[AskWhy](room, project, AskWhy(1, 1.5))
    assert "the demand for lean" in {row.constraint for row in why.without}  # type: ignore[union-attr]
    assert max(row.terms["keys"] for row in why.rows) > 0.01  # type: ignore[union-attr]
    assert why.layers == ("left drives left_shoulder, left_elbow, left_hand",)  # type: ignore[union-attr]
    found = ANSWERS[NextBest](room, project, NextBest(2, 3.0, 3))
    assert {row.take for row in found.rows} == {"right"}  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("project", "says"),
    [
        (Project(mode="sensors", sensors=Sensors(readings="r.csv")), "the section sensors cannot be written"),
        (Project(mode="keys", keys=Keys(lock=Lock((0.0, 1.0), Keys()))), "a request has no locked span"),
        (
            Project(
                mode="keys",
                libraries={"walks": "walks"},
                keys=Keys(rows=(KeyRow("take:left@1", moved={"left_hand": (0.0, 1.0, 0.3)}),)),
            ),
            "take:left@1: a request has no hands and feet that are moved",
        ),
        (Project(walk=Walk(path=PATH)), "the project has no library"),
    ],
)
def test_what_no_request_asks_for_is_refused(project: Project, says: str) -> None:
    with pytest.raises(RequestError, match=says):
        request_of(project)


@pytest.mark.parametrize(
    ("walk", "says"),
    [
        (Walk(keys=(OnPathRow("other.bvh@1", 1.0),)), r"the project has no file 'other\.bvh'"),
        (Walk(keys=(OnPathRow("../pose.bvh@1", 1.0),)), "the name of a file without a folder"),
        (Walk(layers=(LayerRow(("arms",), "../walks"),)), "the name of a file without a folder"),
        (Walk(moves=(MoveRow(1.0, 2.0, "tango"),)), "called 'tango'"),
    ],
)
def test_a_walk_reads_files_of_its_project_only(folder: Path, walk: Walk, says: str) -> None:
    project = Project(libraries={"walks": "walks"}, walk=msgspec.structs.replace(walk, path=PATH))
    with pytest.raises(RequestError, match=says):
        make(project, Room(folder), quiet)


def test_a_path_of_a_file_is_drawn_as_it_is(folder: Path, tmp_path: Path) -> None:
    times = np.arange(121) / 30
    rows = "".join(f"{t:.4f},{0.3 * t!r},{1.1 * t!r}\n" for t in times.tolist())
    (folder / "path.csv").write_text(f"t,x,z\n{rows}")
    request = Request(library="walks", path="path.csv")
    alone = as_command(request, folder, tmp_path)
    made = make(back(request, folder, tmp_path / "other"), Room(tmp_path / "other"), quiet)
    assert made is not None
    assert np.array_equal(made.synthesis.motion.rotations, alone.rotations)


@pytest.mark.parametrize(
    ("request_", "says"),
    [
        (Request(library="walks"), "asks for nothing"),
        (Request(path=PATH), "a section of the studio has one library, the request 0"),
        (Request(library=("walks", "others"), path=PATH), "one library, the request 2"),
        (Request(library="walks", partner="pose.bvh"), "no place for 'partner'"),
        (Request(library="walks", path=PATH, standing=False), "no place for 'standing'"),
        (Request(library="walks", path="files/pose.bvh"), "the studio draws paths, found a motion"),
        (Request(library="walks", path=PATH, keys=(OnPathRow("gone.bvh@1", 1.0),)), "gone.bvh: there is no such file"),
        (Request(library="walks", keys=(OnPathRow("take:left@1", along=1.0),)), "the studio's keys have a time"),
    ],
)
def test_what_the_studio_has_no_place_for_is_refused(
    folder: Path, tmp_path: Path, request_: Request, says: str
) -> None:
    with pytest.raises(RequestError, match=says) as caught:
        back(request_, folder, tmp_path / "other")
    assert "\n" not in str(caught.value)


def test_a_file_of_the_project_is_not_replaced_by_another(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "other" / FILES).mkdir(parents=True)
    (tmp_path / "other" / FILES / "pose.bvh").write_text("another")
    request = Request(library="walks", path=PATH, keys=(OnPathRow("files/pose.bvh@1", 1.0),))
    with pytest.raises(RequestError, match=r"the project has another file 'pose\.bvh'"):
        with_request(Project(), Taken(request, folder, tmp_path / "other"))
