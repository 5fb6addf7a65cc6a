"""Draws a motion file with Blender's Workbench, frames side by side: python picture_with_blender.py FILE OUT.png [N].

Run with a Python that has bpy. Software rendering is enough: about a second a picture.
"""

import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

WIDTH, HEIGHT = 360, 480


def main() -> None:
    name, out = sys.argv[1], sys.argv[2]
    count = int(sys.argv[3]) if len(sys.argv) > 3 else 6
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = 30
    importers = {"glb": bpy.ops.import_scene.gltf, "fbx": bpy.ops.import_scene.fbx}
    importers.get(name.rpartition(".")[2], bpy.ops.wm.usd_import)(filepath=name)
    for thing in bpy.data.objects:  # glTF's importer adds a shape for bones
        thing.hide_render = thing.type == "MESH" and not thing.find_armature()
    dress(scene)
    stop = max(action.frame_range[1] for action in bpy.data.actions)
    pictures = [render(scene, round(frame)) for frame in np.linspace(0, stop, count)]
    save(np.concatenate(pictures, axis=1), out)


def dress(scene) -> None:
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.display.shading.light = "STUDIO"
    scene.display.shading.color_type = "MATERIAL"
    scene.display.shading.show_shadows = True
    scene.display.shading.show_cavity = True
    scene.display.render_aa = "8"
    scene.world = bpy.data.worlds.new("world")
    scene.world.color = (0.8, 0.8, 0.8)
    bpy.ops.mesh.primitive_plane_add(size=60)
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.camera.data.lens = 75
    scene.collection.objects.link(scene.camera)
    for material in bpy.data.materials:
        if material.node_tree and (shader := material.node_tree.nodes.get("Principled BSDF")):
            material.diffuse_color = shader.inputs["Base Color"].default_value


def render(scene, frame: int):
    scene.frame_set(frame)
    armature = next(thing for thing in bpy.data.objects if thing.type == "ARMATURE")
    centre = armature.matrix_world @ armature.pose.bones[0].head
    centre.z = 0.9
    scene.camera.location = centre + Vector((2.4, -3.4, 0.7))
    scene.camera.rotation_euler = (centre - scene.camera.location).to_track_quat("-Z", "Y").to_euler()
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "frame.png")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.array(image.pixels[:]).reshape(HEIGHT, WIDTH, 4)
    bpy.data.images.remove(image)
    return pixels


def save(pixels, out: str) -> None:
    image = bpy.data.images.new("out", pixels.shape[1], pixels.shape[0])
    image.pixels[:] = pixels.ravel()
    image.filepath_raw, image.file_format = out, "PNG"
    image.save()


main()
