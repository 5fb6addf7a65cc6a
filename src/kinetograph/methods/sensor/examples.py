"""From a library to synchronised examples of poses, root motion and virtual readings (Xie 2009, chapter 4)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.methods.sensor.pose_space import PoseSpace, fit_pose_space
from kinetograph.methods.sensor.root import RootModel, fit_root_model, root_features
from kinetograph.motion import Motion, resample
from kinetograph.sensing.layout import Layout
from kinetograph.sensing.readings import Readings, only
from kinetograph.sensing.uniform import Resampling, uniform
from kinetograph.sensing.virtual import simulate_kinds
from kinetograph.skeleton import same_shape

if TYPE_CHECKING:
    from kinetograph.library import Library

LEAST = {"force": 0.5, "angular": 0.1, "tilt": 0.02}
"""Spread of a channel, in its unit, below which it is noise rather than movement."""
SHORTEST = 0.5
"""Seconds; shorter takes are left out."""


@dataclass(frozen=True, eq=False)
class Examples:
    """N frames of recordings, one after another.

    poses ``(N, D)`` in ``space``, root ``(N, A)`` features, readings ``(N, C)`` of some ``kinds`` of channels, divided
    by ``scale`` ``(C,)``. starts ``(T + 1,)``: where each of ``takes``, pairs of take and track, begins, and the end.
    ``names``: the sensors.
    """

    space: PoseSpace
    root: RootModel
    poses: FloatArray
    root_features: FloatArray
    readings: FloatArray
    scale: FloatArray
    starts: IntArray
    takes: tuple[tuple[str, str], ...]
    names: tuple[str, ...]
    fps: float
    kinds: tuple[str, ...] = ("force",)

    @property
    def first(self) -> BoolArray:
        """Which frames begin a take, shape ``(N,)``."""
        mask = np.zeros(len(self.poses), dtype=np.bool_)
        mask[self.starts[:-1]] = True
        return mask


def collect_motions(library: Library, exclude: tuple[str, ...], track: str | None) -> dict[tuple[str, str], Motion]:
    """The motions of a library's takes by take and track. Raises RequestError for no take or two skeletons."""
    motions: dict[tuple[str, str], Motion] = {}
    for name in library.names():
        if name in exclude:
            continue
        take = library.take(name)
        motion = take.motion(track)
        key = next(k for k, v in take.tracks.items() if v is motion)
        if motion.duration >= SHORTEST:
            motions[name, key] = motion
    if not motions:
        raise RequestError(f"the library has no take of {SHORTEST} s or more to use; add recordings, or exclude fewer")
    (first_name, _), first = next(iter(motions.items()))
    for (name, _), motion in motions.items():
        if not same_shape(first.skeleton, motion.skeleton, tolerance=0.02):
            raise RequestError(
                f"takes {first_name!r} ({len(first.skeleton)} joints) and {name!r} ({len(motion.skeleton)} joints) "
                "have different skeletons; put them in libraries of their own"
            )
    return motions


def build_examples(
    motions: dict[tuple[str, str], Motion], layout: Layout, fps: float, how: Resampling, rng: np.random.Generator,
    recorded: Mapping[tuple[str, str], Readings] = MappingProxyType({}), kinds: tuple[str, ...] = ("force",),
) -> Examples:  # fmt: skip
    """Examples of motions that are given a layout's sensors by simulation, where they have no ``recorded`` readings.

    The sensors have their device's faults but for losses and clock offset, and pass through the same resampling as real
    ones, so that whatever it does to the readings it does to both.
    """
    at_rate = {key: resample(motion, fps) for key, motion in motions.items()}
    learner = replace(layout, device=replace(layout.device, loss=0.0, offset=0.0))
    rows = {key: recorded.get(key) or simulate_kinds(motions[key], learner, kinds, rng) for key in at_rate}
    readings = [
        uniform(only(rows[key], layout.names), fps, (len(motion) - 1) / fps, how, kinds).values
        for key, motion in at_rate.items()
    ]
    together = np.concatenate(readings)
    least = np.tile(np.repeat([LEAST[kind] for kind in kinds], 3), len(layout.names))
    scale = np.maximum(together.std(axis=0), least)
    space = fit_pose_space(list(at_rate.values()))
    root = fit_root_model(list(at_rate.values()))
    lengths = [len(motion) for motion in at_rate.values()]
    return Examples(
        space,
        root,
        np.concatenate([space.encode(motion) for motion in at_rate.values()]),
        np.concatenate([root_features(motion, root) for motion in at_rate.values()]),
        together / scale,
        scale,
        np.concatenate([[0], np.cumsum(lengths)]),
        tuple(motions),
        layout.names,
        fps,
        kinds,
    )
