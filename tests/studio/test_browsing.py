"""The library browser: takes by words and tags, by example, their thumbnails and clips, and recordings of one's own."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

import kinetograph as kg
from gltf_files import animated, spun, written
from kinetograph.errors import FormatError, RequestError
from kinetograph.kinematics import joint_positions
from kinetograph.motion import Motion, cut, place
from kinetograph.pipeline import find_alike, index_takes
from kinetograph.pipeline.finding import Found
from kinetograph.signal import Signal
from kinetograph.studio.browsing import ANSWERS, add_recording, with_recordings
from kinetograph.studio.messages import Alike, AskAlike, AskClip, AskTakes, AskThumbnails, Message, Takes
from kinetograph.studio.project import Project
from kinetograph.studio.room import Room
from kinetograph.take import Annotation, Take
from walkers import stick_figure, walk

PROJECT = Project(libraries={"walks": "walks"})


def _room(folder: Path) -> Room:
    library = kg.Library.create(folder / "walks")
    for number, turn in enumerate((0.0, 0.8, -0.8)):
        for period in (0.8, 1.2):
            name = f"{('straight', 'left', 'right')[number]}_{'quick' if period < 1 else 'slow'}"
            notes = (
                Annotation("body", "move", name.split("_")[0], 0, 2),
                Annotation("body", "contact", "left_foot", 0, 1),
            )
            motion = walk(4.0, turn_rate=turn, period=period, speed=0.8 / period)
            library.add(Take(name, {"body": motion}, notes))
    library.add(Take("speeds", {"speed": Signal([[1.0], [2.0]], ("speed",), "m/s", 1.0)}))
    return Room(folder)


@pytest.fixture
def room(tmp_path: Path) -> Room:
    return _room(tmp_path)


def _ask(room: Room, message: Message, project: Project = PROJECT) -> Any:
    answer = ANSWERS[type(message)](room, project, message)
    if not isinstance(answer, bytes):
        return answer
    kind, length = struct.unpack_from("<2I", answer)
    assert kind == 1
    return msgspec.json.decode(answer[8 : 8 + length]), answer[8 + length :]


@pytest.mark.parametrize(
    ("words", "tags", "found"),
    [
        ("", (), 7),
        ("quick", (), 3),
        ("LEFT slow", (), 1),
        ("*_quick", (), 3),
        ("quick*", (), 0),
        ("", ("right",), 2),
        ("quick", ("right",), 1),
        ("", ("right", "left"), 0),
        ("contact", (), 0),
    ],
)
def test_takes_are_found_by_words_and_tags(room: Room, words: str, tags: tuple[str, ...], found: int) -> None:
    answer: Takes = _ask(room, AskTakes(1, words=words, tags=tags))
    assert (answer.found, answer.all) == (found, 7)
    assert len(answer.rows) == found


def test_a_part_of_what_is_found_is_sent(room: Room) -> None:
    answer: Takes = _ask(room, AskTakes(1, first=2, count=2))
    assert [row.name for row in answer.rows] == ["left_quick", "left_slow"]
    assert answer.found == 7
    assert answer.tags == (("left", 2), ("right", 2), ("straight", 2))
    assert (answer.rows[0].seconds, answer.rows[0].tracks) == (4.0, ("body",))
    assert _ask(room, AskTakes(1, first=-5, count=-1)).rows == ()


def test_a_take_that_is_added_is_found(room: Room) -> None:
    assert _ask(room, AskTakes(1)).all == 7
    kg.Library.open(room.folder / "walks").add(Take("late", {"body": walk(1.0)}))
    assert _ask(room, AskTakes(1, words="late")).found == 1


def test_thumbnails_of_a_page_are_one_blob(room: Room) -> None:
    header, payload = _ask(room, AskThumbnails(3, ("left_slow", "speeds", "nobody", "straight_quick")))
    assert [row["take"] for row in header["rows"]] == ["left_slow", "straight_quick"]
    assert len(payload) == sum(8 * row["frames"] * row["bones"] for row in header["rows"])
    assert all(len(row["sides"]) == row["bones"] for row in header["rows"])


def test_a_clip_is_the_take_as_it_was_recorded(room: Room, tmp_path: Path) -> None:
    header, payload = _ask(room, AskClip(4, "left_slow"))
    assert header == {"kind": "clip", "id": 4, "name": "left_slow", "floor": pytest.approx(0, abs=1e-6)}
    (tmp_path / "clip.glb").write_bytes(payload)
    shown, recorded = kg.load(tmp_path / "clip.glb").motion(), walk(4.0, turn_rate=0.8, period=1.2, speed=0.8 / 1.2)
    np.testing.assert_allclose(joint_positions(shown), joint_positions(recorded), atol=1e-4)
    with pytest.raises(RequestError, match="has no motion to show, only speed"):
        _ask(room, AskClip(4, "speeds"))
    with pytest.raises(RequestError, match="no take 'nobody'"):
        _ask(room, AskClip(4, "nobody"))


# ---- by example ----


def test_the_same_clip_is_found_at_another_place_and_in_another_direction() -> None:
    rng = np.random.default_rng(2)
    times = np.arange(241) / 30
    takes = []
    for number in range(8):
        period = 0.7 + 0.1 * number
        turn = 2.0 * np.sin(0.21 * times**2 + number)  # no two seconds of a walk turn alike
        takes.append(Take(f"w{number}", {"m": walk(8.0, period=period, speed=0.8 / period, turn_rate=turn)}))
    index = index_takes(takes)
    for number in range(8):
        motion = takes[number].motion()
        start = int(rng.integers(0, len(motion) - 60))
        example = place(cut(motion, start, start + 60), float(rng.uniform(-3, 3)), rng.normal(size=3) * (9, 0, 9))
        first = find_alike(index, example)[0]
        assert first.take == f"w{number}"
        assert first.start == pytest.approx(start / 30, abs=0.051)
        assert first.distance < 0.15  # half a step of the index away


def test_another_build_is_compared_in_its_own_size() -> None:
    motion = walk(4.0)
    tall = Motion(stick_figure(1.3), 1.3 * motion.translation, motion.rotations, motion.fps)
    found = find_alike(index_takes([Take("tall", {"m": tall}), Take("other", {"m": walk(4.0, period=0.7)})]), motion)
    assert found[0].take == "tall"
    assert found[0].distance < 1e-3


def test_a_window_and_what_overlaps_it_are_left_out() -> None:
    take = Take("w", {"m": walk(9.0)})
    example = cut(take.motion(), 90, 150)
    found = find_alike(index_takes([take]), example, without=Found("w", "m", 3.0, 5.0, 0.0))
    assert len(found) == 1
    assert found[0].stop < 3.0 or found[0].start > 5.0
    assert found[0].distance < 0.01  # a step further on


def test_an_example_longer_than_everything_finds_nothing() -> None:
    assert find_alike(index_takes([Take("short", {"m": walk(1.0)})]), walk(5.0)) == []


def test_the_page_finds_what_is_like_a_part_of_a_take(room: Room) -> None:
    answer: Alike = _ask(room, AskAlike(5, "left_slow", 1.0, 2.2))
    assert len(answer.rows) == 6
    assert answer.rows[0].take in ("left_slow", "straight_slow")
    assert [row.distance for row in answer.rows] == sorted(row.distance for row in answer.rows)
    with pytest.raises(RequestError, match="nothing to compare with"):
        _ask(room, AskAlike(5, "", 0.0, 1.0))
    with pytest.raises(RequestError, match="from one second to a later one"):
        _ask(room, AskAlike(5, "left_slow", 2.0, 1.0))


# ---- recordings of one's own ----


def test_a_recording_is_added_once_and_another_of_its_name_beside_it(tmp_path: Path) -> None:
    room = Room(tmp_path)
    (tmp_path / "files").mkdir()
    kg.save(walk(1.0), tmp_path / "files" / "stroll.bvh")
    kg.save(walk(2.0), tmp_path / "files" / "stroll.glb")
    said = add_recording(room, "stroll.bvh")
    assert all(line.startswith("stroll.bvh: ") for line in said)
    add_recording(room, "stroll.bvh")
    add_recording(room, "stroll.glb")
    assert kg.Library.open(tmp_path / "recordings").names() == ("stroll", "stroll.glb")
    project = with_recordings(PROJECT)
    assert list(project.libraries.items()) == [("walks", "walks"), ("recordings", "recordings")]
    assert with_recordings(project) is project
    assert _ask(room, AskTakes(1, "recordings"), project).tags == ()


def test_every_animation_of_a_file_is_a_recording(tmp_path: Path) -> None:
    room = Room(tmp_path)
    (tmp_path / "files").mkdir()
    nodes = [{"name": "a", "children": [1]}, {"name": "b", "translation": [0, 1, 0]}]
    for suffix in ("gltf", "vrm"):
        written(tmp_path / "files" / f"two.{suffix}", animated(nodes, [("Idle", [spun(0)]), ("Turn", [spun(90)])]))
        said = add_recording(room, f"two.{suffix}")
        assert len(said) == len(set(said))
        add_recording(room, f"two.{suffix}")
    names = ("two:Idle", "two:Turn", "two.vrm:Idle", "two.vrm:Turn")
    assert kg.Library.open(tmp_path / "recordings").names() == names
    shown = _ask(room, AskTakes(1, "recordings"), with_recordings(PROJECT))
    assert [row.name for row in shown.rows] == list(names)


def test_what_is_no_motion_is_refused(tmp_path: Path) -> None:
    room = Room(tmp_path)
    (tmp_path / "files").mkdir()
    (tmp_path / "files" / "path.csv").write_text("t,x,z\n0,0,0\n1,1,0\n")
    (tmp_path / "files" / "broken.bvh").write_text("HIERARCHY nonsense")
    with pytest.raises(RequestError, match="it is no recording"):
        add_recording(room, "path.csv")
    with pytest.raises(FormatError):
        add_recording(room, "broken.bvh")
    assert not (tmp_path / "recordings").exists()
