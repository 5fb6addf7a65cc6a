"""Pictures by Workbench: a person walks along a curve, and between two poses; at several moments at once.

Written into the folder as walk.png and keys.png. A check only of that somebody is there: they are for looking at.
"""

import bpy
import numpy as np
from common import FOLDER, WALKS, bezier, emptied, finish, installed, row
from mathutils import Vector

WIDTH, HEIGHT = 1200, 560
SKIN, KEY, LINE, FLOOR = (0.62, 0.68, 0.76, 1), (0.95, 0.55, 0.2, 1), (0.9, 0.25, 0.2, 1), (0.93, 0.93, 0.93, 1)


def person():
    """The CC0 person, and its armature at the origin."""
    bpy.ops.import_scene.gltf(filepath=str(FOLDER / "person.glb"))
    for thing in list(bpy.data.objects):
        if thing.type == "MESH" and thing.find_armature() is None:
            bpy.data.objects.remove(thing)  # the shape that glTF's importer gives bones
    return next(thing for thing in bpy.data.objects if thing.type == "ARMATURE")


def moments(armature, frames, coloured=()):
    """What an armature's meshes are at some frames, as objects that stay."""
    meshes = [thing for thing in bpy.data.objects if thing.type == "MESH" and thing.find_armature() == armature]
    for frame in frames:
        bpy.context.scene.frame_set(frame)
        graph = bpy.context.evaluated_depsgraph_get()
        for mesh in meshes:
            shown = mesh.evaluated_get(graph)
            still = bpy.data.objects.new(f"at {frame}", bpy.data.meshes.new_from_object(shown))
            still.matrix_world = shown.matrix_world
            still.color = KEY if frame in coloured else SKIN
            bpy.context.collection.objects.link(still)
    for mesh in meshes:
        mesh.hide_render = True


def rendered(name, middle, away, lens=45):
    """A picture, and the share of it that is not floor or sky."""
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=80)
    bpy.context.object.color = FLOOR
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.camera.data.lens = lens
    scene.collection.objects.link(scene.camera)
    scene.camera.location = Vector(middle) + Vector(away)
    scene.camera.rotation_euler = (-Vector(away)).to_track_quat("-Z", "Y").to_euler()
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    shading = scene.display.shading
    shading.light, shading.color_type, shading.show_shadows, shading.show_cavity = "STUDIO", "OBJECT", True, True
    scene.display.render_aa = "16"
    scene.view_settings.view_transform = "Standard"
    scene.world = bpy.data.worlds.new("world")
    scene.world.color = (0.93, 0.93, 0.93)
    scene.render.filepath = str(FOLDER / name)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = np.array(image.pixels[:]).reshape(-1, 4)[:, :3]
    share = float((np.ptp(pixels, axis=1) > 0.04).mean())
    row(f"picture {name}", 0.02 < share < 0.6, f"{100 * share:.1f} % of it are people and lines, by Workbench")


def walk():
    emptied(24)
    armature = person()
    thing = bezier("path", [(0, 0), (2, 0.7), (4, -0.7), (6, 0)])
    bpy.ops.kinetograph.walk(curve=thing.name, library=WALKS, armature=armature.name, speed=1.15)
    thing.data.bevel_depth, thing.color = 0.02, LINE
    last = int(armature.animation_data.action.frame_range[1])
    moments(armature, np.linspace(4, last, 8).round().astype(int).tolist())
    rendered("walk.png", (3, 0, 0.7), (0.4, -8.6, 2.4))


def keys():
    """Two poses of a walk, and what is made between them."""
    emptied(24)
    armature = person()
    thing = bezier("path", [(0, 0), (3, 0.3), (5, 0)])
    bpy.ops.kinetograph.walk(curve=thing.name, library=WALKS, armature=armature.name, speed=1.15)
    bpy.data.objects.remove(thing)
    action = armature.animation_data.action
    while len(action.pose_markers):
        action.pose_markers.remove(action.pose_markers[0])
    for frame in (12, 84):
        action.pose_markers.new("pose").frame = frame
    bpy.ops.kinetograph.inbetween(armature=armature.name, library=WALKS)
    moments(armature, [12, 26, 40, 55, 70, 84], coloured=(12, 84))
    rendered("keys.png", (2.3, 0.1, 0.75), (0.2, -6.6, 1.5))


installed()
if (FOLDER / "person.glb").is_file():
    walk()
    keys()
else:
    print("skipped the pictures: the sample 'character' is not here")
finish()
