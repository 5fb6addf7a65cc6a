"""Small libraries to attack: several states of one, another one, and whether takes are the same."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.library import Library
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.skeleton import Landmark, Skeleton
from kinetograph.take import Annotation, Take


def skeleton_of(size: float) -> Skeleton:
    names = ("hips", "chest", "head", "left_foot")
    offsets = np.array([[0, 1.0, 0], [0, 0.3, 0], [0, 0.25, 0], [0.1, -0.9, 0]]) * size
    return Skeleton(names, np.array([-1, 0, 1, 0]), offsets, roles={"head": Landmark(2, np.zeros(3))})


def take_of(name: str, seed: int, size: float = 1.0) -> Take:
    """A take of a motion, or of a motion and markers, with annotations."""
    rng = np.random.default_rng(seed)
    frames = int(rng.integers(8, 60))
    rotations = rot.normalize(rng.normal(size=(frames, 4, 4)))
    bones = rng.normal(size=(frames, 4, 3)) if seed % 3 == 0 else None
    tracks: dict[str, Motion | Signal] = {
        "motion": Motion(skeleton_of(size), rng.normal(size=(frames, 3)), rotations, 30.0, bones)
    }
    if seed % 2:
        valid = rng.random((frames, 2)) > 0.2
        tracks["markers"] = Signal(rng.normal(size=(frames, 2, 3)), ("a", "b"), "m", 60.0, valid)
    notes = tuple(Annotation("motion", "cut", "footplants", float(t), float(t)) for t in rng.random(5))
    return Take(name, tracks, notes)


def same(a: Take, b: Take) -> bool:
    """Whether two takes are equal to the last bit."""
    if a.name != b.name or list(a.tracks) != list(b.tracks) or a.annotations != b.annotations:
        return False
    return all(_same_track(a.tracks[name], b.tracks[name]) for name in a.tracks)


def _same_track(a: Motion | Signal, b: Motion | Signal) -> bool:
    if isinstance(a, Signal) or isinstance(b, Signal):
        return (
            isinstance(a, Signal)
            and isinstance(b, Signal)
            and (a.names, a.units, a.fps) == (b.names, b.units, b.fps)
            and _equal(a, b, "values", "valid")
        )
    if a.fps != b.fps or not _equal(a, b, "translation", "rotations") or (a.bones is None) != (b.bones is None):
        return False
    if a.bones is not None and not _equal(a, b, "bones"):
        return False
    s, t = a.skeleton, b.skeleton
    roles = [[(role, p.joint, *p.offset) for role, p in one.roles.items()] for one in (s, t)]
    return s.names == t.names and _equal(s, t, "parents", "offsets", "end_offsets") and roles[0] == roles[1]


def _equal(a: object, b: object, *names: str) -> bool:
    return all(np.array_equal(getattr(a, name), getattr(b, name), equal_nan=True) for name in names)


@dataclass(frozen=True)
class Libraries:
    """Folders of one library's states, the last of which is now, and of another library; and their takes."""

    states: tuple[Path, ...]
    other: Path
    takes: tuple[dict[str, Take], ...]

    @property
    def now(self) -> Path:
        return self.states[-1]

    @property
    def truth(self) -> dict[str, Take]:
        return self.takes[-1]

    def versions(self, name: str) -> list[Take]:
        """What a take has been at any time."""
        return [takes[name] for takes in self.takes if name in takes]


def make(folder: Path) -> Libraries:
    """A library that grew, was annotated, lost a take and got others; and one of other takes with the same names."""
    live = Library.create(folder / "live")
    states: list[Path] = []
    takes: list[dict[str, Take]] = []

    def keep() -> None:
        states.append(folder / f"state-{len(states)}")
        shutil.copytree(live.path, states[-1])
        takes.append({name: live.take(name) for name in live.names()})

    for seed in (1, 2, 3):
        live.add(take_of(f"take{seed}", seed))
    keep()
    live.annotate("take1", [Annotation("motion", "move", "turn", 0.0, 0.1)])
    keep()
    live.add(take_of("take4", 4, 1.1))
    keep()
    live.remove("take2")
    keep()
    live.add(take_of("take5", 5))
    live.add(take_of("take3", 33, 1.1), replace=True)
    keep()
    other = Library.create(folder / "other")
    for seed in (1, 2, 3, 4):
        other.add(take_of(f"take{seed}", 100 + seed, 0.9))
    return Libraries(tuple(states), other.path, tuple(takes))
