"""The animation of a glTF file: its channels, their times, and values at those times."""

from __future__ import annotations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats import scene
from kinetograph.formats.gltf.buffers import Gltf, Json
from kinetograph.formats.timing import check_fps

PATHS = {"translation": 3, "rotation": 4, "scale": 3}
"""What a channel moves, and how many numbers each key has."""

_RATES = (24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 240.0)


def first_animation(gltf: Gltf, notes: list[str]) -> Json:
    """The first animation, empty where there is none; ``notes`` gets a line where there is not exactly one."""
    animations = gltf.objects("animations")
    if not animations:
        notes.append("the file has no animation: read its pose")
        return {}
    if len(animations) > 1:
        others = ", ".join(repr(str(a.get("name", "")))[:40] for a in animations[1:6])
        notes.append(f"{len(animations)} animations: read the first one, not {others}")
    return animations[0]


def channels(gltf: Gltf, animation: Json) -> list[tuple[int, str, Json]]:
    """Node, path and sampler of each channel of an animation."""
    samplers = gltf.list_of(animation, "samplers")
    out = []
    for channel in gltf.list_of(animation, "channels"):
        target = channel.get("target")
        if isinstance(target, dict) and target.get("path") in PATHS and "node" in target:
            node = gltf.index(target, "node", len(gltf.objects("nodes")))
            out.append((node, str(target["path"]), samplers[gltf.index(channel, "sampler", len(samplers))]))
    return out


def sample_times(gltf: Gltf, animation: Json, given: float | None, notes: list[str]) -> tuple[FloatArray, float]:
    """The times to sample at, and their rate.

    Parameters
    ----------
    gltf : Gltf
    animation : dict
    given : float or None
        The rate; without it, the rate noted in the file, or that of the keys.
    notes : list of str
        Gets a line where the rate is that of the keys.

    Returns
    -------
    times : ndarray, shape (F,)
        Seconds.
    fps : float

    Raises
    ------
    FormatError
        The times do not increase, or are too many for the file.
    """
    if given is not None:
        check_fps(gltf.path, given)
    accessors = len(gltf.objects("accessors"))
    inputs = {gltf.index(sampler, "input", accessors) for *_, sampler in channels(gltf, animation)}
    keys = {index: gltf.accessor(index)[:, 0] for index in inputs}
    for times in keys.values():
        if len(times) == 0 or np.any(np.diff(times) <= 0) or abs(times[0]) > 1e6 or abs(times[-1]) > 1e6:
            raise FormatError(gltf.path, "expected the times of an animation to increase")
    start = min((float(times[0]) for times in keys.values()), default=0.0)
    stop = max((float(times[-1]) for times in keys.values()), default=0.0)
    noted = [e.get("fps") for node in gltf.objects("nodes") if isinstance(e := node.get("extras"), dict)]
    fps = given or next((float(f) for f in noted if isinstance(f, int | float) and 0 < f < 1e5), None)
    if fps is None:
        longest = max(keys.values(), key=len, default=np.zeros(1))
        step = float(np.median(np.diff(longest))) if len(longest) > 1 else 1 / 30
        fps = next((rate for rate in _RATES if abs(rate * step - 1) < 1e-3), 1.0 / step)
        notes.append(f"rate not given: {fps:g} frames per second, the rate of the keys")
    count = (stop - start) * fps
    if not count * len(gltf.objects("nodes")) <= scene.most_values(gltf.size):
        raise FormatError(gltf.path, f"{stop - start:g} s at {fps:g} frames per second are too many; give --fps")
    return start + np.arange(round(count) + 1) / fps, fps


def sampled(gltf: Gltf, sampler: Json, what: str, times: FloatArray) -> FloatArray:
    """The values of a sampler.

    Parameters
    ----------
    gltf : Gltf
    sampler : dict
    what : {"translation", "rotation", "scale"}
    times : ndarray, shape (F,)
        Seconds.

    Returns
    -------
    ndarray, shape (F, 3) or (F, 4)
        Quaternions are w, x, y, z.

    Raises
    ------
    FormatError
        There are more or fewer values than keys, or rotations are not unit quaternions.
    """
    accessors = len(gltf.objects("accessors"))
    keys = gltf.accessor(gltf.index(sampler, "input", accessors))[:, 0]
    values = gltf.accessor(gltf.index(sampler, "output", accessors))
    kind = sampler.get("interpolation", "LINEAR")
    if kind == "CUBICSPLINE" and values.shape == (3 * len(keys), PATHS[what]):
        return _splined(gltf, keys, values.reshape(len(keys), 3, -1), what, times)
    if values.shape != (len(keys), PATHS[what]):
        raise FormatError(gltf.path, f"expected {len(keys)} values of a {what}, found {values.shape}")
    if what == "rotation":
        values = unit_quaternions(gltf, values[:, [3, 0, 1, 2]])
        kind = "SLERP" if kind == "LINEAR" else kind
    return scene.interpolate(times, keys, values, str(kind))


def _splined(gltf: Gltf, keys: FloatArray, values: FloatArray, what: str, times: FloatArray) -> FloatArray:
    if what != "rotation":
        return scene.spline(times, keys, values)
    values = values[..., [3, 0, 1, 2]]
    values[:, 1] = unit_quaternions(gltf, values[:, 1])
    quaternions = scene.spline(times, keys, values)
    if np.any(np.linalg.norm(quaternions, axis=1) < 1e-3):
        raise FormatError(gltf.path, "a spline of rotations passes through zero")
    return rot.normalize(quaternions)


def unit_quaternions(gltf: Gltf, quaternions: FloatArray) -> FloatArray:
    """Quaternions brought to exactly unit length. Raises FormatError where they are not nearly so."""
    if np.any(np.abs(np.linalg.norm(quaternions, axis=-1) - 1) > 0.1):
        raise FormatError(gltf.path, "expected unit quaternions as rotations")
    return rot.normalize(quaternions)
