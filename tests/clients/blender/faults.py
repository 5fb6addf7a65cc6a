"""Installed, enabled and removed; and what goes wrong is said in one line, with the scene as it was."""

import os
import signal
import stat
import sys
import threading
import time

import bpy
from common import FOLDER, WALKS, ZIP, bezier, emptied, error_of, finish, installed, row

MODULE = "bl_ext.user_default.kinetograph"


def state():
    """All that a failed call might have changed."""
    kinds = ("objects", "armatures", "actions", "curves", "meshes", "collections")
    names = {kind: sorted(thing.name for thing in getattr(bpy.data, kind)) for kind in kinds}
    chosen = sorted(thing.name for thing in bpy.context.selected_objects)
    scene = bpy.context.scene
    active = bpy.context.view_layer.objects.active
    playing = [
        (t.name, t.animation_data.action.name) for t in bpy.data.objects if t.animation_data and t.animation_data.action
    ]
    return names, chosen, active and active.name, scene.frame_current, scene.frame_end, playing


def preferences():
    return bpy.context.preferences.addons[MODULE].preferences


def fails(what, words, call, **given):
    """A call that fails in one line which has some words, and changes nothing."""
    before = state()
    said = error_of(call, **given)
    good = all(word in said for word in words) and "\n" not in said and state() == before and "Traceback" not in said
    row(what, good, said.removeprefix("Error: ") or "it did not fail")


def program(name, text):
    """A program that stands in for kinetograph."""
    path = FOLDER / name
    path.write_text(f"#!{sys.executable}\n{text}")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


def with_command(command):
    preferences().command = command


def walk(**given):
    return bpy.ops.kinetograph.walk(**{"curve": "path", "library": WALKS, **given})


HELLO = """
import json, sys
for line in sys.stdin:
    asked = json.loads(line)
    if asked["method"] == "hello":
        print(json.dumps({"id": asked["id"], "result": {"protocol": 1, "version": "0", "methods": []}}), flush=True)
    else:
        ENDS
"""

installed()
import addon_utils

row("installed by Blender's package call", MODULE in bpy.context.preferences.addons.keys(), ZIP.name)
emptied()
bezier("path", [(0, 0), (0, 4)])

path = os.environ["PATH"]
os.environ["PATH"] = "/nowhere"
fails("no kinetograph", ["not installed", "Install"], walk)
os.environ["PATH"] = path
with_command("/nowhere/kinetograph")
fails("a path that is not there", ["/nowhere/kinetograph"], walk)
with_command(program("old", "import sys\nsys.stderr.write(\"Error: No such command 'serve'.\\n\")\nsys.exit(2)\n"))
fails("an old kinetograph", ["older kinetograph", "pip install -U"], walk)
with_command(program("other", "print('hello')\n"))
fails("another program", ["did not answer as kinetograph does"], walk)
with_command(program("crash", HELLO.replace("ENDS", "sys.exit(3)")))
fails("a crash in mid-call", ["ended unexpectedly", "status 3"], walk)
with_command(program("rubbish", HELLO.replace("ENDS", "print('{rubbish', flush=True); sys.exit(0)")))
fails("rubbish in place of an answer", ["ended unexpectedly"], walk)
with_command("")

tasks = __import__(f"{MODULE}.tasks", fromlist=["tasks"])
tasks.close()


def kill():
    """End kinetograph once it works on something."""
    while tasks._held["link"] is None or not tasks._held["link"].version or not tasks._held["link"]._open:
        time.sleep(0.002)
    os.kill(tasks._held["link"]._process.pid, signal.SIGKILL)


threading.Thread(target=kill, daemon=True).start()
fails("killed in mid-call", ["killed by signal 9"], walk)
row("and the next call works", error_of(walk) == "", "it starts kinetograph again")

emptied()
bezier("path", [(0, 0), (0, 4)])
before = state()
operators = __import__(f"{MODULE}.operators", fromlist=["operators"])


class Asked(operators.KINETOGRAPH_OT_walk.__mro__[1]):
    """The operator's settings, as a task of its own, which a timer would drive."""

    curve, library, armature, speed, by_radius, keep_time, mirror = "path", WALKS, "", 1.2, False, True, False
    hips = "NEAR"
    along = False
    task, _made = operators.KINETOGRAPH_OT_walk.task, operators.KINETOGRAPH_OT_walk._made


runner = tasks.Runner(Asked().task(bpy.context))
started = time.monotonic()
runner.cancel()
seconds = time.monotonic() - started
row("cancelled in mid-call", state() == before and seconds < 1.5, f"after {seconds:.2f} s, the scene as it was")
row("and the next call works", error_of(walk) == "", "kinetograph goes on, or is started again")

emptied()
bezier("path", [(0, 0), (0, 4)])
bpy.ops.ed.undo_push(message="before")
names = state()[0]
bpy.ops.kinetograph.walk("EXEC_DEFAULT", True, curve="path", library=WALKS)
made = state()[0]
bpy.ops.ed.undo()
row("one undo takes all of it back", made != names and state()[0] == names, "objects, armature and action")
emptied()
bezier("path", [(0, 0), (0, 4)])
fails("a library that is not there", ["not a library"], walk, library=str(FOLDER / "none"))
fails("a folder of recordings", ["not a library"], walk, library=str(FOLDER))
bezier("dot", [(0, 0)])
fails("a curve of one point", ["one point", "two or more"], walk, curve="dot")
bpy.data.objects.new("empty curve", bpy.data.curves.new("none", "CURVE"))
fails("a curve of no point", ["no points"], walk, curve="empty curve")
bezier("short", [(0, 0), (0.01, 0)])
fails("a curve that goes nowhere", ["goes nowhere"], walk, curve="short")
bpy.context.collection.objects.link(bpy.data.objects.new("still", None))
fails("an empty that stands still", ["does not move"], walk, curve="still")
fails("an armature that is a curve", ["expected an armature"], walk, armature="path")
bpy.context.collection.objects.link(bpy.data.objects.new("bare", bpy.data.armatures.new("bare")))
fails("an armature without bones", ["no bones"], walk, armature="bare")

data = bpy.data.armatures.new("stick")
stick = bpy.data.objects.new("stick", data)
bpy.context.collection.objects.link(stick)
bpy.context.view_layer.objects.active = stick
bpy.ops.object.mode_set(mode="EDIT")
for number in range(3):
    bone = data.edit_bones.new(f"b{number}")
    bone.head, bone.tail = (0, 0, number), (0, 0, number + 1)
bpy.ops.object.mode_set(mode="OBJECT")
fails("a rig without a skeleton's legs", ["no bone plays the", "hips"], walk, armature="stick")

blend = str(FOLDER / "rig.blend")
walk()
leader = bpy.context.object.name
fails("a library without partners", ["follower"], bpy.ops.kinetograph.follow, leader=leader, library=WALKS)
bpy.context.view_layer.objects.active = bpy.data.objects[leader]
bpy.context.object.name = "linked one"
bpy.data.libraries.write(blend, {bpy.context.object})
emptied()
bezier("path", [(0, 0), (0, 4)])
with bpy.data.libraries.load(blend, link=True) as (_, into):
    into.objects = ["linked one"]
bpy.context.collection.objects.link(into.objects[0])
fails("a linked armature", ["linked", "override"], walk, armature="linked one")

emptied()
bezier('Weg über 腕 "quoted"', [(0, 0), (1, 4)])
said = error_of(walk, curve='Weg über 腕 "quoted"')
rig = bpy.context.object
row("unicode names", said == "" and rig.type == "ARMATURE", rig.name)
for bone in rig.data.bones:
    bone.name = f'{bone.name} "Knöchel" 腕'
roles = {}
said = error_of(bpy.ops.kinetograph.walk, curve='Weg über 腕 "quoted"', library=WALKS, armature=rig.name)
row("unicode bones", said == "", said or rig.data.bones[0].name)

bpy.ops.preferences.addon_disable(module=MODULE)
bpy.ops.preferences.addon_enable(module=MODULE)
repo = next(i for i, r in enumerate(bpy.context.preferences.extensions.repos) if r.module == "user_default")
bpy.ops.extensions.package_uninstall(repo_index=repo, pkg_id="kinetograph")
left = list(dir(bpy.ops.kinetograph)) if hasattr(bpy.types, "KINETOGRAPH_OT_walk") else []
gone = MODULE not in bpy.context.preferences.addons.keys() and not hasattr(bpy.types.Scene, "kinetograph") and not left
row("disabled, enabled, removed", gone and not addon_utils.check(MODULE)[1], "nothing of it is left")
finish()
