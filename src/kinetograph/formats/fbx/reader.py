"""Reading FBX: the joints of a scene, at even times, as motions."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats import scene as scenes
from kinetograph.formats.conventions import UPS, scale_motion, to_metres_y_up
from kinetograph.formats.fbx.nodes import parse
from kinetograph.formats.fbx.scene import Scene
from kinetograph.formats.fbx.times import rate_of_keys
from kinetograph.formats.options import Loaded, ReadOptions
from kinetograph.formats.timing import check_fps
from kinetograph.take import Take

_LIMBS = ("LimbNode", "Limb", "Root", "Effector")


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """Read a binary FBX file as a take in metres, Y up, with one motion per skeleton.

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
        The file is not binary FBX 7, is damaged, or has no joints.

    Notes
    -----
    Joints are the limb nodes, or else the nodes that move. Their rest pose is the bind pose that the file gives, or
    else the pose with all rotations zero. Of several layers of animation the one with the most curves is read, linearly
    between its keys.
    """
    path = Path(path)
    options = options or ReadOptions()
    document = parse(path)
    scene = Scene(path, document)
    notes = scene.notes
    joints = [i for i, m in enumerate(scene.models) if m.kind in _LIMBS]
    joints = joints or [i for i, m in enumerate(scene.models) if m.curves]
    if not joints:
        raise FormatError(path, "expected a skeleton or nodes that move, found neither")
    times, fps = _times(path, scene, options.fps)
    nodes = scene.nodes(times)
    bind = scene.bind(nodes.names)
    motions = scenes.motions(nodes, joints, bind, fps)
    units = options.units
    if units is None:
        factor = 0.01 * scene.setting("UnitScaleFactor", 1.0)
        motions, units = [scale_motion(motion, factor) for motion in motions], "metre"
    up = options.up or UPS[int(scene.setting("UpAxis", 1.0)) % 3]
    converted = to_metres_y_up(motions, units, up, options.keep)
    tracks = converted.tracks([motion.skeleton.names[0] for motion in motions], notes)
    return Loaded(Take(path.stem, tracks), (*notes, *converted.notes))


def _times(path: Path, scene: Scene, given: float | None) -> tuple[FloatArray, float]:
    """The times to sample at, and their rate."""
    if given is not None:
        check_fps(path, given)
    keys = [times for model in scene.models for times, _ in model.curves.values() if len(times) > 1]
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
