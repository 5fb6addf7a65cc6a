"""Dances that a library does not have: torsos in one another, facings, toes, and whether it is said.

On data/salsa: every dance after the six others, and the hard ones after the three easy ones.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from benchmarks._recordings import data_folder
from benchmarks.dance import dances
from kinetograph.evaluation.metrics import contact_speed, low_toe_speed, position_errors
from kinetograph.kinematics import joint_positions
from kinetograph.library import Library
from kinetograph.methods.performance import partner_control
from kinetograph.motion import Motion, cut, resample
from kinetograph.post import contacts_of, overlaps, torso_of
from kinetograph.post.turning import facings
from kinetograph.segmentation import detect_contacts

_DEEP = 0.08
_WRONG = np.deg2rad(60.0)


def main() -> None:
    folder = data_folder()
    if folder is None or not (folder / "salsa").is_dir():
        print("no dances: set KINETOGRAPH_DATA to a folder that holds salsa/")
        return
    with tempfile.TemporaryDirectory() as scratch:
        library = dances(folder / "salsa", Path(scratch) / "dances")
        names = library.names()
        hard = tuple(name for name in names if not name.startswith("Easy"))
        _table("after the six other dances", library, {name: (name,) for name in names})
        _table("after the easy dances", library, dict.fromkeys(hard, hard))


def _table(title: str, library: Library, left_out: dict[str, tuple[str, ...]]) -> None:
    """``left_out``: by dance, the takes that the library does without."""
    print(f"{title:27s} joints   relative   overlap > 8 cm   deepest (recorded)   facing wrong   toes, times recorded")
    rows = [_row(library, name, without) for name, without in left_out.items()]
    for name, row in zip([*left_out, "mean"], [*rows, [*np.mean([r[:7] for r in rows], axis=0), ""]], strict=True):
        joints, relative, deep, deepest, recorded, wrong, toes, warns = row
        print(
            f"   {name:22s} {joints:5.1f} cm {relative:7.1f} cm {deep:12.2f} % {deepest:9.1f} ({recorded:5.1f}) cm"
            f" {wrong:13.1f} % {toes:15.2f}   {warns}"
        )


def _row(library: Library, name: str, without: tuple[str, ...]) -> list[float | str]:
    take = library.take(name)
    leader, follower = take.motion("leader"), take.motion("follower")
    result = partner_control().fit(library, exclude=without, track="follower").synthesize(leader)
    made = resample(result.motion, follower.fps)
    frames = min(len(made), len(follower), len(leader))
    made, real, lead = (cut(motion, 0, frames) for motion in (made, follower, leader))
    absolute, relative = position_errors(joint_positions(made), joint_positions(real))
    deep, recorded = overlaps(torso_of(made), torso_of(lead)), overlaps(torso_of(real), torso_of(lead))
    warns = any("nothing like" in warning for warning in result.warnings)
    return [
        *(100 * absolute, 100 * relative, 100 * float((deep > _DEEP).mean())),
        *(100 * float(deep.max()), 100 * float(recorded.max()), 100 * _facing_wrong(made, real)),
        max(low_toe_speed(made) / low_toe_speed(real), _planted(result.motion, result.annotations) / _planted(real)),
        "warns" if warns else "",
    ]


def _facing_wrong(made: Motion, real: Motion) -> float:
    apart = (facings(made) - facings(real) + np.pi) % (2 * np.pi) - np.pi
    return float((np.abs(apart) > _WRONG).mean())


def _planted(motion: Motion, annotations: tuple | None = None) -> float:
    return contact_speed(motion, detect_contacts(motion) if annotations is None else contacts_of(annotations))
