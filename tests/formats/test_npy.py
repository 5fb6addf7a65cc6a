"""Arrays of joints' positions and HumanML3D's features become motions whose joints are where they say."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats import ReadOptions, load, read
from kinetograph.formats.npy.features import positions_of_features
from kinetograph.formats.npy.sets import JointSet, joint_sets
from kinetograph.kinematics import joint_positions
from kinetograph.motion import Motion

_FRAMES = 40


def moved(joints: JointSet, seed: int = 3, size: float = 1.0) -> Motion:
    """A body with a set's joints that walks in a circle and swings its limbs; bones are not the set's own."""
    rng = np.random.default_rng(seed)
    skeleton = joints.skeleton
    stretched = skeleton.offsets * size * rng.uniform(0.9, 1.1, (len(skeleton), 1))
    for i, name in enumerate(skeleton.names):
        if name.startswith("right"):
            stretched[i] = stretched[skeleton.names.index("left" + name[5:])] * [-1, 1, 1]
    phase = np.linspace(0, 6, _FRAMES)[:, None, None]
    swing = rng.uniform(0.0, 0.35, (1, len(skeleton), 3)) * np.sin(phase + rng.uniform(0, 6, (1, len(skeleton), 3)))
    for i, name in enumerate(skeleton.names):
        part = name.rpartition("_")[2]
        if part == "knee":
            swing[:, i] = np.abs(swing[:, i]) * [3.0, 0, 0]
        if part == "elbow":
            swing[:, i] = np.abs(swing[:, i]) * [0, -3.0 if name.startswith("left") else 3.0, 0]
        if part == "shoulder":
            swing[:, i, 2] -= 1.0 if name.startswith("left") else -1.0
    swing[:, 0] = np.linspace(0, 2, _FRAMES)[:, None] * [0, 1, 0]
    path = np.stack([np.sin(phase[:, 0, 0] / 3), np.full(_FRAMES, 0.95), np.cos(phase[:, 0, 0] / 3)], axis=1) * size
    return Motion(replace(skeleton, offsets=stretched), path, rot.exp(swing), 20.0)


def rows_of(joints: JointSet, motion: Motion) -> FloatArray:
    """What a file of the set has: its rows, where a joint that is the mean of two rows has them to its sides."""
    places = joint_positions(motion)
    out = np.zeros((len(motion), joints.count, 3))
    for joint, rows in enumerate(joints.rows):
        if len(rows) == 1:
            out[:, rows[0]] = places[:, joint]
    return out


def saved(folder: Path, values: np.ndarray) -> Path:
    np.save(folder / "a.npy", values)
    return folder / "a.npy"


@pytest.mark.parametrize("name", ["humanml3d", "smpl", "kit", "h36m", "kinect1", "kinect2"])
def test_joints_are_where_the_positions_are(name: str, tmp_path: Path) -> None:
    joints = joint_sets()[name]
    truth = moved(joints)
    values = rows_of(joints, truth)
    loaded = read(saved(tmp_path, values), ReadOptions(fps=20.0, up="y"))
    motion = loaded.take.motion()
    apart = 1000 * np.linalg.norm(joint_positions(motion) - joint_positions(truth), axis=-1)
    assert apart.mean() < 0.3, name
    assert apart.max() < 3.0, name
    assert any("fitted to positions" in note for note in loaded.notes)
    for side in ("left", "right"):
        knee = motion.skeleton.names.index(f"{side}_knee")
        bend = rot.log(motion.rotations[:, knee])
        assert np.abs(bend[:, 1:]).max() < 0.1  # hinges
        assert bend[:, 0].min() > -0.05
    assert len(motion.skeleton.roles) >= 14


def test_coco_has_joints_that_are_means_of_others(tmp_path: Path) -> None:
    joints = joint_sets()["coco"]
    truth = moved(joints)
    names, values = joints.skeleton.names, rows_of(joints, truth)
    for pair in ("hip", "shoulder", "ear"):  # the middle of two, as the set has it
        assert {f"left_{pair}", f"right_{pair}"} <= set(names)
    motion = load(saved(tmp_path, values), fps=20.0, up="y").motion()
    apart = np.linalg.norm(joint_positions(motion) - joints.joints(values), axis=-1)
    assert apart.mean() < 0.003
    assert apart.max() < 0.02


def test_sets_of_one_size_are_told_apart_by_their_bones(tmp_path: Path) -> None:
    for name in ("h36m", "coco", "kinect2"):
        joints = joint_sets()[name]
        loaded = read(saved(tmp_path, rows_of(joints, moved(joints))), ReadOptions(fps=20.0, up="y"))
        assert any(f"taken as {joints.title}" in note for note in loaded.notes), name
    still = np.zeros((4, 17, 3))
    with pytest.raises(FormatError, match="17 joints could be of h36m or coco; say which with --markers"):
        read(saved(tmp_path, still), ReadOptions(fps=20.0))
    read(saved(tmp_path, still), ReadOptions(fps=20.0, markers="coco"))
    with pytest.raises(RequestError, match="kinect2 has 25 joints, the file 17"):
        read(saved(tmp_path, still), ReadOptions(fps=20.0, markers="kinect2"))
    with pytest.raises(RequestError, match="unknown set of joints 'h37m'; expected one of humanml3d"):
        read(saved(tmp_path, still), ReadOptions(fps=20.0, markers="h37m"))


@pytest.mark.parametrize("shape", ["batch", "axes before frames", "centimetres", "float32"])
def test_other_shapes_and_units(shape: str, tmp_path: Path) -> None:
    joints = joint_sets()["humanml3d"]
    values = joint_positions(moved(joints))
    expected = load(saved(tmp_path, values)).motion()
    other = {
        "batch": values[None],
        "axes before frames": values.transpose(1, 2, 0),
        "centimetres": 100 * values,
        "float32": values.astype(np.float32),
    }[shape]
    motion = load(saved(tmp_path, other)).motion()
    assert motion.fps == 20.0
    np.testing.assert_allclose(joint_positions(motion), joint_positions(expected), atol=1e-5)


def features_of(positions: FloatArray) -> FloatArray:
    """HumanML3D's features by the format's description, joint by joint and frame by frame.

    The heading is that of the line across the hips; what is not read (rotations, velocities, contacts) is left zero.
    """
    frames, count = positions.shape[:2]
    out = np.zeros((frames, 263 if count == 22 else 251))
    angles = []
    for frame in positions:
        across = frame[1] - frame[2]  # to the left
        angles.append(np.arctan2(-across[2], across[0]))
    angles = np.unwrap(angles)
    for f in range(frames):
        cosine, sine = np.cos(-angles[f]), np.sin(-angles[f])
        own = np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]])  # the world, in the body's heading
        if f + 1 < frames:
            # the format's quaternions take the world to the heading: their half angles go the other way
            out[f, 0] = -(angles[f + 1] - angles[f]) / 2
            later_cosine, later_sine = np.cos(-angles[f + 1]), np.sin(-angles[f + 1])
            later = np.array([[later_cosine, 0, later_sine], [0, 1, 0], [-later_sine, 0, later_cosine]])
            out[f, 1:3] = (later @ (positions[f + 1, 0] - positions[f, 0]))[[0, 2]]
        out[f, 3] = positions[f, 0, 1]
        for joint in range(1, count):
            local = own @ (positions[f, joint] - [positions[f, 0, 0], 0, positions[f, 0, 2]])
            out[f, 4 + 3 * (joint - 1) : 7 + 3 * (joint - 1)] = local
    return out


@pytest.mark.parametrize("name", ["humanml3d", "kit"])
def test_features_are_the_positions_they_were_made_of(name: str, tmp_path: Path) -> None:
    joints = joint_sets()[name]
    places = joint_positions(moved(joints))
    if name == "kit":
        places = places[:, [joints.rows.index((row,)) for row in range(21)]]
        places[:, [1, 2]], swap = places[:, [11, 16]], places[:, [1, 2]].copy()
        places[:, [11, 16]] = swap  # only so that the naive twin finds the hips
    # the features' world begins at the origin, in the heading of the first frame
    found = positions_of_features(features_of(places))
    across = places[0, 1] - places[0, 2]
    turned = rot.rotate(rot.about("y", -np.arctan2(-across[2], across[0])), places - places[0, 0] * [1, 0, 1])
    np.testing.assert_allclose(found, turned, atol=1e-9)
    if name == "humanml3d":
        loaded = read(saved(tmp_path, features_of(places)))
        np.testing.assert_allclose(joint_positions(loaded.take.motion()), turned, atol=0.003)
        assert any("263 numbers per frame" in note for note in loaded.notes)
        assert loaded.take.motion().fps == 20.0


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (np.zeros((5, 66)), r"expected positions \(frames, joints, 3\) or features \(frames, 263\), found \(5, 66\)"),
        (np.zeros((5, 19, 3)), "19 joints are of no known set; expected 22 HumanML3D"),
        (np.full((5, 22, 3), np.nan), "expected finite numbers"),
        (np.zeros((0, 22, 3)), "expected positions"),
        (np.zeros((2, 5, 22, 3)), "expected positions"),
        (np.array(["a"]), "expected positions of joints, found an array of <U1"),
        (np.zeros((5, 24, 3)), "say no rate; give it with --fps"),
    ],
)
def test_odd_arrays_are_refused_in_a_line(values: np.ndarray, expected: str, tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=expected) as caught:
        load(saved(tmp_path, values))
    assert "\n" not in str(caught.value)


def test_pickled_arrays_and_claims_are_refused(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.array({"motion": 1}, dtype=object), allow_pickle=True)
    with pytest.raises(FormatError, match="pickled objects, which can run programs"):
        load(tmp_path / "a.npy")
    data = saved(tmp_path, np.zeros((5, 22, 3))).read_bytes().replace(b"(5, 22, 3)", b"(9999999, 22, 3)"[:10])
    (tmp_path / "a.npy").write_bytes(data)
    with pytest.raises(FormatError):
        load(tmp_path / "a.npy")


def test_joints_all_in_one_place_are_read(tmp_path: Path) -> None:
    loaded = read(saved(tmp_path, np.zeros((6, 22, 3))))
    assert len(loaded.take.motion()) == 6
    assert any("no size" in note for note in loaded.notes)
