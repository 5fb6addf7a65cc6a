"""VRM avatars and animations: bones by name, whichever way they face, poses and characters."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gltf_files import HUMANOID, NODE, VRM0, VRM1, VRMA, Json, animated, avatar, humanoid_nodes, turned, written
from kinetograph.errors import FormatError
from kinetograph.formats import ReadOptions, read, read_character
from kinetograph.kinematics import joint_positions, role_positions
from kinetograph.skeleton import ROLES


@pytest.mark.parametrize(("extensions", "facing"), [(VRM1, 1.0), (VRM0, -1.0)], ids=["VRM 1", "VRM 0"])
def test_an_avatar_faces_z_and_its_bones_have_roles(tmp_path: Path, extensions: Json, facing: float) -> None:
    loaded = read(written(tmp_path / "a.vrm", avatar(extensions, facing)))
    motion = loaded.take.motion()
    assert (len(motion), set(motion.skeleton.roles)) == (1, set(ROLES))
    at = dict(zip(ROLES, role_positions(motion, list(ROLES))[0], strict=True))
    np.testing.assert_allclose(at["hips"], [0, 0.9, 0], atol=1e-6)
    np.testing.assert_allclose(at["head"], [0, 1.5, 0], atol=1e-6)
    np.testing.assert_allclose(at["chest"], [0, 1.25, 0], atol=1e-6)
    np.testing.assert_allclose(at["left_hand"], [0.68, 1.35, 0], atol=1e-6)
    np.testing.assert_allclose(at["right_toe"], [-0.1, 0, 0.12], atol=1e-6)
    assert "left out, as they hang on no bone of the humanoid: hair" in loaded.notes
    assert "the file has no animation: read its pose" in loaded.notes


@pytest.mark.parametrize(("extensions", "facing"), [(VRM1, 1.0), (VRM0, -1.0)], ids=["VRM 1", "VRM 0"])
def test_an_avatar_is_a_character(tmp_path: Path, extensions: Json, facing: float) -> None:
    character = read_character(written(tmp_path / "a.vrm", avatar(extensions, facing)))
    skeleton, skin = character.skeleton, character.skin
    corners = skin.points + np.array([0, 0.9, 0])
    side = np.array([facing, 1, facing])
    np.testing.assert_allclose(corners[0], [-0.68, 1.35, 0], atol=1e-6)
    np.testing.assert_allclose(corners[1] - corners[0], np.array([0.1, 0, 0]) * side, atol=1e-6)
    # the second skin lacks the root, and has the same space all the same
    np.testing.assert_allclose(corners[3], [0.1, 0, 0.12], atol=1e-6)
    moved_by = [skeleton.names[joint] for joint in skin.joints[[0, 3], 0]]
    assert moved_by == [f"n{NODE['rightHand']}", f"n{NODE['leftToes']}"]


def test_without_an_upper_chest_the_chest_carries_the_arms(tmp_path: Path) -> None:
    bones = {name: {"node": index} for name, index in NODE.items() if name not in ("upperChest", "chest")}
    path = written(tmp_path / "a.vrm", avatar({"VRMC_vrm": {"humanoid": {"humanBones": bones}}}))
    skeleton = read(path).take.motion().skeleton
    assert skeleton.names[skeleton.roles["chest"].joint] == f"n{NODE['spine']}"


def test_an_animation_moves_every_bone_and_nothing_else(tmp_path: Path) -> None:
    nodes = [*humanoid_nodes(), {"name": "happy"}]
    arm = NODE["leftUpperArm"]
    up = [0.0, 0.0, float(np.sin(np.pi / 4)), float(np.cos(np.pi / 4))]
    moves = [
        (NODE["hips"], "translation", [0.0, 2.0], [[0, 0.9, 0], [0, 0.9, 2]]),
        (arm, "rotation", [0.0, 2.0], [turned(0), up]),
        (len(nodes) - 1, "translation", [0.0, 2.0], [[0, 0, 0], [1, 0, 0]]),
    ]
    path = written(tmp_path / "a.vrma", animated(nodes, [("wave", moves)], extensions=VRMA))
    loaded = read(path, ReadOptions(fps=10.0))
    motion = loaded.take.motion()
    assert (len(motion), len(motion.skeleton), loaded.animations) == (21, len(HUMANOID), ("wave",))
    assert set(motion.skeleton.roles) == set(ROLES)
    hand = role_positions(motion, ["left_hand", "hips"])
    np.testing.assert_allclose(hand[-1], [[0.15, 1.35 + 0.53, 2.0], [0, 0.9, 2.0]], atol=1e-5)
    np.testing.assert_allclose(joint_positions(motion)[:, 0, 2], np.linspace(0, 2, 21), atol=1e-5)


@pytest.mark.parametrize(
    ("bones", "expected"),
    [
        ({"hips": {"node": 999}}, "expected a bone of the humanoid to be an index below"),
        ({"hips": {"node": -1}}, "expected a bone of the humanoid to be an index below"),
        ({"head": {"node": 3}}, "expected the hips of a VRM humanoid, found none"),
        ({"hips": 3}, r"not the structure of glTF: expected `object \| null`, got `int`"),
        ([], "not the structure of glTF: expected `object`, got `array`"),
    ],
)
def test_damaged_humanoids_are_refused(tmp_path: Path, bones: Any, expected: str) -> None:
    path = written(tmp_path / "a.vrm", avatar({"VRMC_vrm": {"humanoid": {"humanBones": bones}}}))
    with pytest.raises(FormatError, match=expected):
        read(path)


def test_bones_that_vrm_0_leaves_out_are_left_out(tmp_path: Path) -> None:
    bones = [{"bone": n, "node": -1 if n.endswith("Toes") else i} for n, i in NODE.items()]
    path = written(tmp_path / "a.vrm", avatar({"VRM": {"humanoid": {"humanBones": bones}}}, -1.0))
    assert len(read(path).take.motion().skeleton) >= len(HUMANOID) - 2
