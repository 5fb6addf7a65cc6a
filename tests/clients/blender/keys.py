"""Poses at pose markers are filled in: keys met, nothing outside changed; alternatives in NLA tracks; a locked span."""

import bpy
import numpy as np
from common import SAMPLE, WALKS, bezier, curves_of, emptied, error_of, finish, installed, role, row

installed()


def walker(rotation_mode="QUATERNION"):
    """An armature that walks for a while, at 24 frames per second."""
    emptied(24)
    bpy.ops.kinetograph.walk(curve=bezier("path", [(0, 0), (0.4, 3), (2, 6)]).name, library=WALKS, speed=1.1)
    thing = bpy.context.object
    action = thing.animation_data.action
    while action.pose_markers:
        action.pose_markers.remove(action.pose_markers[0])
    return thing, action


def evaluated(thing, frames):
    """The matrices of all bones in the world, (F, J, 4, 4)."""
    out = []
    for frame in frames:
        bpy.context.scene.frame_set(int(np.floor(frame)), subframe=float(frame - np.floor(frame)))
        posed = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
        out.append([np.array(posed.matrix_world @ bone.matrix) for bone in posed.pose.bones])
    return np.array(out)


def marked(action, frames):
    for frame, name in frames.items():
        action.pose_markers.new(name).frame = frame


def smooth(thing, action, every=6):
    """Keep only every so many keys, joined by Bezier curves with automatic handles, as animators leave them."""
    for curve in curves_of(action, thing):
        for index in reversed(range(len(curve.keyframe_points))):
            if index % every:
                curve.keyframe_points.remove(curve.keyframe_points[index], fast=True)
        for point in curve.keyframe_points:
            point.interpolation = "BEZIER"
            point.handle_left_type = point.handle_right_type = "AUTO_CLAMPED"
        curve.update()


def in_place():
    thing, action = walker()
    smooth(thing, action)
    marked(action, {33: "start", 87: "end"})
    outside = np.concatenate([np.arange(1, 33, 0.25), np.arange(87.25, 120, 0.25)])
    before, keys = evaluated(thing, outside), evaluated(thing, [33, 87])
    inner = evaluated(thing, [60])
    bpy.ops.kinetograph.inbetween(armature=thing.name, library=WALKS, force=SAMPLE)
    apart = np.linalg.norm((evaluated(thing, [33, 87]) - keys)[..., :3, 3], axis=-1).max()
    changed = abs(evaluated(thing, outside) - before).max()
    moved = np.linalg.norm((evaluated(thing, [60]) - inner)[..., :3, 3], axis=-1).max()
    good = apart < 1e-3 and changed < 1e-4 and moved > 0.01
    row(
        "in place, frames 33 to 87",
        good,
        f"keys met to {1000 * apart:.4f} mm; outside changed by {1000 * changed:.4f} mm",
    )


def posed():
    """Two poses of an armature that has nothing else: a key each, all bones that are not keyed stay."""
    thing, _action = walker()
    poses = {}
    for frame in (20, 74):
        bpy.context.scene.frame_set(frame)
        poses[frame] = {b.name: (b.rotation_quaternion.copy(), b.location.copy()) for b in thing.pose.bones}
    thing.animation_data.action = bpy.data.actions.new("two poses")
    for frame, key in ((1, 20), (61, 74)):
        for bone in thing.pose.bones:
            bone.rotation_quaternion, bone.location = poses[key][bone.name]
            bone.keyframe_insert("rotation_quaternion", frame=frame)
            bone.keyframe_insert("location", frame=frame)
    keys = evaluated(thing, [1, 61])
    bpy.ops.kinetograph.inbetween(armature=thing.name, library=WALKS, force=SAMPLE)
    apart = np.linalg.norm((evaluated(thing, [1, 61]) - keys)[..., :3, 3], axis=-1).max()
    ankles = [thing.data.bones.keys().index(role(thing, f"{side}_foot")) for side in ("left", "right")]
    low = evaluated(thing, range(1, 62))[:, ankles, 2, 3].min(axis=1)
    row("two poses, 60 frames apart", apart < 1e-3 and abs(low).max() < 0.2, f"keys met to {1000 * apart:.4f} mm")


def in_tracks():
    thing, action = walker()
    marked(action, {25: "start", 60: "via ±0.3 free", 110: "end"})
    outside = np.concatenate([np.arange(1, 25), np.arange(111, 130)])
    before, keys = evaluated(thing, outside), evaluated(thing, [25, 110])
    bpy.ops.kinetograph.inbetween(armature=thing.name, library=WALKS, alternatives=3, force=SAMPLE)
    tracks = thing.animation_data.nla_tracks
    apart = np.linalg.norm((evaluated(thing, [25, 110]) - keys)[..., :3, 3], axis=-1).max()
    changed = abs(evaluated(thing, outside) - before).max()
    muted = [track.mute for track in tracks]
    good = (
        apart < 1e-3
        and changed < 1e-6
        and muted[:2] == [False, False]
        and all(muted[2:])
        and len(muted) >= (2 if SAMPLE else 3)
    )
    said = (
        f"keys met to {1000 * apart:.4f} mm, outside changed by {1000 * changed:.4f} mm; {len(muted) - 1} alternatives"
    )
    row("NLA tracks, a window in between", good, said)


def locked():
    thing, action = walker()
    marked(action, {33: "start", 117: "end"})
    bpy.ops.kinetograph.inbetween(armature=thing.name, library=WALKS, force=SAMPLE)
    held = evaluated(thing, range(60, 81))
    while len(action.pose_markers):
        action.pose_markers.remove(action.pose_markers[0])
    marked(action, {33: "start", 117: "end"})
    bpy.ops.kinetograph.inbetween(armature=thing.name, library=WALKS, lock_start=60, lock_end=80, force=SAMPLE)
    again = evaluated(thing, range(60, 81))
    apart = np.linalg.norm((again - held)[..., :3, 3], axis=-1).max()
    row("a span that is locked", apart < 1e-3, f"it moved by {1000 * apart:.2f} mm")


def refused():
    thing, action = walker()
    said = error_of(bpy.ops.kinetograph.inbetween, armature=thing.name, library=WALKS)
    row("too many keyframes", "select those of the poses" in said, said)
    marked(action, {33: "start", 87: "end ±0.5"})
    said = error_of(bpy.ops.kinetograph.inbetween, armature=thing.name, library=WALKS)
    row("a last key with a window, in place", "has a window of time" in said, said)


for each in (in_place, posed, in_tracks, locked, refused):
    each()
finish()
