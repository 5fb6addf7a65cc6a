# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel in the sidebar of the 3D view."""

import bpy


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
        layout.prop(settings, "keep_time")
        layout.operator("kinetograph.walk", icon="CURVE_PATH")


CLASSES = (KINETOGRAPH_PT_recordings, KINETOGRAPH_PT_walk)
