"""Keys of parts of the body, and requests that recordings cannot meet."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.errors import RequestError, TooSoonError, UnmetError
from kinetograph.evaluation import key_requests
from kinetograph.keys import Key, PartFromRoot, PartInWorld, key_at
from kinetograph.kinematics import forward
from kinetograph.methods.keyframe import Example, KeyframeModel, TimedSearch
from kinetograph.methods.keyframe.quality import Ordinary, jumps_of, ordinary_of, quality_of, slides_of
from kinetograph.methods.relative_pose import BODY
from kinetograph.motion import Motion, cut, headings
from kinetograph.post import misses_of_parts
from kinetograph.synthesis import Piece
from kinetograph.take import Annotation, Take
from walkers import slide, walk


@pytest.fixture(scope="module")
def walks(tmp_path_factory: pytest.TempPathFactory) -> kg.Library:
    library = kg.Library.create(tmp_path_factory.mktemp("parts") / "walks")
    for name, motion in (
        ("slow", walk(6.0, speed=0.8)),
        ("quick", walk(6.0, speed=1.2)),
        ("turning", walk(6.0, speed=1.0, turn_rate=0.5)),
    ):
        library.add(Take(name, {"motion": motion}))
    return library


@pytest.fixture(scope="module")
def model(walks: kg.Library) -> KeyframeModel:
    return kg.KeyframeControl().fit(walks)


@pytest.fixture(scope="module")
def forced(walks: kg.Library) -> KeyframeModel:
    """The arms of the walks hardly move: what moves them is worse than they are."""
    return kg.KeyframeControl(solver=TimedSearch(force_timing=True)).fit(walks)


def raised(motion: Motion) -> Motion:
    """With the left arm lifted ahead and bent."""
    rotations = motion.rotations.copy()
    rotations[:, motion.skeleton.index("left_shoulder")] = rot.about("x", -1.2)
    rotations[:, motion.skeleton.index("left_elbow")] = rot.about("x", -0.6)
    return replace(motion, rotations=rotations)


@pytest.mark.parametrize(
    "roles",
    [
        *(("left_hand",), ("left_hand", "right_hand"), ("left_elbow",), ("left_hand", "right_foot")),
        *(("left_knee", "left_foot"), tuple(role for role in BODY if role not in ("right_hand", "chest", "head"))),
    ],
)
def test_parts_of_a_pose_are_met_to_a_millimetre(walks: kg.Library, forced: KeyframeModel, roles: tuple[str, ...]):
    slow = walks.take("slow").motion()
    key = key_at(raised(slow), 3.0, time=(2.5, 2.5), roles=roles)
    result = forced.synthesize([key_at(slow, 0.5), key, key_at(slow, 5.0, time=(4.5, 4.5))])
    apart, twisted = misses_of_parts(cut(result.motion, 75, 76), cut(key.clip, key.frame, key.frame + 1), roles)
    assert apart.max() < 1e-3
    assert twisted.max() < np.radians(0.5)


def test_a_part_is_met_in_the_world_wherever_the_root_goes(walks: kg.Library, forced: KeyframeModel):
    slow = walks.take("slow").motion()
    for given in ({}, {"heading": 0.3}, {"heading": 0.3, "position": (0.1, 2.0)}):
        part = PartInWorld("left_hand", (0.3, 1.3, 2.35))
        key = key_at(slow, 3.0, time=(2.5, 2.5), roles=("left_hand",), parts=(part,), **given)
        result = forced.synthesize([key_at(slow, 0.5), key])
        hand = forward(result.motion)[0][-1, result.motion.skeleton.index("left_hand")]
        assert hand == pytest.approx(part.position, abs=1e-3), given
        if "heading" in given:
            assert headings(result.motion)[-1] == pytest.approx(0.3, abs=1e-6)


def test_parts_may_be_put_elsewhere_in_a_whole_pose(walks: kg.Library, forced: KeyframeModel):
    slow = walks.take("slow").motion()
    q = tuple(float(v) for v in rot.about("x", -1.5))
    part = PartFromRoot("left_hand", (0.25, 1.4, 0.4), (q[0], q[1], q[2], q[3]))
    result = forced.synthesize([key_at(slow, 0.5), key_at(slow, 3.0, time=(2.5, 2.5), parts=(part,))])
    pose = cut(result.motion, 75, 76)
    root = pose.translation[0] * [1.0, 0.0, 1.0]
    positions, world = forward(pose)
    hand = pose.skeleton.index("left_hand")
    turned = rot.about("y", -headings(pose)[0])
    assert rot.rotate(turned, positions[0, hand] - root) == pytest.approx(part.position, abs=1e-3)
    assert rot.angle_between(rot.multiply(turned, world[0, hand]), np.array(q)) < np.radians(0.5)
    right = pose.skeleton.index("right_hand")
    whole = forced.synthesize([key_at(slow, 0.5), key_at(slow, 3.0, time=(2.5, 2.5))]).motion
    assert pose.rotations[0, right] == pytest.approx(whole.rotations[75, right], abs=1e-6)


def test_parts_out_of_reach_are_refused_with_how_near_they_come(walks: kg.Library, model: KeyframeModel):
    slow = walks.take("slow").motion()
    first = key_at(slow, 0.5)
    far = PartFromRoot("left_hand", (0.2, 2.6, 0.0))
    for roles in (None, ("left_hand",)):
        with pytest.raises(
            UnmetError, match=r"high: the left hand is out of reach: it comes within \d+\.\d cm .* 2.60 m high"
        ):
            model.synthesize([first, key_at(slow, 3.0, roles=roles, parts=(far,), label="high")])
    key = key_at(slow, 3.0, position=(0.0, 2.0), parts=(PartInWorld("left_hand", (0.2, 1.2, 2.0)),))
    with pytest.raises(RequestError, match="the left hand is given in the world, and the heading is free"):
        model.synthesize([first, key])
    with pytest.raises(RequestError, match="left_hand: expected a position, an orientation or both"):
        PartFromRoot("left_hand")
    with pytest.raises(RequestError, match="an orientation is a unit quaternion"):
        PartFromRoot("left_hand", orientation=(2.0, 0.0, 0.0, 0.0))
    with pytest.raises(RequestError, match="left_hand is given two places"):
        Key(slow, parts=(far, far))
    with pytest.raises(RequestError, match="no joint plays the role 'tail'"):
        Key(slow, parts=(PartFromRoot("tail", (0.0, 1.0, 0.0)),))


def test_a_place_that_is_too_far_is_refused_with_one_that_is_met(walks: kg.Library, model: KeyframeModel):
    slow = walks.take("slow").motion()
    first = key_at(slow, 0.5)
    for time in ((1.5, 2.0),):
        key = key_at(slow, 3.0, time=time, position=(0.5, 6.0), label="far")
        with pytest.raises(
            TooSoonError, match=r"far: no route .* \(0.50, 6.00\) .*; the nearest place then is"
        ) as found:
            model.synthesize([first, key])
        error = found.value
        assert error.position is not None
        assert error.time is not None
        assert error.seconds == pytest.approx(error.time - 2.0)
        nearer = model.synthesize([first, replace(key, position=error.position)])
        assert nearer.motion.translation[-1, [0, 2]] == pytest.approx(error.position, abs=1e-6)
        # 1.2 m/s is the fastest walk, 15 % faster, and 0.3 m and a third are bent
        assert 2.0 < np.linalg.norm(np.array(error.position) - slow.translation[15, [0, 2]]) < 4.2
        later = model.synthesize([first, replace(key, time=(error.time, error.time))])
        assert later.motion.translation[-1, [0, 2]] == pytest.approx([0.5, 6.0], abs=1e-6)
        assert 3.0 < error.time < 6.0


# ---- quality ----


def test_recordings_are_as_good_as_themselves_and_a_jump_is_not():
    motion = walk(6.0)
    contacts = (Annotation("motion", "contact", "left_foot", 2.0, 2.6),)
    example = _example(motion, contacts)
    ordinary = ordinary_of([example])
    whole = [(Piece("walk", "motion", 0.0, 6.0, 0.0, 6.0), 0)]
    assert quality_of(motion, contacts, whole, [example], ordinary).good
    root = motion.translation.copy()
    root[90:] += [0.05, 0.0, 0.0]  # 1.5 m/s from a frame to the next
    jumped = quality_of(replace(motion, translation=root), contacts, whole, [example], ordinary)
    assert not jumped.good
    assert jumped.jump_at == pytest.approx(3.0, abs=0.05)
    assert "velocities jump" in jumped.words()
    slid = slide(motion, "hips", np.zeros((181, 3))).translation  # the body, and with it the planted foot
    slid = slid + np.outer(np.clip(np.arange(181) / 30 - 2.0, 0.0, 0.6), [0.4, 0.0, 0.0])
    found = quality_of(replace(motion, translation=slid), contacts, whole, [example], ordinary)
    assert found.skate > found.most_skate
    assert "planted feet slide" in found.words()


def test_jumps_and_slides_are_what_they_are():
    motion = walk(4.0)
    root = motion.translation.copy()
    root[60:] += [0.03, 0.0, 0.0]
    more = jumps_of(replace(motion, translation=root)) - jumps_of(motion)
    assert np.argmax(more) in (59, 60)
    assert more.max() == pytest.approx(0.03 * 30, rel=0.2)
    contacts = (Annotation("motion", "contact", "left_foot", 1.0, 3.0),)
    still = replace(motion, translation=motion.translation[:1] + np.outer(np.arange(121) / 30, [0.3, 0.0, 0.0]))
    still = replace(still, rotations=np.repeat(motion.rotations[:1], 121, axis=0))
    speed = slides_of(still, contacts)
    assert speed[60] == pytest.approx(0.3)
    assert speed[5] == 0.0


def _example(motion: Motion, contacts: tuple[Annotation, ...]) -> Example:
    return Example("walk", "motion", False, motion, contacts)


def test_what_is_worse_than_recorded_is_refused_with_a_duration_that_is_not(walks: kg.Library, model: KeyframeModel):
    slow = walks.take("slow").motion()
    rotations = slow.rotations.copy()
    rotations[:, 0] = rot.multiply(rotations[:, 0], rot.about("x", 1.4))  # the body pitched forward
    pitched = replace(slow, rotations=rotations, translation=slow.translation - [0.0, 0.4, 0.0])
    keys = [key_at(slow, 1.0, label="up"), key_at(pitched, 3.0, time=(0.5, 0.5), label="down")]
    with pytest.raises(RequestError, match=r"from up to down in 0.50 s .* x as .*; or force it \(--force-timing\)"):
        model.synthesize(keys)
    forced = replace(model.fitted, settings=TimedSearch(force_timing=True))
    result = replace(model, fitted=forced).synthesize(keys)
    assert any("velocities jump" in line or "planted feet slide" in line for line in result.warnings)
    assert result.statistics["jump"] > result.statistics["jump in recordings"] or (
        result.statistics["skate"] > result.statistics["skate in recordings"]
    )
    assert {"untouched", "furthest edit", "skate in recordings"} <= result.statistics.keys()


def test_figures_are_those_of_the_library(model: KeyframeModel):
    ordinary = model.fitted.index.ordinary
    assert isinstance(ordinary, Ordinary)
    assert len(ordinary.jump) == len(model.examples)
    own = [np.quantile(jumps_of(e.motion), 0.99) for e in model.examples]
    assert ordinary.jump == pytest.approx(np.maximum(own, 0.05))


def test_requests_that_people_met_are_met_or_refused(walks: kg.Library):
    rows = key_requests(walks, 6, held_out=("slow",))
    assert [row.kind for row in rows][-1] == "all"
    assert sum(row.requests for row in rows[:-1]) == rows[-1].requests == 6
    whole = rows[-1]
    assert whole.met + whole.refused == 6
    assert whole.met >= 3
    assert whole.miss_mm <= 1.0
    assert whole.miss_degrees <= 0.5
    assert whole.worst <= 1.0 + 1e-9
    assert whole.holds == whole.named


def test_requests_need_takes_that_are_long_enough(tmp_path: Path):
    short = kg.Library.create(tmp_path / "short")
    short.add(Take("slow", {"motion": walk(0.8)}))
    short.add(Take("quick", {"motion": walk(3.0)}))
    with pytest.raises(RequestError, match="no take of slow is longer"):
        key_requests(short, 2, held_out=("slow",))
