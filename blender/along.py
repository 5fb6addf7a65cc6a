# SPDX-License-Identifier: GPL-3.0-or-later
"""What is asked for along a curve: poses to pass through, moves by name, and motions that drive parts of the body."""

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from . import tasks
from .bodies import find_rig
from .curves import rate, unit
from .link import Trouble
from .motions import described, played, read

PARTS = ("arms", "left arm", "right arm", "head", "upper body")


def _is_armature(_, thing):
    return thing.type == "ARMATURE"


def _armature(description):
    return PointerProperty(name="Armature", type=bpy.types.Object, poll=_is_armature, description=description)


class KINETOGRAPH_PG_key(bpy.types.PropertyGroup):
    """A pose that is passed through"""

    name: StringProperty(name="Name", default="Key")
    armature: _armature("Whose pose it is; a pose of the library's take unless given")
    frame: IntProperty(name="Pose at Frame", description="The frame at which the armature has the pose")
    take: StringProperty(name="Take", description="A pose of the library in place of an armature's: NAME@SECOND")
    when: EnumProperty(
        name="Met",
        items=(("FRAME", "At Frame", "At a frame of the walk"), ("ALONG", "Along", "So many metres along the curve")),
    )
    at: IntProperty(name="At Frame", default=1)
    along: FloatProperty(name="Along", min=0.0, unit="LENGTH")
    window: FloatProperty(name="Window", min=0.0, description="Seconds before or after the frame that will do as well")
    here: BoolProperty(name="Where It Stands", description="At the place of the armature, off the curve if need be")


class KINETOGRAPH_PG_move(bpy.types.PropertyGroup):
    """A move that is asked for in a span"""

    name: StringProperty(
        name="Move", default="walk", description="Words of a take, a tag or a label; ! in front: not it"
    )
    first: IntProperty(name="From", default=1)
    last: IntProperty(name="To", default=48)
    cost: FloatProperty(name="Cost", min=0.0, description="What a second of anything else costs; 0: nothing else")


class KINETOGRAPH_PG_layer(bpy.types.PropertyGroup):
    """A motion that drives a part of the body"""

    name: EnumProperty(name="Part", items=[(part, part.title(), "") for part in PARTS])
    armature: _armature("Whose motion it is; that of the library's take unless given")
    take: StringProperty(name="Take", description="A take of the library in place of an armature's motion")
    at: IntProperty(name="From", default=1, description="The frame of the walk at which it begins")


KINDS = {"key": "keys", "move": "moves", "layer": "layers"}


def asks(scene):
    """Whether something is asked for."""
    return any(len(getattr(scene.kinetograph, rows)) for rows in KINDS.values())


def document(scene, path, settings):
    """The request for a path, rows of seconds and metres, and the motions that it names; a task."""
    start, fps, motions, asked = scene.frame_start, rate(scene), [], {"path": path, **settings}
    asked["fill"] = {"PLACES": None, "ALL": True, "NONE": False}[scene.kinetograph.fill]
    asked["keys"] = []
    for number, row in enumerate(in_order(scene.kinetograph.keys, path, scene), 1):
        asked["keys"].append((yield from _key(row, f"key {number}", scene, motions)))
    asked["moves"] = [_move(row, start, fps) for row in scene.kinetograph.moves]
    asked["layers"] = []
    for number, row in enumerate(scene.kinetograph.layers, 1):
        asked["layers"].append((yield from _layer(row, f"layer {number}", scene, motions)))
    return asked, motions


def in_order(keys, path, scene):
    """Keys by the seconds at which they are met; those that are along a path by when it gets there."""
    points = np.array(path)
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points[:, 1:], axis=0), axis=1))])

    def second(row):
        if row.when == "ALONG":
            return float(np.interp(row.along * unit(scene), lengths, points[:, 0]))
        return (row.at - scene.frame_start) / rate(scene)

    return sorted(keys, key=second)


def _key(row, label, scene, motions):
    """A key, whose pose is taken from an armature into the motions; a task."""
    asked, fps = {"name": row.name or label}, rate(scene)
    if row.armature is not None:
        rig, roles = yield from find_rig(row.armature, unit(scene))
        motions.append(described(rig, roles, scene, [row.frame], tasks.folder(), label))
        asked["pose"] = f"{label}@0"
        if row.here:
            root = read(rig, scene, [row.frame])[0][0]
            asked["position"] = [float(root[0]), float(root[2])]
    elif row.take:
        asked["pose"] = f"take:{row.take.removeprefix('take:')}"
    else:
        raise Trouble(f"{asked['name']} has no pose: choose an armature, or write NAME@SECOND of a take")
    if row.when == "ALONG":
        return {**asked, "along": row.along * unit(scene)}
    at = (row.at - scene.frame_start) / fps
    return {**asked, "time": at if not row.window else [max(at - row.window, 0.0), at + row.window]}


def _move(row, start, fps):
    if not row.name.strip("! "):
        raise Trouble("a move has no name: write words of a take, a tag or a label")
    name = row.name.lstrip("! ")
    what = {"like": name.removeprefix("like:")} if name.startswith("like:") else {"name": name}
    asked = {"start": (row.first - start) / fps, "stop": (row.last - start) / fps, **what}
    return {**asked, "forbid": row.name.startswith("!"), **({"weight": row.cost} if row.cost else {})}


def _layer(row, label, scene, motions):
    """A layer, whose motion is an armature's; a task."""
    asked = {"parts": [row.name], "start": (row.at - scene.frame_start) / rate(scene)}
    if row.armature is not None:
        rig, roles = yield from find_rig(row.armature, unit(scene))
        motions.append(described(rig, roles, scene, played(row.armature), tasks.folder(), label))
        return {**asked, "motion": label}
    if not row.take:
        raise Trouble(f"the layer of {row.name} has no motion: choose an armature, or a take")
    return {**asked, "motion": f"take:{row.take.removeprefix('take:')}"}


# ---- the panel ----


class Rows:
    """What operators of rows have in common."""

    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012
    kind: EnumProperty(items=[(kind, kind.title(), "") for kind in KINDS])


class KINETOGRAPH_OT_row_add(Rows, bpy.types.Operator):
    """Ask for one more"""

    bl_idname, bl_label = "kinetograph.row_add", "Add"

    def execute(self, context):
        scene, settings, active = context.scene, context.scene.kinetograph, context.object
        row = getattr(settings, KINDS[self.kind]).add()
        posed = active is not None and active.type == "ARMATURE"
        if self.kind == "move":
            row.first, row.last = scene.frame_current, scene.frame_current + round(2 * rate(scene))
        else:
            row.at = scene.frame_current
            if posed and active != settings.armature:
                row.armature = active
        if self.kind == "key":
            row.name, row.frame = f"Key {len(settings.keys)}", scene.frame_current
        setattr(settings, f"{self.kind}_index", len(getattr(settings, KINDS[self.kind])) - 1)
        return {"FINISHED"}


class KINETOGRAPH_OT_row_remove(Rows, bpy.types.Operator):
    """Ask for it no more"""

    bl_idname, bl_label = "kinetograph.row_remove", "Remove"

    def execute(self, context):
        settings = context.scene.kinetograph
        index = getattr(settings, f"{self.kind}_index")
        getattr(settings, KINDS[self.kind]).remove(index)
        setattr(settings, f"{self.kind}_index", max(index - 1, 0))
        return {"FINISHED"}


class KINETOGRAPH_UL_rows(bpy.types.UIList):
    """Keys, moves or layers in the panel"""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        row = layout.row(align=True)
        row.prop(item, "name", text="", emboss=False)
        if isinstance(item, KINETOGRAPH_PG_move):
            row.prop(item, "first")
            row.prop(item, "last")
        elif isinstance(item, KINETOGRAPH_PG_key) and item.when == "ALONG":
            row.prop(item, "along")
        else:
            row.prop(item, "at")


class KINETOGRAPH_PT_along(bpy.types.Panel):
    """What else is asked of a walk along a curve"""

    bl_label = "Keys, Moves, Layers"
    bl_space_type, bl_region_type, bl_category = "VIEW_3D", "UI", "Kinetograph"
    bl_parent_id = "KINETOGRAPH_PT_walk"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    def draw(self, context):
        settings, fields = context.scene.kinetograph, {}
        fields["key"] = ("armature", "frame", "take", "when", "window", "here")
        fields["move"] = ("cost",)
        fields["layer"] = ("armature", "take")
        for kind, rows in KINDS.items():
            self._rows(settings, kind, rows, fields[kind])
        self.layout.prop(settings, "fill")

    def _rows(self, settings, kind, rows, fields):
        self.layout.label(text=rows.title())
        row, index = self.layout.row(), f"{kind}_index"
        row.template_list("KINETOGRAPH_UL_rows", kind, settings, rows, settings, index, rows=2)
        column = row.column(align=True)
        column.operator("kinetograph.row_add", text="", icon="ADD").kind = kind
        column.operator("kinetograph.row_remove", text="", icon="REMOVE").kind = kind
        listed = getattr(settings, rows)
        if getattr(settings, index) < len(listed):
            chosen = listed[getattr(settings, index)]
            for field in fields:
                if not (field == "take" and chosen.armature) and not (field == "frame" and not chosen.armature):
                    self.layout.prop(chosen, field)


ROWS = (KINETOGRAPH_PG_key, KINETOGRAPH_PG_move, KINETOGRAPH_PG_layer)
CLASSES = (KINETOGRAPH_OT_row_add, KINETOGRAPH_OT_row_remove, KINETOGRAPH_UL_rows, KINETOGRAPH_PT_along)
