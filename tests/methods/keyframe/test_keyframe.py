"""Keyframe control end to end: on made-up walks, and on the sample's clips where they are at hand."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.errors import FormatError, RequestError
from kinetograph.evaluation.keyframe import key_miss
from kinetograph.formats import read_keys
from kinetograph.keys import Key, key_at
from kinetograph.kinematics import joint_positions
from kinetograph.methods.keyframe import (
    ClusterChain,
    FittedClusterChain,
    FittedTimedSearch,
    KeyframeModel,
    TimedSearch,
    adopt_named,
    collect_examples,
    nearest_frame,
    pose_vectors,
    state_sequence,
)
from kinetograph.methods.keyframe.examples import mean_heading
from kinetograph.motion import Motion, cut, place
from kinetograph.post.assemble import PostSettings
from kinetograph.post.crossfading import crossfade
from kinetograph.post.meet import Waypoint, bend, meet_poses
from kinetograph.skeleton import Skeleton
from kinetograph.take import Take
from walkers import slide, stick_figure, walk

CLIPS = ("getup_facedown", "getup_faceup", "jump", "kick", "punch", "run", "walk")


@pytest.fixture(scope="module")
def walks(tmp_path_factory: pytest.TempPathFactory) -> kg.Library:
    library = kg.Library.create(tmp_path_factory.mktemp("keyframe") / "walks")
    library.add(Take("slow", {"motion": walk(6.0, speed=0.8)}))
    library.add(Take("quick", {"motion": walk(6.0, speed=1.2)}))
    library.add(Take("turning", {"motion": walk(6.0, speed=1.0, turn_rate=0.5)}))
    return library


@pytest.fixture(scope="module")
def model(walks: kg.Library) -> KeyframeModel:
    return kg.KeyframeControl().fit(walks)


@pytest.fixture(scope="module")
def clips(tmp_path_factory: pytest.TempPathFactory, clips_folder: Path) -> kg.Library:
    library = kg.Library.create(tmp_path_factory.mktemp("keyframe") / "clips")
    for name in CLIPS:
        take = kg.load(clips_folder / f"humanoid3d_{name}.txt")
        library.add(Take(name, take.tracks, take.annotations))
    return library


def lying_and_running(clips: kg.Library, seconds: float | None = None) -> list[kg.Key]:
    time = None if seconds is None else (seconds, seconds)
    first, last = clips.take("getup_facedown").motion(), clips.take("run").motion()
    return [key_at(first, 0.0, label="lying"), key_at(last, 0.4, time=time, label="running")]


@pytest.mark.parametrize("seconds", [None, 4.0, 6.0])
def test_from_lying_to_running_on_the_sample(clips: kg.Library, seconds: float | None):
    keys = lying_and_running(clips, seconds)
    result = kg.KeyframeControl().fit(clips).synthesize(keys)
    assert len({piece.take for piece in result.pieces}) >= 2
    assert key_miss(result, keys[0], 0) < 1e-3
    assert key_miss(result, keys[1], len(result.motion) - 1) < 1e-3
    assert seconds is None or result.motion.duration == pytest.approx(seconds)
    # every piece follows the one before, at most 15 % faster or slower than recorded
    for before, after in zip(result.pieces[:-1], result.pieces[1:], strict=True):
        assert after.start == pytest.approx(before.stop)
    assert all(0.85 - 1e-6 <= piece.stretch <= 1.15 + 1e-6 for piece in result.pieces)
    assert result.edited.shape == (len(result.motion),)
    assert 0 < result.statistics["untouched"] < 1


def test_alternatives_differ_and_meet_the_keys(clips: kg.Library):
    keys = lying_and_running(clips, 6.0)
    model = kg.KeyframeControl().fit(clips)
    results = model.alternatives(keys, 3)
    assert len(results) == 3
    assert len({tuple((p.take, round(p.source_start, 2)) for p in result.pieces) for result in results}) == 3
    for result in results:
        assert key_miss(result, keys[1], len(result.motion) - 1) < 1e-3
    assert results[0].cost == min(result.cost for result in results)


def test_a_span_is_held_while_the_rest_is_made_anew(walks: kg.Library, model: KeyframeModel):
    slow, quick = walks.take("slow").motion(), walks.take("quick").motion()
    first = model.synthesize([key_at(slow, 0.5), key_at(quick, 4.0, time=(6.0, 6.0))])
    keys = [key_at(quick, 1.0), key_at(slow, 3.2, time=(7.0, 7.0), label="new end")]
    result = model.synthesize_around(first, (2.0, 4.0), keys)
    assert result.motion.duration == pytest.approx(7.0)
    held = slice(60, 121)
    assert (result.motion.translation[held] == first.motion.translation[held]).all()
    assert (result.motion.rotations[held] == first.motion.rotations[held]).all()
    assert key_miss(result, keys[1], 210) < 1e-3
    for before, after in zip(result.pieces[:-1], result.pieces[1:], strict=True):
        assert after.start == pytest.approx(before.stop)
    assert result.pieces[0].start == 0
    assert result.pieces[-1].stop == pytest.approx(7.0)
    steps = np.linalg.norm(np.diff(result.motion.translation, axis=0), axis=1)
    assert steps.max() < 1.5 * max(np.linalg.norm(np.diff(m.translation, axis=0), axis=1).max() for m in (slow, quick))
    only_after = model.synthesize_around(first, (0.0, 4.0), keys[1:])
    assert only_after.motion.duration == pytest.approx(7.0)
    with pytest.raises(RequestError, match=r"lies between 0 and 6\.00 s, found 5 to 9 s"):
        model.synthesize_around(first, (5.0, 9.0), keys)
    with pytest.raises(RequestError, match="late: its time is within the span"):
        model.synthesize_around(first, (2.0, 4.0), [keys[0], key_at(slow, 1.0, time=(3.0, 3.0), label="late")])
    with pytest.raises(RequestError, match="free: around a span that is held every key has a time"):
        model.synthesize_around(first, (2.0, 4.0), [keys[0], key_at(slow, 1.0, label="free")])
    chain = kg.KeyframeControl(solver=ClusterChain()).fit(walks)
    with pytest.raises(RequestError, match=r"leaves times free; to hold a span use the timed search \(--mode search\)"):
        chain.synthesize_around(first, (2.0, 4.0), keys)


def test_the_least_duration_is_known_and_said(clips: kg.Library):
    with pytest.raises(RequestError, match=r"from lying to running takes 1\.\d+ s at least .* 1\.00 s are given"):
        kg.KeyframeControl().fit(clips).synthesize(lying_and_running(clips, 1.0))


def test_the_cluster_chain_goes_from_lying_to_running(clips: kg.Library):
    keys = lying_and_running(clips)
    chain = ClusterChain(clusters=8).fit(collect_examples(clips, 30.0), np.random.default_rng(0))
    (result,) = chain.solve(tuple(keys), 1, PostSettings())
    assert result.statistics["examples"] >= 2
    assert result.pieces[0].take == "getup_facedown"
    assert result.pieces[0].source_start == 0
    assert result.pieces[-1].take == "run"
    sequence = state_sequence(chain.model, *keys)
    assert sequence.examples[0] == sequence.nearest[0][0]
    assert sequence.examples[-1] == sequence.nearest[1][0]
    assert (np.diff(sequence.clusters) != 0).all()
    assert len(result.motion) == round(sum(p.stop - p.start for p in result.pieces) * 30)


@pytest.mark.parametrize("alone", [False, True])
def test_the_cluster_chain_knows_its_own_frames_however_they_face(walks: kg.Library, alone: bool):
    chain = ClusterChain(clusters=6).fit(collect_examples(walks, 30.0), np.random.default_rng(0))
    rng = np.random.default_rng(1)
    for _ in range(40):
        example = int(rng.integers(3))
        motion, frame = chain.model.examples[example].motion, int(rng.integers(180))
        moved = place(motion, rng.uniform(-np.pi, np.pi), (1.0, 0.0, 2.0))
        key = Key(cut(moved, frame, frame + 1)) if alone else key_at(moved, frame / 30)
        found, at, offset = nearest_frame(chain.model, key)
        assert abs(offset) < 1e-6
        nearest = chain.model.examples[found].motion.rotations[at]  # a made-up walk repeats its poses
        assert rot.angle_between(nearest[1:], motion.rotations[frame, 1:]).max() < 1e-6
        upright = [rot.without_heading(q) for q in (nearest[0], motion.rotations[frame, 0])]
        assert rot.angle_between(*upright) < 1e-6


def test_the_cluster_chain_holds_its_keys(clips: kg.Library):
    model = kg.KeyframeControl(solver=ClusterChain(clusters=8)).fit(clips)
    rng, solved = np.random.default_rng(0), 0
    for _ in range(60):
        keys = [_random_key(model, rng) for _ in range(2)]
        try:
            result = model.synthesize(keys)
        except RequestError:
            continue
        solved += 1
        assert result.met == (0.0, pytest.approx(result.motion.duration))
        assert key_miss(result, keys[0], 0) < 1e-6
        assert key_miss(result, keys[1], len(result.motion) - 1) < 1e-6
    assert solved > 40


def test_the_cluster_chain_meets_keys_between_two_frames(walks: kg.Library):
    model = kg.KeyframeControl(solver=ClusterChain(clusters=6)).fit(walks, exclude=("turning",))
    rng, misses = np.random.default_rng(3), []
    for _ in range(20):
        takes = rng.choice(["slow", "quick"], 3)
        keys = [key_at(walks.take(str(name)).motion(), rng.uniform(0.0, 5.9)) for name in takes]
        result = model.synthesize(keys)
        nearest = [round(second * 30) for second in result.met]
        misses += [key_miss(result, key, frame) for key, frame in zip(keys, nearest, strict=True)]
        # a recording is never played backwards, nor at twice its speed
        steps = np.linalg.norm(np.diff(result.motion.translation[:, [0, 2]], axis=0), axis=1) * 30
        assert steps.min() > 0.3
        assert steps.max() < 1.6


def test_the_cluster_chain_goes_through_several_keys(walks: kg.Library):
    model = kg.KeyframeControl(solver=ClusterChain(clusters=6)).fit(walks, exclude=("turning",))
    rng = np.random.default_rng(2)
    for _ in range(20):
        keys = [_random_key(model, rng) for _ in range(4)]
        result = model.synthesize(keys)
        assert len(result.met) == 4
        for key, second in zip(keys, result.met, strict=True):
            assert key_miss(result, key, round(second * 30)) < 1e-6
        pairs = [model.synthesize(pair) for pair in itertools.pairwise(keys)]
        assert result.cost == pytest.approx(sum(pair.cost for pair in pairs))
        # the key between two pairs is one frame, played through
        assert len(result.motion) == sum(len(pair.motion) for pair in pairs) - 2
        assert result.pieces[-1].stop == pytest.approx(len(result.motion) / 30)


def _random_key(model: KeyframeModel, rng: np.random.Generator) -> Key:
    example = model.examples[rng.integers(len(model.examples))]
    return key_at(example.motion, int(rng.integers(len(example.motion))) / 30, label=example.take)


def test_the_cluster_chain_names_clusters_that_can_be_reached(walks: kg.Library, tmp_path: Path):
    library = kg.Library.create(tmp_path / "apart")
    upright = walks.take("slow").motion()
    flat = upright.rotations.copy()
    flat[:, 0] = rot.multiply(rot.about("x", 1.5), flat[:, 0])
    library.add(Take("upright", {"motion": upright}))
    library.add(Take("flat", {"motion": replace(upright, rotations=flat)}))
    model = kg.KeyframeControl(solver=ClusterChain(clusters=4)).fit(library)
    keys = [key_at(library.take(name).motion(), 1.0) for name in ("upright", "flat")]
    with pytest.raises(RequestError, match=r"nearest that can be reached: \d \(in upright\)"):
        model.synthesize(keys)


def test_a_recording_between_its_own_frames_is_that_recording(walks: kg.Library):
    source = walks.take("turning").motion()
    keys = [key_at(source, 1.0), key_at(source, 4.0, time=(3.0, 3.0))]
    result = kg.KeyframeControl(post=PostSettings(footskate=False)).fit(walks).synthesize(keys)
    assert joint_positions(result.motion) == pytest.approx(joint_positions(cut(source, 30, 121)), abs=1e-3)
    assert result.cost == pytest.approx(0, abs=1e-3)
    assert result.statistics["untouched"] == 1


def test_several_keys_are_met_at_their_times_and_places(walks: kg.Library, model):
    slow, quick = walks.take("slow").motion(), walks.take("quick").motion()
    keys = [
        key_at(slow, 1.0),
        key_at(quick, 2.5, time=(2.0, 3.0), label="middle"),
        key_at(slow, 4.3, time=(5.0, 5.0), position=(0.4, 5.5), heading=0.2, label="end"),
    ]
    result = model.synthesize(keys)
    assert result.motion.duration == pytest.approx(5.0)
    assert result.motion.translation[-1, [0, 2]] == pytest.approx([0.4, 5.5], abs=1e-6)
    assert rot.heading(result.motion.rotations[-1, 0]) == pytest.approx(0.2, abs=1e-6)
    assert key_miss(result, keys[2], 150) < 1e-3
    assert min(key_miss(result, keys[1], frame) for frame in range(60, 91)) < 1e-3


def test_only_some_joints_may_be_keyed(walks: kg.Library, model):
    source = walks.take("slow").motion()
    raised = source.rotations.copy()
    raised[:, source.skeleton.index("left_shoulder")] = rot.about("x", -2.0)
    waving = replace(source, rotations=raised)
    keys = [key_at(source, 0.5), key_at(waving, 3.0, time=(2.5, 2.5), roles=("left_shoulder",))]
    result = model.synthesize(keys)
    shoulder = source.skeleton.index("left_shoulder")
    assert rot.angle_between(result.motion.rotations[-1, shoulder], raised[90, shoulder]) < np.radians(0.5)
    assert rot.angle_between(result.motion.rotations[45, shoulder], raised[90, shoulder]) > 1.0


def test_the_result_begins_where_the_first_key_stands(walks: kg.Library, model):
    moved = place(walks.take("slow").motion(), 1.0, (3.0, 0.0, -2.0))
    result = model.synthesize([key_at(moved, 1.0), key_at(moved, 3.0)])
    assert result.motion.translation[0] == pytest.approx(moved.translation[30], abs=1e-6)
    assert rot.heading(result.motion.rotations[0, 0]) == pytest.approx(1.0, abs=1e-6)


def test_a_key_of_another_size_is_matched_and_said(walks: kg.Library, model):
    small = stick_figure(0.8)
    motion = walks.take("slow").motion()
    child = Motion(small, motion.translation * 0.8, motion.rotations, motion.fps)
    result = model.synthesize([key_at(motion, 1.0), key_at(child, 3.0, label="child")])
    assert any("child: it has another skeleton" in text for text in result.warnings)


def test_bad_keys_are_refused(walks: kg.Library, model):
    motion = walks.take("slow").motion()
    one, two = key_at(motion, 1.0, label="one"), key_at(motion, 2.0, label="two", time=(1.0, 1.0))
    with pytest.raises(RequestError, match="expected 2 keys or more, found 1"):
        model.synthesize([one])
    with pytest.raises(RequestError, match=r"late: 9 s is outside its clip, which lasts from 0 to 6\.000 s"):
        key_at(motion, 9.0, label="late")
    with pytest.raises(RequestError, match="key: frame 500 is outside its clip"):
        kg.Key(motion, 500)
    with pytest.raises(RequestError, match="keys are out of order: early"):
        model.synthesize([one, two, key_at(motion, 3.0, time=(0.5, 0.5), label="early")])
    with pytest.raises(RequestError, match="time window is 0 <= earliest <= latest"):
        key_at(motion, 1.0, time=(2.0, 1.0))
    bare = Skeleton(motion.skeleton.names, motion.skeleton.parents, motion.skeleton.offsets)
    with pytest.raises(RequestError, match="robot: the library's poses are compared by roles that do not map"):
        model.synthesize([one, kg.Key(replace(motion, skeleton=bare), label="robot")])
    with pytest.raises(RequestError, match="no joint plays the role 'tail'"):
        key_at(motion, 1.0, roles=("tail",))
    with pytest.raises(RequestError, match=r"far: no route through the recordings leads to \(50.00, 0.00\) at 2 s; "):
        model.synthesize([one, key_at(motion, 3.0, time=(2.0, 2.0), position=(50.0, 0.0), label="far")])


def test_bad_libraries_and_settings_are_refused(walks: kg.Library, tmp_path: Path):
    with pytest.raises(RequestError, match="the library has no take to use"):
        kg.KeyframeControl().fit(kg.Library.create(tmp_path / "empty"))
    mixed = kg.Library.create(tmp_path / "mixed")
    mixed.add(walks.take("slow"))
    stick = Skeleton(("root",), np.array([-1]), np.zeros((1, 3)))
    mixed.add(Take("stick", {"motion": Motion(stick, np.zeros((9, 3)), rot.identity(9, 1), 30.0)}))
    model = kg.KeyframeControl().fit(mixed)
    assert {example.take for example in model.examples} == {"slow"}
    assert [name for names in model.left_out.values() for name in names] == ["stick"]
    with pytest.raises(RequestError, match="no take 'nobody' to leave out; there are slow, quick, turning"):
        kg.KeyframeControl().fit(walks, exclude=("slow", "nobody"))
    for solver in ("search", TimedSearch):
        with pytest.raises(RequestError, match=r"solver must be TimedSearch\(...\) or ClusterChain\(...\), found"):
            kg.KeyframeControl(solver=solver)
    with pytest.raises(RequestError, match="warp is a share"):
        TimedSearch(warp=0.9)
    with pytest.raises(RequestError, match="expected 2 clusters or more"):
        ClusterChain(clusters=1)


def test_the_solver_is_chosen_by_its_class(walks: kg.Library):
    search, chain = (kg.KeyframeControl(solver=s).fit(walks) for s in (TimedSearch(meet=0.5), ClusterChain()))
    assert isinstance(kg.KeyframeControl().solver, TimedSearch)
    assert isinstance(search.fitted, FittedTimedSearch)
    assert isinstance(chain.fitted, FittedClusterChain)
    slow = walks.take("slow").motion()
    keys = [key_at(slow, 1.0), key_at(slow, 3.0, time=(2.0, 2.0))]
    assert key_miss(search.synthesize(keys), keys[1], 60) < 1e-3
    assert "clusters" in chain.alternatives(keys, 1)[0].statistics


def test_the_cluster_chain_says_what_it_cannot_do(walks: kg.Library):
    model = kg.KeyframeControl(solver=ClusterChain()).fit(walks)
    slow = walks.take("slow").motion()
    one, two = (key_at(slow, float(t), label=f"key {t}") for t in range(2))
    remedy = r"the timed search \(--mode search\)"
    with pytest.raises(RequestError, match=f"has one answer; for alternatives use {remedy}"):
        model.alternatives([one, two])
    with pytest.raises(RequestError, match=f"key 0: .* leave roles out, or use {remedy}"):
        model.synthesize([replace(one, roles=("left_hand",)), two])
    assert model.synthesize([one, replace(two, time=(1.0, 1.0))]).warnings == (
        "key 1: the cluster chain leaves times and places free",
    )
    raised = slow.rotations.copy()
    raised[:, slow.skeleton.index("left_shoulder")] = rot.about("x", -3.0)
    (said,) = model.synthesize([one, key_at(replace(slow, rotations=raised), 2.0, label="waving")]).warnings
    assert "waving: the nearest recorded pose is" in said
    assert "--mode search" in said


def test_takes_that_are_read_are_counted(walks: kg.Library):
    done: list[tuple[int, int]] = []
    kg.KeyframeControl(solver=ClusterChain()).fit(walks, progress=lambda *counts: done.append(counts))
    assert done == [(1, 3), (2, 3), (3, 3)]


def test_examples_are_mirrored_with_their_contacts(walks: kg.Library):
    plain, mirrored = collect_examples(walks, 30.0, mirror=True, exclude=("quick", "turning"))
    assert (plain.mirrored, mirrored.mirrored) == (False, True)
    left, right = ([n for n in e.contacts if n.label == f"{s}_toe"] for e, s in ((plain, "left"), (mirrored, "right")))
    assert [(n.start, n.stop) for n in left] == [(n.start, n.stop) for n in right] != []


def test_examples_have_rigid_bones(tmp_path: Path):
    library = kg.Library.create(tmp_path / "slides")
    for name in ("first", "second"):
        library.add(Take(name, {"motion": slide(walk(2.0), "left_hand", np.full((61, 3), 0.1))}))
    assert [example.motion.bones for example in collect_examples(library, 30.0)] == [None, None]


def test_pose_vectors_do_not_depend_on_facing(walks: kg.Library):
    motion = walks.take("turning").motion()
    turned = place(motion, 2.5, (1.0, 0.0, 1.0))
    assert pose_vectors(turned) == pytest.approx(pose_vectors(motion), abs=1e-9)


def test_the_mean_heading_is_circular():
    assert abs(np.degrees(mean_heading(np.radians([179.0, -179.0, 178.0, -178.0])))) == pytest.approx(180)


def test_another_body_comes_onto_the_librarys_skeleton_or_is_named():
    motion = walk(2.0)
    small = adopt_named(motion, stick_figure(0.5), "a key")
    assert small.translation == pytest.approx(0.5 * motion.translation)
    # one of nearly the same build keeps its path on the ground
    alike = adopt_named(motion, stick_figure(0.98), "a key")
    assert alike.translation[:, [0, 2]] == pytest.approx(motion.translation[:, [0, 2]])
    stick = Skeleton(("root",), np.array([-1]), np.zeros((1, 3)))
    with pytest.raises(RequestError, match=r"a key \(15 joints\) and the library's first take \(1 joints\)"):
        adopt_named(motion, stick, "a key")


def test_a_crossfade_of_a_motion_with_itself_changes_nothing():
    motion = walk(2.0)
    mixed = crossfade(cut(motion, 0, 40), cut(motion, 30, 61), 10)
    assert joint_positions(mixed) == pytest.approx(joint_positions(motion), abs=1e-9)
    with pytest.raises(RequestError, match="cannot blend over 50 frames"):
        crossfade(cut(motion, 0, 40), motion, 50)


def test_bending_meets_places_and_leaves_standing_feet():
    steps = walk(4.0)
    still = Motion(steps.skeleton, steps.translation[[0] * 30], steps.rotations[[0] * 30], 30.0)
    motion = Motion(
        steps.skeleton,
        np.concatenate([steps.translation, steps.translation[-1] + 0 * still.translation]),
        np.concatenate([steps.rotations, steps.rotations[[-1] * 30]]),
        30.0,
    )
    bent = bend(motion, [Waypoint(0, None, 0), Waypoint(len(motion) - 1, None, 0, 5.0 + 1.0j, 0.5)])
    assert bent.translation[-1, [2, 0]] == pytest.approx([5.0, 1.0])
    assert rot.heading(bent.rotations[-1, 0]) == pytest.approx(0.5)
    assert np.ptp(joint_positions(bent)[125:], axis=0).max() < 1e-9
    assert joint_positions(bent)[0] == pytest.approx(joint_positions(motion)[0])


def test_meeting_poses_fades_and_leaves_other_waypoints():
    motion = walk(4.0)
    other = replace(motion, rotations=rot.identity(len(motion), len(motion.skeleton)))
    points = [Waypoint(30, other, 0), Waypoint(40, motion, 40)]
    met = meet_poses(motion, points, 0.5)
    assert met.rotations[30] == pytest.approx(other.rotations[0], abs=1e-9)
    assert rot.angle_between(met.rotations[40], motion.rotations[40]).max() < 1e-6
    assert met.rotations[60:] == pytest.approx(motion.rotations[60:])


def test_keys_are_read_from_json(walks: kg.Library, tmp_path: Path):
    kg.save(walks.take("slow").motion(), tmp_path / "slow.bvh")
    file = tmp_path / "keys.json"
    file.write_text(
        '{"keys": [{"pose": "slow.bvh@1"}, {"pose": "take:quick@2", "time": [1, 2.5], "position": [0.5, 2],'
        ' "heading": 90, "roles": ["left_hand"], "name": "reach"}]}'
    )
    first, second = read_keys(file, walks)
    assert first.label == "key 1"
    assert first.time is None
    assert second.label == "reach"
    assert second.time == (1.0, 2.5)
    assert second.heading == pytest.approx(np.pi / 2)
    assert second.roles == ("left_hand",)
    for text, wanted in (
        ("[]", r"keys.json: expected \{\"keys\""),
        ('{"keys": [{"pose": "slow.bvh@1", "tine": 2}]}', "unknown field `tine`"),
    ):
        file.write_text(text)
        with pytest.raises(FormatError, match=wanted):
            read_keys(file, walks)
    for pose, wanted in (
        ("slow.bvh", "a pose is FILE@SECOND"),
        ("slow.bvh@99", "99 s is outside its clip"),
        ("take:fast@1", "no take 'fast'"),
    ):
        file.write_text(json.dumps({"keys": [{"pose": pose}]}))
        with pytest.raises(RequestError, match=wanted):
            read_keys(file, walks)
    with pytest.raises(FormatError, match=r"none\.json: cannot open it"):
        read_keys(tmp_path / "none.json")
