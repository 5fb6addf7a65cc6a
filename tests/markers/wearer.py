"""A body of other proportions than the reference body's, that moves, and wears the markers of any set."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from actor import actor

from kinetograph.arrays import FloatArray
from kinetograph.kinematics import landmark_positions
from kinetograph.markers import MarkerSet, reference_body
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.skeleton import Landmark


def wearer(seconds: float = 1.3, seed: int = 1, fps: float = 30.0) -> tuple[Motion, dict[str, float]]:
    """The body, and the size of each of its segments in that of the reference body, by the last word of its name."""
    rng = np.random.default_rng(seed)
    body = reference_body()
    size = rng.uniform(0.92, 1.08)
    sizes = {name.rpartition("_")[2]: size * rng.uniform(0.95, 1.05) for name in body.names}
    offsets = body.offsets.copy()
    for joint in range(1, len(body)):
        offsets[joint] *= sizes[body.names[body.parents[joint]].rpartition("_")[2]]
    moved = actor(seconds, fps, seed)
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (len(moved), len(body), 1))
    for joint, name in enumerate(body.names):
        if name in moved.skeleton.names:
            rotations[:, joint] = moved.rotations[:, moved.skeleton.index(name)]
    return Motion(replace(body, offsets=offsets), size * moved.translation, rotations, fps), sizes


def worn(
    motion: Motion, sizes: dict[str, float], markers: MarkerSet, misplaced: float = 0.0, skin: float = 0.0
) -> Signal:
    """Where the markers of a set are, one for each place, off by a constant and a moving error, in metres."""
    rng = np.random.default_rng(1)
    places: dict[tuple[str, tuple[float, ...]], str] = {}
    for name, place in markers.places.items():
        places.setdefault((place.segment, tuple(place.at.tolist())), name)
    marks = [
        Landmark(motion.skeleton.index(segment), np.array(at) * sizes[segment.rpartition("_")[2]] + off)
        for (segment, at), off in zip(places, misplaced * rng.normal(0, 1, (len(places), 3)), strict=True)
    ]
    times = np.arange(len(motion))[:, None, None] / motion.fps
    shape = (1, len(marks), 3)
    waves = [np.sin(2 * np.pi * rng.uniform(0.3, 2, shape) * times + rng.uniform(0, 6, shape)) for _ in range(3)]
    moved: FloatArray = skin / np.sqrt(1.5) * np.sum(waves, axis=0)
    return Signal(landmark_positions(motion, marks) + moved, tuple(places.values()), "m", motion.fps)
