"""Libraries in shards from the command line: a folder of libraries is given as one library is."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import answer

import kinetograph as kg
from kinetograph.errors import KinetographError, RequestError
from kinetograph.methods.bodies import choose_takes
from kinetograph.take import Annotation, Take
from walkers import walk


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same walks in one library and in two."""
    root = tmp_path_factory.mktemp("shards")
    one = kg.Library.create(root / "one")
    for name, turn in (("left", 0.3), ("right", -0.3)):
        cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(13) / 2)
        take = Take(name, {"body": walk(6.0, turn_rate=turn)}, cuts)
        one.add(take)
        kg.Library.create(root / "walks" / name).add(take)
    (root / "path.csv").write_text("t,x,z\n" + "".join(f"{i / 30},{0.1 * np.sin(i / 9)},{i / 30}\n" for i in range(90)))
    return root


def performed(folder: Path, library: str, *options: str) -> dict[str, Any]:
    roles = ("left_toe", "right_toe", "hips")
    targets = [text for role in roles for text in ("--target-point", role)]
    command = ("perform", folder / "path.csv", "-l", folder / library, "-o", folder / f"{library}.bvh")
    told: dict[str, Any] = json.loads(answer(*command, *targets, "--json", "--force", *options).stdout)
    return told


def test_a_folder_of_libraries_performs_as_one_library(folder: Path) -> None:
    one, shards = performed(folder, "one"), performed(folder, "walks")
    assert {**one, "wrote": 0} == {**shards, "wrote": 0}
    assert (folder / "one.bvh").read_bytes() == (folder / "walks.bvh").read_bytes()
    left = performed(folder, "walks", "--takes", "left")
    assert left["takes_used"] == 1


@pytest.mark.parametrize(
    ("library", "options", "message"),
    [
        ("walks", ("--alternatives", "2", "--jobs", "2"), "give one motion: leave out --alternatives"),
        ("one", ("--alternatives", "2", "--cluster", "tcp://127.0.0.1:1"), "give one motion: leave out --alternatives"),
        ("walks", ("--cluster", "0.1", "--jobs", "2"), "segments of several shards cannot be clustered"),
        ("walks", ("--cluster", "near"), "expected metres, or the address of a Dask scheduler"),
        ("walks", ("--cluster", "tcp://nowhere"), "tcp://HOST:PORT"),
        ("walks", ("--cluster", "tcp://127.0.0.1:1", "--jobs", "2"), "give one of the two"),
        ("one", ("--cluster", "tcp://127.0.0.1:1"), "no cluster answers at tcp://127.0.0.1:1"),
        ("one", ("--cluster", "0.1", "--cluster", "0.2"), "expected one distance in metres"),
    ],
)
def test_what_shards_and_clusters_cannot_do_is_one_line(
    folder: Path, library: str, options: tuple[str, ...], message: str
) -> None:
    with pytest.raises(KinetographError, match=message) as refused:
        performed(folder, library, *options)
    assert "\n" not in str(refused.value)


def test_live_performing_works_here(folder: Path) -> None:
    stream = ("--from", "replay:x.csv", "--to", folder / "live.bvh")
    with pytest.raises(RequestError, match="works on this machine only"):
        answer("live", "perform", "-l", folder / "one", *stream, "--cluster", "tcp://127.0.0.1:1")


def test_takes_to_leave_out_have_short_names(tmp_path: Path) -> None:
    library = kg.Library.create(tmp_path / "walks")
    for name in ("a/walk", "b/walk", "b/turn"):
        library.add(Take(name, {"body": walk(1.0)}))
    assert choose_takes(library, exclude=["turn"]).names == ("a/walk", "b/walk")
    assert choose_takes(library, exclude=["b/walk"]).names == ("a/walk", "b/turn")
    with pytest.raises(RequestError, match="take 'walk' to leave out may be a/walk, b/walk"):
        choose_takes(library, exclude=["walk"])
    with pytest.raises(RequestError, match="no take 'run' to leave out"):
        choose_takes(library, exclude=["run"])


def test_several_libraries_perform_as_one(folder: Path) -> None:
    """Alternatives too, as several libraries are fitted as one where nobody shares the work; and kept as one."""
    walks = folder / "walks"
    one = performed(folder, "one", "--alternatives", "2")
    for _ in range(2):
        several = performed(folder, "walks/left", "-l", str(walks / "right"), "--alternatives", "2", "--takes", "*")
        assert {**one, "wrote": 0} == {**several, "wrote": 0}
        assert (folder / "one.bvh").read_bytes() == (walks / "left.bvh").read_bytes()
        assert (folder / "one_2.bvh").read_bytes() == (walks / "left_2.bvh").read_bytes()
