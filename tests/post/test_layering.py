"""Parts of the body as layers have them: what they drive, what stays, and how the rest follows."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import bodies
from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.formats import write_report
from kinetograph.kinematics import forward, joint_positions, role_positions
from kinetograph.motion import Motion, place
from kinetograph.pipeline import layered
from kinetograph.post import (
    Following,
    Layer,
    LayerSettings,
    driven_joints,
    layer_weights,
    learn_following,
    with_layer,
)
from kinetograph.post.balance import facing_of, mass_above
from kinetograph.post.reaching import held_feet, reach_limbs
from kinetograph.synthesis import Piece, Synthesis
from kinetograph.take import Annotation
from walkers import walk

SKELETON = bodies.person()
ARMS = driven_joints(SKELETON, ["arms"])


def _base(frames: int = 240) -> Motion:
    """Somebody who walks on the spot and faces elsewhere as time goes on."""
    motion = bodies.walk(SKELETON, frames=frames)
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.about("y", np.linspace(0.0, 1.5, frames))
    return replace(motion, rotations=rotations)


def _waving(frames: int = 240, swing: float = 0.3, lean: float = 0.2) -> Motion:
    """Somebody who stands, swings the chest, leans and waves both arms."""
    times = np.arange(frames) / 30.0
    motion = bodies.walk(SKELETON, frames=frames)
    rotations = rot.identity(frames, len(SKELETON))
    rotations[:, SKELETON.index("Chest")] = rot.multiply(
        rot.about("y", swing * np.sin(3.0 * times)), rot.about("x", lean * np.ones(frames))
    )
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        rotations[:, SKELETON.index(f"{side}Arm")] = rot.about("z", sign * np.sin(2.0 * times))
        rotations[:, SKELETON.index(f"{side}ForeArm")] = rot.about("y", -sign * (1.0 + 0.3 * np.cos(times)))
    return replace(motion, rotations=rotations)


def _chest(motion: Motion, facing: Motion) -> FloatArray:
    """The chest's rotations as seen from where a body faces."""
    return rot.multiply(rot.about("y", -facing_of(facing)), forward(motion)[1][:, SKELETON.landmark("chest").joint])


def _feet(motion: Motion) -> tuple[FloatArray, FloatArray]:
    own = [SKELETON.index(f"{side}{part}") for side in ("Left", "Right") for part in ("Foot", "Toe")]
    positions, rotations = forward(motion)
    return positions[:, own], rotations[:, own]


@pytest.mark.parametrize("following", [Following(), Following(0.4, 0.5)])
def test_arms_and_chest_are_as_in_the_layer_and_feet_as_without(following: Following) -> None:
    base, other = _base(), _waving()
    made = with_layer(base, Layer(other, ("arms",)), LayerSettings(following))
    np.testing.assert_allclose(made.rotations[:, ARMS], other.rotations[:, ARMS], atol=1e-12)
    assert rot.angle_between(_chest(made, base), _chest(other, other)).max() < 1e-6
    for mine, theirs in zip(_feet(made), _feet(base), strict=True):
        np.testing.assert_allclose(np.abs(mine), np.abs(theirs), atol=1e-5)
    assert rot.angle_between(made.rotations[:, 0], base.rotations[:, 0]).max() == pytest.approx(
        0.3 * following.turning, abs=0.02
    )
    head = SKELETON.index("Head")
    assert rot.angle_between(forward(made)[1][:, head], forward(base)[1][:, head]).max() < 1e-6


def test_where_the_layer_stands_and_faces_does_not_matter() -> None:
    base, other = _base(), _waving()
    plain = with_layer(base, Layer(other, ("arms",)), LayerSettings(Following(0.3, 0.4)))
    moved = with_layer(base, Layer(place(other, 2.0, (3.0, 0.0, 1.0)), ("arms",)), LayerSettings(Following(0.3, 0.4)))
    np.testing.assert_allclose(joint_positions(moved), joint_positions(plain), atol=1e-6)


def test_without_tilt_the_chest_is_rotated_about_the_vertical_only() -> None:
    base, other = _base(), _waving()
    made = with_layer(base, Layer(other, ("arms",)), LayerSettings(tilt=0.0))
    up = rot.rotate(forward(made)[1][:, SKELETON.landmark("chest").joint], np.array([0.0, 1.0, 0.0]))
    np.testing.assert_allclose(up, np.broadcast_to([0.0, 1.0, 0.0], up.shape), atol=1e-9)
    assert np.ptp(rot.heading(_chest(made, base))) > 0.5


def test_hands_that_hold_each_other_go_on_doing_so() -> None:
    base, other = _base(), _waving()
    made = with_layer(base, Layer(other, ("arms",)), LayerSettings(Following(0.5, 1.0)))
    hands = [role_positions(motion, ("left_hand", "right_hand")) for motion in (made, other)]
    apart = [np.linalg.norm(each[:, 0] - each[:, 1], axis=1) for each in hands]
    np.testing.assert_allclose(apart[0], apart[1], atol=1e-9)


def test_a_layer_comes_and_goes() -> None:
    base, other = _base(), _waving(60)
    layer = Layer(other, ("arms",), start=2.0, ease=0.5)
    made = with_layer(base, layer, LayerSettings(Following(0.5, 0.5)))
    weights = layer_weights(layer, len(base), 30.0)
    inside = (np.arange(240) >= 60) & (np.arange(240) <= 119)
    assert np.all(weights[~inside] == 0)
    assert weights[90] == 1.0
    assert np.all(np.diff(weights[60:76]) > 0)
    np.testing.assert_array_equal(made.rotations[~inside], base.rotations[~inside])
    np.testing.assert_array_equal(made.translation[~inside], base.translation[~inside])
    steps = np.linalg.norm(np.diff(joint_positions(made), axis=0), axis=-1).max(axis=1)
    usual = np.linalg.norm(np.diff(joint_positions(other), axis=0), axis=-1).max()
    assert steps.max() < 4.0 * usual
    held = with_layer(base, replace(layer, hold=True))
    np.testing.assert_allclose(held.rotations[:60, ARMS], np.tile(other.rotations[:1, ARMS], (60, 1, 1)), atol=1e-12)


def test_the_upper_body_the_head_and_single_parts() -> None:
    base, other = _base(), _waving()
    upper = with_layer(base, Layer(other, ("upper body",)))
    own = [SKELETON.index(name) for name in ("Chest", "Neck", "LeftArm", "RightForeArm")]
    np.testing.assert_allclose(upper.rotations[:, own], other.rotations[:, own], atol=1e-12)
    assert rot.angle_between(_chest(upper, base), _chest(other, other)).max() < 1e-6
    head = with_layer(base, Layer(other, ("head",)))
    untouched = [i for i in range(len(SKELETON)) if i not in driven_joints(SKELETON, ["head"])]
    np.testing.assert_allclose(np.abs(head.rotations[:, untouched]), np.abs(base.rotations[:, untouched]), atol=1e-6)
    assert driven_joints(SKELETON, ["left_hand"]) == (SKELETON.index("LeftHand"),)
    assert set(driven_joints(SKELETON, ["upper body"])).isdisjoint(driven_joints(SKELETON, ["left_hip", "right_hip"]))


def test_arms_that_hang_on_the_hips_keep_their_rotations() -> None:
    motion = walk(2.0)
    raised = motion.rotations.copy()
    shoulder = motion.skeleton.index("left_shoulder")
    raised[:, shoulder] = rot.about("z", 1.0)
    made = with_layer(motion, Layer(replace(motion, rotations=raised), ("arms",)))
    np.testing.assert_allclose(made.rotations[:, shoulder], raised[:, shoulder], atol=1e-12)


def test_shares_are_learnt_from_recordings() -> None:
    times = np.arange(600) / 30.0
    base = bodies.walk(SKELETON, frames=600)
    rotations = rot.identity(600, len(SKELETON))
    rotations[:, 0] = rot.about("y", 0.6 * 0.2 * np.sin(9.0 * times))
    rotations[:, SKELETON.index("Chest")] = rot.about("y", 0.4 * 0.2 * np.sin(9.0 * times))
    twisting = replace(base, rotations=rotations)
    assert learn_following([twisting]).turning == pytest.approx(0.6, abs=0.01)
    assert learn_following([twisting]).balance == 0.0
    leaning = rot.identity(600, len(SKELETON))
    leaning[:, SKELETON.index("Spine")] = rot.about("x", 0.4 * np.sin(0.7 * times))
    still = replace(base, rotations=leaning)
    away = -0.5 * (mass_above(still) - 0.602 * still.translation) * [1.0, 0.0, 1.0]
    moved = replace(still, translation=still.translation + away - away.mean(axis=0) - [0.0, 0.05, 0.0])
    moved = reach_limbs(moved, held_feet(still, [], []))
    assert learn_following([moved]).balance == pytest.approx(0.5, abs=0.02)
    assert learn_following([]) == Following()


def test_hips_keep_the_mass_where_it_was() -> None:
    base = bodies.walk(SKELETON)
    other = _waving(120, swing=0.0, lean=0.5)
    loose = with_layer(base, Layer(other, ("arms",)), LayerSettings(Following(0.0, 0.0)))
    kept = with_layer(base, Layer(other, ("arms",)), LayerSettings(Following(0.0, 1.0)))
    gaps = [np.linalg.norm((mass_above(m) - mass_above(base))[30:90, [0, 2]], axis=1).mean() for m in (loose, kept)]
    assert gaps[1] < 0.5 * gaps[0]


def test_a_synthesis_says_which_layer_a_joint_is_from(tmp_path: Path) -> None:
    base, other = _base(), _waving(90)
    pieces = (Piece("walk", "motion", 0.0, 8.0, 0.0, 8.0),)
    notes = (
        Annotation("motion", "handhold", "left_hand:right_hand", 2.0, 3.0),
        Annotation("motion", "handhold", "left_hand:right_hand", 6.0, 7.0),
        Annotation("motion", "contact", "left_foot", 0.0, 0.5),
    )
    arms = Layer(other, ("arms",), 1.0, name="wave", pieces=(Piece("wave", "motion", 0.0, 3.0, 0.0, 3.0),))
    left = Layer(other, ("left arm",), 2.0, name="point")
    made = layered(Synthesis(base, pieces, 0.0, annotations=notes), [arms, left])
    named = [made.layer_at(joint, 75) for joint in ("LeftHand", "RightHand", "LeftFoot")]
    assert [layer and layer.name for layer in named] == ["point", "wave", None]
    assert made.layer_at("LeftHand", 10) is None
    assert [piece.start for piece in made.layers[0].pieces] == [1.0]
    assert [note.start for note in made.annotations] == [6.0, 0.0]
    write_report(made, tmp_path / "report.json")
    report = json.loads((tmp_path / "report.json").read_text())
    assert [run["layer"] for run in report["joints"]["LeftHand"]] == [None, "wave", "point", None]
    assert report["joints"]["Hips"] == [{"layer": None, "first": 0, "last": 239}]
    assert report["layers"][0]["pieces"][0]["take"] == "wave"


def test_a_layer_of_another_body_is_retargeted() -> None:
    other = walk(4.0)
    turned = other.rotations.copy()
    turned[:, other.skeleton.index("left_shoulder")] = rot.about("z", np.linspace(0, 1, len(other)))
    made = layered(Synthesis(_base(), (), 0.0), [Layer(replace(other, rotations=turned), ("left arm",), ease=0.0)])
    hands = role_positions(made.motion, ("left_hand",))[:, 0]
    assert hands[100, 1] - hands[5, 1] > 0.1


def test_what_is_refused() -> None:
    base, other = _base(), _waving(60)
    with pytest.raises(RequestError, match=r"parts among arms, left arm, .* or roles; found \['tail'\]"):
        Layer(other, ("tail",))
    with pytest.raises(RequestError, match="ease must be 0 or more, found -1"):
        Layer(other, ("arms",), ease=-1.0)
    with pytest.raises(RequestError, match="cannot drive 'hips'"):
        driven_joints(SKELETON, ["hips"])
    with pytest.raises(RequestError, match=r"begins at 9 s and lasts 1\.97 s: the result, of 7\.97 s, has none"):
        layered(Synthesis(base, (), 0.0), [Layer(other, ("arms",), 9.0)])
    with pytest.raises(RequestError, match="retarget the layer first"):
        with_layer(base, Layer(walk(2.0), ("arms",)))
