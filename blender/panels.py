# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel in the sidebar of the 3D view."""

import bpy

from . import tasks


class Panel:
    """Where all panels are."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Kinetograph"


class KINETOGRAPH_PT_recordings(Panel, bpy.types.Panel):
    """The library, and who moves"""

    bl_label = "Recordings"

    def draw(self, context):
        settings, layout = context.scene.kinetograph, self.layout
        layout.prop(settings, "library")
        layout.prop(settings, "without")
        layout.prop(settings, "armature")
        layout.prop(settings, "mirror")
        layout.prop(settings, "on_fk")


class KINETOGRAPH_PT_walk(Panel, bpy.types.Panel):
    """A curve becomes a walk"""

    bl_label = "Walk"

    def draw(self, context):
        settings, layout = context.scene.kinetograph, self.layout
        layout.prop(settings, "curve")
        layout.prop(settings, "speed")
        layout.prop(settings, "by_radius")
        layout.prop(settings, "hips")
        layout.prop(settings, "keep_time")
        layout.operator("kinetograph.walk", icon="CURVE_PATH")


class KINETOGRAPH_PT_inbetween(Panel, bpy.types.Panel):
    """Poses become a motion"""

    bl_label = "In-between"

    def draw(self, context):
        settings, layout = context.scene.kinetograph, self.layout
        layout.label(text="Pose markers, or selected keyframes")
        layout.prop(settings, "alternatives")
        layout.prop(settings, "layered")
        layout.prop(settings, "moving")
        layout.prop(settings, "force")
        row = layout.row(align=True)
        row.prop(settings, "lock_start")
        row.prop(settings, "lock_end")
        layout.operator("kinetograph.inbetween", icon="POSE_HLT")


class KINETOGRAPH_PT_leader(Panel, bpy.types.Panel):
    """Another armature leads"""

    bl_label = "Leader"

    def draw(self, context):
        layout = self.layout
        layout.prop(context.scene.kinetograph, "leader")
        layout.operator("kinetograph.follow", icon="COMMUNITY")
        layout.operator("kinetograph.retarget", icon="ARMATURE_DATA")


class KINETOGRAPH_PT_sensors(Panel, bpy.types.Panel):
    """Readings become a motion"""

    bl_label = "Sensors"

    def draw(self, context):
        settings, layout = context.scene.kinetograph, self.layout
        layout.prop(settings, "readings")
        layout.prop(settings, "layout")
        layout.operator("kinetograph.sense", icon="TRACKING")
        box = layout.box()
        session = tasks.live()
        box.prop(settings, "sources")
        box.prop(settings, "calls")
        box.prop(settings, "keep_live")
        if session is None:
            box.operator("kinetograph.live", icon="REC")
            return
        box.operator("kinetograph.live_stop", icon="SNAP_FACE")
        for line in session.state:
            box.label(text=line)


CLASSES = (
    KINETOGRAPH_PT_recordings,
    KINETOGRAPH_PT_walk,
    KINETOGRAPH_PT_inbetween,
    KINETOGRAPH_PT_leader,
    KINETOGRAPH_PT_sensors,
)
