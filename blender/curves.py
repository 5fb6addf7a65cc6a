# SPDX-License-Identifier: GPL-3.0-or-later
"""Controls: a curve with a speed, or an object that moves, becomes a path: seconds, and metres on the ground.

How fast a curve is walked along is, in this order: the object's property ``speed`` (metres per second, which may be
keyed or driven), the curve's animated evaluation time, or a constant, which the radius of points may multiply.
"""

import bpy
import numpy as np
from mathutils.geometry import interpolate_bezier

from .link import Trouble

_STEPS = 32  # points of a span of a curve
_LONGEST = 600.0  # seconds


def path_of(thing, scene, speed, by_radius):
    """The path of a curve, or of another object that moves: rows of seconds and metres x, z, Y up. Raises Trouble."""
    if thing.type in ("CURVE", "CURVES"):
        points, factors = polyline(thing)
        points = _walked(thing, points * unit(scene), factors if by_radius else None, scene, speed)
        if len(points) < 2:
            raise Trouble(f"{thing.name} goes nowhere: it is walked within a frame; draw a longer one")
        return _rows(points, scene)
    if not moves(thing):
        raise Trouble(f"{thing.name} does not move: choose a curve, or an object with an animation")
    return _rows(_moving(thing, scene) * unit(scene), scene)


def unit(scene):
    """Metres in a unit of the scene."""
    return scene.unit_settings.scale_length or 1.0


def rate(scene):
    """Frames per second."""
    return scene.render.fps / scene.render.fps_base


def moves(thing):
    """Whether an object is animated."""
    data = thing.animation_data
    driven = data is not None and (data.action is not None or len(data.drivers) > 0 or len(data.nla_tracks) > 0)
    return driven or len(thing.constraints) > 0 or (thing.parent is not None and moves(thing.parent))


def _rows(points, scene):
    """Points at every frame as rows."""
    return [(i / rate(scene), float(x), float(-y)) for i, (x, y) in enumerate(points[:, :2])]


def _moving(thing, scene):
    """Where an object is, from the scene's first frame to the end of its animation."""
    action = thing.animation_data.action if thing.animation_data else None
    last = int(np.ceil(action.frame_range[1])) if action else scene.frame_end
    frames = range(scene.frame_start, max(last, scene.frame_start + 1) + 1)
    return np.array(at_frames(scene, frames, lambda: thing.evaluated_get(_graph()).matrix_world.translation[:]))


def at_frames(scene, frames, look):
    """What is seen at each of some frames; the scene's frame is then as before."""
    before, subframe = scene.frame_current, scene.frame_subframe
    seen = []
    try:
        for frame in frames:
            scene.frame_set(int(np.floor(frame)), subframe=float(frame - np.floor(frame)))
            seen.append(look())
    finally:
        scene.frame_set(before, subframe=subframe)
    return seen


def _graph():
    return bpy.context.evaluated_depsgraph_get()


# ---- shape ----


def polyline(thing):
    """The points of a curve's first spline in the world, (N, 3), and the radius at each. Raises Trouble."""
    data, world = thing.data, np.array(thing.evaluated_get(_graph()).matrix_world)
    if thing.type == "CURVES":
        points, factors = _hair(thing)
    elif not data.splines:
        raise Trouble(f"{thing.name} has no points: draw a curve of two or more")
    elif data.splines[0].type == "NURBS":
        points, factors = _nurbs(thing)
    else:
        points, factors = (_bezier if data.splines[0].type == "BEZIER" else _poly)(data.splines[0])
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    kept = np.concatenate([[True], np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-9]) if len(points) else []
    points, factors = points[kept], np.asarray(factors, dtype=float)[kept]
    if len(points) < 2:
        raise Trouble(f"{thing.name} has one point: a path needs two or more")
    return points @ world[:3, :3].T + world[:3, 3], factors


def _bezier(spline):
    knots = list(spline.bezier_points)
    pairs = list(zip(knots, knots[1:] + (knots[:1] if spline.use_cyclic_u else []), strict=False))
    points, factors = [], []
    for one, other in pairs:
        points += interpolate_bezier(one.co, one.handle_right, other.handle_left, other.co, _STEPS + 1)
        factors += np.linspace(one.radius, other.radius, _STEPS + 1).tolist()
    return [tuple(point) for point in points] or [tuple(knot.co) for knot in knots], factors or [
        k.radius for k in knots
    ]


def _poly(spline):
    knots = list(spline.points) + (list(spline.points[:1]) if spline.use_cyclic_u else [])
    return [tuple(knot.co[:3]) for knot in knots], [knot.radius for knot in knots]


def _nurbs(thing):
    """The points at which Blender evaluates a NURBS, without its bevel; radii are spread evenly over them."""
    copy, data = thing.copy(), thing.data.copy()
    copy.data = data
    data.bevel_depth = data.extrude = data.offset = 0.0
    data.bevel_object = data.taper_object = None
    data.resolution_u = data.render_resolution_u = _STEPS
    for other in list(data.splines)[1:]:
        data.splines.remove(other)
    bpy.context.scene.collection.objects.link(copy)
    try:
        bpy.context.view_layer.update()
        shown = copy.evaluated_get(_graph())
        points = [tuple(vertex.co) for vertex in shown.to_mesh().vertices]
        shown.to_mesh_clear()
        spline = data.splines[0]
        radii = [knot.radius for knot in spline.points]
        if spline.use_cyclic_u:
            points, radii = points + points[:1], radii + radii[:1]
    finally:
        bpy.data.objects.remove(copy)
        bpy.data.curves.remove(data)
    return points, np.interp(np.linspace(0, len(radii) - 1, len(points)), np.arange(len(radii)), radii)


def _hair(thing):
    data = thing.data
    if not len(data.curves):
        raise Trouble(f"{thing.name} has no points: draw a curve of two or more")
    first = data.curves[0]
    positions = np.array([data.attributes["position"].data[i].vector[:] for i in range(first.points_length)])
    speed = data.attributes.get("speed")
    factors = [speed.data[i].value for i in range(len(positions))] if speed is not None else np.ones(len(positions))
    return positions, factors


# ---- speed ----


def _walked(thing, points, factors, scene, speed):
    """Where a curve is at every frame, from its start to its end, in metres."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    if "speed" in thing:
        places = _by_property(thing, along[-1], scene)
    elif thing.type == "CURVE" and _timed(thing.data):
        places = _by_time(thing.data, along[-1], scene)
    else:
        if speed <= 0:
            raise Trouble(f"a speed is more than 0 m/s, found {speed:g}")
        slow = np.ones(len(points)) if factors is None else np.clip(factors, 0.05, 20.0)
        clock = np.concatenate([[0.0], np.cumsum(np.diff(along) / (0.5 * (slow[1:] + slow[:-1]) * speed))])
        _refuse_long(clock[-1])
        times = np.arange(int(np.floor(clock[-1] * rate(scene) + 1e-6)) + 1) / rate(scene)
        places = np.interp(times, clock, along)
    return np.stack([np.interp(places, along, points[:, axis]) for axis in range(3)], axis=1)


def _refuse_long(seconds):
    if seconds > _LONGEST:
        raise Trouble(f"that takes {seconds:.0f} s, {_LONGEST:.0f} at most: walk faster, or shorten the curve")


def _by_property(thing, length, scene):
    """Metres along at every frame, from a speed that may be keyed or driven."""
    places, frame = [0.0], scene.frame_start

    def look():
        return float(thing.evaluated_get(_graph())["speed"])

    while places[-1] < length:
        block = at_frames(scene, range(frame, frame + 48), look)
        for speed in block:
            places.append(places[-1] + max(speed, 0.0) / rate(scene))
        frame += 48
        _refuse_long((frame - scene.frame_start) / rate(scene))
    end = next(i for i, place in enumerate(places) if place >= length)
    return np.minimum(places[: end + 1], length)


def _timed(data):
    if data.animation_data is None or not data.use_path:
        return False
    paths = [driver.data_path for driver in data.animation_data.drivers]
    return data.animation_data.action is not None or "eval_time" in paths


def _by_time(data, length, scene):
    """Metres along at every frame, from the curve's evaluation time."""
    action = data.animation_data.action
    last = int(np.ceil(action.frame_range[1])) if action else scene.frame_end
    frames = range(scene.frame_start, max(last, scene.frame_start + 1) + 1)
    times = at_frames(scene, frames, lambda: data.evaluated_get(_graph()).eval_time)
    shares = np.clip(np.array(times) / max(data.path_duration, 1e-9), 0.0, 1.0)
    if np.ptp(shares) < 1e-6:
        raise Trouble("the curve's evaluation time does not change: key it, or give a speed")
    return shares * length
