"""Commands on files that hold more than a body."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import run

import kinetograph as kg
from bodies import person
from kinetograph.motion import Motion
from kinetograph.take import Take
from trees import controller, on_the_ground, under, walker


@pytest.fixture(scope="module")
def game(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A walk under a root that carries its travel, with a helper bone, and a controller of its own."""
    path = tmp_path_factory.mktemp("trees") / "game.glb"
    body = under(walker(), "root", *on_the_ground(walker()), ("ik_hand_gun",))
    kg.save(Take("game", {"body": body, "ctrl": controller("foot_ctrl")}), path)
    return path


def _track(path: Path) -> Motion:
    return next(track for track in kg.load(path).tracks.values() if isinstance(track, Motion))


def test_info_lists_bodies_and_says_once_what_is_left_out(game: Path) -> None:
    done = run("info", game, "--json")
    (row,) = json.loads(done.stdout)
    assert row["track"] == "motion"
    assert row["what"].startswith("21 joints in root, 1.7")
    assert row["roles"] == "21 of 21"
    assert "left out as no bodies: 'foot_ctrl' (kept by --everything)" in done.stderr
    assert "left out as beside 'Hips', not of the body: 'ik_hand_gun'" in done.stderr
    rows = json.loads(run("info", game, "--json", "--everything").stdout)
    assert [(row["what"].split(",")[0], row["roles"]) for row in rows] == [
        ("23 joints", "21 of 21"),
        ("1 joints", "no body"),
    ]


def test_roles_that_are_missing_are_said_once_and_of_bodies_only(tmp_path: Path) -> None:
    keep = [i for i, name in enumerate(person().names) if not name.endswith(("Shoulder", "Toe"))]
    body = person()
    parents = [int(body.parents[i]) for i in keep]
    offsets = body.offsets[keep]
    for k, parent in enumerate(parents):
        if parent >= 0 and parent not in keep:
            offsets[k] = offsets[k] + body.offsets[parent]
            parents[k] = int(body.parents[parent])
    names = tuple(body.names[i] for i in keep)
    few = kg.Skeleton(names, np.array([keep.index(p) if p >= 0 else -1 for p in parents]), offsets)
    still = Motion(few, np.tile([0.0, 0.95, 0.0], (3, 1)), np.tile([1.0, 0, 0, 0], (3, len(few), 1)), 30.0)
    kg.save(Take("two", {"ann": still, "bob": still}), tmp_path / "two.npz")
    kg.save(controller("sword"), tmp_path / "sword.npz")
    done = run("info", tmp_path / "two.npz", tmp_path / "sword.npz")
    lines = [line for line in done.stderr.splitlines() if "was found for" in line]
    assert len(lines) == 1
    assert "no joint of ann, bob was found for left_collar, left_toe, right_collar, right_toe" in lines[0]


def test_convert_keeps_a_root_that_moves_and_retarget_does_not(game: Path, tmp_path: Path) -> None:
    assert run("convert", game, tmp_path / "plain.bvh").returncode == 0
    text = (tmp_path / "plain.bvh").read_text().splitlines()
    assert text[1] == "ROOT root"
    assert not any("ik_hand_gun" in line or "ctrl" in line for line in text)
    first, last = ([float(word) for word in line.split()[:3]] for line in (text[-60], text[-1]))
    np.testing.assert_allclose(last[2] - first[2], on_the_ground(walker())[0][-1, 2], atol=1e-5)
    assert run("convert", game, tmp_path / "all.bvh", "--everything").returncode == 0
    everything = (tmp_path / "all.bvh").read_text()
    assert "ik_hand_gun" in everything
    assert "ROOT foot_ctrl" in everything
    kg.save(walker(), tmp_path / "other.bvh")
    assert run("convert", game, tmp_path / "worn.bvh", "--retarget", tmp_path / "other.bvh").returncode == 0
    assert (tmp_path / "worn.bvh").read_text().splitlines()[1] == "ROOT Hips"
    for name in ("plain.bvh", "worn.bvh"):
        np.testing.assert_allclose(_track(tmp_path / name).translation, walker().translation, atol=1e-4)
