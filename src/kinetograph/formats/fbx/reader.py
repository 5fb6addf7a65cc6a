"""Reading FBX: the joints of a scene, at even times, as motions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats import scene as scenes
from kinetograph.formats.conventions import rotate_world, scale_motion, to_metres_y_up
from kinetograph.formats.fbx.axes import upright
from kinetograph.formats.fbx.document import read_document
from kinetograph.formats.fbx.scene import Scene
from kinetograph.formats.fbx.times import rate_of_keys
from kinetograph.formats.options import Loaded, ReadOptions
from kinetograph.formats.timing import check_fps
from kinetograph.take import Take


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """Read an FBX file, binary or in text, as a take in metres, Y up, with one motion per skeleton.

    Parameters
    ----------
    path : str or Path
    options : ReadOptions, optional
        ``fps`` is the rate to sample at; without it, the rate of the keys.

    Returns
    -------
    Loaded

    Raises
    ------
    FormatError
        The file is not FBX of version 6 or later, is damaged, or has no joints.
    RequestError
        It has no animation of the name in ``options``.

    Notes
    -----
    Joints are the limb nodes and what skins are bound to, or else the nodes that move. Their rest pose is the bind pose
    that the file gives, or else the pose with all rotations zero. The layers of an animation are combined by their
    modes and weights.
    """
    path = Path(path)
    options = options or ReadOptions()
    scene = Scene(path, read_document(path), options.animation)
    notes = scene.notes
    joints = scene.joints()
    if not joints:
        raise FormatError(path, "expected a skeleton or nodes that move, found neither")
    times, fps = _times(path, scene, options.fps)
    nodes = scene.nodes(times)
    bind = scene.bind(nodes.names)
    motions = scenes.motions(nodes, joints, bind, fps, scene.rest(nodes.names))
    units = options.units
    if units is None:
        factor = 0.01 * (abs(scene.setting("UnitScaleFactor", 1.0)) or 1.0)
        motions, units = [scale_motion(motion, factor) for motion in motions], "metre"
    if options.up is None:
        rotation = upright(scene)
        motions = [rotate_world(motion, rotation) for motion in motions] if abs(rotation[0]) < 1.0 else motions
    keep = replace(options.keep, shared=len(scene.animations) > 1)
    converted = to_metres_y_up(motions, units, options.up or "y", keep)
    tracks = converted.tracks([_name(nodes, motion.skeleton.names[0]) for motion in motions], notes)
    take = Take(path.stem, tracks, animation=scene.animation)
    return Loaded(take, (*notes, *converted.notes), scene.animations)


def _name(nodes: scenes.Nodes, root: str) -> str:
    """What a body is called: the node above its root, which holds the name in files of this package, or the root."""
    above = int(nodes.parents[nodes.names.index(root)])
    return nodes.names[above] if above >= 0 else root


def _times(path: Path, scene: Scene, given: float | None) -> tuple[FloatArray, float]:
    """The times to sample at, and their rate."""
    if given is not None:
        check_fps(path, given)
    keys = [curve.times for curve in scene.curves() if len(curve.times) > 1]
    start = min((float(times[0]) for times in keys), default=0.0)
    stop = max((float(times[-1]) for times in keys), default=0.0)
    fps = given or _rate(scene, keys)
    # from the stack's own start, so that files recorded together stay synchronised; on the grid of its frames
    start = min(start, scene.start if abs(scene.start) < 1e6 else start)
    start = np.floor(start * fps + 1e-3) / fps
    count = (stop - start) * fps
    if not count * len(scene.models) <= scenes.most_values(path.stat().st_size):
        raise FormatError(path, f"{stop - start:g} s at {fps:g} frames per second are too many; give --fps")
    return start + np.arange(round(count) + 1) / fps, fps


def _rate(scene: Scene, keys: list[FloatArray]) -> float:
    mode, custom = int(scene.setting("TimeMode", 0.0)), scene.setting("CustomFrameRate", 30.0)
    fps, notes = rate_of_keys(keys, mode, custom)
    scene.notes += notes
    return fps
