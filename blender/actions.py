# SPDX-License-Identifier: GPL-3.0-or-later
"""Actions: curves of values over frames, in the layers and slots of Blender 4.4 and later, or as before them."""

import bpy
import numpy as np

from . import axes

_ROTATIONS = {"QUATERNION": "rotation_quaternion", "AXIS_ANGLE": "rotation_axis_angle"}


class Curves:
    """The F-curves of an action for one object, found or made."""

    def __init__(self, action, thing):
        self.action = action
        self._thing = thing
        self._bag = _bag(action, thing) if hasattr(action, "layers") else action

    def all(self):
        """Every curve that there is."""
        return list(self._bag.fcurves)

    def at(self, path, index, group=""):
        """The curve of a property, made where there is none."""
        found = self._bag.fcurves.find(path, index=index)
        if found is not None:
            return found
        if self._bag is self.action:
            return self.action.fcurves.new(path, index=index, action_group=group)
        try:
            return self._bag.fcurves.new(path, index=index, group_name=group)
        except TypeError:  # before 5.0 a channel bag knew no groups by name
            return self._bag.fcurves.new(path, index=index)

    def value(self, path, index, frame, still):
        """The value of a property at a frame, or what it is where it has no curve."""
        found = self._bag.fcurves.find(path, index=index)
        return still if found is None or not found.keyframe_points else found.evaluate(frame)

    def write(self, path, frames, values, group="", span=None):
        """Values (F, K) at frames, in place of what there is within a span of frames, or at all."""
        still = np.ravel(self._thing.path_resolve(path)).astype(float)
        for index in range(values.shape[1]):
            curve = self.at(path, index, group)
            if span is None:
                fill(curve, frames, values[:, index])
            else:
                splice(curve, frames, values[:, index], span, still[index])


class Posed:
    """Takes values as `Curves` does, and gives the first of them to the pose itself; nothing is keyed."""

    def __init__(self, rig):
        self._rig = rig

    def write(self, path, frames, values, group="", span=None):
        """Give a property of a bone its value; a bone's own settings have theirs."""
        if not path.endswith("]"):
            owner, _, name = path.rpartition(".")
            setattr(self._rig.thing.path_resolve(owner), name, values[0] if values.shape[1] > 1 else values[0, 0])


def _bag(action, thing):
    """The channel bag of an action's slot for an object."""
    slot = next((s for s in action.slots if s.target_id_type == "OBJECT" and _fits(s, thing)), None)
    if slot is None:
        slot = action.slots.new(id_type="OBJECT", name=thing.name)
    layer = action.layers[0] if action.layers else action.layers.new("Layer")
    strip = layer.strips[0] if layer.strips else layer.strips.new(type="KEYFRAME")
    return strip.channelbag(slot, ensure=True)


def _fits(slot, thing):
    data = thing.animation_data
    if data is not None and data.action_slot is not None and data.action_slot == slot:
        return True
    return slot.name_display == thing.name


def assign(thing, action):
    """Let an object play an action."""
    data = thing.animation_data or thing.animation_data_create()
    data.action = action
    if hasattr(action, "slots") and action.slots and data.action_slot is None:
        fitting = next((s for s in action.slots if _fits(s, thing)), action.slots[0])
        data.action_slot = fitting


def fill(curve, frames, values):
    """Let a curve have these keys only, joined by straight lines."""
    points = curve.keyframe_points
    points.clear()
    points.add(len(frames))
    _set(points, np.asarray(frames, dtype=float), np.asarray(values, dtype=float), range(len(frames)))
    curve.update()


def _set(points, frames, values, indices):
    if len(indices) == len(points):
        points.foreach_set("co", np.stack([frames, values], axis=1).ravel())
        points.foreach_set("interpolation", np.full(len(points), 1, dtype=np.int32))  # LINEAR
        return
    for i, frame, value in zip(indices, frames, values, strict=True):
        points[i].co = (frame, value)
        points[i].interpolation = "LINEAR"


def splice(curve, frames, values, span, still):
    """Put keys in place of those within a span of frames; what a curve is before and after stays as it was.

    A curve that goes on smoothly before or after the span is cut at its borders, exactly. ``still`` is the value of a
    property that was not animated.
    """
    low, high = span
    held = {"interpolation": "CONSTANT", "kind": "FREE"}
    rows = _rows(curve) or [
        {"co": (f, still), "left": (f - 0.3, still), "right": (f + 0.3, still), **held} for f in (low - 1.0, high + 1.0)
    ]
    before = [row for row in _cut(rows, low) if row["co"][0] < low - 1e-6]
    after = [row for row in _cut(rows, high) if row["co"][0] > high + 1e-6]
    first, last = _border(rows, low), _border(rows, high)
    inner = [
        {
            "co": (float(f), float(v)),
            "left": (f - 0.3, v),
            "right": (f + 0.3, v),
            "interpolation": "LINEAR",
            "kind": "VECTOR",
        }
        for f, v in zip(frames, values, strict=True)
    ]
    # at the borders values are those that were there: poses are the same, and rotations must not come back negated
    value, end = first["co"][1], last["co"][1]
    inner[0] |= {"co": (low, value), "left": first["left"], "right": (low + 0.3, value), "kind": "FREE"}
    inner[-1] |= {"co": (high, end), "left": (high - 0.3, end), "right": last["right"], "kind": "FREE"}
    inner[-1]["interpolation"] = last["interpolation"]
    _put(curve, [*before, *inner, *after])


def _rows(curve):
    return [
        {
            "co": tuple(point.co),
            "left": tuple(point.handle_left),
            "right": tuple(point.handle_right),
            "interpolation": point.interpolation,
            "kind": "FREE",
        }
        for point in curve.keyframe_points
    ]


def _border(rows, frame):
    """The key at a frame, with the handles that a curve has there."""
    return next(row for row in _cut(rows, frame) if abs(row["co"][0] - frame) < 1e-6)


def _cut(rows, frame):
    """The keys with one more at a frame, where there is none, so that the curve stays as it was."""
    if any(abs(row["co"][0] - frame) < 1e-6 for row in rows):
        return rows
    later = next((i for i, row in enumerate(rows) if row["co"][0] > frame), len(rows))
    if later in (0, len(rows)):
        value = rows[0 if later == 0 else -1]["co"][1]
        new = {"left": (frame - 1, value), "right": (frame + 1, value), "interpolation": "CONSTANT", "kind": "FREE"}
        new["co"] = (float(frame), value)
        return [new, *rows] if later == 0 else [*rows, new]
    one, other = rows[later - 1], rows[later]
    return [*rows[: later - 1], *_halves(one, other, frame), *rows[later + 1 :]]


def _halves(one, other, frame):
    """A span of a curve cut in two: by de Casteljau where it is a Bezier's."""
    if one["interpolation"] != "BEZIER":
        share = (frame - one["co"][0]) / (other["co"][0] - one["co"][0])
        held = one["interpolation"] == "CONSTANT"
        value = one["co"][1] if held else one["co"][1] + share * (other["co"][1] - one["co"][1])
        middle = {"co": (float(frame), value), "left": (frame - 0.3, value), "right": (frame + 0.3, value)}
        return [one, {**middle, "interpolation": one["interpolation"], "kind": "FREE"}, other]
    p = np.array([one["co"], one["right"], other["left"], other["co"]], dtype=float)
    length = p[3, 0] - p[0, 0]
    for handle, at in ((1, 0), (2, 3)):  # Blender shortens handles that reach beyond the span
        reach = abs(p[handle, 0] - p[at, 0])
        if reach > length:
            p[handle] = p[at] + (p[handle] - p[at]) * length / reach
    low, high = 0.0, 1.0
    for _ in range(60):
        t = 0.5 * (low + high)
        x = ((1 - t) ** 3) * p[0, 0] + 3 * t * (1 - t) ** 2 * p[1, 0] + 3 * t * t * (1 - t) * p[2, 0] + t**3 * p[3, 0]
        low, high = (t, high) if x < frame else (low, t)
    a, b, c = (p[i] + t * (p[i + 1] - p[i]) for i in range(3))
    d, e = a + t * (b - a), b + t * (c - b)
    middle = {
        "co": tuple(d + t * (e - d)),
        "left": tuple(d),
        "right": tuple(e),
        "interpolation": "BEZIER",
        "kind": "FREE",
    }
    middle["co"] = (float(frame), middle["co"][1])
    return [{**one, "right": tuple(a)}, middle, {**other, "left": tuple(c)}]


def _put(curve, rows):
    points = curve.keyframe_points
    points.clear()
    points.add(len(rows))
    for point, row in zip(points, rows, strict=True):
        point.co = row["co"]
        point.interpolation = row["interpolation"]
        point.handle_left_type = point.handle_right_type = row["kind"]
        if row["kind"] == "FREE":
            point.handle_left, point.handle_right = row["left"], row["right"]
    curve.update()


def rotations_as(mode, quaternions, start):
    """Rotations over time as a bone's mode wants them: the property's name, and values (F, 4) or (F, 3).

    ``start`` are the values that the first ones are to be near, of all that mean the same rotation.
    """
    from mathutils import Euler, Quaternion

    if mode == "QUATERNION":
        values = axes.unrolled(quaternions)
        return "rotation_quaternion", values if values[0] @ start >= 0 else -values
    each = [Quaternion(q) for q in quaternions]
    if mode == "AXIS_ANGLE":
        pairs = [q.to_axis_angle() for q in each]
        return "rotation_axis_angle", np.array([[angle, *axis] for axis, angle in pairs])
    rows, before = [], Euler(start, mode)
    for q in each:
        before = q.to_euler(mode, before)
        rows.append(before[:])
    return "rotation_euler", np.array(rows)


def write_bone(curves, thing, name, frames, quaternions, places=None, span=None):
    """Key a pose bone: its rotations (F, 4) and, where given, its places (F, 3), both of its own basis."""
    bone = thing.pose.bones[name]
    base = f'pose.bones["{bpy.utils.escape_identifier(name)}"].'
    path = _ROTATIONS.get(bone.rotation_mode, "rotation_euler")
    start = np.array(getattr(bone, path)[:], dtype=float)
    if span is not None:
        start = np.array([curves.value(base + path, index, span[0], value) for index, value in enumerate(start)])
    path, values = rotations_as(bone.rotation_mode, quaternions, start)
    curves.write(base + path, frames, values, name, span)
    if places is not None:
        if not bone.bone.use_local_location:
            places = places @ _own_axes(bone.bone).T
        curves.write(base + "location", frames, places, name, span)


def _own_axes(bone):
    """The axes of a bone at rest, seen from its parent or from the armature."""
    rest = np.array(bone.matrix_local)[:3, :3]
    return rest if bone.parent is None else np.linalg.inv(np.array(bone.parent.matrix_local)[:3, :3]) @ rest


def mark(action, frames, names):
    """Pose markers of an action."""
    for frame, name in zip(frames, names, strict=True):
        marker = action.pose_markers.new(name)
        marker.frame = round(frame)


def provenance(action, made, start, fps, version, library):
    """Say in an action where its motion comes from, and mark its seams."""
    sources = made.get("sources", [])
    action["kinetograph_version"] = version
    action["kinetograph_library"] = library
    action["kinetograph_sources"] = [
        f"{s['start']:.3f}-{s['stop']:.3f} s: {s['take']} {s['source_start']:.3f}-{s['source_stop']:.3f} s"
        + (", mirrored" if s["mirrored"] else "")
        for s in sources
    ]
    action["kinetograph_result"] = made.get("result", "")
    mark(action, [start + s["start"] * fps for s in sources[1:]], [s["take"] for s in sources[1:]])
