"""Opens motion files in Blender and writes where it puts their joints.

Run with a Python that has bpy: python read_with_blender.py REFERENCE.json OUT.json
The reference says of each file what rate it should have and at what seconds to look: {file: {fps, times}}. The answer
has per file fps, duration, meshes (vertices of each) and positions {bone: [[x, y, z], ...]} of the heads of bones in
metres, Y up; names are "armature/bone" where a file has several armatures.
"""

import json
import sys

import bpy
import numpy as np


def main() -> None:
    with open(sys.argv[1]) as file:
        reference = json.load(file)
    seen = {name: look(name, entry) for name, entry in reference.items()}
    with open(sys.argv[2], "w") as file:
        json.dump(seen, file)


def look(name: str, entry: dict) -> dict:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    suffix = name.rpartition(".")[2].lower()
    if suffix == "bvh":
        # the defaults leave the scene at 24 frames a second and its end at 250
        bpy.ops.import_anim.bvh(filepath=name, update_scene_fps=True, update_scene_duration=True)
    elif suffix in ("glb", "gltf"):
        # seconds become frames of the scene's rate on import, so that it must be set before
        scene.render.fps = round(entry["fps"])
        bpy.ops.import_scene.gltf(filepath=name)
    elif suffix == "fbx":
        bpy.ops.import_scene.fbx(filepath=name)
        # it sets a rate of 119.88 and then places keys as if it were 120; the times below are those of its keys
        scene.render.fps_base = 1.0
    else:
        # time codes become frames as they are, and the scene's rate is left alone
        scene.render.fps = round(entry["fps"])
        scene.render.fps_base = round(entry["fps"]) / entry["fps"]
        bpy.ops.wm.usd_import(filepath=name)
    return measure(scene, entry["times"])


def measure(scene, times: list) -> dict:
    armatures = [thing for thing in bpy.data.objects if thing.type == "ARMATURE"]
    ranges = [action.frame_range for action in bpy.data.actions]
    start = min((r[0] for r in ranges), default=scene.frame_start)
    stop = max((r[1] for r in ranges), default=scene.frame_end)
    fps = scene.render.fps / scene.render.fps_base
    positions = {}
    scene.frame_set(int(stop) + 7)  # a frame that is set already is not evaluated again
    for time in times:
        at = start + time * fps
        scene.frame_set(int(np.floor(at + 1e-6)), subframe=max(0.0, float(at - np.floor(at + 1e-6))))
        for armature in armatures:
            for bone in armature.pose.bones:
                x, y, z = armature.matrix_world @ bone.head
                key = f"{armature.name}/{bone.name}" if len(armatures) > 1 else bone.name
                positions.setdefault(key, []).append([x, z, -y])
    meshes = [len(thing.data.vertices) for thing in bpy.data.objects if thing.type == "MESH"]
    return {"fps": fps, "duration": (stop - start) / fps, "meshes": meshes, "positions": positions}


main()
