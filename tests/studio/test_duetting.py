"""The studio's duet: what the page is sent is what the command line makes, and questions are answered from it."""

from __future__ import annotations

import asyncio
import json
import re
import struct
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from couples import TAKES, couple, dances
from typer.testing import CliRunner

import kinetograph as kg
from bodies import blocks, person
from kinetograph.cli import app
from kinetograph.cli.configurations import Finish, Partner, Search, finished, performance_control
from kinetograph.errors import KinetographError, RequestError
from kinetograph.evaluation.dance import leave_one_dance_out
from kinetograph.formats import ReadOptions, WriteOptions, load, save
from kinetograph.kinematics import joint_positions, role_positions
from kinetograph.methods.performance import PerformanceControl, Rule, partner_control
from kinetograph.motion import Motion, cut, resample
from kinetograph.pipeline import open_library, perform_with, read_take, segment_library
from kinetograph.segmentation import notation
from kinetograph.stopping import stoppable
from kinetograph.studio.duet import making as duetting
from kinetograph.studio.duet import rehearsing
from kinetograph.studio.duet.comparing import FACING, compared
from kinetograph.studio.duet.leading import ADVICE
from kinetograph.studio.duet.making import Dance, MadeDuet, make
from kinetograph.studio.made import bodies
from kinetograph.studio.messages import (
    AskHands,
    AskLeader,
    AskLeaders,
    CandidateClip,
    Candidates,
    LeaderFacts,
    Message,
    NextBest,
    PieceSource,
    Rehearse,
    Rehearsed,
    ShowLeader,
    Transcribe,
)
from kinetograph.studio.project import Duet, Project, RuleRow
from kinetograph.studio.room import FILES, Room
from kinetograph.studio.walk import answers as walk_answers
from kinetograph.take import Annotation, Take

# ---- inputs ----


def _quiet(done: int, total: int) -> None:
    """Nobody watches."""


@pytest.fixture
def room(tmp_path: Path) -> Room:
    dances(tmp_path / "dances")
    (tmp_path / FILES).mkdir()
    return Room(tmp_path)


def _project(**duet: object) -> Project:
    return Project(mode="duet", libraries={"dances": "dances"}, duet=Duet(**duet))  # type: ignore[arg-type]


def _made(room: Room, **duet: object) -> MadeDuet:
    made = make(_project(**duet), room, _quiet)
    assert made is not None
    room.latest["duet"] = made
    return made


def _ask(room: Room, project: Project, message: Message) -> Any:
    """What answers a question of the page."""
    return {**walk_answers.ANSWERS, **duetting.ANSWERS}[type(message)](room, project, message)


def _same(one: Motion, other: Motion) -> None:
    np.testing.assert_array_equal(one.translation, other.translation)
    np.testing.assert_array_equal(one.rotations, other.rotations)


def _near(read: Motion, written: Motion) -> None:
    """Joints of one name are within 2 mm, whatever order a file has them in."""
    order = [read.skeleton.index(name) for name in written.skeleton.names]
    np.testing.assert_allclose(joint_positions(read)[:, order], joint_positions(written), atol=2e-3)


# ---- what is made ----


@pytest.mark.parametrize("mirror", [False, True])
def test_the_configuration_is_that_of_the_command_line(mirror: bool) -> None:
    theirs = finished(performance_control(Search(), Partner(), mirror=mirror, partners=True), None, Finish())
    assert theirs == replace(partner_control(), mirror=mirror)


def test_a_take_is_answered_as_the_command_line_answers_it(room: Room) -> None:
    leader = room.folder / "leader.npz"
    save(open_library(room.folder / "dances").take("even").motion("leader"), leader)
    answer, library = room.folder / "answer.npz", str(room.folder / "dances")
    options = ["--target", "follower", "--exclude", "even", "--mirror", "-o", str(answer)]
    run = CliRunner().invoke(app, ["perform", str(leader), "-l", library, *options])
    assert run.exit_code == 0, run.output
    made = _made(room, leader="take:even", mirror=True)
    theirs = load(answer).motion()
    np.testing.assert_allclose(joint_positions(made.synthesis.motion), joint_positions(theirs), atol=1e-5)
    assert {piece.take for piece in made.synthesis.pieces} <= set(TAKES) - {"even"}


def test_the_leader_and_the_recorded_follower_come_with_it(room: Room) -> None:
    take = open_library(room.folder / "dances").take("even")
    made = _made(room, leader="take:even")
    assert list(made.others) == ["leader", "truth"]
    _same(made.others["leader"], take.motion("leader"))
    _same(made.others["truth"], take.motion("follower"))
    swapped = _made(room, leader="take:even", target="leader")
    _same(swapped.others["leader"], take.motion("follower"))
    assert len(swapped.synthesis.motion) == len(take.motion("leader"))


def test_rules_are_kept(room: Room) -> None:
    rule = RuleRow(2.0, 4.0, take="slow")
    pieces = _made(room, leader="take:even", rules=(rule,)).synthesis.pieces
    assert {p.take for p in pieces if p.start < 3.9 and p.stop > 2.1} == {"slow"}
    rule = msgspec.structs.replace(rule, forbid=True)
    pieces = _made(room, leader="take:even", rules=(rule,)).synthesis.pieces
    assert {p.take for p in pieces if p.start < 3.9 and p.stop > 2.1} == {"quick"}


def test_it_is_fitted_once(room: Room, monkeypatch: pytest.MonkeyPatch) -> None:
    fits: list[tuple[str, ...]] = []
    fit = PerformanceControl.fit

    def counted(self: PerformanceControl, library: kg.Library, **how: object) -> object:
        fits.append(how["exclude"])  # type: ignore[arg-type]
        return fit(self, library, **how)  # type: ignore[arg-type]

    monkeypatch.setattr(PerformanceControl, "fit", counted)
    for rules in ((), (RuleRow(2.0, 4.0, take="slow"),)):
        _made(room, leader="take:even", rules=rules)
    assert fits == [("even",)]
    _made(room, leader="take:slow")
    assert fits == [("even",), ("slow",)]


def test_takes_without_the_target_or_a_partner_are_left_out(room: Room) -> None:
    library = open_library(room.folder / "dances")
    leader, follower = couple(1.0)
    library.add(Take("alone", {"leader": leader}))
    library.add(Take("others", {"a": leader, "b": follower}))
    assert {piece.take for piece in _made(room, leader="take:even").synthesis.pieces} <= {"slow", "quick"}
    answer = _ask(room, _project(), AskLeaders(3))
    assert [row.take for row in answer.takes] == list(TAKES)


# ---- what is said of it ----


def _lanes(made: MadeDuet) -> dict[str, object]:
    return {lane.name: lane for lane in made.lanes}


def test_the_error_is_the_mean_distance_of_the_joints(room: Room) -> None:
    made = _made(room, leader="take:even")
    truth = made.others["truth"]
    distance = np.linalg.norm(joint_positions(made.synthesis.motion) - joint_positions(truth), axis=-1).mean(axis=1)
    lane = next(lane for lane in made.lanes if lane.role == "error")
    np.testing.assert_allclose(lane.values, 100 * distance, atol=1e-3)
    figures = {figure.name: figure.value for figure in made.figures}
    assert figures["from the recording"] == f"{100 * distance.mean():.1f} cm"


def test_facing_right_is_within_a_bound(room: Room) -> None:
    dance = Dance.of(_project(leader="take:even"), room)
    truth = dance.leader.truth
    assert truth is not None
    rotations = truth.rotations.copy()
    away = np.where(np.arange(len(truth)) < len(truth) // 4, FACING + 0.01, FACING - 0.01)
    rotations[:, 0] = kg.rotations.multiply(kg.rotations.about("y", away), rotations[:, 0])
    figures = {f.name: f.value for f in compared(replace(truth, rotations=rotations), (), dance.leader).figures}
    assert figures["facing right"] == "75 %"


def test_hands_that_meet_and_hands_that_do_not() -> None:
    leader, follower = couple(1.0, apart=0.6)
    lead = leader_of_motion(leader)
    apart = np.linalg.norm(role_positions(follower, ("left_hand",)) - role_positions(leader, ("right_hand",)), axis=-1)
    holds = (
        Annotation("motion", "handhold", "left_hand:right_hand", 1.0, 2.0),
        Annotation("motion", "handhold", "left_hand:left_hand", 3.0, 4.0),
    )
    reach = 0.28
    (lane,) = compared(follower, holds, lead).lanes
    assert lane.name == "left hand"
    assert [span.label.startswith("missed: ") for span in lane.spans] == [bool(np.median(apart[30:61]) > reach), True]
    assert f"{100 * np.median(apart[30:61]):.0f} cm apart" in lane.spans[0].title


def test_the_joints_of_hands_are_those_of_the_bodies(room: Room) -> None:
    made = _made(room, leader="take:even")
    notes = [note for note in made.synthesis.annotations if note.kind == "handhold"]
    said = _ask(room, _project(leader="take:even"), AskHands(4))
    assert [(h.start, h.stop) for h in said.holds] == [(n.start, n.stop) for n in notes]
    assert {(h.own, h.theirs) for h in said.holds} == {("LeftHand", "RightHand")}


def test_partners_who_wear_another_build_stay_hand_in_hand(room: Room) -> None:
    made = _made(room, leader="take:even")
    slim = replace(person(), offsets=person().offsets * np.array([1.15, 0.95, 1.0]))
    worn = bodies({"motion": made.synthesis.motion, **made.others}, blocks(slim, 0.1), made.annotations)
    holds = [note for note in made.synthesis.annotations if note.kind == "handhold"]
    recorded = list(made.dance.leader.holds) if made.dance else []
    assert holds
    assert recorded
    for name, notes in (("motion", holds), ("truth", recorded)):
        own = made.synthesis.motion if name == "motion" else made.others[name]
        for note in notes:
            before = _gap(own, made.others["leader"], note)
            np.testing.assert_allclose(_gap(worn.motion(name), worn.motion("leader"), note), before, atol=1e-3)
    alone = bodies({"motion": made.synthesis.motion, **made.others}, blocks(slim, 0.1))
    hand = ("right_hand",)
    moved = role_positions(alone.motion("leader"), hand) - role_positions(made.others["leader"], hand)
    assert np.linalg.norm(moved, axis=-1).max() > 0.05  # without handholds, the longer arm reaches past them


def _gap(own: Motion, partner: Motion, note: Annotation) -> np.ndarray:
    mine, theirs = note.label.split(":")
    held = slice(int(np.ceil(note.start * own.fps)), int(note.stop * own.fps) + 1)
    apart = role_positions(own, (mine,))[held, 0] - role_positions(partner, (theirs,))[held, 0]
    return np.linalg.norm(apart, axis=-1)


def leader_of_motion(motion: Motion):
    from kinetograph.studio.duet.leading import Leader

    return Leader("someone", "motion", motion)


def test_the_transcript_is_that_of_the_model(room: Room) -> None:
    made = _made(room, leader="take:even")
    said = _ask(room, _project(leader="take:even"), Transcribe(5))
    assert made.model is not None
    moves = made.model.transcribe(made.others["leader"])
    assert said.id == 5
    assert [(m.move, m.start, m.stop) for m in said.moves] == [(m.move, m.start, m.stop) for m in moves]
    assert [m.margin for m in said.moves] == [m.margin if np.isfinite(m.margin) else None for m in moves]
    assert [m.notation for m in said.moves] == [notation([m.move]) if m.move else "" for m in moves]
    msgspec.json.encode(said)  # no number that JSON has not


def test_margins_are_the_same_where_states_are_placed_again(room: Room, monkeypatch: pytest.MonkeyPatch) -> None:
    made = _made(room, leader="take:even")
    assert made.model is not None
    once = made.model.transcribe(made.others["leader"])
    monkeypatch.setattr("kinetograph.methods.performance.interpretation.MOST", 0)
    assert made.model.transcribe(made.others["leader"]) == once


def test_without_names_there_is_advice_in_place_of_a_transcript(room: Room) -> None:
    library = open_library(room.folder / "dances")
    for name in TAKES:
        library.annotate(name, (), kind="move", track="follower")
    _made(room, leader="take:even")
    assert "library label" in _ask(room, _project(leader="take:even"), Transcribe(5)).advice


def test_a_transcript_of_what_is_not_shown_any_more_is_given_up(room: Room) -> None:
    made = _made(room, leader="take:even")
    assert made.model is not None

    class Watched:
        fitted = made.model.fitted

        def transcribe(self, control: object, rules: object, progress: Callable[[int, int], None]) -> None:
            del room.latest["duet"]
            progress(0, 3)

    room.latest["duet"] = replace(made, model=Watched())  # type: ignore[arg-type]
    with pytest.raises(RequestError, match="another follower"):
        _ask(room, _project(leader="take:even"), Transcribe(5))


def test_the_next_best_pieces_of_a_duet(room: Room) -> None:
    project = _project(leader="take:even")
    made = _made(room, leader="take:even")
    found = _ask(room, project, NextBest(7, 3.0, 2))
    assert isinstance(found, Candidates)
    shown, *others = found.rows
    piece = made.synthesis.piece_at(90)
    assert (shown.take, shown.source_start) == (piece.take, pytest.approx(piece.source_start, abs=0.2))
    assert others
    assert all(row.cost >= shown.cost for row in others)
    frame = _ask(room, project, CandidateClip(8, others[0].rules))
    assert isinstance(frame, bytes)
    (room.folder / "candidate.glb").write_bytes(frame[8 + struct.unpack_from("<2I", frame)[1] :])
    rules = tuple(Rule(r.start, r.stop, take=r.take, source=r.source, forbid=r.forbid) for r in others[0].rules)
    assert made.model is not None
    wanted = perform_with(made.model, made.others["leader"], rules=rules).motion
    candidate = load(room.folder / "candidate.glb").motion()
    np.testing.assert_allclose(candidate.translation, wanted.translation, atol=1e-4)
    assert isinstance(_ask(room, project, PieceSource(9, 3.0)), bytes)


def test_without_a_follower_there_are_no_pieces(room: Room) -> None:
    with pytest.raises(RequestError, match="there is no follower yet"):
        _ask(room, _project(), NextBest(7, 3.0, 2))


# ---- leaders ----


def test_takes_that_can_lead(room: Room) -> None:
    said = _ask(room, _project(), AskLeaders(7))
    assert said.library == "dances"
    assert [(row.take, row.persons) for row in said.takes] == [(name, ("leader",)) for name in TAKES]
    assert (said.target, said.targets) == ("follower", ("follower", "leader"))
    assert said.takes[0].seconds == pytest.approx(6.0)
    facts = _ask(room, _project(leader="take:slow"), AskLeader(8))
    assert facts == LeaderFacts(8, "slow", 6.0, "leader", ("leader",), True)


def test_a_library_with_partners_is_found_among_others(room: Room) -> None:
    alone = kg.Library.create(room.folder / "alone")
    alone.add(Take("someone", {"body": couple(1.0)[0]}))
    project = msgspec.structs.replace(_project(leader="take:even"), libraries={"alone": "alone", "dances": "dances"})
    assert make(project, room, _quiet) is not None
    named = _ask(room, project, AskLeaders(1, "alone"))
    assert not named.takes
    assert "library add" in named.advice
    project = msgspec.structs.replace(project, libraries={"alone": "alone"})
    assert _ask(room, project, AskLeaders(1)).advice == ADVICE
    with pytest.raises(RequestError, match="library add DANCES --take NAME leader=FILE follower=FILE"):
        make(project, room, _quiet)


def test_a_file_of_another_build_in_other_units_leads(room: Room) -> None:
    leader, _ = couple(1.0)
    tall = replace(
        leader,
        skeleton=replace(leader.skeleton, offsets=1.1 * leader.skeleton.offsets),
        translation=leader.translation * [1.0, 1.1, 1.0],
    )
    save(tall, room.folder / FILES / "tall.bvh", options=WriteOptions(units="centimetre", up="z"))
    made = _made(room, leader="tall.bvh", units="centimetre", up="z")
    assert list(made.others) == ["leader"]
    _near(made.others["leader"], tall)
    dance = Dance.of(_project(leader="tall.bvh", units="centimetre", up="z"), room)
    assert dance.leader.take is None
    _same(made.synthesis.motion, perform_with(dance.model(room), made.others["leader"]).motion)


def test_what_is_guessed_of_a_file_is_said(room: Room) -> None:
    odd = room.folder / FILES / "odd.bvh"
    save(couple(1.0)[0], odd, options=WriteOptions(units="centimetre", up="z"))
    odd.write_text(re.sub(r"Frame Time: .*", "Frame Time: 0.033333", odd.read_text()))  # as another program writes it
    guessed = load_notes(odd)
    assert guessed
    made = _made(room, leader="odd.bvh")
    assert set(guessed) <= set(made.synthesis.warnings)
    assert _ask(room, _project(leader="odd.bvh"), AskLeader(1)).notes == guessed


def load_notes(path: Path) -> tuple[str, ...]:
    return read_take(path, ReadOptions())[1]


def test_someone_of_a_file_of_several_is_chosen(room: Room) -> None:
    leader, follower = couple(1.0)
    save(Take("pair", {"Ann": follower, "Ben": leader}), room.folder / FILES / "pair.glb")
    facts = _ask(room, _project(leader="pair.glb"), AskLeader(1))
    assert (facts.person, facts.persons) == ("Ann", ("Ann", "Ben"))
    assert any("2 people in it (Ann, Ben); Ann leads" in note for note in facts.notes)
    made = _made(room, leader="pair.glb", person="Ben")
    np.testing.assert_allclose(made.others["leader"].translation, leader.translation, atol=1e-5)
    assert not any("people in it" in warning for warning in made.synthesis.warnings)


@pytest.mark.parametrize(
    ("duet", "message"),
    [
        ({"leader": "take:nobody"}, "no take 'nobody'"),
        ({"leader": "gone.bvh"}, "no file 'gone.bvh'"),
        ({"leader": "../secret.bvh"}, "without a folder"),
        ({"leader": "take:even", "target": "cook"}, "no take of two people has a track 'cook'"),
        ({"leader": "take:even", "person": "cook"}, "nobody in it is called 'cook'; choose one of leader"),
        ({"leader": "take:even", "library": "walks"}, "no library 'walks'"),
        ({"leader": "broken.bvh"}, "broken.bvh"),
        ({"leader": "path.csv"}, "expected a motion to lead"),
        ({"leader": "short.npz"}, "too short"),
        ({"leader": "tall.bvh", "units": "elbow"}, "elbow"),
    ],
)
def test_what_cannot_lead_is_said_in_a_line(room: Room, duet: dict[str, str], message: str) -> None:
    files = room.folder / FILES
    (files / "broken.bvh").write_text("HIERARCHY\nROOT")
    (files / "path.csv").write_text("t,x,z\n0,0,0\n0.5,0.6,0\n1,1.2,0\n")
    save(cut(couple(1.0)[0], 0, 3), files / "short.npz")
    save(couple(1.0)[0], files / "tall.bvh")
    with pytest.raises(KinetographError, match=message) as raised:
        make(_project(**duet), room, _quiet)
    assert "\n" not in str(raised.value)


def test_without_a_leader_nothing_is_made(room: Room) -> None:
    assert make(_project(), room, _quiet) is None
    with pytest.raises(RequestError, match="choose a leader first"):
        _ask(room, _project(), AskLeader(1))
    with pytest.raises(RequestError, match="choose a leader first"):
        _ask(room, _project(), Transcribe(1))


def test_the_leader_is_shown_before_anything_is_made(room: Room) -> None:
    frame = _ask(room, _project(leader="take:even"), ShowLeader(9))
    kind, length = struct.unpack_from("<2I", frame)
    assert kind == 1
    assert json.loads(frame[8 : 8 + length])["name"] == "even"
    path = room.folder / "leader.glb"
    path.write_bytes(frame[8 + length :])
    take = load(path)
    leader = open_library(room.folder / "dances").take("even").motion("leader")
    _near(take.motion(), leader)


# ---- stopping ----


class _Stopped(Exception):
    pass


def test_work_that_reports_nothing_is_left_at_once() -> None:
    let_go, began = threading.Event(), time.monotonic()

    def progress(done: int, total: int) -> None:
        if time.monotonic() - began > 0.2:
            raise _Stopped

    with pytest.raises(_Stopped):
        stoppable(lambda report: let_go.wait(30), progress)
    assert time.monotonic() - began < 1.0
    let_go.set()


def test_work_that_is_left_stops_where_it_reports() -> None:
    went_on, ended = [], threading.Event()

    def work(report: Callable[[int, int], None]) -> None:
        try:
            while True:
                time.sleep(0.01)
                report(1, 2)
                went_on.append(1)
        finally:
            ended.set()

    def progress(done: int, total: int) -> None:
        if (done, total) == (1, 2):
            raise _Stopped

    with pytest.raises(_Stopped):
        stoppable(work, progress)
    assert ended.wait(5)


def test_results_errors_and_progress_come_through() -> None:
    seen = set()

    def work(report: Callable[[int, int], None]) -> str:
        report(3, 4)
        time.sleep(0.2)
        return "done"

    assert stoppable(work, lambda done, total: seen.add((done, total))) == "done"
    assert (3, 4) in seen
    with pytest.raises(RequestError, match="no such"):
        stoppable(lambda report: (_ for _ in ()).throw(RequestError("no such")), _quiet)


def test_a_dance_is_stopped_within_a_second(room: Room) -> None:
    began: list[float] = []

    def progress(done: int, total: int) -> None:
        began.append(time.monotonic())
        raise _Stopped

    with pytest.raises(_Stopped):
        make(_project(leader="take:even"), room, progress)
    assert time.monotonic() - began[0] < 1.0


# ---- live ----


def test_a_rehearsal_gives_what_the_model_gives_live(room: Room) -> None:
    dance = Dance.of(_project(leader="take:even"), room)
    model = dance.model(room)
    live = model.start(rehearsing.FPS, 0.5, keep=False)
    frames = resample(dance.leader.motion, rehearsing.FPS)
    poses = [pose for i in range(len(frames)) for pose in live.step(cut(frames, i, i + 1))] + list(live.rest())
    rehearsal = rehearsing.Rehearsal(model, dance.leader, 0.5)
    shown, second = [], 0.0
    while not rehearsal.is_over():
        while rehearsal.seen <= second + 1e-9:
            rehearsal.see()
        if (pose := rehearsal.due(second)) is not None:
            assert pose.time <= second - rehearsal.delay + 1e-9
            shown.append(pose)
        second += 1 / rehearsing.FPS
    by_time = {pose.time: pose for pose in poses}
    assert len(shown) > 0.9 * len(poses)
    assert all(np.array_equal(pose.rotations, by_time[pose.time].rotations) for pose in shown)
    gaps = np.diff([pose.time for pose in shown])
    assert gaps.max() < 2.5 / rehearsing.FPS  # no bursts
    assert rehearsal.error() is not None


def test_rehearsing_sends_a_body_poses_and_how_it_goes(room: Room) -> None:
    sent: list[Message | bytes] = []
    short = Take("short", {"leader": cut(couple(1.0)[0], 0, 61)})
    save(short.motion("leader"), room.folder / FILES / "short.npz")
    asyncio.run(rehearsing.rehearse(room, _project(leader="short.npz"), Rehearse(0.3), asyncio.Queue(), sent.append))
    kinds = [struct.unpack_from("<I", frame)[0] for frame in sent if isinstance(frame, bytes)]
    assert kinds[0] == 1
    assert kinds[1:] == [2] * len(kinds[1:])
    assert len(kinds) > 30
    said = [message for message in sent if isinstance(message, Rehearsed)]
    assert [message.running for message in said] == [True] * (len(said) - 1) + [False]
    assert np.all(np.diff([message.second for message in said]) >= 0)
    assert said[-1].error is None  # nobody knows who followed
    assert said[-1].seconds == pytest.approx(2.0)
    joints = (len(next(f for f in sent[1:] if isinstance(f, bytes))) - 4) // 4 - 4
    assert joints == 4 * len(person())


@pytest.mark.parametrize("lag", [-0.1, 11.0])
def test_a_lag_out_of_range_is_refused(room: Room, lag: float) -> None:
    run = rehearsing.rehearse(room, _project(leader="take:even"), Rehearse(lag), asyncio.Queue(), lambda frame: None)
    with pytest.raises(RequestError, match="the lag of a rehearsal is 0 to 10 s"):
        asyncio.run(run)


# ---- real dances ----


@pytest.fixture(scope="module")
def salsa(data_folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Room:
    folder = data_folder / "salsa"
    if not folder.is_dir():
        pytest.skip("no dances: the folder of recordings has no salsa/")
    room = Room(tmp_path_factory.mktemp("salsa"))
    library = kg.Library.create(room.folder / "dances")
    for name in ("Easy_01", "Easy_02", "Easy_03"):
        pair = {t: read_take(folder / f"{name}_{t}.bvh", ReadOptions("inch", "z"))[0].motion() for t in _PAIR}
        library.add(Take(name, {track: resample(motion, 30.0) for track, motion in pair.items()}))
    segment_library(library, "beats")
    return room


_PAIR = ("leader", "follower")


def test_a_real_dance_has_the_figures_of_the_evaluation(salsa: Room) -> None:
    made = _made(salsa, leader="take:Easy_02")
    library = open_library(salsa.folder / "dances")
    rows = leave_one_dance_out(partner_control(), library, "follower", baselines=False)
    (row,) = (each for each in rows if each.take == "Easy_02")
    figures = {figure.name: figure.value for figure in made.figures}
    assert figures["from the recording"] == f"{row.joint_cm:.1f} cm"
    assert figures["handholds"] == f"{row.hold_median_cm:.1f} cm"
    assert row.joint_cm < 12.0
    assert row.hold_median_cm < 2.0
    assert float(figures["facing right"].removesuffix(" %")) > 90.0
    assert {piece.take for piece in made.synthesis.pieces} <= {"Easy_01", "Easy_03"}
