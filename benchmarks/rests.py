"""Retargeting from and onto other rest poses of the same motion: ``python -m benchmarks rests``.

Recordings whose rest pose stands are given rest poses in which nobody stands, by rotating the frames of their joints at
random; the motion in the world stays. Printed is how far joints of the retargeted motion are from those with the
recording's own rest pose. Settings were chosen on `CHOSEN_ON`.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks._recordings import data_folder
from kinetograph import rotations as rot
from kinetograph.formats import load
from kinetograph.kinematics import joint_positions
from kinetograph.motion import Motion, cut
from kinetograph.post import retarget
from kinetograph.stance import find_stance

CHOSEN_ON = (
    "walks/15_01.bvh",
    "salsa/Easy_01_leader.bvh",
    "walks/humanoid3d_long_walk1.txt",
    "acclaim/16_12.amc",
    "actions/35_01.bvh",
    "fbx/135_01.fbx",
    "actions/humanoid3d_run.txt",
)
OTHERS = (
    "walks/15_03.bvh",
    "walks/15_09.bvh",
    "actions/77_10.bvh",
    "actions/127_06.bvh",
    "sports/06_14_amass30.bvh",
    "acclaim/16_17.amc",
    "acclaim/16_24.amc",
    "salsa/Medium_01_follower.bvh",
    "salsa/move_03_03_leader.bvh",
    "walks/humanoid3d_long_walk2.txt",
    "walks/humanoid3d_long_walk3.txt",
    "actions/humanoid3d_walk.txt",
)
PARTNERS = ("actions/humanoid3d_walk.txt", "salsa/Easy_01_follower.bvh", "walks/15_01.bvh")
FRAMES, LOOKED_AT = 600, 4000


def scrambled(motion: Motion, seed: int = 1) -> Motion:
    """The same motion in the world, with random frames of its joints, and the stance that is found."""
    skeleton = motion.skeleton
    frames = rot.normalize(np.random.default_rng(seed).normal(size=(len(skeleton), 4)))
    above = np.concatenate([rot.identity(1), frames[skeleton.parents[1:]]])
    roles = {role: replace(p, offset=rot.rotate(frames[p.joint], p.offset)) for role, p in skeleton.roles.items()}
    ends = rot.rotate(frames[skeleton.end_parents], skeleton.end_offsets)
    changed = replace(skeleton, offsets=rot.rotate(above, skeleton.offsets), end_offsets=ends, roles=roles)
    local = rot.multiply(rot.multiply(above, motion.rotations), rot.conjugate(frames))
    bones = None if motion.bones is None else rot.rotate(above, motion.bones)
    out = replace(motion, skeleton=changed, rotations=local, bones=bones)
    found = find_stance(out)
    assert found is not None
    return replace(out, skeleton=replace(changed, stance=found.rotations))


def gaps(motion: Motion, other: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Centimetres, ``(F, J)``, that joints are off: with the motion as the source, and with its body as the target."""
    changed = scrambled(motion)
    stop = min(FRAMES, len(motion))
    pairs = [
        [retarget(cut(m, 0, stop), other.skeleton).motion for m in (motion, changed)],
        [retarget(other, m.skeleton).motion for m in (motion, changed)],
    ]
    source, target = (100 * np.linalg.norm(joint_positions(a) - joint_positions(b), axis=-1) for a, b in pairs)
    return source, target


def _motion(path: Path, frames: int) -> Motion:
    motion = load(path).motion()
    return cut(motion, 0, min(frames, len(motion)))


def main() -> None:
    data = data_folder()
    if data is None:
        print("no recordings: set KINETOGRAPH_DATA to a folder that holds walks/, salsa/, acclaim/, ...")
        return
    others = [_motion(data / path, 200) for path in PARTNERS]
    for title, takes in (("settings were chosen on", CHOSEN_ON), ("others", OTHERS)):
        print(f"{title:34s} {'source, median':>15s} {'most':>6s} {'target, median':>15s} {'most':>6s}   cm")
        medians = []
        for path in takes:
            found = [gaps(_motion(data / path, LOOKED_AT), other) for other in others]
            source, target = (np.concatenate([pair[i].ravel() for pair in found]) for i in (0, 1))
            medians.append((np.median(source), np.median(target)))
            row = f"{np.median(source):15.2f} {source.max():6.1f} {np.median(target):15.2f} {target.max():6.1f}"
            print(f"  {path:32s} {row}")
        a, b = np.median(np.array(medians), axis=0)
        print(f"  {'median':32s} {a:15.2f} {'':6s} {b:15.2f}")
