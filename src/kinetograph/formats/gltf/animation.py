"""The animation of a glTF file: its channels, their times, and values at those times."""

from __future__ import annotations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats import scene
from kinetograph.formats.animations import choose, labels, title
from kinetograph.formats.gltf.buffers import Gltf
from kinetograph.formats.gltf.structure import Animation, Sampler
from kinetograph.formats.timing import check_fps

PATHS = {"translation": 3, "rotation": 4, "scale": 3}
"""What a channel moves, and how many numbers each key has."""

_RATES = (24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 240.0)
_SPARSE, _LEAST = 12.0, 30.0  # frames per second: keys of fewer are not frames, and are sampled at this rate at least


def chosen_animation(gltf: Gltf, wanted: str | None, notes: list[str]) -> tuple[Animation, str, tuple[str, ...]]:
    """The animation that is wanted, what it is called, and what all are called; an empty one where the file has none.

    Parameters
    ----------
    gltf : Gltf
    wanted : str or None
        A name or a number; the first one unless given.
    notes : list of str
        Gets a line where there is not exactly one and none is wanted.

    Raises
    ------
    RequestError
        There is no such animation.
    """
    animations = gltf.document.animations
    known = labels([animation.name for animation in animations])
    if not animations and wanted is None:
        notes.append("the file has no animation: read its pose")
        return Animation(), "", ()
    chosen = choose(gltf.path, known, wanted, notes)
    return animations[chosen], title(known, chosen, animations[chosen].name), known


def channels(gltf: Gltf, animation: Animation) -> list[tuple[int, str, Sampler]]:
    """Node, path and sampler of each channel of an animation."""
    out = []
    for channel in animation.channels:
        node = channel.target.node
        if channel.target.path in PATHS and node is not None:
            gltf.pick(gltf.document.nodes, node, "node")
            out.append((node, channel.target.path, gltf.pick(animation.samplers, channel.sampler, "sampler")))
    return out


def sample_times(gltf: Gltf, animation: Animation, given: float | None, notes: list[str]) -> tuple[FloatArray, float]:
    """The times to sample at, and their rate.

    Parameters
    ----------
    gltf : Gltf
    animation : Animation
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
    inputs = {sampler.input for *_, sampler in channels(gltf, animation)}
    keys = {index: gltf.accessor(index)[:, 0] for index in inputs}
    for times in keys.values():
        if len(times) == 0 or np.any(np.diff(times) <= 0) or abs(times[0]) > 1e6 or abs(times[-1]) > 1e6:
            raise FormatError(gltf.path, "expected the times of an animation to increase")
    start = min((float(times[0]) for times in keys.values()), default=0.0)
    stop = max((float(times[-1]) for times in keys.values()), default=0.0)
    noted = [node.noted.fps for node in gltf.document.nodes]
    fps = given or max((rate for rate in noted if rate is not None and 0 < rate < 1e5), default=None)
    if fps is None:
        fps = _rate_of_keys(max(keys.values(), key=len, default=np.zeros(1)), notes)
    count = (stop - start) * fps
    if not count * len(gltf.document.nodes) <= scene.most_values(gltf.size):
        raise FormatError(gltf.path, f"{stop - start:g} s at {fps:g} frames per second are too many; give --fps")
    return start + np.arange(round(count) + 1) / fps, fps


def _rate_of_keys(times: FloatArray, notes: list[str]) -> float:
    """The rate of the densest keys; where those are few, as in keyframe animation, a multiple of it."""
    if len(times) < 2:
        return _LEAST
    step = float(np.median(np.diff(times)))
    fps = next((rate for rate in _RATES if abs(rate * step - 1) < 1e-3), 1.0 / step)
    if fps < _SPARSE:
        fps *= np.ceil(_LEAST / fps - 1e-6)
        notes.append(f"rate not given: {fps:g} frames per second, as keys are only every {step:.2g} s")
    else:
        notes.append(f"rate not given: {fps:g} frames per second, the rate of the keys")
    return float(fps)


def sampled(gltf: Gltf, sampler: Sampler, what: str, times: FloatArray) -> FloatArray:
    """The values of a sampler.

    Parameters
    ----------
    gltf : Gltf
    sampler : Sampler
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
    keys, values, kind = gltf.accessor(sampler.input)[:, 0], gltf.accessor(sampler.output), sampler.interpolation
    keys = _on_frames(keys, times)
    if kind == "CUBICSPLINE" and values.shape == (3 * len(keys), PATHS[what]):
        return _splined(gltf, keys, values.reshape(len(keys), 3, -1), what, times)
    if values.shape != (len(keys), PATHS[what]):
        raise FormatError(gltf.path, f"expected {len(keys)} values of a {what}, found {values.shape}")
    if what == "rotation":
        values = unit_quaternions(gltf, values[:, [3, 0, 1, 2]])
        kind = "SLERP" if kind == "LINEAR" else kind
    return scene.interpolate(times, keys, values, kind)


def _on_frames(keys: FloatArray, times: FloatArray) -> FloatArray:
    """Keys that are nearly on frames, as seconds in single precision are, exactly on them."""
    if len(times) < 2 or len(keys) < 2:
        return keys
    step = (times[-1] - times[0]) / (len(times) - 1)
    frames = (keys - times[0]) / step
    near = np.abs(frames - np.round(frames)) < min(1e-3 + 2 * float(np.spacing(np.float32(times[-1]))) / step, 0.05)
    snapped = np.where(near, times[0] + np.round(frames) * step, keys)
    return snapped if np.all(np.diff(snapped) > 0) else keys


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
