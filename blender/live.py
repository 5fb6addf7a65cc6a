# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors that are worn now move an armature; what was received becomes an action at the end."""

import os
import time

import bpy
import numpy as np
from bpy.props import BoolProperty, FloatProperty, StringProperty

from . import axes, tasks
from .actions import assign
from .apply import Put, Shower, new_armature, put, rest
from .curves import rate
from .link import Trouble
from .operators import Asking, Target, facts, recordings, shown

_VALUES = ("location", "rotation_quaternion", "rotation_euler", "rotation_axis_angle", "scale")
_OWN = ("IK_FK", "pole_vector")  # settings of Rigify's bones that showing a pose changes


class Pose:
    """How an armature stands, and what it plays, so that it can be put back."""

    def __init__(self, thing):
        data = thing.animation_data
        self._playing = data and (data.action, getattr(data, "action_slot", None), data.use_nla)
        self._values = {bone.name: [np.array(getattr(bone, name)) for name in _VALUES] for bone in thing.pose.bones}
        self._own = {b.name: {name: b[name] for name in _OWN if name in b} for b in thing.pose.bones}
        if data is not None:
            assign(thing, None)
            data.use_nla = False
        rest(thing)

    def put_back(self, thing):
        """Let the armature stand as it did, and play what it played."""
        for name, values in self._values.items():
            bone = thing.pose.bones.get(name)
            if bone is not None:
                for each, value in zip(_VALUES, values, strict=True):
                    setattr(bone, each, value)
                for each, value in self._own[name].items():
                    bone[each] = value
        if self._playing:
            action, slot, thing.animation_data.use_nla = self._playing
            thing.animation_data.action = action
            if slot is not None:
                thing.animation_data.action_slot = slot


class Shown:
    """The armature that shows poses: a new one, or that of a target."""

    def __init__(self, context, target, body):
        self._target, self.body, self._pose = target, body, None
        self.second = self._shower = None
        if target.thing is None:
            self.rig = new_armature(context, body, "Live", target.unit)
        else:
            self.rig, self._pose = target.rig, Pose(target.thing)
        self.name = self.rig.thing.name

    def show(self, pose, scene):
        """Pose it as an event says. Raises Trouble."""
        self.found()
        worn = pose.get("worn")
        own = worn is not None or self._target.thing is None
        names = list(self.rig.bones) if own else self.body["names"]
        worn = worn or pose
        self._shower = self._shower or Shower(self.rig, scene)
        self._shower.show(names, np.array([worn["root"]]), np.array([worn["rotations"]]))
        self.second = pose["second"]

    def found(self):
        """Look for the armature, which undo may have replaced. Raises Trouble where it is gone."""
        thing = bpy.data.objects.get(self.name)
        if thing is None:
            raise Trouble(f"{self.name} is gone; start again")
        self.rig.thing = thing
        if self._target.thing is not None:
            self._target.thing = thing

    def put_back(self):
        """Leave the scene as it was."""
        thing = bpy.data.objects.get(self.name)
        if thing is None:
            return
        if self._pose is not None:
            self._pose.put_back(thing)
        else:
            data = thing.data
            bpy.data.objects.remove(thing)
            bpy.data.armatures.remove(data)

    def keep(self, context, made, how, origin):
        """A motion on it, as an action; in slices."""
        if self._target.thing is None:
            return (yield from put(self.rig, None, made, list(self.rig.bones), how, context.scene, origin))
        self._pose.put_back(self.rig.thing)
        return (yield from self._target.put(context, made, how, origin))[1]


class Listening:
    """A session of sensors: a timer, or a loop, calls `pump` until it is over."""

    def __init__(self, context, target, asked, keep):
        self.target, self.keep, self.poses = target, keep, []
        self.began = self.message = self.shown = None
        self._asked, self._start = asked, context.scene.frame_current
        self._newest, self._next = None, 0.0
        self._keeping, self._failure = False, ""
        self._runner = tasks.Runner(_heard(target, asked))
        tasks.keep_live(self)

    @property
    def kept(self):
        """Whether what was received has become an action."""
        return self._keeping and self.message == self._runner.message

    @property
    def writing(self):
        """Whether keys are being written, in slices."""
        return self.message is None and self._runner.writing

    @property
    def state(self):
        """How far it is, in lines."""
        if self.began is None:
            return [f"getting ready, {round(100 * self._runner.progress)} %"]
        heard = f"{self.poses[-1][0]:.1f} s, {len(self.poses)} poses" if self.poses else "nothing is heard yet"
        said = self._runner.said.replace("say --sensor ", "under Names, write ")
        return [heard, said] if said else [heard]

    def pump(self, context):
        """Take what has arrived and show the newest pose; whether it is over. Raises Trouble."""
        if self.message is not None:
            return True
        try:
            done = self._runner.step()
            self._take(context)
        except Trouble as error:
            self._fail(context, error)
            return self.message is not None
        if done and self._keeping:
            self._end(self._runner.message)
        elif done:
            self._finish(context)
        return self.message is not None

    def stop(self, context):
        """Listen no more. Raises Trouble where nothing was heard."""
        if self.message is None and not self._keeping:
            self._runner.cancel()
            try:
                self._take(context)
                self._finish(context)
            except Trouble as error:
                self._end(str(error), back=True)
                raise

    def forget(self):
        """Give it up where the scene has gone."""
        self._runner.cancel()
        self._end("given up")

    def _fail(self, context, error):
        """Keep what there is, where that is asked for, and say what went wrong. Raises Trouble otherwise."""
        if self._keeping or not (self.keep and self.poses):
            self._end(str(error), back=True)
            raise error
        self._failure = f"{error}; "
        self._finish(context)

    def _finish(self, context):
        """After the last pose. Raises Trouble."""
        if not self.poses or not self.keep:
            self._end(f"{self._failure}{len(self.poses)} poses were shown", back=True)
            if not self.poses:
                raise Trouble(f"nothing was heard from {', '.join(self._asked['sources'])}")
            return
        tasks.keep_live(None)
        self._keeping = True
        try:
            self._runner = tasks.Runner(self._kept(context))
        except Trouble as error:
            self._end(str(error), back=True)
            raise
        tasks.keep_live(self)
        if self._runner.done:
            self._end(self._runner.message)

    def _end(self, message, back=False):
        self.message = message
        tasks.keep_live(None)
        if back and self.shown is not None:
            self.shown.put_back()

    def _take(self, context):
        """Take in events, of which the newest pose is shown."""
        for event in self._runner.events():
            if "body" in event:
                self.shown, self.began = Shown(context, self.target, event["body"]), time.monotonic()
            else:
                turned = np.array(event["rotations"], dtype=np.float32)
                self.poses.append((event["second"], np.array(event["root"]), turned))
                self._newest = event
        now = time.monotonic()
        if self._newest is not None and now >= self._next:
            newest, self._newest = self._newest, None
            self.shown.show(newest, context.scene)
            self._next = 2.0 * time.monotonic() - now  # half of the time, at least, is the interface's

    def _kept(self, context):
        """A task that makes an action of what was received."""
        scene, sources = context.scene, ", ".join(self._asked["sources"])
        motion, frames = received(self.poses, self.shown.body, rate(scene))
        how, made = Put(f"Live from {sources}"[:60], self._start), {"motion": motion}
        if self.target.thing is not None:
            made = yield "retarget", {"motion": motion, **self.target.asked(), "folder": tasks.folder()}
        origin = facts(self._asked["recordings"])
        self.shown.found()
        with tasks.at_once():
            action = yield from self.shown.keep(context, made, how, origin)
            action["kinetograph_sources"] = [f"0.000-{self.poses[-1][0]:.3f} s: live from {sources}"]
            shown(scene, self._start, frames)
        return f"{self._failure}{self.shown.name} moves as was received, {frames} frames"


def _heard(target, asked):
    """A task that goes on until it is cancelled, or a replay ends."""
    yield from target.prepared()
    yield "live", {**asked, **target.asked()}
    return "no more readings"


def received(poses, body, fps):
    """Poses at a rate, as kinetograph is given a motion; and how many frames it has."""
    times = np.array([pose[0] for pose in poses])
    at = np.arange(int((times[-1] - times[0]) * fps + 1e-6) + 1) / fps + times[0]
    root, turned = sampled(times, np.array([pose[1] for pose in poses]), np.array([pose[2] for pose in poses]), at)
    path = os.path.join(tasks.folder(), f"live-{len(os.listdir(tasks.folder()))}.npz")
    np.savez(path, translation=root, rotations=turned)
    return {"body": body, "fps": fps, "arrays": path, "name": "live"}, len(at)


def sampled(times, root, turned, at):
    """Places (N, 3) and rotations (N, J, 4) at other times, between the nearest before and after."""
    later = np.clip(np.searchsorted(times, at), 1, max(len(times) - 1, 1))
    later = np.minimum(later, len(times) - 1)
    before = np.maximum(later - 1, 0)
    span = np.maximum(times[later] - times[before], 1e-9)
    share = np.clip((at - times[before]) / span, 0.0, 1.0)
    turned = axes.unrolled(np.asarray(turned, dtype=float))
    mixed = turned[before] + share[:, None, None] * (turned[later] - turned[before])
    mixed /= np.linalg.norm(mixed, axis=-1, keepdims=True)
    return root[before] + share[:, None] * (root[later] - root[before]), mixed


def named_by(text):
    """``NAME=HEARD`` words as a table from what is heard to the name. Raises Trouble."""
    table = {}
    for word in text.replace(",", " ").split():
        name, _, heard = word.partition("=")
        if not name or not heard:
            raise Trouble(f"names of sensors are written as right_wrist=NAME; found {word!r}")
        table[heard] = name
    return table


class KINETOGRAPH_OT_live(Asking, bpy.types.Operator):
    """Let sensors that are worn now move the rig, or a new armature"""

    bl_idname = "kinetograph.live"
    bl_label = "Start"

    sources: StringProperty(name="From", description="Where readings come from, with spaces between")
    library: StringProperty(name="Library", subtype="DIR_PATH")
    armature: StringProperty(name="Armature", description="The armature that moves; a new one unless given")
    layout: StringProperty(name="Layout", default="wii", description="wii, phone, imu, ideal, or a .toml file")
    names: StringProperty(name="Names", description="What the layout calls devices' sensors: right_wrist=NAME")
    keep: BoolProperty(name="Keep", default=True, description="What was received becomes an action at the end")
    seconds: FloatProperty(name="Seconds", min=0.0, description="Stop after so long; 0 for the end of a replay")

    def filled_in(self, context):
        super().filled_in(context)
        settings = context.scene.kinetograph
        self.sources, self.names = self.sources or settings.sources, self.names or settings.calls
        self.layout, self.keep = settings.layout, settings.keep_live

    def session(self, context):
        """Begin to listen. Raises Trouble."""
        scene, sources = context.scene, split(self.sources)
        asked = {"recordings": recordings(self.library, scene), "sources": sources, "layout": self.layout}
        asked |= {"names": named_by(self.names), "fps": min(rate(scene), 240.0)}
        return Listening(context, Target(self.armature, scene), asked, self.keep)

    def execute(self, context):
        """Listen, and wait for the end."""
        try:
            if not self.seconds and not all(source.startswith("replay:") for source in split(self.sources)):
                raise Trouble("say for how many seconds; only replays end by themselves")
            listening = self.session(context)
            while not listening.pump(context):
                if self.seconds and listening.began and time.monotonic() - listening.began > self.seconds:
                    listening.stop(context)
                time.sleep(0.005)
        except Trouble as error:
            return self._failed(error)
        self.report({"INFO"}, listening.message)
        return {"FINISHED"}

    def invoke(self, context, event):
        """Listen while the interface goes on."""
        if bpy.app.background:
            return self.execute(context)
        self.filled_in(context)
        try:
            self._session = self.session(context)
        except Trouble as error:
            return self._failed(error)
        self._timer = context.window_manager.event_timer_add(1.0 / 60.0, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """Show what has come; the panel's Stop ends it."""
        if event.type != "TIMER":
            return {"RUNNING_MODAL"} if self._session.writing else {"PASS_THROUGH"}
        try:
            over = self._session.pump(context)
        except Trouble as error:
            self._over(context, {"CANCELLED"})
            return self._failed(error)
        if over:
            if self._session.message:
                self.report({"INFO"}, self._session.message)
            return self._over(context, {"FINISHED"} if self._session.kept else {"CANCELLED"})
        context.workspace.status_text_set(f"Kinetograph: {self._session.state[0]}")
        return {"PASS_THROUGH"}

    def cancel(self, context):
        """Called by Blender where the file or the window goes."""
        self._session.forget()


class KINETOGRAPH_OT_live_stop(bpy.types.Operator):
    """Listen to the sensors no more"""

    bl_idname = "kinetograph.live_stop"
    bl_label = "Stop"

    def execute(self, context):
        session = tasks.live()
        if session is None:
            return {"CANCELLED"}
        try:
            session.stop(context)
        except Trouble as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


def split(text):
    """Sources that have spaces between; a replayed file's name may have spaces as well. Raises Trouble."""
    sources = [text.strip()] if text.strip().startswith("replay:") else text.split()
    if not sources:
        raise Trouble("say where readings come from, as slimevr:// or replay:FILE")
    return [f"replay:{os.path.abspath(bpy.path.abspath(s[7:]))}" if s.startswith("replay:") else s for s in sources]


CLASSES = (KINETOGRAPH_OT_live, KINETOGRAPH_OT_live_stop)
