"""Other bodies from the command line: retargeting with a table to edit, characters, films."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import answer, run

import kinetograph as kg
from kinetograph.formats import read_character, save
from kinetograph.formats.deepmimic import skeleton
from kinetograph.kinematics import role_positions
from kinetograph.motion import cut


def clip(folder: Path, clips_folder: Path) -> Path:
    save(cut(kg.load(clips_folder / "humanoid3d_walk.txt").motion(), 0, 8), folder / "walk.glb")
    return folder / "walk.glb"


def test_a_table_is_written_edited_and_heeded(tmp_path: Path, clips_folder: Path) -> None:
    walk, table = clip(tmp_path, clips_folder), tmp_path / "table.tsv"
    arguments = ("convert", walk, tmp_path / "a.bvh", "--retarget", walk, "--joint-table", table, "--force")
    done = run(*arguments)
    assert done.returncode == 0, done.stderr
    assert "15 of 15 joints mapped, root path scaled by 1.000" in done.stderr
    table.write_text(table.read_text().replace("left_knee\tleft_knee", "left_knee\t-"))
    done = run(*arguments, "--json")
    assert "14 of 15 joints mapped" in done.stderr
    assert json.loads(done.stdout)["frames"] == 8
    table.write_text("left_knee\tleft_wing\n")
    done = run(*arguments)
    assert (done.returncode, "no joint 'left_wing'" in done.stderr) == (1, True)


def test_the_body_of_a_file_is_worn(tmp_path: Path, clips_folder: Path) -> None:
    walk = clip(tmp_path, clips_folder)
    done = run("convert", clips_folder / "humanoid3d_run.txt", tmp_path / "run.glb", "--character", walk)
    assert done.returncode == 0, done.stderr
    assert set(read_character(tmp_path / "run.glb").skeleton.names) == set(skeleton().names)


def test_a_film(tmp_path: Path, clips_folder: Path) -> None:
    walk = clip(tmp_path, clips_folder)
    done = run("view", walk, "-o", tmp_path / "walk.gif", "--seconds", "0.1")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "walk.gif").read_bytes()[:3] == b"GIF"


def test_a_page(tmp_path: Path, clips_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import kinetograph.studio.sharing

    for name in ("player.js", "style.css", "three.LICENSE.txt"):
        (tmp_path / name).write_text(name)
    monkeypatch.setattr(kinetograph.studio.sharing, "page_folder", lambda: tmp_path)
    page = tmp_path / "walk.html"
    answer("view", clips_folder / "humanoid3d_walk.txt", "-o", page)
    plain = page.read_text()
    assert '"name":"humanoid3d_walk.txt"' in plain
    assert '"role":"contacts"' in plain
    answer(
        "view", clips_folder / "humanoid3d_walk.txt", "-o", page, "--force", "--no-contacts", "--character", "capsules"
    )
    assert '"role":"contacts"' not in page.read_text()


def test_what_goes_together(tmp_path: Path, clips_folder: Path) -> None:
    walk = clip(tmp_path, clips_folder)
    for options, says in (
        (("--character", "robot"), "expected human, capsules or a .glb or .vrm file"),
        (("--character", walk, "--retarget", walk), "brings its own skeleton"),
        (("--scale", "2"), "--joint-table and --scale go with --retarget or --character"),
    ):
        done = run("convert", walk, tmp_path / "b.glb", *options)
        assert (done.returncode, says in done.stderr) == (1, True), done.stderr


def test_a_very_long_file_is_read_in_blocks(
    tmp_path: Path, clips_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from kinetograph.library import Library
    from kinetograph.pipeline import ingesting

    walk = kg.load(clips_folder / "humanoid3d_walk.txt").motion()
    save(walk, tmp_path / "long.bvh")
    monkeypatch.setattr(ingesting, "LONG", 1000)
    answer("library", "create", tmp_path / "library", tmp_path / "long.bvh", "--units", "metre", "--up", "y")
    assert len(Library.open(tmp_path / "library").take("long").motion()) == len(walk)


def test_markers_become_a_motion(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "markers"))
    from actor import actor, markers

    from kinetograph.library import Library

    body = markers(actor(1.0), "Ann:")
    kg.save(body, tmp_path / "serve.csv")
    done = run("convert", tmp_path / "serve.csv", tmp_path / "serve.bvh")
    assert done.returncode == 0, done.stderr
    assert "motion: fitted to 39 markers, which miss by" in done.stderr
    assert "LFRM" in done.stdout
    assert len(kg.load(tmp_path / "serve.bvh").motion()) == len(body)
    plain = run("convert", tmp_path / "serve.csv", tmp_path / "same.csv", "--json")
    assert "residuals" not in plain.stdout
    made = run("convert", tmp_path / "serve.csv", tmp_path / "same.npz", "--fit-markers", "--json")
    assert '"marker": "all"' in made.stdout
    assert len(kg.load(tmp_path / "same.npz").motion()) == len(body)
    assert run("library", "create", tmp_path / "library").returncode == 0
    added = run(
        "library", "add", tmp_path / "library", "--take", "a", f"motion={tmp_path / 'serve.csv'}", "--fit-markers"
    )
    assert added.returncode == 0, added.stderr
    assert len(Library.open(tmp_path / "library").take("a").motion()) == len(body)


def test_a_file_without_the_markers_says_which(tmp_path: Path) -> None:
    from kinetograph.signal import Signal

    few = Signal(np.zeros((3, 2, 3)), ("LASI", "RASI"), "m", 50.0)
    kg.save(few, tmp_path / "few.csv")
    done = run("convert", tmp_path / "few.csv", tmp_path / "few.bvh")
    assert done.returncode == 1
    assert "no five markers of any known set" in done.stderr


def pair(folder: Path, clips_folder: Path) -> Path:
    """Two walkers side by side whose inner hands are near each other, in one file."""
    from kinetograph.motion import place
    from kinetograph.take import Take

    one = cut(kg.load(clips_folder / "humanoid3d_walk.txt").motion(), 0, 30)
    hands = [role_positions(one, [role])[:, 0] for role in ("left_hand", "right_hand")]
    beside = (hands[0] - hands[1]).mean(axis=0) * [1, 0, 1] + [0, 0, 0.05]
    save(Take("pair", {"one": one, "two": place(one, 0.0, beside)}), folder / "pair.glb")
    return folder / "pair.glb"


def held_apart(path: Path) -> np.ndarray:
    take = kg.load(path)
    left, right = role_positions(take.motion("one"), ["left_hand"]), role_positions(take.motion("two"), ["right_hand"])
    return np.linalg.norm(left - right, axis=-1)[:, 0]


def test_held_hands_stay_held_on_other_bodies(tmp_path: Path, clips_folder: Path) -> None:
    both, other, table = pair(tmp_path, clips_folder), tmp_path / "other.glb", tmp_path / "holds.csv"
    motion = kg.load(both).motion("one")
    limbs = [[1.2 if name.endswith(("elbow", "wrist")) else 1.0] for name in motion.skeleton.names]
    save(replace(motion, skeleton=replace(motion.skeleton, offsets=motion.skeleton.offsets * limbs)), other)
    rows = ["take,track,kind,label,start,stop"]
    rows += [f"pair,{track},handhold,{hand},0.2,0.6" for track, hand in (("one", "left_hand"), ("two", "right_hand"))]
    table.write_text("\n".join(rows))
    wanted = held_apart(both)
    onto = ("--retarget", other, "--scale", "1", "--force")
    assert run("convert", both, tmp_path / "free.glb", *onto).returncode == 0
    done = run("convert", both, tmp_path / "held.glb", *onto, "--handholds", table)
    assert done.returncode == 0, done.stderr
    inside = slice(int(0.2 * motion.fps) + 1, int(0.6 * motion.fps))
    assert np.abs(held_apart(tmp_path / "held.glb") - wanted)[inside].max() < 1e-4
    assert np.abs(held_apart(tmp_path / "free.glb") - wanted)[inside].max() > 1e-3
    found = run("convert", both, tmp_path / "found.glb", *onto, "--handholds", "find")
    assert "found 2 handholds" in found.stderr  # the hands swing past one another twice
    near = held_apart(both) < 0.2
    assert np.abs(held_apart(tmp_path / "found.glb") - wanted)[near].max() < 1e-4


def test_handholds_that_cannot_be(tmp_path: Path, clips_folder: Path) -> None:
    walk, table = clip(tmp_path, clips_folder), tmp_path / "holds.csv"
    table.write_text("take,track,kind,label,start,stop\nwalk,her,handhold,left_hand,0,1\n")
    for options, says in (
        (("--handholds", "find"), "--handholds goes with --retarget or --character"),
        (("--handholds", "find", "--retarget", walk), "for two dancers in one file, found 1 motions"),
        (("--handholds", table, "--retarget", walk), "no track 'her'; the file has motion"),
    ):
        done = run("convert", walk, tmp_path / "b.glb", *options)
        assert (done.returncode, says in done.stderr) == (1, True), done.stderr


def test_annotations_go_with_what_is_cut_and_mirrored() -> None:
    from kinetograph.cli.files import edited_annotations
    from kinetograph.take import Annotation

    annotations = (
        Annotation("a", "handhold", "left_hand:right_hand", 0.5, 2.0),
        Annotation("a", "contact", "left_toe", 0, 0.4),
    )
    left = edited_annotations(annotations, 1.0, 0.7, True)
    assert left == (Annotation("a", "handhold", "right_hand:left_hand", 0.0, 0.7),)
