"""Two people of one build who step to and fro hand in hand, each take in a way of its own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import kinetograph as kg
from bodies import person, walk
from kinetograph import rotations as rot
from kinetograph.motion import Motion
from kinetograph.take import Annotation, Take

SECONDS, BEAT = 6.0, 0.5
TAKES = {"slow": 0.7, "even": 1.0, "quick": 1.3}
"""Takes, and how often a second the couple goes to and fro."""


def couple(often: float, seconds: float = SECONDS, apart: float = 0.9) -> tuple[Motion, Motion]:
    """A leader who goes to and fro along z, and a follower who faces him and goes with him."""
    step = walk(person(), frames=round(30 * seconds) + 1)
    times = np.arange(len(step)) / step.fps
    path = 0.3 * np.sin(2 * np.pi * often * times / 2) * np.array([[0.0], [0.0], [1.0]])
    leader = replace(step, translation=step.translation + path.T)
    rotations = step.rotations.copy()
    rotations[:, 0] = rot.about("y", np.full(len(times), np.pi))
    place = step.translation + path.T + [0.0, 0.0, apart]
    return leader, replace(step, translation=place, rotations=rotations)


def dance(name: str, often: float) -> Take:
    """A take of a couple, cut at every beat, with its moves and a handhold."""
    leader, follower = couple(often)
    beats = np.arange(round(SECONDS / BEAT) + 1) * BEAT
    cuts = [Annotation("follower", "cut", "", t, t) for t in beats]
    names = ("open step open", "open inside turn open")
    moves = [Annotation("follower", "move", names[int(t) % 2], t, t + 1.0) for t in beats[:-1:2]]
    hold = Annotation("follower", "handhold", "left_hand:right_hand", 1.0, 4.0)
    return Take(name, {"leader": leader, "follower": follower}, (*cuts, *moves, hold))


def dances(folder: Path) -> kg.Library:
    """A library of couples."""
    library = kg.Library.create(folder)
    for name, often in TAKES.items():
        library.add(dance(name, often))
    return library
