# SPDX-License-Identifier: GPL-3.0-or-later
"""Kinetograph in Blender: new human motion out of recordings, on curves, poses, partners and your own rig."""

import bpy
from bpy.props import CollectionProperty, IntProperty, PointerProperty, StringProperty

from . import along, live, operators, panels, preferences, recordings, settings, tasks

_ROOMS = (settings, preferences, operators, live, panels, along, recordings)
_CLASSES = tuple(each for room in _ROOMS for each in room.CLASSES)


def register():
    """Called by Blender."""
    for each in _CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.kinetograph = PointerProperty(type=settings.KINETOGRAPH_PG_settings)
    manager = bpy.types.WindowManager  # what is listed is no part of the file
    manager.kinetograph_takes = CollectionProperty(type=recordings.KINETOGRAPH_PG_take)
    manager.kinetograph_roles = CollectionProperty(type=recordings.KINETOGRAPH_PG_role)
    manager.kinetograph_index = IntProperty()
    manager.kinetograph_shown = StringProperty()


def unregister():
    """Called by Blender."""
    tasks.close()
    tasks.keep_live(None)
    for name in ("kinetograph_takes", "kinetograph_roles", "kinetograph_index", "kinetograph_shown"):
        delattr(bpy.types.WindowManager, name)
    del bpy.types.Scene.kinetograph
    for each in reversed(_CLASSES):
        bpy.utils.unregister_class(each)
