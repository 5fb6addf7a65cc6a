"""What the studio makes of a drawn path, small enough for tests."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import kinetograph as kg
from kinetograph.studio.made import Made
from kinetograph.studio.project import Project, Walk
from kinetograph.studio.room import Room
from kinetograph.studio.walk.making import make
from kinetograph.synthesis import Piece, Synthesis
from kinetograph.take import Annotation, Take
from walkers import walk

PATH = tuple((t / 10, 0.02 * t, 0.1 * t) for t in range(41))


def quiet(done: float, total: float) -> None:
    """Nobody watches."""


def walked(folder: Path) -> tuple[Made, Project]:
    """What is walked along a path, and the project of it."""
    library = kg.Library.create(folder / "walks")
    for name, turn in (("straight", 0.0), ("left", 0.6), ("right", -0.6)):
        cuts = tuple(Annotation("motion", "cut", "", t, t) for t in np.arange(13) / 2)
        library.add(Take(name, {"motion": walk(6.0, turn_rate=turn)}, cuts))
    project = Project(libraries={"walks": "walks"}, walk=Walk(path=PATH))
    made = make(project, Room(folder), quiet)
    assert made is not None
    return made, project


def stood(seconds: float = 1.0) -> Made:
    """A short walk that takes no search."""
    motion = walk(seconds)
    return Made((Synthesis(motion, (Piece("t", "m", 0, motion.duration, 0, motion.duration),), 1.0),))
