"""Frames as VMC sends them, read by python-osc, which is not ours."""

from __future__ import annotations

import numpy as np
import pytest
from pythonosc.osc_bundle import OscBundle

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.formats import load
from kinetograph.formats.deepmimic import skeleton as deepmimic
from kinetograph.kinematics import forward
from kinetograph.live.sinks.humanoid import BONES, Humanoid
from kinetograph.live.sinks.osc import bundles, message
from kinetograph.live.sinks.vmc import datagrams, right_handed
from kinetograph.motion import Motion, cut
from kinetograph.roles import with_found_roles
from kinetograph.skeleton import Skeleton

_DIRECTIONS = {"UpperArm": (1, 0, 0), "LowerArm": (1, 0, 0), "UpperLeg": (0, -1, 0), "LowerLeg": (0, -1, 0)}
_NEXT = {"UpperArm": "LowerArm", "LowerArm": "Hand", "UpperLeg": "LowerLeg", "LowerLeg": "Foot"}
# Unity's hierarchy of humanoid bones
_PARENTS = {"Spine": "Hips", "Chest": "Spine", "Neck": "Chest", "Head": "Neck"}
_PARENTS |= {f"{s}{b}": p.replace("*", s) for s in ("Left", "Right") for b, p in {
    "Shoulder": "Chest", "UpperArm": "*Shoulder", "LowerArm": "*UpperArm", "Hand": "*LowerArm",
    "UpperLeg": "Hips", "LowerLeg": "*UpperLeg", "Foot": "*LowerLeg", "Toes": "*Foot"}.items()}  # fmt: skip


def _decoded(packets: list[bytes]) -> tuple[dict[str, FloatArray], list[str]]:
    """Bones with their seven numbers, and all addresses in order, as python-osc reads them."""
    bones: dict[str, FloatArray] = {}
    addresses = []
    for packet in packets:
        assert len(packet) <= 1400
        for one in OscBundle(packet):
            addresses.append(one.address)
            if one.address == "/VMC/Ext/Bone/Pos":
                bones[one.params[0]] = np.array(one.params[1:])
    return bones, addresses


def _world(bones: dict[str, FloatArray]) -> dict[str, tuple[FloatArray, FloatArray]]:
    """World position and rotation of every bone in our axes, by Unity's own hierarchy."""
    world: dict[str, tuple[FloatArray, FloatArray]] = {}

    def place(bone: str) -> tuple[FloatArray, FloatArray]:
        if bone not in world:
            position, rotation = right_handed(bones[bone])
            above: str | None = _PARENTS.get(bone)
            while above is not None and above not in bones:
                above = _PARENTS.get(above)
            if above is not None:
                at, turned = place(above)
                position, rotation = at + rot.rotate(turned, position), rot.multiply(turned, rotation)
            world[bone] = position, rotation
        return world[bone]

    for bone in bones:
        place(bone)
    return world


def _check(motion: Motion) -> None:
    body = Humanoid(motion.skeleton)
    bones, _ = _decoded(datagrams(body, motion, 0.0))
    world = _world(bones)
    positions = forward(motion)[0][0]
    for bone, (position, _) in world.items():
        joint = motion.skeleton.roles[BONES[bone]].joint
        assert np.linalg.norm(position - positions[joint]) < 1e-3, bone
    for part, direction in _DIRECTIONS.items():
        for side, sign in (("Left", 1.0), ("Right", -1.0)):
            bone, below = f"{side}{part}", f"{side}{_NEXT[part]}"
            along = world[below][0] - world[bone][0]
            pointed = rot.rotate(world[bone][1], np.array(direction) * [sign, 1.0, 1.0])
            assert pointed @ along / np.linalg.norm(along) > 0.999, bone  # rotations are none in a T pose


def test_python_osc_reads_a_clip_back_to_where_its_joints_are(clips_folder) -> None:
    motion = load(clips_folder / "humanoid3d_spinkick.txt").motion()
    for frame in range(0, len(motion), 7):
        _check(cut(motion, frame, frame + 1))


@pytest.mark.parametrize("name", ["walks/15_01.bvh", "fbx/135_01.fbx", "acclaim/16_11.amc"])
def test_python_osc_reads_recordings_of_other_skeletons_back(data_folder, name) -> None:
    motion = load(data_folder / name).motion()
    _check(cut(motion, len(motion) // 2, len(motion) // 2 + 1))


def test_messages_come_in_the_order_that_receivers_need() -> None:
    still = Motion(deepmimic(), np.zeros((1, 3)), rot.identity(1, 15), 60.0)
    _, addresses = _decoded(datagrams(Humanoid(still.skeleton), still, 2.5))
    assert addresses[:3] == ["/VMC/Ext/OK", "/VMC/Ext/T", "/VMC/Ext/Root/Pos"]
    assert addresses[-1] == "/VMC/Ext/Blend/Apply"


def test_a_body_in_an_a_pose_stands_in_the_t_pose_without_rotations() -> None:
    down = np.radians(50)
    names = ("Hips", "Spine", "Chest", "Neck", "Head")
    offsets = [(0, 1, 0), (0, 0.1, 0), (0, 0.2, 0), (0, 0.2, 0), (0, 0.1, 0)]
    parents = [-1, 0, 1, 2, 3]
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        first = len(names)
        names += tuple(f"{side}{part}" for part in ("Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot"))
        arm = [(0.15 * sign, 0.15, 0), *[(0.28 * sign * np.cos(down), -0.28 * np.sin(down), 0)] * 2]
        offsets += [*arm, (0.1 * sign, 0, 0), (0, -0.45, 0), (0, -0.42, 0)]
        parents += [2, first, first + 1, 0, first + 3, first + 4]
    body = with_found_roles(Skeleton(names, np.array(parents), np.array(offsets, dtype=float)))
    local = rot.identity(1, len(names))
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        local[0, body.roles[f"{side.lower()}_shoulder"].joint] = rot.about("z", sign * down)
    _, rotations = Humanoid(body).pose(Motion(body, np.array([[0.0, 1.0, 0.0]]), local, 60.0))
    assert np.abs(np.abs(rotations[0, :, 0]) - 1.0).max() < 1e-9


def test_a_skeleton_without_legs_is_refused() -> None:
    with pytest.raises(RequestError, match="expected a skeleton of a person, found none of hips"):
        Humanoid(Skeleton(("a",), np.array([-1]), np.zeros((1, 3))))


def test_messages_hold_what_they_were_given() -> None:
    (packet,) = bundles([message("/a/b", 7, -1.5, "naïve")])
    (one,) = OscBundle(packet)
    assert one.params == [7, -1.5, "naïve"]


def test_a_message_longer_than_a_bundle_has_one_of_its_own() -> None:
    packets = bundles([message("/short", 1), message("/long", "x" * 2000), message("/short", 2)])
    assert [len(list(OscBundle(packet))) for packet in packets] == [1, 1, 1]
