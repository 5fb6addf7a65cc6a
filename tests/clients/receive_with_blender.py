"""Run by Blender's Python: VMC4B, in a folder that is given, takes datagrams over a socket and poses an armature."""

import base64
import importlib
import json
import socket
import sys
import time
from pathlib import Path

import bpy
from mathutils import Vector

receiver, todo, done = Path(sys.argv[1]).resolve(), Path(sys.argv[2]), Path(sys.argv[3])
work = json.loads(todo.read_text())
sys.path.insert(0, str(receiver.parent))
core = importlib.import_module(f"{receiver.name}.core")
config = importlib.import_module(f"{receiver.name}.core.config")
state = importlib.import_module(f"{receiver.name}.core.state")
applier = importlib.import_module(f"{receiver.name}.core.applier")


def to_blender(place):
    """Y up and facing +Z becomes Z up and facing -Y."""
    return Vector((place[0], -place[2], place[1]))


def from_blender(place):
    return [place[0], place[2], -place[1]]


data = bpy.data.armatures.new("body")
armature = bpy.data.objects.new("body", data)
bpy.context.scene.collection.objects.link(armature)
bpy.context.view_layer.objects.active = armature
bpy.ops.object.mode_set(mode="EDIT")
for name, parent, place in zip(work["bones"], work["parents"], work["rest"], strict=True):
    bone = data.edit_bones.new(name)
    bone.head = to_blender(place)
    bone.tail = bone.head + Vector((0.0, 0.03, 0.07))  # any direction will do
    if parent >= 0:
        bone.parent = data.edit_bones[work["bones"][parent]]
bpy.ops.object.mode_set(mode="OBJECT")
for bone in armature.pose.bones:
    bone.rotation_mode = "QUATERNION"
armature.rotation_mode = "QUATERNION"

bpy.types.Scene.vmc4b_target_armature = bpy.props.StringProperty()
config.register()
bpy.context.scene.vmc4b_target_armature = "body"
for name in work["bones"]:
    setattr(bpy.context.scene, f"vmc4b_bones_{name}", name)
state.config = config.Config()
posing = applier.Applier()
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
    probe.bind(("127.0.0.1", 0))
    port = probe.getsockname()[1]
state.server.start("127.0.0.1", port)
for _ in range(100):
    if state.server.server is not None:
        break
    time.sleep(0.05)
places = []
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
    for frame in work["frames"]:
        for datagram in frame:
            sender.sendto(base64.b64decode(datagram), ("127.0.0.1", port))
        applied = False
        began = time.monotonic()
        while not applied and time.monotonic() - began < 10:
            while state.server.queue:
                item = state.server.queue.popleft()
                posing.update(item["address"], item["args"])
                applied |= item["address"] == "/VMC/Ext/Blend/Apply"
            time.sleep(0.002)
        bpy.context.view_layer.update()
        places.append([from_blender(armature.matrix_world @ armature.pose.bones[n].head) for n in work["bones"]])
done.write_text(json.dumps(places))
state.server.stop()
