"""Sensors that move an armature live: a file of readings is replayed, and a timer's pump is called by hand."""

import signal
import time
from types import SimpleNamespace

import bpy
import numpy as np
from common import FOLDER, SAMPLE, WALKS, emptied, error_of, finish, installed, readings, role, row

MODULE = "bl_ext.user_default.kinetograph"
installed()
live = __import__(f"{MODULE}.live", fromlist=["live"])
tasks = __import__(f"{MODULE}.tasks", fromlist=["tasks"])
apply = __import__(f"{MODULE}.apply", fromlist=["apply"])
motions = __import__(f"{MODULE}.motions", fromlist=["motions"])
UNUSED = ("breast", "pelvis", "heel", "ear", "eye")
FILE = f"replay:{readings()}"


class Asked(live.KINETOGRAPH_OT_live.__mro__[1]):
    """The operator's settings, as a session of its own, which a timer would drive."""

    sources, library, armature, layout, names, keep = FILE, WALKS, "", "wii", "", True
    session = live.KINETOGRAPH_OT_live.session

    def __init__(self, **given):
        for name, value in given.items():
            setattr(self, name, value)


def driven(session, seconds=None, each=lambda: None):
    """Pump a session until its end, or stop it so many seconds after its first pose; the calls' processor time."""
    took = []
    while True:
        began, count = time.thread_time(), len(session.poses)
        over = session.pump(bpy.context)
        if len(session.poses) > count and session._newest is None:
            took.append(time.thread_time() - began)
        if over:
            return np.array(took)
        each()
        if seconds is not None and session.poses and session.poses[-1][0] > seconds:
            session.stop(bpy.context)
            seconds = None
        time.sleep(0.008)


def placed(thing, bone):
    """Where the head of a bone is in the world, as it is posed now."""
    bpy.context.view_layer.update()
    posed = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return np.array((posed.matrix_world @ posed.pose.bones[bone].head)[:])


def state():
    return sorted(thing.name for thing in bpy.data.objects), len(bpy.data.actions), len(bpy.data.armatures)


def new_armature():
    emptied(30)
    session = Asked().session(bpy.context)
    seen, keyed = [], []

    def look():
        if session.poses and not session._keeping:
            thing = bpy.context.object
            seen.append((session.shown.second - session.poses[0][0], placed(thing, role(thing, "hips"))))
            keyed.append(bool(thing.animation_data and thing.animation_data.action))

    took = driven(session, each=look)
    thing = bpy.context.object
    frames = [int(frame) for frame in thing.animation_data.action.frame_range]
    went = float(np.linalg.norm((seen[-1][1] - seen[0][1])[:2]))
    good = len(seen) > 10 and went > (0.2 if SAMPLE else 1.5) and not any(keyed)
    row("live on a new armature", good, f"{len(session.poses)} poses, {went:.1f} m walked, no key until the end")
    second, place = seen[len(seen) // 2]
    frame = frames[0] + 30 * second
    bpy.context.scene.frame_set(int(frame), subframe=frame % 1)
    apart = float(np.linalg.norm(placed(thing, role(thing, "hips")) - place))
    said = f"{frames[1] - frames[0] + 1} frames, hips {100 * apart:.2f} cm off what was shown"
    row("what was received is an action", apart < 0.01, said)
    said = f"a look takes {1000 * np.median(took):.0f} ms, the longest {1000 * took.max():.0f} ms"
    row("the interface goes on", np.median(took) < 0.03, said)
    row("its origin", "live from replay:" in thing.animation_data.action["kinetograph_sources"][0], session.message)


def by_the_timer():
    """The operator's own handling of events, in a window that is not there."""
    emptied(24)

    class Window(Asked):
        said = ()
        modal, cancel = live.KINETOGRAPH_OT_live.modal, live.KINETOGRAPH_OT_live.cancel

        def report(self, kind, text):
            self.said = (*self.said, text)

        def _over(self, context, how):
            return how

    class Context:
        workspace = SimpleNamespace(status_text_set=lambda text: None)

        def __getattr__(self, name):
            return getattr(bpy.context, name)

    window, context, timer = Window(), Context(), SimpleNamespace(type="TIMER")
    window._session = window.session(bpy.context)
    other = window.modal(context, SimpleNamespace(type="LEFTMOUSE"))
    went_on = set()
    while not window._session.poses:
        went_on |= window.modal(context, timer)
        time.sleep(0.01)
    bpy.ops.kinetograph.live_stop()
    last = {"PASS_THROUGH"}
    while last == {"PASS_THROUGH"}:  # what was received becomes keys in slices
        last = window.modal(context, timer)
    action = bpy.context.object.animation_data.action
    good = other == went_on == {"PASS_THROUGH"} and last == {"FINISHED"} and action is not None
    row("events pass through until Stop", good, window.said[-1])
    window._session = window.session(bpy.context)
    window.cancel(context)
    row("the file is closed meanwhile", tasks.live() is None, window._session.message)


def my_rig():
    emptied(24)
    bpy.ops.import_scene.gltf(filepath=str(FOLDER / "person.glb"))
    thing = next(t for t in bpy.data.objects if t.type == "ARMATURE")
    before = {bone.name: np.array(bone.matrix_basis) for bone in thing.pose.bones}
    action = thing.animation_data.action
    session = Asked(armature=thing.name, keep=False).session(bpy.context)
    driven(session, 1.5)
    same = max(np.abs(np.array(bone.matrix_basis) - before[bone.name]).max() for bone in thing.pose.bones)
    good = same < 1e-5 and thing.animation_data.action == action and len(session.poses) > 5
    row("shown only, and put back", good, f"{session.message}; the pose before is {same:.0e} off")
    session = Asked(armature=thing.name).session(bpy.context)
    names, seen = ("hips", "left_hand", "left_foot", "right_foot"), []

    def look():
        if session.poses and not session._keeping:
            seen.append(
                (
                    session.shown.second - session.poses[0][0],
                    [placed(thing, session.target.roles[name]) for name in names],
                )
            )

    driven(session, 1.5, look)
    first, apart = thing.animation_data.action.frame_range[0], []
    for second, places in seen[5:-5:4]:
        frame = first + 24 * second
        bpy.context.scene.frame_set(int(frame), subframe=frame % 1)
        apart.append(
            [float(np.linalg.norm(placed(thing, role(thing, name)) - p)) for name, p in zip(names, places, strict=True)]
        )
    most = 100 * np.max(apart, axis=0)
    said = ", ".join(f"{name.replace('_', ' ')} {cm:.1f} cm" for name, cm in zip(names, most, strict=True))
    good = thing.animation_data.action != action and most.max() < 10
    row("my rig, shown and kept", good, f"at most apart: {said}")


def rigify():
    emptied(24)
    bpy.ops.preferences.addon_enable(module="rigify")
    bpy.ops.object.armature_basic_human_metarig_add()
    meta = bpy.context.object
    bpy.ops.pose.rigify_generate()
    thing = next(each for each in bpy.data.objects if each.type == "ARMATURE" and each != meta)
    session = Asked(armature=thing.name, keep=False).session(bpy.context)
    apart, off, wanted = [], [], {}

    def remember(rig, *given):
        wanted["turned"], wanted["heads"] = targets(rig, *given)
        return wanted["turned"], wanted["heads"]

    targets, apply.targets = apply.targets, remember

    def look():
        if session.poses and wanted:
            bpy.context.view_layer.update()
            bones = motions.evaluated(thing).pose.bones
            heads = np.array([bones[name].head[:] for name in session.shown.rig.bones])
            used = [i for i, name in enumerate(session.shown.rig.bones) if not any(w in name for w in UNUSED)]
            off.append(np.linalg.norm(heads - wanted["heads"][0], axis=1)[used].max())
            feet = [placed(thing, session.target.roles[name]) for name in ("left_foot", "right_foot")]
            apart.append(float(np.linalg.norm(feet[0][:2] - feet[1][:2])))

    took = driven(session, 3.5, look)
    apply.targets = targets
    looks = f"{len(took)} looks took {1000 * np.median(took):.0f} ms, the longest {1000 * took.max():.0f}"
    said = f"feet up to {max(apart):.2f} m apart; {looks}"
    row("live on Rigify's controls", (SAMPLE or max(apart) > 0.4) and np.median(took) < 0.03, said)
    said = f"joints {100 * np.median(off):.1f} cm off what was received, at most {100 * max(off):.1f}"
    row("and where they should be", max(off) < 0.05, said)


def faults():
    emptied(24)
    before = state()
    for what, words, given in (
        ("no end in a script", "how many seconds", {"sources": "slimevr://"}),
        ("a file that is not there", "nowhere.csv", {"sources": "replay:/nowhere.csv"}),
        ("a source that is none", "expected a source", {"sources": "telepathy://", "seconds": 1.0}),
        ("nothing is heard", "nothing was heard", {"sources": "slimevr://:16969", "seconds": 0.5}),
        ("a name that is none", "right_wrist=NAME", {"sources": FILE, "names": "right_wrist"}),
    ):
        said = error_of(bpy.ops.kinetograph.live, library=WALKS, **given).removeprefix("Error: ")
        row(what, words in said and "\n" not in said and state() == before and tasks.live() is None, said)
    session = Asked().session(bpy.context)
    said = error_of(bpy.ops.kinetograph.look, library=WALKS)
    row("asked for more meanwhile", "stop them first" in said, said.removeprefix("Error: "))
    process = tasks.link()._process
    driven(
        session, each=lambda: len(session.poses) > 15 and process.poll() is None and process.send_signal(signal.SIGKILL)
    )
    kept = bpy.context.object.animation_data.action is not None
    row("killed while it listens", kept and "killed by signal 9" in session.message, session.message)
    session, said = Asked().session(bpy.context), ""

    def remove():
        if len(session.poses) > 5 and session.shown.name in bpy.data.objects:
            bpy.data.objects.remove(bpy.data.objects[session.shown.name])

    try:
        driven(session, each=remove)
    except live.Trouble as error:
        said = str(error)
    row("the armature is removed", "is gone" in said and tasks.live() is None, said)
    said = error_of(bpy.ops.kinetograph.live, sources=FILE, library=WALKS, seconds=1.0)
    row("and the next session works", said == "" and tasks.live() is None, said or "from a script, for 1 s")


new_armature()
by_the_timer()
if (FOLDER / "person.glb").is_file():
    my_rig()
rigify()
faults()
finish()
