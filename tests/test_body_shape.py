"""Roles of bodies without names: among twisting joints, fingers, skirts and hair, whichever way they face."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from bodies import BONES, person
from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.formats import load, save
from kinetograph.motion import Motion
from kinetograph.roles import find_roles, is_body
from kinetograph.skeleton import Skeleton

NAMED = {name: i for i, (name, *_) in enumerate(BONES)}


@dataclass
class Rig:
    """A tree of joints under construction: names, parents and offsets."""

    names: list[str] = field(default_factory=lambda: [name for name, *_ in BONES])
    parents: list[int] = field(default_factory=lambda: [NAMED.get(parent, -1) for _, parent, _ in BONES])
    offsets: list[FloatArray] = field(default_factory=lambda: [np.array(at, float) for *_, at in BONES])

    def chain(self, on: str, name: str, *offsets: tuple[float, float, float]) -> Rig:
        """Hang a chain on a joint."""
        parent = self.names.index(on)
        for i, offset in enumerate(offsets):
            self.names.append(f"{name}{i}")
            self.parents.append(parent)
            self.offsets.append(np.array(offset))
            parent = len(self.names) - 1
        return self

    def split(self, joint: str, share: float = 0.5) -> Rig:
        """Cut the bone that ends at a joint in two by a joint that twists."""
        at = self.names.index(joint)
        self.names.append(f"{joint}_twist")
        self.parents.append(self.parents[at])
        self.offsets.append(share * self.offsets[at])
        self.parents[at], self.offsets[at] = len(self.names) - 1, (1 - share) * self.offsets[at]
        return self

    def skeleton(self, seed: int = 0) -> Skeleton:
        """The skeleton, parents first, siblings in a random order."""
        rng = np.random.default_rng(seed)
        order: list[int] = []
        todo = [self.parents.index(-1)]
        while todo:
            order.append(todo.pop(rng.integers(len(todo))))
            todo += [i for i, parent in enumerate(self.parents) if parent == order[-1]]
        place = {old: new for new, old in enumerate(order)}
        parents = np.array([place.get(self.parents[old], -1) for old in order])
        return Skeleton(
            tuple(self.names[old] for old in order), parents, np.array([self.offsets[old] for old in order])
        )


def _fingers(rig: Rig) -> Rig:
    for side, s in (("Left", 1), ("Right", -1)):
        for i in range(5):
            rig.chain(
                f"{side}Hand",
                f"{side}Finger{i}_",
                *(((0.09 * s, 0, 0.02 * i - 0.04)), (0.03 * s, 0, 0), (0.02 * s, 0, 0)),
            )
    return rig


def _twists(rig: Rig) -> Rig:
    for side in ("Left", "Right"):
        for joint in ("ForeArm", "Hand", "Leg", "Foot"):
            rig.split(f"{side}{joint}")
    return rig


def _leaves(rig: Rig) -> Rig:
    for side, s in (("Left", 1), ("Right", -1)):
        rig.chain(f"{side}Arm", f"{side}twist", (0.14 * s, 0, 0)).chain(
            f"{side}UpLeg", f"{side}leg_twist", (0, -0.2, 0)
        )
    return rig


def _skirt(rig: Rig) -> Rig:
    for i in range(8):
        x, z = np.sin(i * np.pi / 4), np.cos(i * np.pi / 4)
        rig.chain("Hips", f"skirt{i}_", (0.12 * x, 0, 0.12 * z), *[(0.05 * x, -0.2, 0.05 * z)] * 4)
    return rig


def _hair(rig: Rig) -> Rig:
    for side, s in (("Left", 1), ("Right", -1)):
        rig.chain("Head", f"{side}pigtail", (0.08 * s, 0.05, -0.02), *[(0.02 * s, -0.15, 0.0)] * 4)
    return rig.chain("Head", "top", (0, 0.2, 0)).chain("Head", "jaw", (0, -0.02, 0.1))


def _spine(rig: Rig) -> Rig:
    return rig.split("Spine").split("Chest").split("Neck").split("Chest_twist")


EXTRAS = {
    "plain": lambda rig: rig,
    "fingers": _fingers,
    "twists in the bones": lambda rig: _twists(_fingers(rig)),
    "twists beside the bones": _leaves,
    "a skirt": _skirt,
    "hair and a jaw": _hair,
    "many joints in the spine": _spine,
    "all of it": lambda rig: _spine(_hair(_skirt(_leaves(_fingers(rig))))),
}


def _nameless(skeleton: Skeleton, style: str) -> Skeleton:
    names = tuple(style.format(i) for i in range(len(skeleton)))
    return Skeleton(names, skeleton.parents, skeleton.offsets, skeleton.end_parents, skeleton.end_offsets)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("extra", EXTRAS)
def test_limbs_are_found_among_what_else_a_rig_has(extra: str, seed: int) -> None:
    skeleton = EXTRAS[extra](Rig()).skeleton(seed)
    named = {role: mark.joint for role, mark in person().roles.items()}
    wanted = {role: skeleton.index(BONES[joint][0]) for role, joint in named.items()}
    if "spine" in extra or "all" in extra:
        wanted["spine"] = skeleton.index("Spine_twist")
        wanted["neck"] = skeleton.index("Neck_twist")
    found = {role: mark.joint for role, mark in find_roles(_nameless(skeleton, "Bone.{:03}")).items()}
    assert {role: skeleton.names[joint] for role, joint in found.items()} == {
        role: skeleton.names[joint] for role, joint in wanted.items()
    }


@pytest.mark.parametrize("angle", [0.0, 1.0, 2.5, np.pi])
@pytest.mark.parametrize("lying", [False, True])
def test_left_is_left_whichever_way_the_body_faces(angle: float, lying: bool) -> None:
    way = rot.multiply(rot.about("y", angle), rot.about("x", -np.pi / 2 if lying else 0.0))
    body = person()
    offsets = rot.rotate(way, body.offsets)
    roles = find_roles(_nameless(Skeleton(body.names, body.parents, offsets), "node_{}"))
    assert {role: mark.joint for role, mark in roles.items()} == {r: m.joint for r, m in body.roles.items()}


def test_a_stance_shows_what_a_rest_pose_does_not() -> None:
    body = _fingers(Rig()).skeleton()
    rng = np.random.default_rng(5)
    facing = rot.normalize(rng.normal(size=(len(body), 4)))  # of the joints' axes in the stance: at rest all is tangled
    parents = np.maximum(body.parents, 0)
    offsets = rot.rotate(rot.conjugate(facing[parents]), body.offsets)
    stance = rot.multiply(rot.conjugate(facing[parents]), facing)
    stance[0] = facing[0]
    nameless = _nameless(body, "node_{}")
    tangled = Skeleton(nameless.names, body.parents, offsets, stance=stance)
    assert len(find_roles(tangled)) == 21
    assert {r: m.joint for r, m in find_roles(tangled).items()} == {r: m.joint for r, m in find_roles(nameless).items()}
    # names show roles, and bones heights, whatever the rest pose
    named = Skeleton(body.names, body.parents, offsets, stance=stance, roles=find_roles(body))
    assert named.height == pytest.approx(
        Skeleton(body.names, body.parents, body.offsets, roles=find_roles(body)).height
    )


@pytest.mark.parametrize("style", ["node_{}", "Bone.{:03}", "{}", "joint{}"])
def test_glb_files_without_names_have_roles(tmp_path: Path, style: str) -> None:
    skeleton = _nameless(_fingers(Rig()).skeleton(1), style)
    motion = Motion(skeleton, np.tile([0.0, 0.95, 0.0], (3, 1)), rot.identity(3, len(skeleton)), 30.0)
    save(motion, tmp_path / "a.glb")
    back = load(tmp_path / "a.glb").motion().skeleton
    assert len(back.roles) == 21
    assert {r: back.names[m.joint] for r, m in back.roles.items()} == {
        r: skeleton.names[m.joint] for r, m in find_roles(skeleton).items()
    }


def test_a_table_and_a_snake_are_no_bodies() -> None:
    snake = Skeleton(tuple(f"n{i}" for i in range(30)), np.arange(30) - 1, np.tile([0.0, 0.0, 0.1], (30, 1)))
    assert not find_roles(snake)
    table = Rig(["top"], [-1], [np.zeros(3)])
    for i, (x, z) in enumerate([(1, 1), (1, -1), (-1, 1), (-1, -1)]):
        table.chain("top", f"leg{i}", (x, 0, z), (0, -0.4, 0), (0, -0.4, 0))
    assert not is_body(Skeleton(*_parts(table), roles=find_roles(Skeleton(*_parts(table)))))


def _parts(rig: Rig) -> tuple[tuple[str, ...], np.ndarray, np.ndarray]:
    return tuple(rig.names), np.array(rig.parents), np.array(rig.offsets)
