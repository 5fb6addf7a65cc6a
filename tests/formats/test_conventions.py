"""Units and upward axes: conversions with known answers, and guesses on synthetic and on recorded motions."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.formats import ReadOptions, read
from kinetograph.formats.conventions import (
    UNITS,
    from_up,
    guess_units,
    guess_up,
    points_from_up,
    scale_motion,
    to_metres_y_up,
    to_up,
    unit_factor,
)
from kinetograph.kinematics import joint_positions, role_positions
from kinetograph.motion import Motion, cut
from kinetograph.skeleton import Landmark, Skeleton

BODY = (
    ("hips", -1, (0, 0.95, 0)),
    ("spine", 0, (0, 0.3, 0)),
    ("neck", 1, (0, 0.25, 0)),
    ("head", 2, (0, 0.1, 0)),
    ("left_thigh", 0, (0.1, 0, 0)),
    ("left_shin", 4, (0, -0.45, 0)),
    ("left_foot", 5, (0, -0.42, 0)),
    ("right_thigh", 0, (-0.1, 0, 0)),
    ("right_shin", 7, (0, -0.45, 0)),
    ("right_foot", 8, (0, -0.42, 0)),
)


def body() -> Skeleton:
    names, parents, offsets = zip(*BODY, strict=True)
    ends = np.array([[0, 0.2, 0.0]])
    roles = {"hips": Landmark(0), "head": Landmark(3), "left_foot": Landmark(6), "right_foot": Landmark(9)}
    return Skeleton(names, np.array(parents), np.array(offsets, dtype=float), np.array([3]), ends, roles)


def pose_over_time(translation: FloatArray, root: FloatArray) -> Motion:
    skeleton = body()
    rotations = rot.identity(len(translation), len(skeleton))
    rotations[:, 0] = root
    return Motion(skeleton, translation, rotations, 30.0)


def walking() -> Motion:
    """Along z, straight: the lowest point keeps its x as well as its height."""
    s = np.linspace(0, 1, 60)
    return pose_over_time(np.stack([0 * s, 0.95 + 0.02 * np.sin(20 * s), 4 * s], axis=1), rot.identity(60))


def getting_up() -> Motion:
    """Most of the time on the back, head towards +x and sliding about, then up."""
    angle = np.clip(np.linspace(2.5, 0, 90), 0, 1) * -np.pi / 2
    root = rot.about("z", angle)
    feet = np.array([0, -0.87, 0.0])
    slide = np.stack([0.3 * np.sin(np.arange(90) / 10), np.full(90, 0.1), 0.2 * np.cos(np.arange(90) / 15)], axis=1)
    return pose_over_time(slide - rot.rotate(root, feet), root)


def test_factors_are_those_of_the_units() -> None:
    assert [unit_factor(u) for u in ("metre", "centimetre", "millimetre", "inch", "foot")] == [
        1,
        0.01,
        0.001,
        0.0254,
        0.3048,
    ]
    assert unit_factor("cmu") == pytest.approx(0.056444, abs=1e-6)
    with pytest.raises(RequestError, match="unknown units 'yard'; expected one of metre, centimetre"):
        unit_factor("yard")


@pytest.mark.parametrize(("up", "point"), [("x", [-2, 1, 3]), ("y", [1, 2, 3]), ("z", [1, 3, -2])])
def test_points_turn_to_y_up(up: str, point: list[float]) -> None:
    np.testing.assert_allclose(points_from_up(np.array([1.0, 2, 3]), up), point, atol=1e-12)


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_turning_moves_every_joint_and_no_rest_offset(up: str) -> None:
    motion = getting_up()
    turned = from_up(motion, up)
    np.testing.assert_allclose(joint_positions(turned), points_from_up(joint_positions(motion), up), atol=1e-12)
    np.testing.assert_array_equal(turned.skeleton.offsets[1:], motion.skeleton.offsets[1:])
    np.testing.assert_allclose(turned.skeleton.offsets[0], points_from_up(motion.skeleton.offsets[0], up), atol=1e-12)
    back = to_up(turned, up)
    np.testing.assert_allclose(joint_positions(back), joint_positions(motion), atol=1e-12)


def test_scaling_takes_everything_with_it() -> None:
    motion = walking()
    bones = np.tile(motion.skeleton.offsets, (len(motion), 1, 1))
    big = scale_motion(Motion(motion.skeleton, motion.translation, motion.rotations, 30, bones), 100)
    np.testing.assert_allclose(joint_positions(big), 100 * joint_positions(motion), atol=1e-9)
    np.testing.assert_allclose(big.skeleton.end_offsets, [[0, 20, 0]])
    assert big.skeleton.roles["head"].joint == 3


@pytest.mark.parametrize("units", list(UNITS))
@pytest.mark.parametrize("size", [0.85, 1.0, 1.2])
def test_units_of_children_and_of_tall_people_are_guessed(units: str, size: float) -> None:
    motion = scale_motion(walking(), size / UNITS[units])
    guessed, note = guess_units([motion])
    assert guessed == units
    assert re.fullmatch(rf"units not given: guessed {units}, as the skeleton would stand [12]\.\d\d m tall", note)


def test_legs_alone_in_centimetres_are_no_giant_in_inches() -> None:
    skeleton = body()
    legs = Skeleton(
        skeleton.names[:1] + skeleton.names[4:], np.array([-1, 0, 1, 2, 0, 4, 5]), skeleton.offsets[[0, *range(4, 10)]]
    )
    motion = Motion(legs, walking().translation, rot.identity(60, 7), 30)
    guessed, note = guess_units([scale_motion(motion, 108)])
    assert guessed == "centimetre"
    assert "unlikely for a person, so check it with --units" in note


def test_a_skeleton_without_size_is_taken_as_metres() -> None:
    dot = Motion(Skeleton(("dot",), np.array([-1]), np.zeros((1, 3))), np.zeros((2, 3)), rot.identity(2, 1), 30)
    assert guess_units([dot]) == ("metre", "units not given, and the skeleton has no size: taken as metres")
    assert guess_up([dot])[0] == "y"


@pytest.mark.parametrize("up", ["x", "y", "z"])
@pytest.mark.parametrize("kind", [walking, getting_up])
def test_up_is_guessed_of_walking_and_of_getting_up(kind: object, up: str) -> None:
    motion = to_up(kind(), up)  # type: ignore[operator]
    assert guess_up([motion])[0] == up
    assert guess_up([cut(motion, len(motion) - 1, len(motion))])[0] == up  # one standing frame is enough


def test_what_is_given_is_not_guessed() -> None:
    motion = scale_motion(to_up(walking(), "z"), 1 / 0.0254)
    given = to_metres_y_up([motion], "inch", "z")
    assert given.notes == ()
    np.testing.assert_allclose(joint_positions(given.motions[0]), joint_positions(walking()), atol=1e-9)
    guessed = to_metres_y_up([motion], None, None)
    (note,) = guessed.notes  # one for a file
    assert [part.split(":")[1].split(",")[0] for part in note.split("; ")] == [" guessed inch", " guessed z"]
    np.testing.assert_allclose(joint_positions(guessed.motions[0]), joint_positions(walking()), atol=1e-9)
    with pytest.raises(RequestError, match="unknown upward axis 'up'; expected one of x, y, z"):
        to_metres_y_up([motion], "inch", "up")


EXPECTED = {
    "walks/*.bvh": ("metre", "z"),
    "actions/*.bvh": ("metre", "z"),
    "sports/*_amass30.bvh": ("metre", "z"),
    "sports/*_cmu60.bvh": ("centimetre", "y"),
    "salsa/*.bvh": ("inch", "z"),
    "sensors/neura/*.bvh": ("millimetre", "y"),
}


@pytest.mark.parametrize("pattern", EXPECTED)
def test_every_recording_is_guessed_right(data_folder: Path, pattern: str) -> None:
    files = sorted(data_folder.glob(pattern))
    if not files:
        pytest.skip(f"no recordings {pattern}")
    units, up = EXPECTED[pattern]
    for path in files:
        loaded = read(path)
        guesses = next(note for note in loaded.notes if note.startswith("units not given"))
        assert f"units not given: guessed {units}" in guesses, path.name
        assert f"up axis not given: guessed {up}" in guesses, path.name
    motion = read(files[0], ReadOptions(units, up)).take.motion()
    head, foot = role_positions(motion, ["head", "left_foot"])[-1, :, 1]
    assert head > foot
