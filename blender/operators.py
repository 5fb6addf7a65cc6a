# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person or a script may do: each operator is a task, which a timer or a loop drives."""

import os
import re

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from . import along, tasks
from .actions import Curves, mark
from .apply import Put, in_tracks, new_armature, put
from .bodies import find_rig, require_armature, require_writable, store_roles, stored_roles
from .controls import held_elsewhere
from .curves import path_of, rate, unit
from .link import Trouble
from .motions import described, played
from .settings import HIPS, SWAYS

_MOST_KEYS = 60


class Asking:
    """What all operators that ask kinetograph have in common."""

    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    def execute(self, context):
        """Do it, and wait."""
        try:
            self.report({"INFO"}, tasks.wait_for(self.task(context)))
        except Trouble as error:
            return self._failed(error)
        return {"FINISHED"}

    def invoke(self, context, event):
        """Do it while the interface goes on."""
        if bpy.app.background:
            return self.execute(context)
        self.filled_in(context)
        try:
            self._runner = tasks.Runner(self.task(context))
        except Trouble as error:
            return self._failed(error)
        self._timer = context.window_manager.event_timer_add(0.05, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """Look whether an answer has come; Esc gives it up."""
        if event.type == "ESC":
            self._runner.cancel()
            return self._over(context, {"CANCELLED"})
        if event.type != "TIMER":
            return {"RUNNING_MODAL"} if self._runner.writing else {"PASS_THROUGH"}
        try:
            done = self._runner.step()
        except Trouble as error:
            self._over(context, {"CANCELLED"})
            return self._failed(error)
        if done:
            self.report({"INFO"}, self._runner.message)
            return self._over(context, {"FINISHED"})
        share = "keys" if self._runner.writing else f"{round(100 * self._runner.progress)} %"
        context.workspace.status_text_set(f"Kinetograph: {self.bl_label}, {share} (Esc to cancel)")
        return {"RUNNING_MODAL"}

    def filled_in(self, context):
        """Take what is not given from the panel's settings and the selection."""
        settings = context.scene.kinetograph
        for name in ("library", "armature"):
            if hasattr(self, name) and not getattr(self, name):
                setattr(self, name, _setting(settings, name))

    def _over(self, context, how):
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)
        return how

    def _failed(self, error):
        self.report({"ERROR"}, " ".join(str(error).split()).replace("--force-timing", "Force"))
        return {"CANCELLED"}


def _setting(settings, name):
    value = getattr(settings, name, "")
    return value.name if hasattr(value, "name") else (value or "")


def recordings(library, scene, mirror=False):
    """The library that is named, or that of the scene. Raises Trouble."""
    path = library or scene.kinetograph.library
    if not path:
        raise Trouble("choose a library of recordings (kinetograph library create makes one)")
    without = [word for word in scene.kinetograph.without.replace(",", " ").split() if word]
    return {"library": os.path.abspath(bpy.path.abspath(path)), "mirror": mirror, "without": without}


def facts(asked):
    """What an action says of its origin: the version and the library."""
    return tasks.link().version, asked["library"]


class Target:
    """The armature that gets a result: one that there is, or a new one."""

    def __init__(self, name, scene):
        self.thing = tasks.named(name, "armature") if name else None
        self.unit = unit(scene)
        self.rig = self.roles = None
        if self.thing is not None:
            require_armature(self.thing)
            require_writable(self.thing)

    def prepared(self):
        """A task that finds out what it is made of."""
        if self.thing is not None:
            self.rig, self.roles = yield from find_rig(self.thing, self.unit)

    def asked(self):
        """What is asked for of a result."""
        if self.rig is None:
            return {}
        return {"body": {**self.rig.body(self.roles), "skin": self.rig.skin(self.roles, tasks.folder())}}

    def put(self, context, made, how, facts):
        """The result on it, in slices of one change of the scene."""
        rig, roles = self.rig, self.roles
        body = made["motion"]["body"]
        if rig is None:
            rig, roles = new_armature(context, body, how.name, self.unit), None
            names = list(rig.bones)
        else:
            names = body["names"]
            if not stored_roles(self.thing):
                store_roles(self.thing, roles)
            held = held_elsewhere(rig)
            made["warnings"] = [held] * bool(held) + list(made.get("warnings", []))
        return rig, (yield from put(rig, roles, made, names, how, context.scene, facts))


def shown(scene, start, frames):
    """Let the scene last as long as what was made."""
    scene.frame_end = max(scene.frame_end, int(start + frames - 1))


class KINETOGRAPH_OT_walk(Asking, bpy.types.Operator):
    """Walk along a curve, or where an object moves"""

    bl_idname = "kinetograph.walk"
    bl_label = "Walk Along Curve"

    curve: StringProperty(name="Curve", description="The curve, or the object that moves; the active one unless given")
    library: StringProperty(name="Library", subtype="DIR_PATH")
    armature: StringProperty(name="Armature", description="The armature that walks; a new one unless given")
    speed: FloatProperty(
        name="Speed", default=1.2, min=0.05, max=12.0, unit="VELOCITY", description="Metres per second"
    )
    by_radius: BoolProperty(name="Speed by Radius", description="The radius of the curve's points multiplies the speed")
    keep_time: BoolProperty(name="Keep Times", default=True, description="Even where it is faster than the recordings")
    hips: EnumProperty(name="Hips", items=HIPS, default="NEAR", description="How near the hips are to the curve")
    mirror: BoolProperty(name="Mirror", description="Use recordings mirrored as well")
    along: BoolProperty(
        name="Keys, Moves, Layers", description="Pass through the scene's keys, with its moves and layers"
    )

    def filled_in(self, context):
        super().filled_in(context)
        settings = context.scene.kinetograph
        self.speed, self.mirror, self.by_radius = settings.speed, settings.mirror, settings.by_radius
        self.keep_time, self.hips, self.along = settings.keep_time, settings.hips, along.asks(context.scene)
        if not self.curve and settings.curve is not None:
            self.curve = settings.curve.name

    def task(self, context):
        scene = context.scene
        thing = tasks.named(self.curve or getattr(context.object, "name", ""), "curve")
        target = Target(self.armature, scene)
        asked = recordings(self.library, scene, self.mirror)
        path = path_of(thing, scene, self.speed, self.by_radius)
        yield from target.prepared()
        made = yield from self._made(scene, asked, path, target)
        with tasks.at_once():
            how = Put(f"Walk along {thing.name}"[:60], scene.frame_start)
            rig, action = yield from target.put(context, made, how, facts(asked))
            met = [scene.frame_start + second * rate(scene) for second in made.get("met", [])]
            mark(action, met, [f"key {number}" for number in range(1, len(met) + 1)])
            shown(scene, scene.frame_start, made["frames"])
        return _said(f"{rig.thing.name} walks along {thing.name}", made)

    def _made(self, scene, asked, path, target):
        """A task that asks for the walk, and for what is asked for along it."""
        settings = {"keep_time": self.keep_time, "onto_path": SWAYS[self.hips]}
        params = {"recordings": asked, "fps": rate(scene), "folder": tasks.folder(), **target.asked()}
        if not self.along:
            return (yield "walk", {**params, "path": path, **settings})
        request, motions = yield from along.document(scene, path, settings)
        return (yield "render", {**params, "request": request, "motions": motions})


def _said(text, made):
    return "; ".join([text, *made.get("warnings", [])[:2]])


class KINETOGRAPH_OT_retarget(Asking, bpy.types.Operator):
    """Put the motion of an armature onto another"""

    bl_idname = "kinetograph.retarget"
    bl_label = "Retarget"

    source: StringProperty(name="Source", description="The armature that moves")
    target: StringProperty(name="Target", description="The armature that gets the motion")
    keep_place: BoolProperty(name="Keep Place", description="Do not scale the path on the ground with the legs")

    def filled_in(self, context):
        settings = context.scene.kinetograph
        self.source = self.source or _setting(settings, "leader")
        self.target = self.target or _setting(settings, "armature")

    def task(self, context):
        scene = context.scene
        source, target = tasks.named(self.source, "armature"), Target(self.target or " ", scene)
        if source == target.thing:
            raise Trouble("source and target are the same armature; choose two")
        rig, roles = yield from find_rig(source, unit(scene))
        yield from target.prepared()
        frames = played(source)
        motion = described(rig, roles, scene, frames, tasks.folder(), source.name)
        scale = {"scale": 1.0} if self.keep_place else {}
        made = yield "retarget", {"motion": motion, **target.asked(), **scale, "folder": tasks.folder()}
        with tasks.at_once():
            yield from target.put(
                context, made, Put(f"{source.name} on {target.thing.name}"[:60], frames[0]), facts({"library": ""})
            )
            shown(scene, frames[0], len(frames))
        return f"{target.thing.name} moves as {source.name}"


class KINETOGRAPH_OT_inbetween(Asking, bpy.types.Operator):
    """Fill in between poses: pose markers of the action, or selected keyframes"""

    bl_idname = "kinetograph.inbetween"
    bl_label = "In-between"

    armature: StringProperty(name="Armature", description="The active one unless given")
    library: StringProperty(name="Library", subtype="DIR_PATH")
    alternatives: IntProperty(
        name="Alternatives", default=1, min=1, max=8, description="More than one go into NLA tracks"
    )
    layered: BoolProperty(name="Into NLA Tracks", description="Above the action, in place of into it")
    moving: BoolProperty(name="Keep Speeds", description="Pass through the keys as fast as the action does")
    mirror: BoolProperty(name="Mirror", description="Use recordings mirrored as well")
    force: BoolProperty(name="Force", description="Make motion that is worse than the recordings, with a warning")
    lock_start: IntProperty(name="Lock From", description="A span of an earlier result that stays; 0 and 0 for none")
    lock_end: IntProperty(name="Lock To")

    def filled_in(self, context):
        active = context.object
        self.armature = self.armature or (active.name if active is not None else "")
        super().filled_in(context)
        settings = context.scene.kinetograph
        self.alternatives, self.mirror, self.moving = settings.alternatives, settings.mirror, settings.moving
        self.force = settings.force
        self.layered, self.lock_start, self.lock_end = settings.layered, settings.lock_start, settings.lock_end

    def task(self, context):
        scene = context.scene
        target = Target(self.armature or getattr(context.object, "name", " "), scene)
        thing = target.thing
        asked = recordings(self.library, scene, self.mirror)
        keys = keyed_poses(thing)
        layered = self.layered or self.alternatives > 1
        if not layered and not isinstance(keys[-1].time, float):
            raise Trouble(f"the last key, {keys[-1].name}, has a window of time: fill in NLA tracks, or make it exact")
        action, first, last = thing.animation_data.action, keys[0].frame, keys[-1].frame
        yield from target.prepared()
        motion = described(target.rig, target.roles, scene, range(first, last + 1), tasks.folder(), thing.name)
        params = {"recordings": asked, "motion": motion, "alternatives": self.alternatives, "fps": rate(scene)}
        params["force_timing"] = self.force
        params["keys"] = [key.asked(first, rate(scene), self.moving) for key in keys]
        params |= self._held(action, first, rate(scene))
        found = yield "inbetween", {**params, **target.asked(), "folder": tasks.folder()}
        with tasks.at_once():
            if layered:
                made = []
                for number, each in enumerate(found["made"], start=1):
                    how = Put(f"{thing.name} in between {number}"[:60], first, keep_pose=True)
                    rig_and_action = yield from target.put(context, each, how, facts(asked))
                    made.append(rig_and_action[1])
                in_tracks(thing, action, made, first)
            else:
                yield from target.put(
                    context, found["made"][0], Put(action.name, first, action, (first, last)), facts(asked)
                )
        return _said(f"{thing.name}: frames {first} to {last} are filled in", found["made"][0])

    def _held(self, action, first, fps):
        """The span of an earlier result that stays."""
        if self.lock_end <= self.lock_start:
            return {}
        named = action.get("kinetograph_result", "") if action is not None else ""
        span = {"start": (self.lock_start - first) / fps, "stop": (self.lock_end - first) / fps}
        return {"held": {"result": named, **span}}


class Key:
    """A pose that is to be met: its frame, and when, as its marker says."""

    def __init__(self, frame, name, start, fps):
        self.frame, self.name = frame, name
        at = (frame - start) / fps
        window = re.search(r"(?:±|\+-)\s*(\d+(?:\.\d+)?)", name)
        self.time = at if window is None else [max(at - float(window[1]), 0.0), at + float(window[1])]
        self.free = re.search(r"\bfree\b", name) is not None

    def asked(self, first, fps, moving):
        """What is asked of it."""
        there = {"placed": not self.free, "facing": not self.free, "moving": moving}
        return {"second": (self.frame - first) / fps, "time": self.time, "name": self.name, **there}


def keyed_poses(thing):
    """The poses that an armature is to go through: pose markers, or else selected keyframes. Raises Trouble."""
    data = thing.animation_data
    action = data.action if data is not None else None
    if action is None:
        raise Trouble(f"{thing.name} has no action: pose it at two frames or more, with a keyframe at each")
    named = {marker.frame: marker.name for marker in action.pose_markers}
    if len(named) < 2:
        points = [point for curve in Curves(action, thing).all() for point in curve.keyframe_points]
        chosen = {round(point.co[0]) for point in points if point.select_control_point}
        every = {round(point.co[0]) for point in points}
        named = {frame: f"frame {frame}" for frame in (chosen if len(chosen) > 1 else every)}
        if len(named) > _MOST_KEYS:
            raise Trouble(f"{len(named)} keyframes are chosen: select those of the poses, or add pose markers")
    if len(named) < 2:
        raise Trouble(f"{thing.name}: two keys or more are needed; add pose markers, or select keyframes of two frames")
    frames = sorted(named)
    scene = bpy.context.scene
    return [Key(frame, named[frame], frames[0], rate(scene)) for frame in frames]


class KINETOGRAPH_OT_follow(Asking, bpy.types.Operator):
    """Make a partner who follows an armature, hands held as in the recordings"""

    bl_idname = "kinetograph.follow"
    bl_label = "Follow Leader"

    leader: StringProperty(name="Leader", description="The armature that leads")
    library: StringProperty(name="Library", subtype="DIR_PATH", description="A library of takes of two people")
    armature: StringProperty(name="Armature", description="The armature that follows; a new one unless given")
    track: StringProperty(name="Track", default="follower", description="Of the library's takes, the one who follows")
    mirror: BoolProperty(name="Mirror", description="Use recordings mirrored as well")

    def filled_in(self, context):
        super().filled_in(context)
        self.leader = self.leader or _setting(context.scene.kinetograph, "leader")
        self.mirror = context.scene.kinetograph.mirror

    def task(self, context):
        scene = context.scene
        leader, target = tasks.named(self.leader, "armature"), Target(self.armature, scene)
        asked = recordings(self.library, scene, self.mirror)
        rig, roles = yield from find_rig(leader, unit(scene))
        frames = played(leader)
        yield from target.prepared()
        motion = described(rig, roles, scene, frames, tasks.folder(), leader.name)
        params = {"recordings": asked, "leader": motion, "target": self.track, "fps": rate(scene)}
        made = yield "follow", {**params, **target.asked(), "folder": tasks.folder()}
        with tasks.at_once():
            follower, _ = yield from target.put(
                context, made, Put(f"Follows {leader.name}"[:60], frames[0]), facts(asked)
            )
            shown(scene, frames[0], made["frames"])
        return _said(f"{follower.thing.name} follows {leader.name}", made)


class KINETOGRAPH_OT_sense(Asking, bpy.types.Operator):
    """Make a motion from a file of body-worn sensors' readings"""

    bl_idname = "kinetograph.sense"
    bl_label = "From Sensors"

    readings: StringProperty(name="Readings", subtype="FILE_PATH")
    library: StringProperty(name="Library", subtype="DIR_PATH")
    armature: StringProperty(name="Armature", description="The armature that moves; a new one unless given")
    layout: StringProperty(name="Layout", default="wii", description="wii, phone, imu, ideal, or a .toml file")

    def filled_in(self, context):
        super().filled_in(context)
        settings = context.scene.kinetograph
        self.readings, self.layout = self.readings or settings.readings, settings.layout

    def task(self, context):
        scene = context.scene
        target, asked = Target(self.armature, scene), recordings(self.library, scene)
        path = os.path.abspath(bpy.path.abspath(self.readings))
        if not os.path.isfile(path):
            raise Trouble(f"{self.readings or 'choose a file of readings'}: there is no such file")
        yield from target.prepared()
        params = {"recordings": asked, "readings": path, "layout": self.layout, "fps": rate(scene)}
        made = yield "sense", {**params, **target.asked(), "folder": tasks.folder()}
        with tasks.at_once():
            how = Put(os.path.basename(path)[:60], scene.frame_start)
            rig, _ = yield from target.put(context, made, how, facts(asked))
            shown(scene, scene.frame_start, made["frames"])
        return _said(f"{rig.thing.name} moves as the readings say", made)


CLASSES = (
    KINETOGRAPH_OT_walk,
    KINETOGRAPH_OT_retarget,
    KINETOGRAPH_OT_inbetween,
    KINETOGRAPH_OT_follow,
    KINETOGRAPH_OT_sense,
)
