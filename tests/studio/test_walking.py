"""The studio's walk: what the page is sent is what the command line makes, and questions are answered from it."""

from __future__ import annotations

import asyncio
import itertools
import json
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.errors import KinetographError, RequestError
from kinetograph.formats import KeySources
from kinetograph.formats.csv import path_of
from kinetograph.formats.csv import read as read_csv
from kinetograph.methods.performance import (
    Fitted,
    PerformanceControl,
    PerformanceModel,
    Rule,
    arrivals,
    at_rate,
    left_early,
    next_best,
)
from kinetograph.motion import Motion
from kinetograph.pipeline import Smoothing, open_library, perform
from kinetograph.pipeline.requesting import asked_of
from kinetograph.studio.messages import (
    AskPace,
    AskWhy,
    CandidateClip,
    Candidates,
    Message,
    NextBest,
    Pace,
    PieceSource,
    PlayTake,
    WalkDrawn,
    WalkLive,
    Why,
)
from kinetograph.studio.project import LayerRow, Project, RuleRow, Walk
from kinetograph.studio.requests import walk_request
from kinetograph.studio.room import FILES, Room
from kinetograph.studio.walk.live import AT_ONCE, Follower, ready
from kinetograph.studio.walk.making import ANSWERS, HEARD, RUNS, make
from kinetograph.take import Annotation, Take
from walkers import walk

Path3 = tuple[tuple[float, float, float], ...]

_TURNS = {"straight": 0.0, "left": 0.7, "right": -0.7}


def _quiet(done: int, total: int) -> None:
    """Nobody watches."""


def _library(folder: Path) -> kg.Library:
    library = kg.Library.create(folder / "walks")
    for name, turn in _TURNS.items():
        cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(13) / 2)
        moves = (Annotation("body", "move", f"{name} step", 0.0, 6.0),)
        library.add(Take(name, {"body": walk(6.0, turn_rate=turn)}, (*cuts, *moves)))
    return library


def _drawn(seconds: float = 6.0, turn: float = 0.7, speed: float = 1.0) -> Path3:
    """A path whose points come at uneven times, as a mouse's do."""
    rng = np.random.default_rng(3)
    times = np.sort(rng.uniform(0.0, seconds, 200))
    times[0], times[-1] = 0.0, seconds
    motion = walk(seconds, turn_rate=turn, speed=speed, fps=300.0)
    ground = [np.interp(times, np.arange(len(motion)) / 300.0, motion.translation[:, axis]) for axis in (0, 2)]
    return tuple((float(t), float(x), float(z)) for t, x, z in zip(times, *ground, strict=True))


@pytest.fixture
def project(tmp_path: Path) -> Project:
    _library(tmp_path)
    return Project(libraries={"walks": "walks"}, walk=Walk(path=_drawn(), smooth_time=0.1, smooth_space=0.05))


def _ask(room: Room, project: Project, message: Message) -> Message | bytes:
    return ANSWERS[type(message)](room, project, message)


def _motion(data: Message | bytes, folder: Path) -> tuple[dict[str, object], Motion]:
    """The header and the motion of a blob."""
    assert isinstance(data, bytes)
    kind, length = struct.unpack_from("<2I", data)
    assert kind == 1
    (folder / "blob.glb").write_bytes(data[8 + length :])
    return json.loads(data[8 : 8 + length]), kg.load(folder / "blob.glb").motion()


def test_points_at_uneven_times_are_the_path_of_a_file_of_them(tmp_path: Path) -> None:
    rows = _drawn()
    (tmp_path / "path.csv").write_text("t,x,z\n" + "".join(f"{t!r},{x!r},{z!r}\n" for t, x, z in rows))
    read, made = read_csv(tmp_path / "path.csv").take.signal(), path_of(rows)
    np.testing.assert_array_equal(made.values, read.values)
    assert (made.fps, made.names, made.units) == (read.fps, read.names, read.units)


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (((0.0, 0.0, 0.0),), "expected two points or more"),
        (((0.0, 0.0, 0.0), (1.0, np.nan, 0.0)), "expected two points or more of finite numbers"),
        (((0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (1.0, 2.0, 0.0)), "times must increase, found 1 after 1"),
    ],
)
def test_points_that_are_no_path(rows: Path3, said: str) -> None:
    with pytest.raises(KinetographError, match=said):
        path_of(rows)


def test_a_walk_is_that_of_the_command_line(tmp_path: Path, project: Project) -> None:
    made = make(project, Room(tmp_path), _quiet)
    assert made is not None
    rows = "".join(f"{t!r},{x!r},{z!r}\n" for t, x, z in project.walk.path)
    (tmp_path / "path.csv").write_text("t,x,z\n" + rows)
    method = PerformanceControl(mirror=True)
    control = read_csv(tmp_path / "path.csv").take
    expected = perform(control, open_library(tmp_path / "walks"), method, smoothing=Smoothing(0.1, 0.05))
    np.testing.assert_array_equal(made.synthesis.motion.translation, expected.motion.translation)
    np.testing.assert_array_equal(made.synthesis.motion.rotations, expected.motion.rotations)
    assert made.synthesis.pieces == expected.pieces
    assert made.synthesis.cost == expected.cost


def test_figures_and_lanes_are_of_the_motion(tmp_path: Path, project: Project) -> None:
    made = make(project, Room(tmp_path), _quiet)
    assert made is not None
    error = next(lane for lane in made.lanes if lane.role == "error")
    moves = next(lane for lane in made.lanes if lane.role == "moves")
    assert len(error.values) == len(made.synthesis.motion)
    assert {span.label for span in moves.spans} == {"left step"}
    figures = {figure.name: figure.value for figure in made.figures}
    assert figures["path error"] == f"{np.mean(error.values):.1f} cm"
    assert float(figures["path error"].split()[0]) < 5.0
    assert figures["speed"] in ("0.99 m/s", "1.00 m/s", "1.01 m/s")
    # the error is of the path as it was drawn: a circle of radius 1 / 0.7 m
    hips = made.synthesis.motion.translation
    away = np.abs(np.hypot(hips[:, 0] - 1 / 0.7, hips[:, 2]) - 1 / 0.7)
    assert np.all(100 * away[15:-15] < np.array(error.values)[15:-15] + 2.0)


def test_without_a_path_there_is_no_walk(tmp_path: Path) -> None:
    _library(tmp_path)
    project = Project(libraries={"walks": "walks"}, walk=Walk(path=((0.0, 0.0, 0.0),)))
    assert make(project, Room(tmp_path), _quiet) is None


@pytest.mark.parametrize(
    ("walk_", "said"),
    [
        (Walk(path=((0.0, 0.0, 0.0), (0.05, 0.1, 0.0))), "too short"),
        (Walk(path=((0.0, 0.0, 0.0), (0.0, 0.1, 0.0))), "times must increase"),
        (Walk(path=_drawn(), rules=(RuleRow(2.0, 1.0),)), "a rule runs from a start to a later stop"),
        (Walk(path=_drawn(), rules=(RuleRow(1.0, 2.0, take="moon"),)), "no segment of the library matches"),
        (Walk(path=_drawn(), library="other"), "the project has no library 'other'"),
    ],
)
def test_what_cannot_be_walked_is_said_in_one_line(tmp_path: Path, walk_: Walk, said: str) -> None:
    _library(tmp_path)
    with pytest.raises(KinetographError, match=said) as failed:
        make(Project(libraries={"walks": "walks"}, walk=walk_), Room(tmp_path), _quiet)
    assert "\n" not in str(failed.value)


def test_what_progress_raises_ends_the_work(tmp_path: Path, project: Project) -> None:
    class Stopped(Exception):
        pass

    def stop(done: int, total: int) -> None:
        raise Stopped

    with pytest.raises(Stopped):
        make(project, Room(tmp_path), stop)


def test_the_pace_of_a_library(tmp_path: Path, project: Project) -> None:
    pace = _ask(Room(tmp_path), project, AskPace(5))
    assert isinstance(pace, Pace)
    assert pace.id == 5
    assert pace.usual == pytest.approx((1.0, 1.0, 1.0), abs=0.02)
    assert pace.fastest == pytest.approx(1.25, abs=0.02)  # a quarter faster than anybody walks
    assert pace.slowest == pytest.approx(0.0, abs=1e-6)  # somebody holds a pose
    assert [(take.name, take.seconds) for take in pace.takes] == [(name, 6.0) for name in _TURNS]


def _best_without(fitted: Fitted, x: np.ndarray, time: float, banned: set[int]) -> tuple[float, int]:
    """The least score of all sequences that show none of some segments at a time, and the segment that it shows."""
    states, durations = fitted.instances.states, fitted.instances.states[:, 1]
    steps, k, at = len(x) - 1, fitted.settings.continuity, time * fitted.settings.rate
    by_step = dict(enumerate(arrivals(fitted, x), start=1))
    early = left_early(fitted, x)
    best = (np.inf, -1)

    def go_back(stop: int, head: np.ndarray, score: float, shown: int) -> None:
        """Every sequence before a piece that begins at ``stop``."""
        nonlocal best
        if score >= best[0]:
            return
        if stop <= 0:
            best = (score, shown)
            return
        arrival = by_step[stop]
        for state in range(len(states)):
            start = stop - int(durations[state])
            here = start < at + 1e-5 and at < stop
            if not np.isfinite(arrival.costs[state]) or (here and int(states[state, 0]) in banned):
                continue
            seam = k * float(np.sum((arrival.tails[state].astype(float) - head) ** 2))
            after = int(states[state, 0]) if here else shown
            go_back(start, arrival.heads[state].astype(float), score + float(arrival.costs[state]) + seam, after)

    for used, arrival in itertools.chain([(None, by_step[steps])], early.items()):
        for state in range(len(states)):
            span = int(durations[state]) if used is None else used
            if used is not None and durations[state] <= used:
                continue
            here = steps - span < at + 1e-5 and at < steps
            if here and int(states[state, 0]) in banned:
                continue
            shown = int(states[state, 0]) if here else -1
            go_back(steps - span, arrival.heads[state].astype(float), float(arrival.costs[state]), shown)
    return best


def test_the_next_best_are_those_of_a_search_through_all_sequences(tmp_path: Path) -> None:
    library = kg.Library.create(tmp_path / "small")
    for name, turn in (("straight", 0.0), ("left", 0.6), ("right", -0.5)):
        motion = walk(2.4, turn_rate=turn, speed=1.0 + 0.1 * turn)
        cuts = tuple(Annotation("body", "cut", "", t, t) for t in (0.0, 0.8, 1.6, 2.4))
        library.add(Take(name, {"body": motion}, cuts))
    method = PerformanceControl(stretch=0.0, continuity=0.01, rate=5.0, reuse=0.0, stand=False)
    model = method.fit(library)
    control = model.read(path_of(_drawn(2.4, 0.3)))
    found = next_best(model.fitted, control, 1.3, 4)
    x = at_rate(control.points, control.fps, model.method.rate)
    banned: set[int] = set()
    assert len(found) == 5
    for each in found:
        score, segment = _best_without(model.fitted, x, 1.3, banned)
        assert each.cost == pytest.approx(score, rel=1e-5)
        chosen = model.fitted.instances.segments[segment]
        assert (each.piece.take, each.piece.source_start) == (model.fitted.sources[chosen.source].take, chosen.start)
        banned.add(segment)
    costs = [each.cost for each in found]
    assert costs == sorted(costs)
    for each in found:
        assert each.interpretation + each.continuity + each.reuse == pytest.approx(each.cost)
        terms = model.synthesize(path_of(_drawn(2.4, 0.3)), rules=each.rules)
        assert terms.cost == pytest.approx(each.cost, rel=1e-6)


def test_nothing_else_is_next_best_where_one_piece_is_left(tmp_path: Path) -> None:
    library = kg.Library.create(tmp_path / "one")
    cuts = tuple(Annotation("body", "cut", "", t, t) for t in (0.0, 0.6))
    library.add(Take("only", {"body": walk(0.6)}, cuts))
    model = PerformanceControl(stand=False).fit(library)
    assert len(next_best(model.fitted, model.read(path_of(_drawn(2.0, 0.0))), 1.0, 4)) == 1
    with pytest.raises(RequestError, match=r"lasts 2\.00 s, found a time of 3\.00 s"):
        next_best(model.fitted, model.read(path_of(_drawn(2.0, 0.0))), 3.0, 4)


def _made(tmp_path: Path, project: Project) -> Room:
    room = Room(tmp_path)
    made = make(project, room, _quiet)
    assert made is not None
    room.latest["walk"] = made
    return room


def test_why_a_piece_is_there(tmp_path: Path, project: Project) -> None:
    room = _made(tmp_path, project)
    shown = room.latest["walk"].synthesis
    answer = _ask(room, project, AskWhy(7, 3.0))
    assert isinstance(answer, Why)
    (chosen,) = (row for row in answer.rows if row.chosen)
    piece = shown.piece_at(90)
    assert (chosen.take, chosen.source_start) == (piece.take, piece.source_start)
    assert sum(chosen.terms.values()) == pytest.approx(shown.cost, rel=1e-4)
    other = next(row for row in answer.rows if not row.chosen)
    pinned = RuleRow(2.98, 3.02, other.take, (other.source_start + other.source_stop) / 2)
    ruled = Project(libraries=project.libraries, walk=_with(project.walk, (pinned,)))
    again = _ask(_made(tmp_path, ruled), ruled, AskWhy(8, 3.0))
    assert isinstance(again, Why)
    constraints = [row.constraint for row in again.without]
    assert any("pins take" in constraint for constraint in constraints)


def test_takes_and_files_drive_parts_of_a_walk(tmp_path: Path, project: Project) -> None:
    plain = make(project, Room(tmp_path), _quiet)
    assert plain is not None
    (tmp_path / FILES).mkdir(exist_ok=True)
    raised = walk(3.0)
    turned = raised.rotations.copy()
    turned[:, raised.skeleton.index("right_shoulder")] = rot.about("z", -1.0)
    kg.save(replace(raised, rotations=turned), tmp_path / FILES / "wave.bvh")
    layers = (
        LayerRow(("left arm",), "take:left", start=0.5, second=1.0, seconds=1.0),
        LayerRow(("right arm",), "wave.bvh", start=1.0, hold=True),
    )
    made = make(
        Project(libraries=project.libraries, walk=msgspec.structs.replace(project.walk, layers=layers)),
        Room(tmp_path),
        _quiet,
    )
    assert made is not None
    motion, before = made.synthesis.motion, plain.synthesis.motion
    knee, left, right = (motion.skeleton.index(name) for name in ("left_knee", "left_shoulder", "right_shoulder"))
    np.testing.assert_allclose(np.abs(motion.rotations[:, knee]), np.abs(before.rotations[:, knee]), atol=1e-4)
    assert rot.angle_between(motion.rotations[:, right], rot.about("z", -1.0)).max() < 1e-3
    recorded = kg.Library.open(tmp_path / "walks").take("left").motion()
    np.testing.assert_allclose(
        rot.angle_between(motion.rotations[30, left], recorded.rotations[round(1.5 * recorded.fps), left]),
        0.0,
        atol=1e-3,
    )
    lane = next(lane for lane in made.lanes if lane.name == "layers")
    assert [span.label for span in lane.spans] == ["left", "wave.bvh"]


@pytest.mark.parametrize(
    ("row", "match"),
    [
        (LayerRow(("arms",), "take:nobody"), "nobody"),
        (LayerRow(("arms",), "other.bvh"), "the project has no file 'other.bvh'"),
        (LayerRow(("wings",), "take:left"), "parts among arms"),
        (LayerRow(("arms",), "take:left", start=-1.0), "a layer's start is 0 s or more, found -1"),
        (LayerRow(("arms",), "take:left", second=90.0), r"a layer needs 0\.2 s of it, found 0\.00 s from 90\.00 s on"),
        (LayerRow(("arms",), "take:left", start=90.0), "the result, .* has none of it"),
    ],
)
def test_layers_that_cannot_be_get_one_line(tmp_path: Path, project: Project, row: LayerRow, match: str) -> None:
    asked = Project(libraries=project.libraries, walk=msgspec.structs.replace(project.walk, layers=(row,)))
    with pytest.raises(KinetographError, match=match) as caught:
        make(asked, Room(tmp_path), _quiet)
    assert "\n" not in str(caught.value)


def test_candidates_are_shown_pinned_and_forbidden(tmp_path: Path, project: Project) -> None:
    room = _made(tmp_path, project)
    shown = room.latest["walk"].synthesis
    answer = _ask(room, project, NextBest(7, 3.0))
    assert isinstance(answer, Candidates)
    first, second, *_ = answer.rows
    piece = shown.piece_at(90)
    assert (first.take, first.source_start, first.more, first.rules) == (piece.take, piece.source_start, 0.0, ())
    assert first.cost == pytest.approx(shown.cost)
    assert (second.take, second.source_start) != (first.take, first.source_start)
    assert second.more == pytest.approx(second.cost - first.cost)

    header, ghost = _motion(_ask(room, project, CandidateClip(8, second.rules)), tmp_path)
    assert header["id"] == 8
    ruled = Project(libraries=project.libraries, walk=_with(project.walk, second.rules))
    bound = make(ruled, Room(tmp_path), _quiet)
    assert bound is not None
    np.testing.assert_allclose(ghost.translation, bound.synthesis.motion.translation, atol=1e-5)
    there = bound.synthesis.piece_at(round(answer.time * 30))
    assert (there.take, there.source_start) == (second.take, second.source_start)

    middle = 0.5 * (second.source_start + second.source_stop)
    pin = RuleRow(answer.time, answer.time + 0.01, second.take, middle)
    pinned = make(Project(libraries=project.libraries, walk=_with(project.walk, (pin,))), Room(tmp_path), _quiet)
    assert pinned is not None
    there = pinned.synthesis.piece_at(round(answer.time * 30))
    assert (there.take, there.source_start) == (second.take, second.source_start)


def _with(walk_: Walk, rules: tuple[RuleRow, ...]) -> Walk:
    return Walk(path=walk_.path, smooth_time=walk_.smooth_time, smooth_space=walk_.smooth_space, rules=rules)


def test_the_source_of_a_piece_is_its_recording_where_it_stands(tmp_path: Path, project: Project) -> None:
    room = _made(tmp_path, project)
    piece = room.latest["walk"].synthesis.piece_at(90)
    header, ghost = _motion(_ask(room, project, PieceSource(9, 3.0)), tmp_path)
    assert header["start"] == pytest.approx(piece.start)
    recorded = walk(6.0, turn_rate=_TURNS[piece.take], fps=30.0)
    frames = (piece.source_time(piece.start + np.arange(len(ghost)) / 30) * 30).clip(0, len(recorded) - 1)
    lower = frames.astype(int)
    share = (frames - lower)[:, None]
    between = (1 - share) * recorded.translation[lower] + share * recorded.translation[(lower + 1).clip(max=180)]
    sign = np.array([-1.0, 1.0, 1.0]) if piece.mirrored else np.ones(3)
    cosine, sine = np.cos(piece.turn), np.sin(piece.turn)
    x, y, z = (between * sign).T
    placed = np.stack([cosine * x + sine * z, y, cosine * z - sine * x], axis=1) + piece.shift
    np.testing.assert_allclose(ghost.translation, placed, atol=2e-3)


def test_a_take_is_played_from_where_the_path_begins(tmp_path: Path, project: Project) -> None:
    there = tuple((t, x + 3.0, z - 2.0) for t, x, z in project.walk.path)
    moved = Project(libraries=project.libraries, walk=Walk(path=there))
    _, motion = _motion(_ask(Room(tmp_path), moved, PlayTake(3, "straight")), tmp_path)
    np.testing.assert_allclose(motion.translation[0, [0, 2]], [3.0, -2.0], atol=1e-5)
    way = motion.translation[30] - motion.translation[0]
    assert np.linalg.norm(way[[0, 2]]) == pytest.approx(1.0, abs=0.01)
    assert np.arctan2(way[0], way[2]) == pytest.approx(0.12, abs=0.08)  # the path turns left from z on
    with pytest.raises(RequestError, match="the library has no take 'moon'"):
        _ask(Room(tmp_path), moved, PlayTake(3, "moon"))


@pytest.mark.parametrize("message", [NextBest(1, 1.0), PieceSource(1, 1.0)])
def test_questions_about_a_walk_that_is_not_there(tmp_path: Path, project: Project, message: Message) -> None:
    with pytest.raises(RequestError, match="there is no walk yet; draw a path first"):
        _ask(Room(tmp_path), project, message)


def test_a_body_follows_while_the_path_is_drawn(tmp_path: Path, project: Project) -> None:
    path = np.array(_drawn(6.0, 0.7))
    sent: list[Message | bytes] = []

    async def draw() -> None:
        inbox: asyncio.Queue[Message] = asyncio.Queue()
        following = asyncio.create_task(RUNS[WalkLive](Room(tmp_path), project, WalkLive(), inbox, sent.append))
        for row in path:
            inbox.put_nowait(WalkDrawn((tuple(row.tolist()),)))
        while len(sent) < 1 + 165:
            assert not following.done()
            await asyncio.sleep(0.01)
        following.cancel()

    asyncio.run(asyncio.wait_for(draw(), 120))
    assert (WalkDrawn,) == HEARD
    header, body = _motion(sent[0], tmp_path)
    assert (header["kind"], header["section"], len(body)) == ("live", "walk", 1)
    poses = np.stack([np.frombuffer(each[4:], dtype="<f4") for each in sent[1:] if isinstance(each, bytes)])
    assert poses.shape[1] == 1 + 3 + 4 * len(body.skeleton)
    np.testing.assert_allclose(np.diff(poses[:, 0]), 1 / 30, atol=1e-5)
    late = poses[:, 0] > 1.0
    x, z = (np.interp(poses[late, 0], path[:, 0], path[:, i]) for i in (1, 2))
    gap = np.hypot(poses[late, 1] - x, poses[late, 3] - z)
    assert np.median(gap) < 0.15
    assert gap.max() < 0.4


def _followed(follower: Follower, points: tuple[tuple[float, float, float], ...]) -> list[Any]:
    """All poses that are due after some points."""
    poses = follower.draw(points)
    while follower.late:
        poses += follower.draw(())
    return poses


def test_poses_that_are_due_are_made_a_few_at_a_time(tmp_path: Path, project: Project) -> None:
    follower = Follower(ready(project, Room(tmp_path))[0])
    poses = follower.draw(tuple((0.1 * i, 0.0, 0.1 * i) for i in range(100)))
    assert len(poses) == AT_ONCE
    assert follower.late


def test_a_body_that_has_lost_the_path_begins_again_on_it(tmp_path: Path, project: Project) -> None:
    follower = Follower(ready(project, Room(tmp_path))[0])
    _followed(follower, ((0.0, 0.0, 0.0), (1.0, 0.0, 1.0), (9.0, 0.0, 1.0)))  # a pen that was thought to be held
    poses = _followed(follower, tuple((1.0 + 0.1 * i, 0.0, 1.0 + 0.1 * i) for i in range(1, 150)))
    assert len(poses) > 100
    for second, pose in poses[60:]:
        assert np.hypot(pose.translation[0], pose.translation[2] - second) < 0.5


def test_a_body_stays_where_the_pen_is_held(tmp_path: Path, project: Project) -> None:
    follower = Follower(ready(project, Room(tmp_path))[0])
    _followed(follower, tuple((0.1 * i, 0.0, 0.1 * i) for i in range(31)))
    poses = _followed(follower, tuple((3.0 + 0.1 * i, 0.0, 3.0) for i in range(1, 60)))
    for _, pose in poses[30:]:
        assert np.hypot(pose.translation[0], pose.translation[2] - 3.0) < 0.35


def test_a_model_is_fitted_once(tmp_path: Path, project: Project) -> None:
    from kinetograph.studio.walk.model import model_of

    room = Room(tmp_path)
    kept = Project(libraries=project.libraries, walk=Walk(path=_drawn(), keep_time=True))
    model: PerformanceModel = model_of(project, room)
    assert model_of(project, room) is model
    timely = model_of(kept, room)
    assert timely.fitted.instances is model.fitted.instances
    assert timely.method.keep_time
    assert not model.method.keep_time


@pytest.mark.parametrize("facing", [-120.0, 0.0, 60.0, 180.0])
def test_a_walk_begins_facing_as_it_is_asked(tmp_path: Path, project: Project, facing: float) -> None:
    walk_ = Walk(path=_drawn(6.0, 0.2), facing=facing)
    made = make(Project(libraries=project.libraries, walk=walk_), Room(tmp_path), _quiet)
    assert made is not None
    motion = made.synthesis.motion
    first = np.degrees(rot.heading(motion.rotations[0, 0]))
    assert abs((first - facing + 180) % 360 - 180) < 20
    x, z = motion.translation[-1, [0, 2]]
    assert np.hypot(x - walk_.path[-1][1], z - walk_.path[-1][2]) < 0.15  # and ends where the path does
    assert motion.duration >= 6.0 - 1e-6


def test_a_rule_is_that_of_the_search(tmp_path: Path, project: Project) -> None:
    rows = (RuleRow(1.0, 2.0, "left", 3.0), RuleRow(2.0, 3.0, "right", forbid=True))
    asking = msgspec.structs.replace(project, walk=msgspec.structs.replace(project.walk, rules=rows))
    asked = asked_of(walk_request(asking), KeySources())
    assert asked.rules == (Rule(1.0, 2.0, "left", source=3.0), Rule(2.0, 3.0, "right", forbid=True))
