# SPDX-License-Identifier: GPL-3.0-or-later
"""Rigs whose bones are driven by control bones: those that Rigify generates, and others with IK or copied transforms.

Each control belongs to a joint, from which it stands as at rest. Its keys are worked out from where its parents are to
be, and then, where the rig does otherwise (a neck that does not turn with the chest), once more from where the rig, as
Blender evaluates it, has put them; a few times at most.
"""

import re

import bpy
import numpy as np

from . import axes
from .actions import Posed, write_bone
from .bodies import is_rigify
from .motions import evaluated, watched
from .slices import Slice, at_a_stretch

_PASSES = 5
_ANGLE, _PLACE = np.radians(0.05), 2e-4  # radians and shares of the rig's size that are near enough
_COPIES = ("COPY_TRANSFORMS", "COPY_ROTATION")
_HOLDS = ("COPY_LOCATION", "IK", "CHILD_OF", "DAMPED_TRACK", "TRACK_TO", "LOCKED_TRACK", "STRETCH_TO", "FOLLOW_PATH")
_FULL, _TURNED, _PLACED = "full", "turned", "placed"
_SIDES = ("L", "R")
_AT_ONCE = 256  # poses of controls that are worked out at once


class Control:
    """A control bone, its joint, and what of it is keyed."""

    def __init__(self, bone, joint, what=_TURNED):
        self.bone, self.joint, self.what = bone, joint, what


class Pole:
    """A control bone that the knee, or the elbow, of a limb points to."""

    what = _PLACED

    def __init__(self, bone, limb):
        self.bone, self.limb = bone, limb
        self.turn = 0.0  # radians about the line from the first joint to the last, that what it does is corrected by


def driven(rig):
    """Whether some of a rig's bones are driven by others."""
    if is_rigify(rig.thing):
        return True
    return any(_goes_by(rig, name) != name or _ik(rig, name) for name in rig.bones)


def held_elsewhere(rig):
    """A line for a person where other objects hold bones of a rig, whatever keys say; empty otherwise."""
    held = [name for name in rig.bones if any(_by_another(rig, c) for c in rig.thing.pose.bones[name].constraints)]
    if not held:
        return ""
    more = f" and {len(held) - 4} more" if len(held) > 4 else ""
    return f"other objects hold {', '.join(held[:4])}{more} by constraints, whatever keys say: mute those"


def _by_another(rig, constraint):
    target = getattr(constraint, "target", None)
    there = target is not None and target != rig.thing and constraint.type in (*_COPIES, *_HOLDS)
    return there and not constraint.mute and constraint.influence > 0.01


def write(rig, curves, scene, frames, turned, heads, span=None):
    """Key the controls of a rig so that its bones are where a motion puts them, as near as it lets them; in slices."""
    if is_rigify(rig.thing) and scene.kinetograph.on_fk:
        _switch_to_fk(rig, curves, frames, span)
    solver, slice_ = _Solver(rig, *_controls(rig, curves, frames, span)), Slice()
    solver.aim(_matrices(turned, heads))
    before = np.inf
    for _ in range(_PASSES):
        yield from solver.write(curves, frames, span, slice_)
        solver.learn((yield from watched(rig.thing, solver.names, frames, slice_)))
        missing = solver.missing()
        if solver.near or missing > 0.99 * before:
            break
        before = missing
    tweaks = _tweaks(rig) if is_rigify(rig.thing) else []
    if tweaks and not solver.near:
        solver.tweak(tweaks)
        yield from solver.write(curves, frames, span, slice_)


class Live:
    """Poses the controls of a rig for one frame after another, by what the rig did with them at the one before."""

    def __init__(self, rig, scene):
        self._rig, self._posed = rig, Posed(rig)
        frames = np.zeros(1)
        if is_rigify(rig.thing) and scene.kinetograph.on_fk:
            _switch_to_fk(rig, self._posed, frames, None)
        table, poles = _controls(rig, self._posed, frames, None)
        self._solver = _Solver(rig, table + (_tweaks(rig) if is_rigify(rig.thing) else []), poles)
        self._passes = _PASSES - 1  # the first time, nothing is known of the rig

    def show(self, turned, heads):
        """Pose it."""
        goals = _matrices(turned, heads)
        for _ in range(self._passes):
            self._solver.aim(goals)
            self._write()
            self._solver.learn(self._seen())
        if self._passes == 0:
            self._solver.learn(self._seen())
        self._passes = 0
        self._solver.aim(goals)
        self._write()

    def _write(self):
        at_a_stretch(self._solver.write(self._posed, np.zeros(1), None, Slice()))

    def _seen(self):
        posed = evaluated(self._rig.thing).pose.bones
        return np.array([[np.array(posed[name].matrix) for name in self._solver.names]])


def _controls(rig, curves, frames, span):
    """The controls of a rig, and its poles; settings that its IK cannot do with are keyed."""
    if is_rigify(rig.thing):
        return _rigify(rig, curves, frames, span)
    for name in rig.bones:
        for constraint in _ik(rig, name):
            _keep_lengths(rig, name, constraint, curves, frames, span)
    return _others(rig)


class _Solver:
    """Keys of controls, made better by what the rig does with them. Matrices are (F, 4, 4), in the armature's space."""

    def __init__(self, rig, table, poles):
        self.rig, self.table, self.poles = rig, table, poles
        self.names = list(dict.fromkeys([*rig.bones, *(control.bone for control in [*table, *poles])]))
        self.known = set(rig.bones) | {control.bone for control in table}
        bones = rig.thing.data.bones
        self.rest = {name: np.array(bones[name].matrix_local) for name in self.names}
        self.posed = {name: self.rest[name][None] for name in self.names}
        self.basis = {each.bone: np.eye(4)[None] for each in [*table, *poles]}
        self.shift = {"torso": np.zeros((1, 3))}
        self.goal, self.planes, self.near = {}, [], False
        heads = np.array([self.rest[name][:3, 3] for name in rig.bones])
        self._size = np.ptp(heads, axis=0).max()

    def aim(self, goals):
        """Know where joints are to be, (F, J, 4, 4)."""
        self.goal |= {name: goals[:, joint] for joint, name in enumerate(self.rig.bones)}
        for control in self.table:
            to = np.linalg.inv(self.rest[control.joint]) @ self.rest[control.bone]
            self.goal[control.bone] = self.goal[control.joint] @ to
            if control.bone in self.shift:
                moved = self.goal[control.bone].copy()
                moved[:, :3, 3] += (moved[:, :3, :3] @ self.shift[control.bone][..., None])[..., 0]
                self.goal[control.bone] = moved

    def write(self, curves, frames, span, slice_):
        """Work out the controls' bases, and key them; in slices."""
        for pole in self.poles:
            goal = np.broadcast_to(np.eye(4), (len(frames), 4, 4)).copy()
            goal[:, :3, 3] = _pole_places(self.goal, self.rest, pole)
            self.goal[pole.bone] = goal
        every, some = [*self.table, *self.poles], max(_AT_ONCE // len(frames), 1)
        for first in range(0, len(every), some):
            group = every[first : first + some]
            for control, (q, places) in zip(group, self._bases(group, len(frames)), strict=True):
                places = places if control.what in (_FULL, _PLACED) else None
                write_bone(curves, self.rig.thing, control.bone, frames, q, places, span)
                if slice_.over():
                    yield

    def _bases(self, group, count):
        """The rotations and places, in their own bases, of some controls at every frame."""
        shape = (count, 4, 4)
        spaces = np.stack([np.broadcast_to(self._space(control.bone), shape) for control in group])
        basis = np.linalg.inv(spaces) @ np.stack([np.broadcast_to(self.goal[c.bone], shape) for c in group])
        q, places = axes.quaternions(_pure(basis[..., :3, :3])), basis[..., :3, 3]
        for control, turned, place in zip(group, q, places, strict=True):
            if control.what == _PLACED:
                turned[:] = (1.0, 0.0, 0.0, 0.0)
            if control.what == _TURNED:
                place[:] = 0.0
        for control, made in zip(group, _matrices(q, places), strict=True):
            self.basis[control.bone] = made
        return zip(q, places, strict=True)

    def _space(self, name):
        """The space that a control moves in, where the bones above it are as they are to be."""
        here = self.posed[name] @ np.linalg.inv(self.basis[name])
        above = self.rig.thing.data.bones[name].parent
        while above is not None and above.name not in self.known:
            above = above.parent
        return here if above is None else self.goal[above.name] @ np.linalg.inv(self.posed[above.name]) @ here

    def learn(self, seen):
        """Take in what the rig does, (F, N, 4, 4) of `names`."""
        self.posed = {name: seen[:, i] for i, name in enumerate(self.names)}
        for control in self.table:
            if control.bone in self.shift:
                self._shift(control)
        self.planes = [_amiss(self.posed, self.goal, pole.limb) for pole in self.poles]
        for pole, plane in zip(self.poles, self.planes, strict=True):
            pole.turn = pole.turn + np.where(self._stands(pole), plane, 0.0)

    def missing(self):
        """How far, all together, joints are from their places; whether they are `near` them."""
        bent = {name for pole in self.poles for name in pole.limb[:2]}  # a knee is a hinge: rotations may differ
        joints = [control.joint for control in self.table if control.joint not in bent]
        off = [apart(self.posed[joint], self.goal[joint]) for joint in joints]
        self.near = all(self._is_near(joint) for joint in joints) and all(abs(p).max() < _ANGLE for p in self.planes)
        missing = sum(float(turn.mean() + place.mean() / self._size) for turn, place in off)
        return missing + sum(float(abs(plane).mean()) for plane in self.planes)

    def _stands(self, pole):
        """At which frames a pole is where it was put; what a knee misses at others is not its plane's fault."""
        apart = np.linalg.norm(self.posed[pole.bone][:, :3, 3] - self.goal[pole.bone][:, :3, 3], axis=1)
        return apart < 0.01 * self._size

    def _shift(self, control):
        """Move a control by what its joint is missing, since others between them move that as well."""
        moved = self.goal[control.bone].copy()
        missing = self.goal[control.joint][:, :3, 3] - self.posed[control.joint][:, :3, 3]
        moved[:, :3, 3] += missing
        own = np.linalg.inv(_pure(moved[:, :3, :3])) @ missing[..., None]
        self.shift[control.bone] = self.shift[control.bone] + own[..., 0]
        self.goal[control.bone] = moved

    def _is_near(self, name):
        turn, place = apart(self.posed[name], self.goal[name])
        return turn.max() < _ANGLE and place.max() < _PLACE * self._size

    def tweak(self, controls):
        """Let controls that are next to their joints take what is still missing."""
        self.table, self.poles = [control for control in controls if not self._is_near(control.joint)], []
        for control in self.table:
            rest = np.array(self.rig.thing.data.bones[control.bone].matrix_local)
            to = np.linalg.inv(self.rest[control.joint]) @ rest
            self.rest[control.bone], self.goal[control.bone] = rest, self.goal[control.joint] @ to
            self.posed[control.bone] = self.posed[control.joint] @ to
            self.basis[control.bone] = np.broadcast_to(np.eye(4), self.posed[control.bone].shape)


def apart(one, other):
    """How far matrices are from one another: radians, and distances."""
    turn = axes.multiply(
        axes.inverse(axes.quaternions(_pure(one[..., :3, :3]))), axes.quaternions(_pure(other[..., :3, :3]))
    )
    angle = 2 * np.arctan2(np.linalg.norm(turn[..., 1:], axis=-1), np.abs(turn[..., 0]))
    return angle, np.linalg.norm(one[..., :3, 3] - other[..., :3, 3], axis=-1)


def _pure(matrices):
    return matrices / np.maximum(np.linalg.norm(matrices, axis=-2, keepdims=True), 1e-12)


def _matrices(turned, heads):
    out = np.zeros((*turned.shape[:-1], 4, 4))
    out[..., :3, :3], out[..., :3, 3], out[..., 3, 3] = axes.matrices(turned), heads, 1.0
    return out


def _pole_places(goal, rest, pole):
    """Where a pole stands: as far from the knee as the limb is long, on the side that the knee bends to."""
    upper = pole.limb[0]
    a, b, c = (goal[name][:, :3, 3] for name in pole.limb)
    still = _outward(*(rest[name][:3, 3][None] for name in pole.limb))[0]
    turn = goal[upper][:, :3, :3] @ np.linalg.inv(rest[upper][:3, :3])
    usual = turn @ _unit(still)
    bent = _outward(a, b, c)
    length = np.linalg.norm(b - a, axis=1) + np.linalg.norm(c - b, axis=1)
    share = np.clip(np.linalg.norm(bent, axis=1) / (0.01 * length), 0.0, 1.0)[:, None]  # a straight knee shows no plane
    towards = _unit(share * _unit(bent) + (1 - share) * usual)
    half = 0.5 * np.broadcast_to(pole.turn, length.shape)[:, None]
    turn = np.concatenate([np.cos(half), np.sin(half) * _unit(c - a)], axis=1)
    return b + axes.rotate(turn, towards) * length[:, None]


def _amiss(posed, goal, limb):
    """By how much a knee is off its place, (F,) radians about the line from hip to ankle."""
    a, b, c = (goal[name][:, :3, 3] for name in limb)
    wanted, found = _outward(a, b, c), _outward(*(posed[name][:, :3, 3] for name in limb))
    about = (_unit(c - a) * axes.cross(found, wanted)).sum(-1)
    angle = np.arctan2(about, (found * wanted).sum(-1))
    return angle * np.clip(np.linalg.norm(wanted, axis=1) / (0.01 * np.linalg.norm(b - a, axis=1)), 0.0, 1.0)


def _outward(a, b, c):
    line = _unit(c - a)
    return (b - a) - ((b - a) * line).sum(-1, keepdims=True) * line


def _unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)


# ---- rigs of Rigify ----

_FK = {
    "shoulder.{}": "ORG-shoulder.{}",
    "upper_arm_fk.{}": "ORG-upper_arm.{}",
    "forearm_fk.{}": "ORG-forearm.{}",
    "hand_fk.{}": "ORG-hand.{}",
    "thigh_fk.{}": "ORG-thigh.{}",
    "shin_fk.{}": "ORG-shin.{}",
    "foot_fk.{}": "ORG-foot.{}",
    "toe_fk.{}": "ORG-toe.{}",
}
_IK = {
    "arm": ("upper_arm_parent.{}", "upper_arm_ik_target.{}", ("upper_arm", "forearm", "hand"), {"hand_ik.{}": "hand"}),
    "leg": (
        "thigh_parent.{}",
        "thigh_ik_target.{}",
        ("thigh", "shin", "foot"),
        {"foot_ik.{}": "foot", "toe_ik.{}": "toe"},
    ),
}


def _rigify(rig, curves, frames, span):
    """The controls of a rig that Rigify generated. A limb on IK has its end and its pole keyed too."""
    bones = rig.thing.pose.bones
    table = [Control("torso", rig.bones[0], _FULL)] if "torso" in bones else []
    spine = [name for name in rig.bones if re.fullmatch(r"ORG-spine(\.\d+)?", name)]
    trunk = [name for name in spine if f"spine_fk{name[9:]}" in bones]
    table += [Control(f"spine_fk{name[9:]}", name) for name in trunk]
    neck = spine[len(trunk) :]
    if neck and "head" in bones:
        table.append(Control("head", neck[-1], _FULL))
        if len(neck) > 1 and "neck" in bones:
            table.append(Control("neck", neck[0]))
    poles = []
    for side in _SIDES:
        pairs = [(c.format(side), j.format(side)) for c, j in _FK.items()]
        table += [Control(c, j) for c, j in pairs if c in bones and j in rig.bones]
        for limb in _IK.values():
            more, pole = _on_ik(rig, side, limb, curves, frames, span)
            table, poles = table + more, poles + pole
    return table, poles


def _switch_to_fk(rig, curves, frames, span):
    for bone in rig.thing.pose.bones:
        if "IK_FK" in bone:
            _set(rig, bone.name, "IK_FK", 1.0, curves, frames, span)


def _on_ik(rig, side, limb, curves, frames, span):
    """The controls of a limb that is on IK."""
    bones = rig.thing.pose.bones
    switch, pole, joints, ends = limb[0].format(side), limb[1].format(side), limb[2], limb[3]
    if switch not in bones or bones[switch].get("IK_FK", 1.0) > 0.5:
        return [], []
    table = []
    for name, joint in ends.items():
        whole = joint != "toe"
        pair = name.format(side), f"ORG-{joint}.{side}"
        if pair[0] in bones and pair[1] in rig.bones:
            table.append(Control(*pair, _FULL if whole else _TURNED))
    names = tuple(f"ORG-{joint}.{side}" for joint in joints)
    copied = [c.subtarget for name in names if name in bones for c in bones[name].constraints if c.type in _COPIES]
    for name in (name for name in copied if name in bones):
        for constraint in _ik(rig, name, muted=True):
            _keep_lengths(rig, name, constraint, curves, frames, span)
    if pole not in bones or not set(names) <= set(rig.bones) or "pole_vector" not in bones[switch]:
        return table, []
    _set(rig, switch, "pole_vector", True, curves, frames, span)
    return table, [Pole(pole, names)]


def _keep_lengths(rig, name, constraint, curves, frames, span):
    """Let the chain of an IK constraint not stretch: one that may is solved with limbs that are 2 % shorter."""
    bones = rig.thing.pose.bones
    above = bones[name].parent_recursive[: max(constraint.chain_count - 1, 0)]
    for bone in (bones[name], *above):
        if bone.ik_stretch > 0:
            bone.ik_stretch = 0.0
            path = f'pose.bones["{bpy.utils.escape_identifier(bone.name)}"].ik_stretch'
            curves.write(path, frames[[0, -1]], np.zeros((2, 1)), bone.name, span)


def _set(rig, bone, name, value, curves, frames, span):
    """Give a bone's own setting a value, and key it."""
    rig.thing.pose.bones[bone][name] = value
    path = f'pose.bones["{bone}"]["{name}"]'
    curves.write(path, frames[[0, -1]], np.full((2, 1), float(value)), bone, span)


def _tweaks(rig):
    """The controls next to the bones of the spine."""
    bones = rig.thing.pose.bones
    names = [name for name in rig.bones if name.startswith("ORG-spine") and f"tweak_{name[4:]}" in bones]
    return [Control(f"tweak_{name[4:]}", name, _FULL) for name in names]


def _above(rig, name):
    parent = rig.parents[rig.bones.index(name)]
    return rig.bones[parent] if parent >= 0 else None


# ---- other rigs ----


def _others(rig):
    """The controls of a rig with constraints: each joint's own bone or that which it copies, and the goals of IK."""
    table, poles = [], []
    for joint, name in enumerate(rig.bones):
        table.append(Control(_goes_by(rig, name), name, _TURNED if joint else _FULL))
    for name in rig.bones:
        for constraint in _ik(rig, name):
            ends = [rig.bones[i] for i, parent in enumerate(rig.parents) if parent >= 0 and rig.bones[parent] == name]
            upper = _above(rig, name)
            if not ends or upper is None:
                continue
            table.append(Control(constraint.subtarget, ends[0], _FULL))
            if constraint.pole_target == rig.thing and constraint.pole_subtarget:
                poles.append(Pole(constraint.pole_subtarget, (upper, name, ends[0])))
    return table, poles


def _acts(rig, constraint):
    on = not constraint.mute and constraint.influence > 0.5
    return on and getattr(constraint, "target", None) == rig.thing and constraint.subtarget in rig.thing.data.bones


def _goes_by(rig, name):
    """The bone whose transforms a bone copies, or the bone itself."""
    for _ in range(8):
        copies = [c for c in rig.thing.pose.bones[name].constraints if c.type in _COPIES and _acts(rig, c)]
        if not copies or copies[-1].subtarget in rig.bones:
            return name
        name = copies[-1].subtarget
    return name


def _ik(rig, name, muted=False):
    found = [c for c in rig.thing.pose.bones[name].constraints if c.type == "IK"]
    return [c for c in found if muted or _acts(rig, c)]
