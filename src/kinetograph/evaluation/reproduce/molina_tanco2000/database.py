"""The recordings that are used instead of the paper's, and keys in them."""

from __future__ import annotations

from pathlib import Path

from kinetograph import samples
from kinetograph.formats import load
from kinetograph.keys import Key, key_at
from kinetograph.library import Library
from kinetograph.motion import Motion, cut
from kinetograph.take import Take

ACTIONS = (("111_06", 240, 381), ("09_01", 0, 37), ("77_10", 180, 345), ("02_01", 0, 86))
"""Files of data/actions and their frames: standing up, running, setting off into a run, walking; 429 frames."""
CLIPS = (
    *("humanoid3d_getup_facedown", "humanoid3d_run", "humanoid3d_getup_faceup"),
    *("humanoid3d_walk", "humanoid3d_jump", "0walk_forward"),
)
"""Clips of the sample that are used where there are no such files."""
FOLDERS = ("actions", "corpus")
"""Folders of the recordings of the next stage."""
LONGEST = 15.0
"""Seconds of a recording that counts as one action."""


def takes(data: Path | None) -> list[Take]:
    """The database of section 4: `ACTIONS` of a folder of recordings, or `CLIPS`."""
    if data is not None:
        motions = [(name, load(data / "actions" / f"{name}.bvh").motion(), a, b) for name, a, b in ACTIONS]
        return [Take(name, {"motion": cut(motion, a, b)}) for name, motion, a, b in motions]
    clips = samples.where("deepmimic-clips") or samples.fetch("deepmimic-clips")
    loaded = [(name, load(clips / f"{name}.txt")) for name in CLIPS]
    return [Take(name.removeprefix("humanoid3d_"), take.tracks, take.annotations) for name, take in loaded]


def actions(data: Path) -> list[tuple[str, Motion]]:
    """All recordings of one action, whole, of the folders of recordings, with names."""
    named: dict[str, Motion] = {}
    for folder in FOLDERS:
        for file in sorted((data / folder).rglob("*.bvh")):
            motion = load(file, up="z").motion()
            if motion.duration <= LONGEST:
                named.setdefault(file.stem.removesuffix("_poses"), motion)
    return list(named.items())


def key_within(library: Library, name: str, share: float) -> Key:
    """The frame of a take at a share of its duration, 0 to 1."""
    motion = library.take(name).motion()
    return key_at(motion, round(share * (len(motion) - 1)) / motion.fps, label=name)
