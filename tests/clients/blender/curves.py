"""Walks along straight, S-shaped and closed curves, at constant and varying speed and several rates.

The hips are compared, frame by frame, with the place along the curve as Blender itself draws it.
"""

import importlib
import time

import bpy
import numpy as np
from common import FOLDER, SAMPLE, WALKS, along, bezier, curves_of, emptied, finish, heads, installed, role, row, seen

S = [(0, 0), (2, 1), (4, -1), (6, 0)]
CIRCLE = [(2, 0), (0, 2), (-2, 0), (0, -2)]
P95, MOST = 0.02, 0.035 if SAMPLE else 0.025  # metres: hips sway from side to side with every step


def look(what, thing, distances, armature):
    """Compare the hips with the curve, metres along it at every frame."""
    hips = role(armature, "hips")
    points = seen(thing)
    places, length = along(points, distances)
    frames = bpy.context.scene.frame_start + np.arange(len(distances))
    found = heads(armature, [hips], frames)[:, 0]
    apart = np.linalg.norm((found - places)[:, :2], axis=1)
    last = armature.animation_data.action.frame_range[1]
    whole = abs(last - frames[-1]) <= 1 and distances[-1] > length - 0.1
    row(what, near(apart) and whole, f"{said(apart)}; to frame {last:.0f}")


def near(apart):
    """Whether hips are as near the curve as they should be."""
    return np.quantile(apart, 0.95) < P95 and apart.max() < MOST


def said(apart):
    """Metres in words."""
    half, most, every = 100 * np.quantile(apart, [0.5, 0.95, 1.0])
    return f"hips off the curve by {half:.1f} cm in half of the frames, {most:.1f} in 95 %, {every:.1f} at most"


def constant(what, points, cyclic, fps, base=1.0, speed=1.1, **moved):
    emptied(fps, base)
    thing = bezier("path", points, cyclic)
    for name, value in moved.items():
        setattr(thing, name, value)
    bpy.context.view_layer.update()
    bpy.ops.kinetograph.walk(curve=thing.name, library=WALKS, speed=speed)
    length = along(seen(thing), np.zeros(1))[1]
    count = int(length / speed * fps / base + 1e-4) + 1
    look(what, thing, np.minimum(np.arange(count) * speed * base / fps, length), bpy.context.object)


def varying():
    emptied(30)
    thing = bezier("path", S)
    thing["speed"] = 0.8
    for frame, speed in ((1, 0.8), (90, 1.3), (180, 0.7)):
        thing["speed"] = speed
        thing.keyframe_insert('["speed"]', frame=frame)
    bpy.ops.kinetograph.walk(curve=thing.name, library=WALKS)
    look("an S, keyed speed, 30 fps", thing, _driven(thing, lambda: thing["speed"]), bpy.context.object)


def driven():
    emptied(30)
    thing = bezier("path", S)
    thing["speed"] = 1.0
    driver = thing.driver_add('["speed"]').driver
    driver.expression = "1.0 + 0.25 * sin(frame / 30)"
    bpy.context.view_layer.update()
    bpy.ops.kinetograph.walk(curve=thing.name, library=WALKS)
    places, length = [0.0], along(seen(thing), np.zeros(1))[1]
    frame = 1
    while places[-1] < length:
        places.append(places[-1] + (1.0 + 0.25 * np.sin(frame / 30)) / 30)
        frame += 1
    look("an S, driven speed, 30 fps", thing, np.minimum(places, length), bpy.context.object)


def _driven(thing, speed):
    places, length = [0.0], along(seen(thing), np.zeros(1))[1]
    frame = 1
    while places[-1] < length:
        bpy.context.scene.frame_set(frame)
        shown = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
        places.append(places[-1] + shown["speed"] / 30)
        frame += 1
    return np.minimum(places, length)


def timed():
    """A curve that is walked as its evaluation time says: slow, fast, slow."""
    scene = emptied(25)
    thing = bezier("path", S)
    thing.data.use_path, thing.data.path_duration = True, 100
    thing.data.eval_time = 0
    thing.data.keyframe_insert("eval_time", frame=1)
    thing.data.eval_time = 100
    thing.data.keyframe_insert("eval_time", frame=171)
    bpy.ops.kinetograph.walk(curve=thing.name, library=WALKS)
    length, shares = along(seen(thing), np.zeros(1))[1], []
    for frame in range(1, 172):
        scene.frame_set(frame)
        shares.append(thing.data.evaluated_get(bpy.context.evaluated_depsgraph_get()).eval_time / 100)
    look("an S, eased evaluation time, 25 fps", thing, np.array(shares) * length, bpy.context.object)


def radii():
    """The radius of points says how fast: twice as fast at the end as at the beginning."""
    emptied(60)
    thing = bezier("path", [(0, 0), (0, 6)])
    for knot, radius in zip(thing.data.splines[0].bezier_points, (0.6, 1.2), strict=True):
        knot.radius = radius
        knot.handle_left_type = knot.handle_right_type = "VECTOR"
    bpy.context.view_layer.update()
    bpy.ops.kinetograph.walk(curve=thing.name, library=WALKS, speed=1.0, by_radius=True)
    seconds = np.arange(0, 10, 1 / 60)  # knots at a third of the way make the radius linear in the distance
    places = 6 * (np.exp(0.1 * seconds) - 1)
    count = int(np.searchsorted(places, 6.0))
    look("straight, speed by radius, 60 fps", thing, places[:count], bpy.context.object)


def nurbs():
    """A NURBS circle, as Blender adds one."""
    emptied(24)
    bpy.ops.curve.primitive_nurbs_circle_add(radius=2.5)
    thing = bpy.context.object
    thing.data.resolution_u = 64
    bpy.context.view_layer.update()
    bpy.ops.kinetograph.walk(curve=thing.name, library=WALKS, speed=1.1)
    length = along(seen(thing), np.zeros(1))[1]
    count = int(length / 1.1 * 24) + 1
    look("a NURBS circle, 24 fps", thing, np.arange(count) * 1.1 / 24, bpy.context.object)


def empty():
    """An empty that moves along a line."""
    scene = emptied(24)
    thing = bpy.data.objects.new("lead", None)
    bpy.context.collection.objects.link(thing)
    for frame, y in ((1, 0.0), (121, 5.5)):
        thing.location = (1.0, y, 0.0)
        thing.keyframe_insert("location", frame=frame)
    for curve in curves_of(thing.animation_data.action, thing):
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    bpy.ops.kinetograph.walk(curve=thing.name, library=WALKS)
    armature = bpy.context.object
    frames = np.arange(1, 122)
    found = heads(armature, [role(armature, "hips")], frames)[:, 0]
    expected = np.stack([np.ones(121), np.linspace(0, 5.5, 121)], axis=1)
    apart = np.linalg.norm(found[:, :2] - expected, axis=1)
    row("an animated empty, 24 fps", near(apart), f"{said(apart)}; to frame {scene.frame_end}")


def scaled():
    """A scene in centimetres: a unit is 0.01 m."""
    scene = emptied(24)
    scene.unit_settings.scale_length = 0.01
    thing = bezier("path", [(0, 0), (300, 100), (600, 0)])
    bpy.ops.kinetograph.walk(curve=thing.name, library=WALKS, speed=1.1)
    armature = bpy.context.object
    length = along(seen(thing), np.zeros(1))[1]
    count = int(length / 110 * 24) + 1
    found = heads(armature, [role(armature, "hips"), role(armature, "left_shoulder")], 1 + np.arange(count))
    places, _ = along(seen(thing), np.arange(count) * 110 / 24)
    apart = np.linalg.norm((found[:, 0] - places)[:, :2], axis=1) / 100
    row("a scene in centimetres", near(apart) and 110 < found[:, 1, 2].mean() < 170, said(apart))


def on_it(fps):
    """Hips that are to be on the curve at every frame, of a new armature and of the person, whose bones are others."""
    emptied(fps)
    thing = bezier("path", S)
    path = FOLDER / "person.glb"
    if path.is_file():
        bpy.ops.import_scene.gltf(filepath=str(path))
    person = next((each.name for each in bpy.data.objects if each.type == "ARMATURE"), "")
    for armature in {"", person}:
        bpy.ops.kinetograph.walk(curve=thing.name, library=WALKS, speed=1.1, armature=armature, hips="ON")
        who = bpy.data.objects[armature] if armature else bpy.context.object
        count = int(along(seen(thing), np.zeros(1))[1] / 1.1 * fps + 1e-4) + 1
        places, _ = along(seen(thing), np.arange(count) * 1.1 / fps)
        found = heads(who, [role(who, "hips")], 1 + np.arange(count))[:, 0]
        apart = np.linalg.norm((found - places)[:, :2], axis=1)
        what = f"{'the person' if armature else 'an S'}, on the curve, {fps} fps"
        row(what, apart.max() < 0.015, said(apart))


def again():
    """The second call on a library: how long it takes, and how much of that kinetograph takes to answer."""
    link = importlib.import_module("bl_ext.user_default.kinetograph.link")
    emptied(24)
    thing, waited, ask, take = bezier("path", S), [], link.Link.ask, link.Link._take

    def asked(self, *given):
        waited.append(-time.perf_counter())
        return ask(self, *given)

    def taken(self, line):
        if b'"result"' in (line if isinstance(line, bytes) else line.encode())[:40]:
            waited.append(time.perf_counter())
        return take(self, line)

    link.Link.ask, link.Link._take = asked, taken
    began = time.perf_counter()
    bpy.ops.kinetograph.walk(curve=thing.name, library=WALKS, speed=1.1)
    seconds = time.perf_counter() - began
    link.Link.ask, link.Link._take = ask, take
    rest = seconds - sum(waited)
    row("the second call", rest < 0.5, f"{seconds:.2f} s, of which {sum(waited):.2f} s until kinetograph answers")


installed()
constant("straight, 24 fps", [(0, 0), (0, 3), (0, 6)], False, 24)
constant("an S, 25 fps", S, False, 25)
constant(
    "an S, moved and scaled, 30 fps", S, False, 30, location=(3, -2, 0), rotation_euler=(0, 0, 1), scale=(1.2,) * 3
)
constant("closed, 60 fps", CIRCLE, True, 60)
constant("closed, 29.97 fps", CIRCLE, True, 30, 1.001)
varying()
driven()
timed()
radii()
nurbs()
empty()
scaled()
again()
for each in (24, 25, 30, 60):
    on_it(each)
finish()
