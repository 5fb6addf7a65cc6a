# SPDX-License-Identifier: GPL-3.0-or-later
"""Results become armatures and actions."""

import bpy
import numpy as np

from . import axes, controls
from .actions import Curves, Posed, assign, provenance, write_bone
from .bodies import MADE, Rig, store_roles
from .link import Trouble
from .motions import arrays, targets
from .slices import Slice, at_a_stretch

_SHORT = 0.02  # metres, the least length of a bone


def new_armature(context, body, name, unit):
    """An armature with the bones of a body, and it as a `Rig`."""
    data = bpy.data.armatures.new(name)
    thing = bpy.data.objects.new(name, data)
    context.collection.objects.link(thing)
    if context.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for other in context.selected_objects:
        other.select_set(False)
    context.view_layer.objects.active = thing
    thing.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    try:
        names = _bones(data, body, unit)
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")
    data[MADE] = True
    store_roles(thing, {role: names[body["names"].index(bone)] for role, bone in body["roles"].items()})
    for bone in thing.pose.bones:
        bone.rotation_mode = "QUATERNION"
    return Rig(thing, names, list(body["parents"]), unit)


def _bones(data, body, unit):
    """Make the bones of a body at rest, each towards its child; their names, which Blender may shorten."""
    heads = np.zeros((len(body["names"]), 3))
    for joint, (parent, offset) in enumerate(zip(body["parents"], body["offsets"], strict=True)):
        if parent >= 0:
            heads[joint] = heads[parent] + axes.to_z_up(offset)
    ends = {end["joint"]: axes.to_z_up(end["offset"]) for end in body.get("ends", [])}
    made = []
    for joint, name in enumerate(body["names"]):
        bone = data.edit_bones.new(name)
        bone.head = heads[joint] / unit
        bone.tail = (heads[joint] + _bone_of(joint, body, heads, ends)) / unit
        if body["parents"][joint] >= 0:
            bone.parent = made[body["parents"][joint]]
        made.append(bone)
    return [bone.name for bone in made]


def _bone_of(joint, body, heads, ends):
    """From the head of a joint's bone to its tail: to the child with most below it, or to its end."""
    below = [i for i, parent in enumerate(body["parents"]) if parent == joint]
    if below:
        bone = heads[max(below, key=lambda i: _size(i, body["parents"]))] - heads[joint]
    else:
        bone = ends.get(body["names"][joint], np.zeros(3))
    if np.linalg.norm(bone) >= _SHORT:
        return bone
    above = heads[joint] - heads[body["parents"][joint]] if body["parents"][joint] >= 0 else np.zeros(3)
    length = np.linalg.norm(above)
    return above / length * 0.08 if length > 1e-6 else np.array([0.0, 0.0, 0.1])


def _size(joint, parents):
    return 1 + sum(_size(i, parents) for i, parent in enumerate(parents) if parent == joint)


class Put:
    """How a result is put onto a rig.

    The name of a new action and its first frame; an action, and a span of its frames, that it goes into instead; and
    whether bones that it does not move stay as they are.
    """

    def __init__(self, name, start, action=None, span=None, keep_pose=False):
        self.name, self.start, self.action, self.span, self.keep_pose = name, start, action, span, keep_pose


def put(rig, roles, made, names, how, scene, facts):
    """A result as an action of a rig, which plays it from then on; in slices.

    ``names`` are the bones that the result's joints are. ``facts`` are the version and the library, for the action.
    """
    translation, rotations = arrays(made["motion"])
    if len(translation) == 0 or not np.isfinite(translation).all():
        raise Trouble("kinetograph's result has no frames")
    if rig.thing.mode == "EDIT":
        bpy.ops.object.mode_set(mode="OBJECT")
    frames = how.start + np.arange(len(translation))
    fresh = how.action is None
    action = bpy.data.actions.new(how.name) if fresh else how.action
    if fresh:
        assign(rig.thing, None)
        if not how.keep_pose:
            rest(rig.thing)
        assign(rig.thing, action)
    curves = Curves(action, rig.thing)
    assign(rig.thing, action)
    turned, heads = targets(rig, names, translation, rotations)
    if controls.driven(rig):
        yield from controls.write(rig, curves, scene, frames, turned, heads, how.span)
    else:
        yield from write_plain(rig, curves, frames, turned, heads, how.span)
    scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
    provenance(action, made, how.start, made["motion"]["fps"], *facts)
    return action


class Shower:
    """Poses a rig for one frame after another, without keys."""

    def __init__(self, rig, scene):
        self._rig = rig
        self._controls = controls.Live(rig, scene) if controls.driven(rig) else None

    def show(self, names, translation, rotations):
        """Pose it as a single frame says; ``names`` are the bones that the joints are."""
        turned, heads = targets(self._rig, names, translation, rotations)
        if self._controls is not None:
            self._controls.show(turned, heads)
        else:
            at_a_stretch(write_plain(self._rig, Posed(self._rig), np.zeros(1), turned, heads, None))


def rest(thing):
    """Put an armature's bones to rest, so that nothing of an earlier pose stays."""
    for bone in thing.pose.bones:
        bone.matrix_basis.identity()
        bone.location = (0.0, 0.0, 0.0)
        bone.scale = (1.0, 1.0, 1.0)
        if bone.rotation_mode == "QUATERNION":
            bone.rotation_quaternion = (1.0, 0.0, 0.0, 0.0)
        elif bone.rotation_mode == "AXIS_ANGLE":
            bone.rotation_axis_angle = (0.0, 0.0, 1.0, 0.0)
        else:
            bone.rotation_euler = (0.0, 0.0, 0.0)


def write_plain(rig, curves, frames, turned, heads, span):
    """Key every bone of a rig that is posed bone by bone; in slices."""
    slice_ = Slice()
    for joint, name in enumerate(rig.bones):
        parent = rig.parents[joint]
        if parent < 0:
            _write_root(rig, curves, frames, turned[:, 0], heads[:, 0], span)
            continue
        still = axes.multiply(axes.inverse(rig.local[parent]), rig.local[joint])
        moving = axes.multiply(axes.inverse(turned[:, parent]), turned[:, joint])
        basis = axes.multiply(np.broadcast_to(axes.inverse(still), moving.shape), moving)
        write_bone(curves, rig.thing, name, frames, basis, None, span)
        if slice_.over():
            yield


def _write_root(rig, curves, frames, turned, heads, span):
    """Key the root, in which what is above it stands as it stands now."""
    bone = rig.thing.data.bones[rig.bones[0]]
    if bone.use_connect:
        raise Trouble(
            f"{rig.thing.name}: the bone {bone.name} is connected to its parent and cannot move; disconnect it"
        )
    above, below = np.eye(4), np.array(bone.matrix_local)
    if bone.parent is not None:
        posed = np.array(rig.thing.pose.bones[bone.parent.name].matrix)
        above = posed @ np.linalg.inv(np.array(bone.parent.matrix_local)) @ below
    else:
        above = below
    inverse = np.linalg.inv(above)
    scale = np.linalg.norm(above[:3, 0])
    q = axes.quaternions(above[:3, :3] / scale)
    basis = axes.multiply(np.broadcast_to(axes.inverse(q), turned.shape), turned)
    places = heads @ inverse[:3, :3].T + inverse[:3, 3]
    write_bone(curves, rig.thing, bone.name, frames, basis, places, span)


def in_tracks(thing, original, made, start):
    """Put actions into NLA tracks above the original one, each from its first frame; only the first is heard."""
    data = thing.animation_data
    data.action = None
    if original is not None and not any(s.action == original for t in data.nla_tracks for s in t.strips):
        _track(data, original, round(original.frame_range[0]), "HOLD").name = "original"
    for number, action in enumerate(made):
        track = _track(data, action, start, "NOTHING")
        track.name, track.mute = action.name, number > 0


def _track(data, action, start, extrapolation):
    track = data.nla_tracks.new()
    strip = track.strips.new(action.name, start, action)
    strip.extrapolation, strip.blend_type = extrapolation, "REPLACE"
    if hasattr(strip, "action_slot") and strip.action_slot is None and action.slots:
        strip.action_slot = action.slots[0]
    return track
