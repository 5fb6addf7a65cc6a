"""Feet that slide because they were made to, and stand once they are cleaned."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.kinematics import forward, joint_positions, role_positions
from kinetograph.motion import Motion, place
from kinetograph.post.footskate import (
    DEEPEST,
    FURTHEST,
    GRIP,
    clean_feet,
    contact_mask,
    foot_correction,
    hip_drop,
    move_foot,
)
from kinetograph.segmentation import detect_contacts
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation
from walkers import slide, walk

_FPS = 60.0


def _plants(duration: float = 4.0) -> tuple[Annotation, ...]:
    """The contacts of `walkers.walk`, which are known: left from 0 to 0.6 of a cycle, right half a cycle later."""
    notes = []
    for side, later in (("left", 0.0), ("right", 0.5)):
        for start in np.arange(-1, duration) + later:
            first, last = max(start, 0.0), min(start + 0.6, duration)
            if first < last:
                notes += [Annotation("motion", "contact", f"{side}_{part}", first, last) for part in ("foot", "toe")]
    return tuple(notes)


def _sliding(slip: float = 0.15) -> Motion:
    """A walk whose root goes faster than its legs: planted feet slide forward at ``slip`` m/s."""
    motion = walk(4.0, fps=_FPS)
    moved = motion.translation + np.outer(np.arange(len(motion)) / _FPS, [0.3 * slip, 0.0, slip])
    return dataclasses.replace(motion, translation=moved)


def _held(role: str, margin: float = GRIP) -> FloatArray:
    """Steps between frames at both of which a foot is planted and, ``margin`` s from either end, held."""
    inside = tuple(
        dataclasses.replace(n, start=n.start + margin, stop=n.stop - margin)
        for n in _plants()
        if n.label == role and n.stop - n.start > 2 * margin
    )
    mask = contact_mask(inside, role, 241, _FPS)
    return np.asarray(mask[1:] & mask[:-1])


def _ground_speed(motion: Motion, role: str) -> FloatArray:
    steps = np.diff(role_positions(motion, (role,))[:, 0, [0, 2]], axis=0)
    return np.asarray(np.linalg.norm(steps, axis=1) * _FPS)


@pytest.fixture(scope="module")
def cleaned() -> Motion:
    return clean_feet(_sliding(), _plants())


@pytest.mark.parametrize("role", ["left_foot", "left_toe", "right_foot", "right_toe"])
def test_a_planted_foot_stands_still(cleaned: Motion, role: str) -> None:
    assert _ground_speed(_sliding(), role)[_held(role)].min() > 0.14
    # what is left of 150 mm/s is the price of straightening the walker's long leg gently, see within_reach
    assert _ground_speed(cleaned, role)[_held(role)].max() < 2e-4


def test_only_the_legs_are_touched(cleaned: Motion) -> None:
    before = _sliding()
    np.testing.assert_array_equal(cleaned.translation, before.translation)
    legs = [before.skeleton.index(f"{s}_{p}") for s in ("left", "right") for p in ("hip", "knee", "foot")]
    others = np.setdiff1d(np.arange(15), legs)
    np.testing.assert_allclose(cleaned.rotations[:, others], before.rotations[:, others], atol=1e-15)


def test_feet_keep_their_turn_in_the_world_and_their_height(cleaned: Motion) -> None:
    before = _sliding()
    (old, old_turns), (new, new_turns) = forward(before), forward(cleaned)
    feet = [before.skeleton.index(f"{s}_{p}") for s in ("left", "right") for p in ("foot", "toe")]
    assert rot.angle_between(old_turns[:, feet], new_turns[:, feet]).max() < 1e-7
    np.testing.assert_allclose(new[:, feet, 1], old[:, feet, 1], atol=1e-3)  # as far as a leg is long enough


def test_a_leg_with_length_to_spare_holds_its_foot_better() -> None:
    crouched = _sliding()
    crouched = dataclasses.replace(crouched, translation=crouched.translation - [0.0, 0.12, 0.0])
    up = np.tile([0.0, 0.12, 0.0], (len(crouched), 1))
    bent = move_foot(move_foot(crouched, "left", up), "right", up)
    held = clean_feet(bent, _plants())
    for role in ("left_foot", "right_toe"):
        assert _ground_speed(bent, role)[_held(role)].min() > 0.14
        assert _ground_speed(held, role)[_held(role)].max() < 5e-5


def test_bones_keep_their_length(cleaned: Motion) -> None:
    for motion in (cleaned, _sliding()):
        positions = joint_positions(motion)
        lengths = np.linalg.norm(positions[:, 1:] - positions[:, motion.skeleton.parents[1:]], axis=-1)
        rest = np.linalg.norm(motion.skeleton.offsets[1:], axis=-1)
        np.testing.assert_allclose(lengths, np.broadcast_to(rest, lengths.shape), atol=1e-9)


def test_corrections_come_and_go_without_a_jump(cleaned: Motion) -> None:
    feet = ("left_foot", "right_foot")
    moved = role_positions(cleaned, feet) - role_positions(_sliding(), feet)
    slid = np.hypot(0.15, 0.045) / _FPS  # in a frame
    assert np.linalg.norm(np.diff(moved, axis=0), axis=-1).max() < 2 * slid
    assert np.linalg.norm(np.diff(moved, n=2, axis=0), axis=-1).max() < 0.6 * slid


def test_the_correction_of_a_plant_is_nought_on_average() -> None:
    offset = foot_correction(_sliding(), _plants(), "left", 0.2)
    for start in (0, 1, 2, 3):
        first, last = round(start * _FPS), round((start + 0.6) * _FPS)
        np.testing.assert_allclose(offset[first : last + 1].mean(axis=0), 0.0, atol=1e-9)
    np.testing.assert_array_equal(offset[:, 1], 0.0)


def test_a_correction_fades_before_the_first_and_after_the_last_plant() -> None:
    lone = (Annotation("motion", "contact", "left_toe", 2.0, 2.6),)
    size = np.linalg.norm(foot_correction(_sliding(), lone, "left", 0.2), axis=1)
    assert size[: round(1.79 * _FPS)].max() == 0.0
    assert size[round(2.81 * _FPS) :].max() == 0.0
    assert size[round(1.9 * _FPS)] > 0.0
    assert size[round(2.7 * _FPS)] > 0.0


def test_what_a_toe_moves_before_it_is_planted_is_not_held_against_it() -> None:
    # the ankle stands from 1.0 s on; the toe comes down at 1.3 s, 0.2 m on from where it was
    path = np.where(np.arange(121) < round(1.3 * _FPS), 0.0, 0.2)[:, None] * [0.0, 0.0, 1.0]
    motion = slide(walk(2.0, fps=_FPS, speed=0.0), "left_toe", path)
    contacts = tuple(Annotation("motion", "contact", f"left_{p}", t, 1.9) for p, t in (("foot", 1.0), ("toe", 1.3)))
    np.testing.assert_allclose(foot_correction(motion, contacts, "left", 0.2), 0.0, atol=1e-9)


def test_without_contacts_nothing_changes() -> None:
    motion = _sliding()
    assert clean_feet(motion, ()) is motion


def test_a_walk_that_does_not_slide_is_left_alone() -> None:
    motion = walk(4.0, fps=_FPS)
    np.testing.assert_allclose(clean_feet(motion, _plants()).rotations, motion.rotations, atol=1e-7)


def test_detected_contacts_do_as_well() -> None:
    motion = _sliding()
    contacts = detect_contacts(motion)
    cleaned = clean_feet(motion, contacts)
    assert _ground_speed(cleaned, "left_toe")[_held("left_toe", GRIP + 0.05)].max() < 2e-4


def test_a_body_without_legs_comes_back_as_it_was() -> None:
    plain = _sliding()
    skeleton = Skeleton(plain.skeleton.names, plain.skeleton.parents, plain.skeleton.offsets)
    motion = dataclasses.replace(plain, skeleton=skeleton)
    assert clean_feet(motion, _plants()) is motion


@pytest.mark.parametrize("turn", [0.0, 1.0, 2.5, -2.0])
def test_cleanup_does_not_depend_on_where_the_walker_faces(turn: float, cleaned: Motion) -> None:
    # but for a leg that is exactly straight, which has no plane of its own
    elsewhere = clean_feet(place(_sliding(), turn, (3.0, 0.0, -2.0)), _plants())
    expected = joint_positions(place(cleaned, turn, (3.0, 0.0, -2.0)))
    np.testing.assert_allclose(joint_positions(elsewhere), expected, atol=1e-6)


def test_twist_bones_between_hip_and_knee_are_kept() -> None:
    plain = _sliding()
    knee = plain.skeleton.index("left_knee")
    names = (*plain.skeleton.names[:knee], "left_twist", *plain.skeleton.names[knee:])
    moved = np.where(plain.skeleton.parents >= knee, plain.skeleton.parents + 1, plain.skeleton.parents)
    parents = np.insert(moved, knee, knee - 1)
    parents[knee + 1] = knee
    half = plain.skeleton.offsets[knee] / 2
    offsets = np.insert(plain.skeleton.offsets, knee, half, axis=0)
    offsets[knee + 1] = half
    roles = {r: dataclasses.replace(m, joint=m.joint + (m.joint >= knee)) for r, m in plain.skeleton.roles.items()}
    skeleton = Skeleton(names, parents, offsets, roles=roles)
    twist = rot.about("y", 0.3 * np.ones(241))
    rotations = np.insert(plain.rotations, knee, twist, axis=1)
    rotations[:, knee + 1] = rot.multiply(rot.about("y", -0.3), rotations[:, knee + 1])
    twisted = clean_feet(Motion(skeleton, plain.translation, rotations, _FPS), _plants())
    feet = ("left_foot", "left_toe", "left_knee")
    np.testing.assert_allclose(
        role_positions(twisted, feet), role_positions(clean_feet(plain, _plants()), feet), atol=1e-9
    )
    np.testing.assert_allclose(twisted.rotations[:, knee], twist, atol=1e-15)


def test_a_foot_is_moved_by_what_is_asked() -> None:
    motion = walk(1.0, fps=_FPS)
    offset = np.outer(np.sin(np.linspace(0, np.pi, 61)), [0.02, 0.05, -0.01])
    moved = role_positions(move_foot(motion, "right", offset), ("right_foot",)) - role_positions(
        motion, ("right_foot",)
    )
    np.testing.assert_allclose(moved[:, 0], offset, atol=2e-7)
    assert move_foot(motion, "right", np.zeros((61, 3))) is motion


def test_contact_frames_include_both_ends() -> None:
    notes = (Annotation("motion", "contact", "left_toe", 0.1, 0.3), Annotation("motion", "contact", "left_foot", 0, 1))
    assert np.flatnonzero(contact_mask(notes, "left_toe", 8, 10.0)).tolist() == [1, 2, 3]
    assert not contact_mask(notes, "right_toe", 8, 10.0).any()


def test_a_leg_is_straightened_gently_and_never_past_its_limit():
    from kinetograph.post.footskate import STRETCHED, straight_length, within_reach

    bend = np.radians(10)
    hip = np.array([[0.0, 0.8 * np.cos(bend), 0.0]])
    knee = np.array([[0.4 * np.sin(bend), 0.4 * np.cos(bend), 0.0]])
    ankle = np.zeros((1, 3))
    shift = np.linspace(0, 0.1, 200)[:, None] * np.array([0.0, -1.0, 0.0])
    furthest = STRETCHED * straight_length(hip, knee, ankle)
    drawn = within_reach(hip.repeat(200, axis=0), furthest.repeat(200), ankle.repeat(200, axis=0), shift)
    length = np.linalg.norm(drawn - hip, axis=1)
    now = np.linalg.norm(ankle - hip)
    assert np.all(length <= max(STRETCHED * 0.8, now) + 1e-12)
    assert np.all(np.diff(length) >= -1e-12)
    nearer = within_reach(hip, furthest, ankle, np.array([[0.0, 0.05, 0.0]]))
    np.testing.assert_allclose(nearer, [[0.0, 0.05, 0.0]], atol=1e-12)


def _tall() -> tuple[Motion, dict[str, FloatArray]]:
    """A walker who stands nearly straight, and a step aside of the left foot that its leg is too short for."""
    motion = walk(4.0, fps=_FPS)
    still = dataclasses.replace(
        motion,
        translation=np.tile(motion.translation[:1], (241, 1)),
        rotations=np.tile(motion.rotations[:1], (241, 1, 1)),
    )
    height = np.linalg.norm(np.diff(role_positions(still, ("left_hip", "left_foot"))[0], axis=0))
    bump = np.exp(-(((np.arange(241) - 120) / 30.0) ** 2))
    return still, {"left": 0.6 * height * bump[:, None] * [1.0, 0.0, 0.0]}


def test_the_hips_go_down_for_a_foot_to_be_reached() -> None:
    motion, offsets = _tall()
    drop = hip_drop(motion, offsets)
    assert np.all(drop[:, [0, 2]] == 0)
    assert 0.01 < drop[:, 1].max() <= DEEPEST + 1e-9
    assert np.all(drop[:20] == 0)
    assert np.abs(np.diff(drop[:, 1])).max() < 0.006
    before = role_positions(motion, ("left_foot",))[:, 0] + offsets["left"]
    lower = dataclasses.replace(motion, translation=motion.translation - drop)
    missed = [
        np.linalg.norm(role_positions(m, ("left_foot",))[:, 0] - before, axis=1)[100:140].max()
        for m in (move_foot(motion, "left", offsets["left"]), move_foot(lower, "left", offsets["left"], lowered=drop))
    ]
    assert missed[1] < 0.9 * missed[0]
    there = role_positions(move_foot(lower, "left", offsets["left"], lowered=drop), ("left_foot",))
    np.testing.assert_allclose(there[:, 0, 1], before[:, 1], atol=1e-6)  # on the floor all the while


def test_the_hips_stay_where_legs_are_long_enough() -> None:
    motion, offsets = _tall()
    assert not hip_drop(motion, {"left": 0.02 * offsets["left"]}).any()
    assert not hip_drop(motion, {}).any()


def test_a_foot_set_down_in_two_places_is_not_torn_to_their_middle() -> None:
    offset = foot_correction(_sliding(slip=2.0), _plants(), "left", 0.2)
    assert np.linalg.norm(offset, axis=1).max() == pytest.approx(FURTHEST)
    assert np.linalg.norm(foot_correction(_sliding(), _plants(), "left", 0.2), axis=1).max() < FURTHEST
