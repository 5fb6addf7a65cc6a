"""What the checks of the Blender extension share: install it, make scenes, and print a row for each thing looked at."""

import os
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np

ZIP, FOLDER = Path(sys.argv[1]), Path(sys.argv[2])
WALKS = str(FOLDER / "walks")
SAMPLE = (FOLDER / "sample").exists()
"""Whether the walks are the few of the sample, of which less can be made."""
_failed = []


def row(what, good, said):
    """Print what was looked at, and remember whether it is as it should be."""
    print(f"Blender extension  {what:34} {'ok  ' if good else 'FAIL'} {said}", flush=True)
    if not good:
        _failed.append(what)


def finish():
    """Leave with the status that a check wants."""
    sys.stdout.flush()
    os._exit(1 if _failed else 0)  # Blender may take long to clear up


def installed():
    """An empty file, and the extension installed from its zip by Blender's own package call."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.extensions.package_install_files(filepath=str(ZIP), repo="user_default", enable_on_install=True)
    return bpy.context.scene


def emptied(fps=24, base=1.0):
    """Remove everything from the file, and set its rate."""
    for kind in ("objects", "armatures", "actions", "curves", "meshes"):
        for thing in list(getattr(bpy.data, kind)):
            getattr(bpy.data, kind).remove(thing)
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = fps, base
    scene.frame_start, scene.frame_end = 1, 250
    scene.unit_settings.scale_length = 1.0
    return scene


def curves_of(action, thing):
    """The F-curves of an action for an object, in layers or, before Blender 4.4, its own."""
    if not hasattr(action, "layers"):
        return action.fcurves
    from bpy_extras import anim_utils

    return anim_utils.action_get_channelbag_for_slot(action, thing.animation_data.action_slot).fcurves


def error_of(call, **given):
    """What an operator says when it fails; empty where it does not."""
    try:
        call(**given)
    except RuntimeError as error:
        return str(error).strip()
    return ""


def bezier(name, points, cyclic=False):
    """A smooth curve through points."""
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions, data.resolution_u = "3D", 64
    spline = data.splines.new("BEZIER")
    spline.bezier_points.add(len(points) - 1)
    spline.use_cyclic_u = cyclic
    for knot, (x, y) in zip(spline.bezier_points, points, strict=True):
        knot.co, knot.handle_left_type, knot.handle_right_type = (x, y, 0.0), "AUTO", "AUTO"
    thing = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(thing)
    bpy.context.view_layer.update()
    return thing


def seen(thing):
    """Where Blender itself draws a curve in the world, (N, 3)."""
    shown = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = shown.to_mesh()
    points = np.array([vertex.co[:] for vertex in mesh.vertices])
    if thing.data.splines[0].use_cyclic_u:
        points = np.concatenate([points, points[:1]])
    shown.to_mesh_clear()
    world = np.array(thing.matrix_world)
    return points @ world[:3, :3].T + world[:3, 3]


def along(points, distances):
    """The places so many metres along a polyline."""
    metres = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    return np.stack([np.interp(distances, metres, points[:, axis]) for axis in range(3)], axis=1), metres[-1]


def heads(thing, bones, frames):
    """Where the heads of bones are in the world at some frames, (F, B, 3)."""
    scene, places = bpy.context.scene, []
    for frame in frames:
        scene.frame_set(int(frame))
        posed = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
        places.append([(posed.matrix_world @ posed.pose.bones[bone].head)[:] for bone in bones])
    return np.array(places)


def role(thing, name):
    """The bone of an armature that plays a role."""
    import json

    return json.loads(thing.data["kinetograph_roles"])[name]


def readings():
    """A file of what sensors would say of a walk of 4 s along a straight line."""
    path, walked = FOLDER / "readings.csv", FOLDER / "walked.bvh"
    if not path.is_file():
        program = str(FOLDER / "bin" / "kinetograph") if (FOLDER / "bin").is_dir() else "kinetograph"
        line = FOLDER / "sensed_path.csv"
        line.write_text("t,x,z\n" + "".join(f"{i / 10},0,{i / 10}\n" for i in range(41)))
        made = ["perform", line, "-l", WALKS, "-o", walked, "--force"], ["simulate", walked, "-o", path, "--force"]
        for call in made:
            subprocess.run([program, *call], check=True, capture_output=True)
    return path
