# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel shows and a file keeps."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from .along import ROWS, KINETOGRAPH_PG_key, KINETOGRAPH_PG_layer, KINETOGRAPH_PG_move

HIPS = (
    ("FREE", "As Recorded", "Steps are those of the recordings, and the hips are some centimetres off the curve"),
    ("NEAR", "Near the Curve", "The hips sway about the curve as those of people do, by 2 cm"),
    ("ON", "On the Curve", "The hips are on the curve at every frame, without sway"),
)
"""How near hips are to the curve that they are walked along."""

FILLS = (
    ("PLACES", "At Places", "For keys along the curve, where the walk waits meanwhile; not with Keep Times"),
    ("ALL", "For All Keys", "Also for keys at frames, in their time, away from the curve for a while"),
    ("NONE", "Never", "The nearest step is edited instead"),
)
"""For which keys recordings play."""

SWAYS = {"FREE": None, "NEAR": 0.12, "ON": 0.0}
"""Seconds over which the hips sway."""


def _is_armature(_, thing):
    return thing.type == "ARMATURE"


class KINETOGRAPH_PG_settings(bpy.types.PropertyGroup):
    """Settings of a scene."""

    library: StringProperty(name="Library", subtype="DIR_PATH", description="A library of recordings")
    without: StringProperty(name="Leave Out", description="Takes or tags that are not used, with spaces between")
    armature: PointerProperty(
        name="My Rig", type=bpy.types.Object, poll=_is_armature, description="Who moves; a new armature unless given"
    )
    curve: PointerProperty(name="Curve", type=bpy.types.Object, description="A curve, or an object that moves")
    leader: PointerProperty(name="Leader", type=bpy.types.Object, poll=_is_armature)
    speed: FloatProperty(name="Speed", default=1.2, min=0.05, max=12.0, description="Metres per second")
    by_radius: BoolProperty(name="Speed by Radius", description="The radius of the curve's points multiplies the speed")
    keep_time: BoolProperty(name="Keep Times", default=True, description="Even where it is faster than the recordings")
    hips: EnumProperty(name="Hips", items=HIPS, default="NEAR", description="How near the hips are to the curve")
    keys: CollectionProperty(type=KINETOGRAPH_PG_key)
    moves: CollectionProperty(type=KINETOGRAPH_PG_move)
    layers: CollectionProperty(type=KINETOGRAPH_PG_layer)
    key_index: IntProperty()
    move_index: IntProperty()
    layer_index: IntProperty()
    fill: EnumProperty(
        name="Recordings of Keys",
        items=FILLS,
        default="PLACES",
        description="Whether the recording of a key plays where no step is like it; otherwise the nearest is edited",
    )
    mirror: BoolProperty(name="Mirror", description="Use recordings mirrored as well")
    on_fk: BoolProperty(
        name="Rigify on FK",
        description="Switch arms and legs to FK, where joints may be rotated about their own length as well",
    )
    alternatives: IntProperty(name="Alternatives", default=1, min=1, max=8)
    layered: BoolProperty(name="Into NLA Tracks", description="Above the action, in place of into it")
    moving: BoolProperty(name="Keep Speeds", description="Pass through the keys as fast as the action does")
    force: BoolProperty(name="Force", description="Make motion that is worse than the recordings, with a warning")
    lock_start: IntProperty(name="Lock From", description="A span of an earlier result that stays; 0 and 0 for none")
    lock_end: IntProperty(name="Lock To")
    readings: StringProperty(name="Readings", subtype="FILE_PATH", description="A file of body-worn sensors' readings")
    layout: StringProperty(name="Layout", default="wii", description="wii, phone, imu, ideal, or a .toml file")
    sources: StringProperty(
        name="From",
        default="slimevr://",
        description="phone, sensorserver://HOST, slimevr://, mvn://, mocopi://, or replay:FILE; with spaces between",
    )
    calls: StringProperty(
        name="Names", description="What the layout calls devices' sensors: right_wrist=NAME, with spaces between"
    )
    keep_live: BoolProperty(name="Keep", default=True, description="What was received becomes an action at the end")
    words: StringProperty(name="Search", description="Words of a take's name, its tags or its labels")


CLASSES = (*ROWS, KINETOGRAPH_PG_settings)
