# SPDX-License-Identifier: GPL-3.0-or-later
"""Armatures as bodies: the bones that are joints, their rest pose in the world, and the roles that they play.

A body's joints are frames that are aligned with the world at rest, so that rest poses of any bone axes look alike to
kinetograph. The first joint is the bone that plays the hips; what is above it stands still.
"""

import json
import os
import re

import bpy
import numpy as np

from . import axes
from .link import Trouble

ROLES = "kinetograph_roles"
"""The property of an armature that keeps the bones by role, as JSON."""

MADE = "kinetograph_made"
"""The property of armatures that the extension made."""


class Rig:
    """An armature, the bones of it that are joints, and how they stand in the world at rest.

    `bones` are names, parents first; `parents` are indices, -1 for the first. `heads` and `frames` are of the rest pose
    in the world: metres and quaternions, Z up.
    """

    def __init__(self, thing, bones, parents, unit):
        self.thing, self.bones, self.parents, self.unit = thing, bones, parents, unit
        self.world = np.array(thing.matrix_world)
        self.turn, self.scale = _turn_and_scale(thing, self.world)
        data = thing.data.bones
        rest = np.array([np.array(data[name].matrix_local) for name in bones]).reshape(-1, 4, 4)
        self.local = axes.quaternions(rest[:, :3, :3])
        self.places = rest[:, :3, 3]
        self.tails = np.array([data[name].tail_local[:] for name in bones])
        self.heads = self.to_world(self.places)
        self.frames = axes.multiply(np.broadcast_to(self.turn, self.local.shape), self.local)

    def to_world(self, points):
        """Points of the armature in metres of the world."""
        return (points @ self.world[:3, :3].T + self.world[:3, 3]) * self.unit

    def to_armature(self, points):
        """Points in metres of the world as the armature's own."""
        inverse = np.linalg.inv(self.world)
        return (np.asarray(points) / self.unit) @ inverse[:3, :3].T + inverse[:3, 3]

    def body(self, roles=None):
        """It as kinetograph takes it."""
        heads, tails = axes.to_y_up(self.heads), axes.to_y_up(self.to_world(self.tails))
        offsets = [
            head - (heads[parent] if parent >= 0 else 0.0) for head, parent in zip(heads, self.parents, strict=True)
        ]
        last = [i for i in range(len(self.bones)) if i not in self.parents]
        ends = [{"joint": self.bones[i], "offset": (tails[i] - heads[i]).tolist()} for i in last]
        return {
            "names": self.bones,
            "parents": self.parents,
            "offsets": [offset.tolist() for offset in np.array(offsets)],
            "ends": ends,
            "roles": {role: bone for role, bone in (roles or {}).items() if bone in self.bones or bone == ""},
        }

    def skin(self, roles, folder):
        """A file of what is around the joints at rest: the meshes that the armature moves, or else its soles.

        Empty for an armature that the extension made, which stays at the heights of the recordings.
        """
        found = _meshes(self)
        if found is None and self.thing.data.get(MADE):
            return ""
        points, joints, weights = found or _soles(self, roles)
        points = axes.to_y_up(points) - axes.to_y_up(self.heads[0])
        path = os.path.join(folder, f"skin-{len(os.listdir(folder))}.npz")
        np.savez(path, points=points, joints=joints, weights=weights)
        return path


def _meshes(rig):
    """Points (V, 3) of meshes in metres of the world, and the joints (V, 4) that move them, with weights (V, 4)."""
    points, joints, weights = [], [], []
    for mesh in bpy.data.objects:
        if mesh.type != "MESH" or mesh.find_armature() != rig.thing or not len(mesh.data.vertices):
            continue
        places = np.empty(3 * len(mesh.data.vertices))
        mesh.data.vertices.foreach_get("co", places)
        world = np.array(mesh.matrix_world)
        moved = [_joint_of(rig, group.name) for group in mesh.vertex_groups]
        for vertex, place in zip(mesh.data.vertices, places.reshape(-1, 3), strict=True):
            found = [(g.weight, moved[g.group]) for g in vertex.groups if moved[g.group] is not None and g.weight > 0]
            if found:
                best = sorted(found, reverse=True)[:4]
                total = sum(weight for weight, _ in best)
                points.append((world[:3, :3] @ place + world[:3, 3]) * rig.unit)
                joints.append([joint for _, joint in best] + [0] * (4 - len(best)))
                weights.append([weight / total for weight, _ in best] + [0.0] * (4 - len(best)))
    return (np.array(points), np.array(joints), np.array(weights)) if points else None


def _joint_of(rig, name):
    """The joint that a vertex group goes with: its bone, the bone that it is a copy of, or one above it."""
    bone = rig.thing.data.bones.get(name)
    while bone is not None:
        for known in (
            bone.name,
            re.sub(r"^DEF-", "ORG-", bone.name),
            re.sub(r"^DEF-(.*?)(\.\d+)?$", r"ORG-\1", bone.name),
        ):
            if known in rig.bones:
                return rig.bones.index(known)
        bone = bone.parent
    return None


def _soles(rig, roles):
    """Points below the ankles, the toes and their tips, as low as anything of the armature."""
    points, joints = [rig.heads[0].tolist()], [[0, 0, 0, 0]]
    floor = min(rig.heads[:, 2].min(), rig.to_world(rig.tails)[:, 2].min())
    for role in ("left_foot", "left_toe", "right_foot", "right_toe"):
        if roles.get(role) in rig.bones:
            joint = rig.bones.index(roles[role])
            tip = rig.to_world(rig.tails)[joint]
            for place in (rig.heads[joint], tip) if role.endswith("toe") else (rig.heads[joint],):
                points.append([place[0], place[1], floor])
                joints.append([joint, 0, 0, 0])
    return np.array(points), np.array(joints), np.tile([1.0, 0.0, 0.0, 0.0], (len(points), 1))


def _turn_and_scale(thing, world):
    """The rotation of an object, a quaternion, and its scale. Raises Trouble where it is sheared or mirrored."""
    scales = np.linalg.norm(world[:3, :3], axis=0)
    if np.ptp(scales) > 1e-3 * scales.max() or np.linalg.det(world[:3, :3]) <= 0:
        raise Trouble(f"{thing.name} is scaled differently along its axes, or mirrored: apply its scale (Ctrl-A)")
    return axes.quaternions(world[:3, :3] / scales), float(scales.mean())


def require_armature(thing, name="an armature"):
    """Raise Trouble unless an object is an armature that may be animated."""
    if thing is None or thing.type != "ARMATURE":
        found = "nothing" if thing is None else f"{thing.name}, a {thing.type.lower()}"
        raise Trouble(f"expected {name}, found {found}")
    if not thing.data.bones:
        raise Trouble(f"{thing.name} has no bones")


def require_writable(thing):
    """Raise Trouble where an object is linked from another file."""
    if thing.library is not None or not thing.is_editable:
        raise Trouble(f"{thing.name} is linked and cannot be animated: make a library override, or append it")


def is_rigify(thing):
    """Whether an armature is a rig that Rigify generated."""
    return "rig_id" in thing.data and any(name.startswith("ORG-") for name in thing.data.bones.keys())


def tree(thing):
    """All bones that may be joints, parents first, and their parents."""
    if is_rigify(thing):
        return _rigify_tree(thing)
    roots = [bone for bone in thing.data.bones if bone.parent is None]
    deform = [root for root in roots if any(bone.use_deform for bone in [root, *root.children_recursive])] or roots
    root = max(deform, key=lambda bone: len(bone.children_recursive))
    return _listed(root, lambda bone: bone.children)


def _listed(root, children):
    names, parents, row = [root.name], [-1], [root]
    for bone in row:  # which grows
        for child in children(bone):
            parents.append(names.index(bone.name))
            names.append(child.name)
            row.append(child)
    return names, parents


def _rigify_tree(thing):
    """The bones of the metarig, whose copies begin with ORG-; the spine's are joined where one ends and one begins."""
    face = thing.data.bones.get("ORG-face")
    left = {bone.name for bone in face.children_recursive} if face is not None else set()
    bones = [bone for bone in thing.data.bones if bone.name.startswith("ORG-") and bone.name not in left]
    known, below = {bone.name for bone in bones}, {bone.name: [] for bone in bones}
    root = thing.data.bones.get("ORG-spine") or bones[0]
    spine = [bone for bone in bones if bone.name.startswith("ORG-spine")]
    for bone in bones:
        above = bone.parent
        while above is not None and above.name not in known:
            above = above.parent
        if bone != root:
            parent = above or _ending_at(spine, bone) or root
            below[parent.name].append(bone)
    return _listed(root, lambda bone: below[bone.name])


def _ending_at(bones, bone):
    """The bone before in the numbered row of a spine, which ends where this one begins."""
    before = [other for other in bones if other.name < bone.name]
    return next((other for other in before if (other.tail_local - bone.head_local).length < 1e-4), None)


def below_hips(names, parents, hips):
    """The part of a tree from the hips on."""
    kept = [names.index(hips)]
    for i, parent in enumerate(parents):
        if parent in kept:
            kept.append(i)
    kept = sorted(set(kept))
    return [names[i] for i in kept], [kept.index(parents[i]) if parents[i] in kept else -1 for i in kept]


def stored_roles(thing):
    """The bones by role that are kept with an armature; empty where there are none."""
    try:
        roles = json.loads(thing.data.get(ROLES, "{}"))
    except ValueError:
        return {}
    return {role: bone for role, bone in roles.items() if bone in thing.data.bones or bone == ""}


def store_roles(thing, roles):
    """Keep bones by role with an armature."""
    thing.data[ROLES] = json.dumps(roles)


def find_rig(thing, unit):
    """An armature as a `Rig`, with its roles; a task (see tasks.py) that asks kinetograph for those that are not kept.

    Raises Trouble for an armature that is nobody's.
    """
    require_armature(thing)
    names, parents = tree(thing)
    given = stored_roles(thing)
    found = yield "roles", {"body": Rig(thing, names, parents, unit).body(given)}
    roles = {**found["roles"], **given}
    lacking = [role for role in ("hips", "left_hip", "right_hip", "left_foot", "right_foot") if not roles.get(role)]
    if lacking:
        said = ", ".join(role.replace("_", " ") for role in lacking)
        raise Trouble(f"{thing.name}: no bone plays the {said}; name them in the panel Roles")
    names, parents = below_hips(names, parents, roles["hips"])
    return Rig(thing, names, parents, unit), {role: bone for role, bone in roles.items() if bone in names}
