# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions: read off the poses of an armature, and turned into poses of one."""

import contextlib
import os

import numpy as np

from . import axes
from .curves import at_frames
from .link import Trouble


def evaluated(thing):
    """The armature as constraints and drivers leave it."""
    import bpy

    return thing.evaluated_get(bpy.context.evaluated_depsgraph_get())


def poses(thing, bones, scene, frames):
    """The matrices of bones in the armature's space at some frames, (F, J, 4, 4)."""

    def look():
        posed = evaluated(thing).pose.bones
        return [np.array(posed[name].matrix) for name in bones]

    return np.array(at_frames(scene, frames, look)).reshape(-1, len(bones), 4, 4)


def watched(thing, bones, frames, slice_):
    """As `poses`, in slices, and in a scene of its own: that of the interface stays at its frame.

    What is evaluated there is the armature and what it depends on, without meshes that hang on it.
    """
    import bpy

    scene, seen = bpy.data.scenes.new("kinetograph"), []
    try:
        scene.collection.objects.link(thing)
        for frame in frames:
            scene.frame_set(int(np.floor(frame)), subframe=float(frame - np.floor(frame)))
            posed = thing.evaluated_get(scene.view_layers[0].depsgraph).pose.bones
            seen.append([np.array(posed[name].matrix) for name in bones])
            if slice_.over():
                yield
    finally:
        bpy.data.scenes.remove(scene)
    return np.array(seen).reshape(-1, len(bones), 4, 4)


def read(rig, scene, frames):
    """What an armature does at some frames: the root's place, (F, 3), and rotations, (F, J, 4), Y up."""
    matrices = poses(rig.thing, rig.bones, scene, frames)
    turned = _without_scale(matrices[..., :3, :3])
    world = axes.multiply(np.broadcast_to(rig.turn, turned.shape), turned)
    world = axes.multiply(world, np.broadcast_to(axes.inverse(rig.frames), world.shape))
    local = world.copy()
    for joint, parent in enumerate(rig.parents):
        if parent >= 0:
            local[:, joint] = axes.multiply(axes.inverse(world[:, parent]), world[:, joint])
    root = rig.to_world(matrices[:, 0, :3, 3])
    return axes.to_y_up(root), axes.turned_to_y_up(axes.unrolled(local))


def _without_scale(matrices):
    return axes.quaternions(matrices / np.maximum(np.linalg.norm(matrices, axis=-2, keepdims=True), 1e-12))


def described(rig, roles, scene, frames, folder, name):
    """A motion as kinetograph takes it, its arrays in a file of a folder."""
    translation, rotations = read(rig, scene, frames)
    path = os.path.join(folder, f"{name_of_file(name)}-{len(os.listdir(folder))}.npz")
    np.savez(path, translation=translation, rotations=rotations)
    fps = scene.render.fps / scene.render.fps_base
    return {"body": rig.body(roles), "fps": fps, "arrays": path, "name": name}


def name_of_file(name):
    """A name with letters and digits only."""
    return "".join(c if c.isascii() and c.isalnum() else "_" for c in name)[:40] or "motion"


def arrays(moving):
    """The root's places and the rotations of an answer, Y up. Raises Trouble."""
    try:
        with np.load(moving["arrays"]) as found:
            out = found["translation"], found["rotations"]
    except (OSError, ValueError, KeyError) as error:
        raise Trouble(f"kinetograph's result cannot be read: {error}") from None
    with contextlib.suppress(OSError):
        os.remove(moving["arrays"])
    return out


def targets(rig, names, translation, rotations):
    """Where a motion puts the bones of a rig, in the armature's space: quaternions (F, J, 4) and heads (F, J, 3).

    ``names`` are the joints of the motion, which are bones of the rig in any order.
    """
    order = [names.index(name) for name in rig.bones]
    local = axes.turned_to_z_up(np.asarray(rotations)[:, order])
    world, heads = np.empty_like(local), np.empty((*local.shape[:2], 3))
    for joint, parent in enumerate(rig.parents):
        if parent < 0:
            world[:, joint], heads[:, joint] = local[:, joint], axes.to_z_up(translation)
        else:
            world[:, joint] = axes.multiply(world[:, parent], local[:, joint])
            bone = rig.heads[joint] - rig.heads[parent]
            heads[:, joint] = heads[:, parent] + axes.rotate(world[:, parent], np.broadcast_to(bone, heads[:, 0].shape))
    turned = axes.multiply(world, np.broadcast_to(rig.frames, world.shape))
    turned = axes.multiply(np.broadcast_to(axes.inverse(rig.turn), turned.shape), turned)
    return axes.unrolled(turned), rig.to_armature(heads)


def played(thing):
    """The frames of the action that an armature plays. Raises Trouble."""
    data = thing.animation_data
    action = data.action if data is not None else None
    strips = [strip for track in data.nla_tracks for strip in track.strips] if data is not None else []
    if action is None and not strips:
        raise Trouble(f"{thing.name} has no action")
    first = min([s.frame_start for s in strips] + ([action.frame_range[0]] if action else []))
    last = max([s.frame_end for s in strips] + ([action.frame_range[1]] if action else []))
    return list(range(round(first), round(last) + 1))
