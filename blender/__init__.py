# SPDX-License-Identifier: GPL-3.0-or-later
"""Kinetograph in Blender: new human motion out of recordings, on curves, poses, partners and your own rig."""

import bpy

from . import operators, panels, preferences, settings, tasks

_CLASSES = (*settings.CLASSES, *preferences.CLASSES, *operators.CLASSES, *panels.CLASSES)


def register():
    """Called by Blender."""
    for each in _CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.kinetograph = bpy.props.PointerProperty(type=settings.KINETOGRAPH_PG_settings)


def unregister():
    """Called by Blender."""
    tasks.close()
    del bpy.types.Scene.kinetograph
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
