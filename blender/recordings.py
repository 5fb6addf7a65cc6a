# SPDX-License-Identifier: GPL-3.0-or-later
"""The library's panel: takes are listed, searched by words and by example, dropped onto rigs, and added."""

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from . import tasks
from .apply import Put
from .bodies import ROLES, find_rig, store_roles, stored_roles
from .curves import rate, unit
from .link import Trouble
from .motions import described, played
from .operators import Asking, Target, facts, recordings, shown


class KINETOGRAPH_PG_take(bpy.types.PropertyGroup):
    """A take, or some seconds of one."""

    name: StringProperty()
    track: StringProperty()
    seconds: FloatProperty()
    start: FloatProperty()
    stop: FloatProperty()
    said: StringProperty()


class KINETOGRAPH_PG_role(bpy.types.PropertyGroup):
    """A role, and the bone that plays it."""

    def _changed(self, context):
        thing = context.object
        if thing is not None and thing.type == "ARMATURE" and not _filling:
            store_roles(thing, {row.name: row.bone for row in context.window_manager.kinetograph_roles})

    name: StringProperty()
    bone: StringProperty(name="Bone", update=_changed)


_filling = []


def list_takes(context, rows):
    """Show takes in the panel."""
    listed = context.window_manager.kinetograph_takes
    listed.clear()
    for row in rows:
        one = listed.add()
        for name, value in row.items():
            setattr(one, name, value)


class KINETOGRAPH_OT_look(Asking, bpy.types.Operator):
    """List the library's takes that have some words, or all"""

    bl_idname = "kinetograph.look"
    bl_label = "List"
    bl_options = {"REGISTER"}  # noqa: RUF012

    library: StringProperty(name="Library", subtype="DIR_PATH")
    words: StringProperty(name="Words")

    def filled_in(self, context):
        super().filled_in(context)
        self.words = self.words or context.scene.kinetograph.words

    def task(self, context):
        asked = recordings(self.library, context.scene)
        found = yield "look", {"library": asked["library"], "words": self.words}
        rows = [
            {
                "name": r["name"],
                "seconds": r["seconds"],
                "stop": r["seconds"],
                "said": ", ".join([*r["tags"], r["text"]]),
            }
            for r in found["rows"]
        ]
        list_takes(context, rows)
        return f"{len(rows)} of {found['count']} takes"


class KINETOGRAPH_OT_alike(Asking, bpy.types.Operator):
    """List what of the library is most like the motion of the selected armature"""

    bl_idname = "kinetograph.alike"
    bl_label = "Alike"
    bl_options = {"REGISTER"}  # noqa: RUF012

    library: StringProperty(name="Library", subtype="DIR_PATH")
    armature: StringProperty(name="Armature", description="The example; the active one unless given")

    def task(self, context):
        scene, asked = context.scene, recordings(self.library, context.scene)
        thing = tasks.named(self.armature or getattr(context.object, "name", ""), "armature")
        rig, roles = yield from find_rig(thing, unit(scene))
        example = described(rig, roles, scene, played(thing), tasks.folder(), thing.name)
        found = yield "alike", {"library": asked["library"], "example": example}
        rows = [
            {"name": r["take"], "track": r["track"], "start": r["start"], "stop": r["stop"]}
            | {"seconds": r["stop"] - r["start"], "said": f"{100 * r['distance']:.0f} cm away"}
            for r in found["rows"]
        ]
        list_takes(context, rows)
        return f"{len(rows)} parts of recordings"


class KINETOGRAPH_OT_drop(Asking, bpy.types.Operator):
    """Put a recording onto the rig, or onto a new armature, from the present frame on"""

    bl_idname = "kinetograph.drop"
    bl_label = "Drop"

    library: StringProperty(name="Library", subtype="DIR_PATH")
    take: StringProperty(name="Take")
    track: StringProperty(name="Track")
    armature: StringProperty(name="Armature", description="The armature that moves; a new one unless given")
    start: FloatProperty(name="From", description="Seconds of the take")
    stop: FloatProperty(name="To", description="Seconds of the take; 0 for its end")

    def filled_in(self, context):
        super().filled_in(context)
        takes, index = context.window_manager.kinetograph_takes, context.window_manager.kinetograph_index
        if not self.take and index < len(takes):
            row = takes[index]
            self.take, self.track, self.start, self.stop = row.name, row.track, row.start, row.stop

    def task(self, context):
        scene, asked = context.scene, recordings(self.library, context.scene)
        if not self.take:
            raise Trouble("choose a take of the list")
        target = Target(self.armature, scene)
        yield from target.prepared()
        part = {"start": self.start, **({"stop": self.stop} if self.stop > self.start else {})}
        params = {"library": asked["library"], "take": self.take, "track": self.track or None, "fps": rate(scene)}
        made = yield "drop", {**params, **part, **target.asked(), "folder": tasks.folder()}
        with tasks.at_once():
            rig, _ = yield from target.put(context, made, Put(self.take[:60], scene.frame_current), facts(asked))
            shown(scene, scene.frame_current, made["frames"])
        return f"{rig.thing.name} moves as in {self.take}"


class KINETOGRAPH_OT_add(Asking, bpy.types.Operator):
    """Add the actions of the selected armatures to the library, a take each"""

    bl_idname = "kinetograph.add"
    bl_label = "Add Selected"
    bl_options = {"REGISTER"}  # noqa: RUF012

    library: StringProperty(name="Library", subtype="DIR_PATH")
    replace: BoolProperty(name="Replace", description="Replace takes of the same names")

    def task(self, context):
        scene, asked = context.scene, recordings(self.library, context.scene)
        things = [thing for thing in context.selected_objects if thing.type == "ARMATURE"]
        if not things:
            raise Trouble("select an armature or more whose actions are to be added")
        motions = []
        for thing in things:
            frames = played(thing)
            rig, roles = yield from find_rig(thing, unit(scene))
            name = thing.animation_data.action.name if thing.animation_data.action else thing.name
            motions.append(described(rig, roles, scene, frames, tasks.folder(), name))
        source = f"Blender: {bpy.data.filepath or 'a new file'}"
        added = yield (
            "add",
            {"library": asked["library"], "motions": motions, "replace": self.replace, "source": source},
        )
        return f"added {', '.join(added['names'])}"


class KINETOGRAPH_OT_roles(Asking, bpy.types.Operator):
    """Find the bones that play each role, and keep them with the armature"""

    bl_idname = "kinetograph.roles"
    bl_label = "Find Roles"

    armature: StringProperty(name="Armature", description="The active one unless given")
    again: BoolProperty(name="Again", description="Forget those that were picked")

    def filled_in(self, context):
        self.armature = self.armature or getattr(context.object, "name", "")

    def task(self, context):
        target = Target(self.armature or getattr(context.object, "name", " "), context.scene)
        thing = target.thing
        if self.again and ROLES in thing.data:
            del thing.data[ROLES]
        _, roles = yield from find_rig(thing, target.unit)
        store_roles(thing, {**roles, **stored_roles(thing)})
        show_roles(context, thing)
        return f"{thing.name}: {len([bone for bone in roles.values() if bone])} roles"


_ALL = ("hips", "spine", "chest", "neck", "head")
_SIDED = ("collar", "shoulder", "elbow", "hand", "hip", "knee", "foot", "toe")


def show_roles(context, thing):
    """Fill in the table of the panel."""
    known, rows = stored_roles(thing), context.window_manager.kinetograph_roles
    _filling.append(True)
    rows.clear()
    for role in [*_ALL, *(f"{side}_{part}" for side in ("left", "right") for part in _SIDED)]:
        row = rows.add()
        row.name, row.bone = role, known.get(role, "")
    context.window_manager.kinetograph_shown = thing.name
    _filling.clear()


class KINETOGRAPH_UL_takes(bpy.types.UIList):
    """Takes in the panel"""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        row = layout.row()
        row.label(text=item.name)
        row.label(text=f"{item.seconds:.1f} s  {item.said}")


class KINETOGRAPH_PT_library(bpy.types.Panel):
    """What the library has"""

    bl_label = "Library"
    bl_space_type, bl_region_type, bl_category = "VIEW_3D", "UI", "Kinetograph"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    def draw(self, context):
        layout, manager = self.layout, context.window_manager
        layout.prop(context.scene.kinetograph, "words", icon="VIEWZOOM")
        row = layout.row(align=True)
        row.operator("kinetograph.look")
        row.operator("kinetograph.alike")
        layout.template_list("KINETOGRAPH_UL_takes", "", manager, "kinetograph_takes", manager, "kinetograph_index")
        row = layout.row(align=True)
        row.operator("kinetograph.drop")
        row.operator("kinetograph.add")


class KINETOGRAPH_PT_roles(bpy.types.Panel):
    """Which bone of the active armature plays which role"""

    bl_label = "Roles"
    bl_space_type, bl_region_type, bl_category = "VIEW_3D", "UI", "Kinetograph"
    bl_options = {"DEFAULT_CLOSED"}  # noqa: RUF012

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == "ARMATURE"

    def draw(self, context):
        layout, thing = self.layout, context.object
        layout.operator("kinetograph.roles")
        if context.window_manager.kinetograph_shown != thing.name:
            return
        for row in context.window_manager.kinetograph_roles:
            layout.prop_search(row, "bone", thing.data, "bones", text=row.name.replace("_", " "))


CLASSES = (
    KINETOGRAPH_PG_take,
    KINETOGRAPH_PG_role,
    KINETOGRAPH_OT_look,
    KINETOGRAPH_OT_alike,
    KINETOGRAPH_OT_drop,
    KINETOGRAPH_OT_add,
    KINETOGRAPH_OT_roles,
    KINETOGRAPH_UL_takes,
    KINETOGRAPH_PT_library,
    KINETOGRAPH_PT_roles,
)
