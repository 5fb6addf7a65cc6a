"""Roles on the naming of the bodies that people have, and on a body whose names say nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinetograph.formats import deepmimic, load
from kinetograph.roles import JointName, find_roles, read_names, with_found_roles
from kinetograph.skeleton import ROLES, Skeleton

_MIDLINE = ("hips", "spine", "chest", "neck", "head")
_SIDE = ("collar", "shoulder", "elbow", "hand", "hip", "knee", "foot", "toe")


def _skeleton(*chains: str) -> Skeleton:
    """A skeleton of chains ``"a,b,c"``: every name hangs on the one before it, each chain begins in the tree so far."""
    names: list[str] = []
    parents: list[int] = []
    for chain in chains:
        above = -1
        for name in chain.split(","):
            if name not in names:
                names.append(name)
                parents.append(above)
            above = names.index(name)
    return Skeleton(tuple(names), np.array(parents), np.ones((len(names), 3)))


def _both(left: str, right: str, *chains: str) -> list[str]:
    return [chain.replace("<", side) for side in (left, right) for chain in chains]


BODIES: dict[str, tuple[Skeleton, dict[str, str]]] = {}


def _add(title: str, skeleton: Skeleton, midline: str, limbs: str, sides: tuple[str, str]) -> None:
    roles = dict(zip(_MIDLINE, midline.split(","), strict=True))
    for side, mark in zip(("left", "right"), sides, strict=True):
        named = zip(_SIDE, limbs.replace("<", mark).split(","), strict=True)
        roles |= {f"{side}_{part}": name for part, name in named}
    BODIES[title] = skeleton, {role: name for role, name in roles.items() if name}


_add(
    "cmu",
    _skeleton(
        "Hips,LHipJoint,LeftUpLeg,LeftLeg,LeftFoot,LeftToeBase",
        "Hips,RHipJoint,RightUpLeg,RightLeg,RightFoot,RightToeBase",
        "Hips,LowerBack,Spine,Spine1,Neck,Neck1,Head",
        *_both("Left", "Right", "Spine1,<Shoulder,<Arm,<ForeArm,<Hand,<FingerBase,<HandIndex1"),
        *("LeftHand,LThumb", "RightHand,RThumb"),
    ),
    "Hips,LowerBack,Spine1,Neck,Head",
    "<Shoulder,<Arm,<ForeArm,<Hand,<UpLeg,<Leg,<Foot,<ToeBase",
    ("Left", "Right"),
)
_add(
    "mixamo",
    _skeleton(
        *(
            "mixamorig:Hips,mixamorig:Spine,mixamorig:Spine1,mixamorig:Spine2",
            "mixamorig:Spine2,mixamorig:Neck,mixamorig:Head",
        ),
        *_both(
            *("mixamorig:Left", "mixamorig:Right", "mixamorig:Spine2,<Shoulder,<Arm,<ForeArm,<Hand,<HandThumb1"),
            *("<Hand,<HandIndex1,<HandIndex2", "mixamorig:Hips,<UpLeg,<Leg,<Foot,<ToeBase,<Toe_End"),
        ),
    ),
    "mixamorig:Hips,mixamorig:Spine,mixamorig:Spine2,mixamorig:Neck,mixamorig:Head",
    "<Shoulder,<Arm,<ForeArm,<Hand,<UpLeg,<Leg,<Foot,<ToeBase",
    ("mixamorig:Left", "mixamorig:Right"),
)
_add(
    "amass",
    _skeleton(
        *_both("l", "r", "root,<hip,<knee,<ankle,<toe"),
        "root,lowerback,upperback,chest,lowerneck,upperneck",
        *_both("l", "r", "chest,<clavicle,<shoulder,<elbow,<wrist"),
    ),
    "root,lowerback,chest,lowerneck,upperneck",
    "<clavicle,<shoulder,<elbow,<wrist,<hip,<knee,<ankle,<toe",
    ("l", "r"),
)
_add(
    "smpl",
    _skeleton(
        *_both("L", "R", "Pelvis,<_Hip,<_Knee,<_Ankle,<_Foot"),
        "Pelvis,Spine1,Spine2,Spine3,Neck,Head",
        *_both("L", "R", "Spine3,<_Collar,<_Shoulder,<_Elbow,<_Wrist,<_Hand"),
    ),
    "Pelvis,Spine1,Spine3,Neck,Head",
    "<_Collar,<_Shoulder,<_Elbow,<_Wrist,<_Hip,<_Knee,<_Ankle,<_Foot",
    ("L", "R"),
)
_add(
    "smplx",
    _skeleton(
        *_both("left", "right", "pelvis,<_hip,<_knee,<_ankle,<_foot"),
        "pelvis,spine1,spine2,spine3,neck,head,jaw",
        *_both("left", "right", "spine3,<_collar,<_shoulder,<_elbow,<_wrist,<_index1,<_index2", "head,<_eye_smplhf"),
    ),
    "pelvis,spine1,spine3,neck,head",
    "<_collar,<_shoulder,<_elbow,<_wrist,<_hip,<_knee,<_ankle,<_foot",
    ("left", "right"),
)
_add(
    "unreal",
    _skeleton(
        "root,pelvis,spine_01,spine_02,spine_03,neck_01,head",
        *_both(
            "l", "r", "spine_03,clavicle_<,upperarm_<,lowerarm_<,hand_<,index_01_<", "upperarm_<,upperarm_twist_01_<"
        ),
        *_both("l", "r", "lowerarm_<,lowerarm_twist_01_<", "pelvis,thigh_<,calf_<,foot_<,ball_<"),
        "root,ik_foot_root,ik_foot_l",
        "ik_foot_root,ik_foot_r",
    ),
    "pelvis,spine_01,spine_03,neck_01,head",
    "clavicle_<,upperarm_<,lowerarm_<,hand_<,thigh_<,calf_<,foot_<,ball_<",
    ("l", "r"),
)
_add(
    "biped",
    _skeleton(
        "Bip01,Bip01 Pelvis,Bip01 Spine,Bip01 Spine1,Bip01 Neck,Bip01 Head",
        *_both("L", "R", "Bip01 Neck,Bip01 < Clavicle,Bip01 < UpperArm,Bip01 < Forearm,Bip01 < Hand,Bip01 < Finger0"),
        *_both("L", "R", "Bip01 Spine,Bip01 < Thigh,Bip01 < Calf,Bip01 < Foot,Bip01 < Toe0"),
    ),
    "Bip01 Pelvis,Bip01 Spine,Bip01 Spine1,Bip01 Neck,Bip01 Head",
    "Bip01 < Clavicle,Bip01 < UpperArm,Bip01 < Forearm,Bip01 < Hand,"
    "Bip01 < Thigh,Bip01 < Calf,Bip01 < Foot,Bip01 < Toe0",
    ("L", "R"),
)
_add(
    "rigify",
    _skeleton(
        "root,DEF-spine,DEF-spine.001,DEF-spine.002,DEF-neck,DEF-head",
        *_both(
            *("L", "R", "DEF-spine.002,DEF-shoulder.<,DEF-upper_arm.<,DEF-upper_arm.<.001,DEF-forearm.<"),
            *("DEF-forearm.<,DEF-forearm.<.001,DEF-hand.<", "DEF-spine,DEF-thigh.<,DEF-thigh.<.001,DEF-shin.<"),
            "DEF-shin.<,DEF-shin.<.001,DEF-foot.<,DEF-toe.<",
        ),
    ),
    "DEF-spine,DEF-spine.001,DEF-spine.002,DEF-neck,DEF-head",
    "DEF-shoulder.<,DEF-upper_arm.<,DEF-forearm.<,DEF-hand.<,DEF-thigh.<,DEF-shin.<,DEF-foot.<,DEF-toe.<",
    ("L", "R"),
)
_add(
    "character creator",
    _skeleton(
        "CC_Base_Hip,CC_Base_Pelvis",
        *_both(
            *("L", "R", "CC_Base_Pelvis,CC_Base_<_Thigh,CC_Base_<_Calf,CC_Base_<_Foot,CC_Base_<_ToeBaseShareBone"),
            *("CC_Base_<_Thigh,CC_Base_<_ThighTwist01", "CC_Base_<_Foot,CC_Base_<_ToeBase,CC_Base_<_BigToe1"),
        ),
        "CC_Base_Hip,CC_Base_Waist,CC_Base_Spine01,CC_Base_Spine02,CC_Base_NeckTwist01,CC_Base_NeckTwist02,CC_Base_Head",
        *_both("L", "R", "CC_Base_Spine02,CC_Base_<_Clavicle,CC_Base_<_Upperarm,CC_Base_<_Forearm,CC_Base_<_Hand"),
        *_both("L", "R", "CC_Base_Head,CC_Base_<_Eye"),
    ),
    "CC_Base_Hip,CC_Base_Waist,CC_Base_Spine02,CC_Base_NeckTwist01,CC_Base_Head",
    "CC_Base_<_Clavicle,CC_Base_<_Upperarm,CC_Base_<_Forearm,CC_Base_<_Hand,"
    "CC_Base_<_Thigh,CC_Base_<_Calf,CC_Base_<_Foot,CC_Base_<_ToeBase",
    ("L", "R"),
)
_add(
    "xsens",
    _skeleton(
        "Hips,Chest,Chest2,Chest3,Chest4,Neck,Head",
        *_both("Left", "Right", "Chest4,<Collar,<Shoulder,<Elbow,<Wrist", "Hips,<Hip,<Knee,<Ankle,<Toe"),
    ),
    "Hips,Chest,Chest4,Neck,Head",
    "<Collar,<Shoulder,<Elbow,<Wrist,<Hip,<Knee,<Ankle,<Toe",
    ("Left", "Right"),
)
_add(
    "mvn",
    _skeleton(
        "Pelvis,L5,L3,T12,T8,Neck,Head",
        *_both("Left", "Right", "T8,<Shoulder,<UpperArm,<ForeArm,<Hand", "Pelvis,<UpperLeg,<LowerLeg,<Foot,<Toe"),
    ),
    "Pelvis,L5,T8,Neck,Head",
    "<Shoulder,<UpperArm,<ForeArm,<Hand,<UpperLeg,<LowerLeg,<Foot,<Toe",
    ("Left", "Right"),
)
_add(
    "acclaim",
    _skeleton(
        *_both("l", "r", "root,<hipjoint,<femur,<tibia,<foot,<toes"),
        "root,lowerback,upperback,thorax,lowerneck,upperneck,head",
        *_both("l", "r", "thorax,<clavicle,<humerus,<radius,<wrist,<hand,<fingers", "<wrist,<thumb"),
    ),
    "root,lowerback,thorax,lowerneck,head",
    "<clavicle,<humerus,<radius,<wrist,<femur,<tibia,<foot,<toes",
    ("l", "r"),
)
_add(
    "vrm",
    _skeleton(
        "Root,J_Bip_C_Hips,J_Bip_C_Spine,J_Bip_C_Chest,J_Bip_C_UpperChest,J_Bip_C_Neck,J_Bip_C_Head",
        *_both(
            *("L", "R", "J_Bip_C_UpperChest,J_Bip_<_Shoulder,J_Bip_<_UpperArm,J_Bip_<_LowerArm,J_Bip_<_Hand"),
            "J_Bip_C_Hips,J_Bip_<_UpperLeg,J_Bip_<_LowerLeg,J_Bip_<_Foot,J_Bip_<_ToeBase",
        ),
    ),
    "J_Bip_C_Hips,J_Bip_C_Spine,J_Bip_C_UpperChest,J_Bip_C_Neck,J_Bip_C_Head",
    "J_Bip_<_Shoulder,J_Bip_<_UpperArm,J_Bip_<_LowerArm,J_Bip_<_Hand,"
    "J_Bip_<_UpperLeg,J_Bip_<_LowerLeg,J_Bip_<_Foot,J_Bip_<_ToeBase",
    ("L", "R"),
)


@pytest.mark.parametrize("title", BODIES)
def test_the_names_of_a_convention_are_understood(title: str) -> None:
    skeleton, expected = BODIES[title]
    roles = {role: skeleton.names[mark.joint] for role, mark in find_roles(skeleton).items()}
    assert roles == expected


def test_sides_prefixes_and_numbers_are_read_apart_from_the_word() -> None:
    names = read_names(["LHipJoint", "upper_arm.R.001", "Bip01 L Toe0", "leg", "LEFTHAND", "righthand", "L5"])
    assert names == (
        JointName("left", "hip", ""),
        JointName("right", "upperarm", "1"),
        JointName("left", "toe", "1.0"),
        JointName("", "leg", ""),
        JointName("left", "hand", ""),
        JointName("right", "hand", ""),
        JointName("", "l", "5"),
    )


def test_deepmimic_roles_are_found_as_its_reader_states_them() -> None:
    stated = deepmimic.skeleton()
    roles = find_roles(stated)
    assert set(roles) == set(stated.roles)
    for role, mark in stated.roles.items():
        assert (roles[role].joint, roles[role].offset.tolist()) == (mark.joint, mark.offset.tolist())


def _anonymous(skeleton: Skeleton) -> Skeleton:
    names = tuple(f"joint_{i}" for i in range(len(skeleton)))
    return Skeleton(names, skeleton.parents, skeleton.offsets, skeleton.end_parents, skeleton.end_offsets)


def test_a_body_whose_names_say_nothing_is_read_from_its_shape() -> None:
    named = deepmimic.skeleton()
    roles = find_roles(_anonymous(named))
    assert {role: mark.joint for role, mark in roles.items()} == {r: m.joint for r, m in named.roles.items()}


def test_sides_are_left_out_where_the_body_may_face_either_way() -> None:
    body = deepmimic.skeleton()
    footless = Skeleton(body.names, body.parents, body.offsets)
    assert not find_roles(_anonymous(footless))


def test_a_chain_of_nameless_joints_has_no_roles() -> None:
    assert not find_roles(_skeleton("joint_0,joint_1,joint_2,joint_3"))


_SOME_NAMES = ["Hips", "LeftUpLeg", "l_leg", "LFoot", "rfoot", "Toe.L", "Arm_r", "hand_l", "neck", "Head", "x", "7", ""]


@given(data=st.data(), joints=st.integers(1, 30))
@settings(max_examples=100)
def test_any_tree_has_roles_on_its_own_joints(data: st.DataObject, joints: int) -> None:
    parents = [-1] + [data.draw(st.integers(0, i - 1)) for i in range(1, joints)]
    names = [f"{data.draw(st.sampled_from(_SOME_NAMES))} {i}" for i in range(joints)]
    offsets = np.random.default_rng(joints).integers(-1, 2, size=(joints, 3)).astype(float)
    tree = Skeleton(tuple(names), np.array(parents), offsets, np.array([joints - 1]), np.ones((1, 3)))
    roles = with_found_roles(tree).roles
    limbs = [mark.joint for role, mark in roles.items() if role.startswith(("left", "right")) and "toe" not in role]
    assert len(set(limbs)) == len(limbs)


def test_roles_that_the_skeleton_had_give_way() -> None:
    body = deepmimic.skeleton()
    stale = Skeleton(body.names, body.parents, body.offsets, roles={"spine": body.landmark("head")})
    assert "spine" not in with_found_roles(stale).roles


@pytest.mark.parametrize(
    "name",
    ["walks/15_01.bvh", "salsa/Easy_01_leader.bvh", "sports/006_15_cmu60.bvh", "sensors/neura/S02-Trial-Walk-1.bvh"],
)
def test_recordings_have_every_role(data_folder: Path, name: str) -> None:
    if not (data_folder / name).exists():
        pytest.skip(f"no {name} in the recordings")
    skeleton = load(data_folder / name).motion().skeleton
    named = find_roles(skeleton)
    assert set(named) == set(ROLES)
    if "cmu60" not in name:  # the rest pose of that one does not stand
        by_shape = find_roles(_anonymous(skeleton))
        assert {role: mark.joint for role, mark in by_shape.items()} == {r: m.joint for r, m in named.items()}
