"""Keys of a project: the same motions as `inbetween`, hands where they were put, spans that stay."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.cli.configurations import InbetweenSearch, keyframe_control
from kinetograph.errors import RequestError, TooSoonError, UnmetError
from kinetograph.formats.gltf import encode
from kinetograph.keys import key_at
from kinetograph.kinematics import role_positions
from kinetograph.pipeline import inbetween
from kinetograph.post import ends_of, parts_of, put_ends
from kinetograph.studio.keys import making
from kinetograph.studio.keys.making import ANSWERS, MOST, Solved, control_of, make, solve
from kinetograph.studio.made import Made
from kinetograph.studio.messages import (
    Alternative,
    EndPlaces,
    KeyEnds,
    KeyPose,
    KeysMet,
    KeyTrouble,
    Message,
    Met,
    Trouble,
)
from kinetograph.studio.project import KeyRow, Keys, Lock, PartRow, Project
from kinetograph.studio.room import FILES, Room
from kinetograph.take import Take
from walkers import walk

SLOW = KeyRow("take:slow@1", position=(0.0, 0.0), heading=0.0)
QUICK = KeyRow("take:quick@2.5", time=(2.0, 3.0))
TURNING = KeyRow("take:turning@4", time=5.0)
ROWS = (SLOW, QUICK, TURNING)


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Room:
    folder = tmp_path_factory.mktemp("keying")
    library = kg.Library.create(folder / "walks")
    library.add(Take("slow", {"motion": walk(6.0, speed=0.8)}))
    library.add(Take("quick", {"motion": walk(6.0, speed=1.2)}))
    library.add(Take("turning", {"motion": walk(6.0, speed=1.0, turn_rate=0.5)}))
    return Room(folder)


@pytest.fixture(scope="module")
def moves(tmp_path_factory: pytest.TempPathFactory, clips_folder: Path) -> Room:
    folder = tmp_path_factory.mktemp("keying_moves")
    library = kg.Library.create(folder / "walks")
    for name in ("walk", "run", "kick", "punch", "jump"):
        library.add(replace(kg.load(clips_folder / f"humanoid3d_{name}.txt"), name=name))
    return Room(folder)


WALK, KICK, PUNCH = KeyRow("take:walk@0.4"), KeyRow("take:kick@0.6"), KeyRow("take:punch@0.5")


def project_of(*rows: KeyRow, **fields: Any) -> Project:
    return Project(libraries={"walks": "walks"}, keys=Keys(rows=rows, **fields))


def progress(done: int, total: int) -> None:
    pass


def made_of(project: Project, room: Room) -> Made:
    made = make(project, room, progress)
    assert made is not None
    return made


def solved_of(project: Project, room: Room) -> Solved:
    return solve(project.keys, project, room, progress)


def library_of(room: Room) -> kg.Library:
    return kg.Library.open(room.folder / "walks")


def test_motions_are_those_of_inbetween(room: Room) -> None:
    rows = (SLOW, QUICK, msgspec.structs.replace(TURNING, time=None))
    made = made_of(project_of(*rows, alternatives=3, mirror=True), room)
    takes = library_of(room)
    keys = (
        key_at(takes.take("slow").motion(), 1.0, position=(0.0, 0.0), heading=0.0, label="key 1"),
        key_at(takes.take("quick").motion(), 2.5, time=(2.0, 3.0), label="key 2"),
        key_at(takes.take("turning").motion(), 4.0, label="key 3"),
    )
    expected = inbetween(keys, takes, keyframe_control(InbetweenSearch(), mirror=True, footskate=True), 3)
    assert [each.cost for each in made.syntheses] == [each.cost for each in expected]
    for found, wanted in zip(made.syntheses, expected, strict=True):
        assert np.array_equal(found.motion.rotations, wanted.motion.rotations)
        assert np.array_equal(found.motion.translation, wanted.motion.translation)


@pytest.mark.parametrize(
    ("fields", "search", "without"),
    [
        ({"filler": True, "force": True}, InbetweenSearch(filler=True, force_timing=True), ()),
        ({"moves": ("slow",), "without": ("turning",)}, InbetweenSearch(move=["slow"]), ("turning",)),
    ],
)
def test_the_configuration_is_that_of_the_command(
    fields: dict[str, Any], search: InbetweenSearch, without: tuple[str, ...]
) -> None:
    assert control_of(Keys(**fields)) == keyframe_control(search, without, mirror=False, footskate=True)


def test_nothing_is_made_of_one_key(room: Room) -> None:
    assert make(project_of(SLOW), room, progress) is None


def test_keys_are_met_at_the_times_that_are_shown(room: Room) -> None:
    made = made_of(project_of(SLOW, QUICK, TURNING), room)
    lane = next(lane for lane in made.lanes if lane.role == "keys")
    assert lane.spans[0].start == 0.0
    assert lane.spans[2].start == pytest.approx(5.0)
    motion, takes = made.synthesis.motion, library_of(room)
    for span, (take, second) in zip(lane.spans, (("slow", 1.0), ("quick", 2.5), ("turning", 4.0)), strict=True):
        key = key_at(takes.take(take).motion(), second)
        met, wanted = motion.rotations[round(span.start * motion.fps), 1:], key.clip.rotations[key.frame, 1:]
        assert np.abs(rot.angle_between(met, wanted)).max() < 1e-6


def test_choosing_an_alternative_searches_for_nothing(moves: Room, monkeypatch: pytest.MonkeyPatch) -> None:
    project = project_of(WALK, KICK, PUNCH, alternatives=3)
    first = made_of(project, moves)
    monkeypatch.setattr("kinetograph.methods.keyframe.timed_search.find_route", None)  # whoever searches fails
    other = made_of(project_of(WALK, KICK, PUNCH, alternatives=3, chosen=1), moves)
    assert other.syntheses == first.syntheses
    assert other.synthesis is first.syntheses[1]
    assert made_of(project_of(WALK, KICK, PUNCH, alternatives=3, chosen=MOST - 1), moves).chosen < MOST


def test_moved_hands_are_where_they_were_put(room: Room) -> None:
    wanted = {"left_hand": (0.3, 1.2, 0.25), "right_foot": (-0.15, 0.3, 0.2)}
    row = msgspec.structs.replace(QUICK, moved=wanted, position=(0.3, 1.5), heading=20.0)
    made = made_of(project_of(SLOW, row, TURNING, force=True), room)
    motion = made.synthesis.motion
    frame = round(made.lanes[0].spans[1].start * motion.fps)
    ends = ends_of(motion, frame)
    for role, place in wanted.items():
        assert np.linalg.norm(ends[role] - place) < 1e-3
    world = rot.rotate(rot.about("y", np.radians(20.0)), np.array(wanted["left_hand"])) + np.array([0.3, 0.0, 1.5])
    assert np.linalg.norm(role_positions(motion, ("left_hand",))[frame, 0] - world) < 1e-3
    assert not any("out of reach" in line for line in made.synthesis.warnings)


def test_a_moved_hand_is_met_where_only_hands_count(room: Room) -> None:
    place = (0.3, 1.2, 0.25)
    row = msgspec.structs.replace(QUICK, moved={"left_hand": place}, roles=("left_hand", "right_hand"))
    made = made_of(project_of(SLOW, row, TURNING), room)
    frame = round(made.lanes[0].spans[1].start * made.synthesis.motion.fps)
    assert np.linalg.norm(ends_of(made.synthesis.motion, frame)["left_hand"] - place) < 1e-3


def test_what_is_out_of_reach_is_said(room: Room) -> None:
    row = msgspec.structs.replace(QUICK, moved={"left_hand": (2.0, 1.2, 0.0)}, name="wave")
    made = made_of(project_of(SLOW, row), room)
    assert any(line.startswith("wave: the left hand is out of reach, ") for line in made.synthesis.warnings)


def test_ends_keep_their_velocity_and_bones_their_length() -> None:
    motion = walk(2.0)
    before = ends_of(motion, 30)
    moved = put_ends(motion, 30, {"left_hand": before["left_hand"] + [0.02, 0.05, 0.03]})
    steps = [np.diff([ends_of(m, f)["left_hand"] for f in (29, 30, 31)], axis=0) for m in (motion, moved)]
    assert np.allclose(steps[0], steps[1], atol=1e-6)
    hand, elbow = np.moveaxis(role_positions(moved, ("left_hand", "left_elbow")), 1, 0)
    assert np.allclose(np.linalg.norm(hand - elbow, axis=1), 0.25)
    same = np.delete(
        np.arange(len(motion.skeleton)), [motion.skeleton.index(f"left_{j}") for j in ("shoulder", "elbow")]
    )
    assert np.array_equal(moved.rotations[:, same], motion.rotations[:, same])


def test_a_change_that_fades_leaves_the_rest() -> None:
    motion = walk(2.0)
    moved = put_ends(motion, 30, {"left_hand": ends_of(motion, 30)["left_hand"] + [0.02, 0.05, 0.03]}, 0.3)
    far = np.abs(np.arange(len(motion)) - 30) >= 9
    assert np.array_equal(moved.rotations[far], motion.rotations[far])
    assert not np.array_equal(moved.rotations[30], motion.rotations[30])


@pytest.mark.parametrize(
    ("places", "match"),
    [({"left_knee": (0, 0, 0)}, "expected one of left_hand, "), ({"left_hand": (0, 1)}, "three finite metres")],
)
def test_places_of_nothing_are_refused(places: dict[str, Any], match: str) -> None:
    with pytest.raises(RequestError, match=match):
        put_ends(walk(1.0), 0, places)


# ---- spans that are locked ----


def locked(
    room: Room, span: tuple[float, float], change: Callable[[Keys], Keys], rows: tuple[KeyRow, ...] = ROWS
) -> tuple[Solved, Solved]:
    """A result, and what it is with a span of it locked and other keys."""
    project = project_of(*rows)
    keys = project.keys
    later = msgspec.structs.replace(change(keys), lock=Lock(span, keys))
    return solved_of(project, room), solve(later, project, room, progress)


def test_a_locked_span_stays_frame_by_frame(room: Room) -> None:
    def retimed(keys: Keys) -> Keys:
        met = solved_of(project_of(*keys.rows), room).times[0]
        last = msgspec.structs.replace(TURNING, time=met[2] + 1.0, name="later")
        return msgspec.structs.replace(keys, rows=(*keys.rows[:2], last))

    met = solved_of(project_of(SLOW, QUICK, TURNING), room).times[0]
    low, high = met[1] - 0.4, met[1] + 0.4
    first, second = locked(room, (low, high), retimed)
    before, after = first.syntheses[0].motion, second.syntheses[0].motion
    span = slice(round(low * before.fps), round(high * before.fps) + 1)
    assert np.array_equal(before.rotations[span], after.rotations[span])
    assert np.array_equal(before.translation[span], after.translation[span])
    assert second.times[0][:2] == pytest.approx(first.times[0][:2])
    assert second.times[0][2] == pytest.approx(round((met[2] + 1.0) * before.fps) / before.fps)
    assert len(after) > len(before)


def test_alternatives_around_a_locked_span(moves: Room) -> None:
    met = solved_of(project_of(WALK, KICK, PUNCH), moves).times[0]
    span = (0.0, met[1] - 1.3)
    first, second = locked(moves, span, lambda keys: msgspec.structs.replace(keys, alternatives=3), (WALK, KICK, PUNCH))
    held = slice(round(span[0] * 30), round(span[1] * 30) + 1)
    assert len(second.syntheses) > 1
    for synthesis in second.syntheses:
        assert np.array_equal(synthesis.motion.rotations[held], first.syntheses[0].motion.rotations[held])
    others = [tuple((p.take, p.source_start) for p in synthesis.pieces) for synthesis in second.syntheses]
    assert len(set(others)) == len(others)


def test_locks_in_locks_are_solved_once(room: Room, monkeypatch: pytest.MonkeyPatch) -> None:
    project = project_of(SLOW, QUICK, TURNING)
    met = solved_of(project, room).times[0]
    once = msgspec.structs.replace(project.keys, lock=Lock((met[1] - 0.2, met[1] + 0.2), project.keys))
    twice = msgspec.structs.replace(project.keys, lock=Lock((met[1] - 0.1, met[1] + 0.1), once))
    solved = solve(twice, project, room, progress)
    assert solved.times[0] == pytest.approx(met)
    monkeypatch.setattr("kinetograph.methods.keyframe.timed_search.find_route", None)
    assert solve(twice, project, room, progress) is solved
    keys = project.keys
    for _ in range(40):
        keys = msgspec.structs.replace(keys, lock=Lock((0.1, 0.2), keys))
    with pytest.raises(RequestError, match="at most 32 spans"):
        solve(keys, project, room, progress)


# ---- what cannot be ----


@pytest.mark.parametrize(
    ("rows", "fields", "match"),
    [
        ((SLOW, KeyRow("take:none@1")), {}, "none"),
        ((SLOW, KeyRow("../keys.bvh@1")), {}, "name of a file without a folder"),
        ((SLOW, KeyRow("gone.bvh@1")), {}, "no file 'gone.bvh'"),
        ((SLOW, KeyRow("slow")), {}, "key 2: a pose is FILE@SECOND"),
        ((SLOW, KeyRow("take:slow@99")), {}, "key 2: 99 s is outside"),
        ((SLOW, KeyRow("take:slow@1", position=(1e300, 0.0))), {}, "key 2: expected a place within"),
        ((SLOW, KeyRow("take:slow@1", moved={"tail": (0, 0, 0)})), {}, "key 2: expected one of left_hand"),
        ((SLOW, KeyRow("take:slow@1", roles=("tail",))), {}, "tail"),
        ((SLOW, QUICK), {"alternatives": 9}, "expected 1 to 4 alternatives"),
        ((SLOW, QUICK), {"moves": ("swim",)}, "nothing is called 'swim'"),
        ((SLOW, QUICK), {"library": "others"}, "no library 'others'"),
    ],
)
def test_bad_documents_get_one_line(room: Room, rows: tuple[KeyRow, ...], fields: dict[str, Any], match: str) -> None:
    with pytest.raises(RequestError, match=match) as caught:
        make(project_of(*rows, **fields), room, progress)
    assert "\n" not in str(caught.value)


def test_a_key_that_comes_too_soon_can_be_put_off(room: Room) -> None:
    rows = (SLOW, msgspec.structs.replace(TURNING, time=0.1, name="turn"))
    project = project_of(*rows)
    with pytest.raises(TooSoonError, match="from key 1 to turn takes"):
        make(project, room, progress)
    trouble = ANSWERS[KeyTrouble](room, project, KeyTrouble(1))
    assert isinstance(trouble, Trouble)
    assert trouble.row == 1
    assert trouble.seconds is not None
    later = msgspec.structs.replace(rows[1], time=0.1 + trouble.seconds)
    made = made_of(project_of(SLOW, later), room)
    assert made.synthesis.met[1] == pytest.approx(0.1 + trouble.seconds)
    assert ANSWERS[KeyTrouble](room, project_of(SLOW, later), KeyTrouble(2)) == Trouble(2)


def test_parts_are_met_where_they_are_asked_for(room: Room) -> None:
    wanted = (0.35, 1.25, 0.2)
    turned = tuple(rot.about("x", -0.4).tolist())
    parts = (PartRow("left_hand", "root", wanted), PartRow("right_hand", "world", (-0.2, 1.3, 2.2), None))
    row = msgspec.structs.replace(QUICK, position=(0.3, 1.9), heading=0.0, roles=("left_hand",), parts=parts)
    made = made_of(project_of(SLOW, row, force=True), room)
    motion = made.synthesis.motion
    frame = round(made.synthesis.met[1] * motion.fps)
    assert np.linalg.norm(ends_of(motion, frame)["left_hand"] - np.array(wanted)) < 1.5e-3
    there = role_positions(motion, ("right_hand",))[frame, 0]
    assert np.linalg.norm(there - np.array([-0.2, 1.3, 2.2])) < 1.5e-3
    hand = msgspec.structs.replace(QUICK, roles=("left_hand",), parts=(PartRow("left_hand", "root", None, turned),))
    waving = made_of(project_of(SLOW, hand, force=True), room)
    frame = round(waving.synthesis.met[1] * waving.synthesis.motion.fps)
    _, rotations = parts_of(waving.synthesis.motion, ["left_hand"])
    assert np.degrees(rot.angle_between(rotations[frame, 0], np.array(turned))) < 0.6


def test_where_every_part_of_a_key_is(room: Room) -> None:
    answer = ANSWERS[KeyEnds](room, project_of(SLOW), KeyEnds(1, SLOW))
    assert isinstance(answer, EndPlaces)
    motion = library_of(room).take("slow").motion()
    places, rotations = parts_of(motion, list(answer.positions))
    frame = round(motion.fps)
    np.testing.assert_allclose(list(answer.positions.values()), places[frame], atol=1e-6)
    np.testing.assert_allclose(list(answer.orientations.values()), rotations[frame], atol=1e-6)


def test_a_timing_that_is_too_quick_is_forced_only_where_it_is_asked(
    moves: Room, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = (WALK, msgspec.structs.replace(KICK, time=0.8))
    quick = project_of(*rows)
    with pytest.raises(UnmetError, match="force-timing"):
        make(quick, moves, progress)
    monkeypatch.setattr(making, "inbetween_with", None)  # what was refused is not searched for again
    trouble = ANSWERS[KeyTrouble](moves, quick, KeyTrouble(1))
    monkeypatch.undo()
    assert isinstance(trouble, Trouble)
    assert trouble.row == 1
    assert trouble.force
    assert "force" not in trouble.message
    made = made_of(project_of(*rows, force=True), moves)
    assert made.synthesis.met[1] == pytest.approx(0.8, abs=0.02)
    assert trouble.seconds is not None
    later = (WALK, msgspec.structs.replace(KICK, time=0.8 + trouble.seconds))
    assert made_of(project_of(*later), moves).synthesis.met[1] == pytest.approx(0.8 + trouble.seconds, abs=0.02)


def test_it_stops_when_progress_raises(room: Room) -> None:
    class Stop(Exception):
        pass

    def stop(done: int, total: int) -> None:
        raise Stop

    with pytest.raises(Stop):
        make(project_of(SLOW, QUICK, mirror=True, without=("turning",)), room, stop)


# ---- questions of the page ----


def answer(room: Room, project: Project, question: Message) -> Message | bytes:
    return ANSWERS[type(question)](room, project, question)


def test_the_pose_of_a_key_stands_above_the_origin(room: Room) -> None:
    frame = answer(room, project_of(), KeyPose(7, QUICK))
    assert isinstance(frame, bytes)
    assert b'"id":7' in frame[:120]
    path = room.folder / "pose.glb"
    path.write_bytes(_payload(frame))
    pose = kg.load(path).motion()
    assert len(pose) == 1
    assert pose.translation[0, [0, 2]] == pytest.approx(0.0, abs=1e-6)
    assert float(rot.heading(pose.rotations[0, 0])) == pytest.approx(0.0, abs=1e-6)


def _payload(frame: bytes) -> bytes:
    length = int.from_bytes(frame[4:8], "little")
    return frame[8 + length :]


def test_where_the_hands_of_a_key_are(room: Room) -> None:
    places = answer(
        room, project_of(), KeyEnds(1, msgspec.structs.replace(QUICK, moved={"left_hand": (0.3, 1.2, 0.2)}))
    )
    assert isinstance(places, EndPlaces)
    assert places.ends["left_hand"] == pytest.approx((0.3, 1.2, 0.2), abs=1e-3)
    assert set(places.ends) == {"left_hand", "right_hand", "left_foot", "right_foot"}
    motion = library_of(room).take("quick").motion()
    assert places.position == pytest.approx((motion.translation[75, 0], motion.translation[75, 2]), abs=1e-3)


def test_where_keys_are_met_and_alternatives_as_clips(moves: Room) -> None:
    project = project_of(WALK, KICK, PUNCH, alternatives=2)
    made = made_of(project, moves)
    moves.latest["keys"] = made
    met = answer(moves, project, KeysMet(1))
    assert isinstance(met, Met)
    assert [row.time for row in met.rows] == pytest.approx(made.synthesis.met)
    x, _, z = made.synthesis.motion.translation[round(30 * met.rows[1].time)]
    assert met.rows[1].position == pytest.approx((x, z))
    frame = answer(moves, project, Alternative(2, 1))
    assert isinstance(frame, bytes)
    assert _payload(frame) == encode(Take("studio", {"motion": made.syntheses[1].motion}), None)
    with pytest.raises(RequestError, match="no alternative 9"):
        answer(moves, project, Alternative(3, 8))


def test_a_pose_of_a_file_of_the_project(room: Room) -> None:
    folder = room.folder / FILES
    folder.mkdir(exist_ok=True)
    kg.save(walk(3.0, speed=0.9), folder / "mine.bvh")
    made = made_of(project_of(SLOW, KeyRow("mine.bvh@1.5")), room)
    assert len(made.synthesis.met) == 2
    kg.save(walk(3.0, speed=1.1), folder / "mine.bvh")
    other = made_of(project_of(SLOW, KeyRow("mine.bvh@1.5")), room)
    assert other.synthesis is not made.synthesis  # the file has changed


def test_the_same_names_are_told_apart(room: Room) -> None:
    rows = [replace_name(row, "step") for row in (SLOW, QUICK)]
    made = made_of(project_of(*rows), room)
    assert [span.label for span in made.lanes[0].spans] == ["step (1)", "step (2)"]


def replace_name(row: KeyRow, name: str) -> KeyRow:
    return msgspec.structs.replace(row, name=name)


def test_another_library_is_learned_anew(room: Room) -> None:
    before = made_of(project_of(SLOW, QUICK), room)
    library_of(room).add(Take("more", {"motion": walk(3.0, speed=1.0)}))
    after = made_of(project_of(SLOW, QUICK), room)
    assert after.synthesis is not before.synthesis


@pytest.mark.parametrize("name", ["walk"])
def test_hands_of_the_sample(clips_folder: Path, name: str) -> None:
    motion = kg.load(clips_folder / f"humanoid3d_{name}.txt").motion()
    ends = ends_of(motion, 10)
    for role, place in ends.items():
        wanted = place + np.array([0.05, 0.12, 0.1])
        moved = put_ends(motion, 10, {role: wanted})
        assert np.linalg.norm(ends_of(moved, 10)[role] - wanted) < 1e-6
        others = [other for other in ends if other != role]
        assert all(np.allclose(ends_of(moved, 10)[other], ends[other], atol=1e-9) for other in others)


def test_other_moves_need_no_other_index(moves: Room, monkeypatch: pytest.MonkeyPatch) -> None:
    made_of(project_of(WALK, PUNCH), moves)
    takes = library_of(moves)
    keys = tuple(key_at(takes.take(name).motion(), second) for name, second in (("walk", 0.4), ("punch", 0.5)))
    method = keyframe_control(InbetweenSearch(move=["run"]), ("kick",), mirror=False, footskate=True)
    expected = inbetween(keys, takes, method)[0]
    monkeypatch.setattr("kinetograph.methods.keyframe.timed_search.build_index", None)  # whoever builds one fails
    found = made_of(project_of(WALK, PUNCH, moves=("run",), without=("kick",)), moves).synthesis
    assert np.array_equal(found.motion.rotations, expected.motion.rotations)
    assert found.cost == expected.cost
