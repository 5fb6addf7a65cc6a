"""A body whose joints are known, that moves, and wears Plug-in-Gait markers."""

from __future__ import annotations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.kinematics import landmark_positions
from kinetograph.motion import Motion
from kinetograph.signal import Signal
from kinetograph.skeleton import Landmark, Skeleton

# joint, parent, offset in metres in a T pose: left is +x, up +y, forward +z
_MIDDLE = (
    ("hips", "", (0.0, 0.0, 0.0)),
    ("spine", "hips", (0.0, 0.135, -0.02)),
    ("chest", "spine", (0.0, 0.25, 0.0)),
    ("neck", "chest", (0.0, 0.21, 0.02)),
    ("head", "neck", (0.0, 0.12, 0.01)),
)
_SIDE = (
    ("hip", "hips", (0.085, 0.0, 0.0)),
    ("knee", "hip", (0.0, -0.42, 0.0)),
    ("foot", "knee", (0.0, -0.42, 0.0)),
    ("collar", "chest", (0.03, 0.17, 0.08)),
    ("shoulder", "collar", (0.15, -0.03, -0.06)),
    ("elbow", "shoulder", (0.29, 0.0, 0.0)),
    ("hand", "elbow", (0.25, 0.0, 0.0)),
)
# the segment that a marker is on, and where; the left one of two, metres
_MARKERS = {
    "C7": ("chest", (0.0, 0.22, -0.06)),
    "T10": ("chest", (0.0, 0.0, -0.09)),
    "CLAV": ("chest", (0.0, 0.17, 0.10)),
    "STRN": ("chest", (0.0, 0.01, 0.12)),
    "RBAK": ("chest", (-0.09, 0.12, -0.10)),
    "ASI": ("hips", (0.125, 0.095, 0.05)),
    "PSI": ("hips", (0.05, 0.12, -0.14)),
    "THI": ("hip", (0.09, -0.25, 0.01)),
    "KNE": ("hip", (0.06, -0.42, 0.0)),
    "TIB": ("knee", (0.06, -0.2, 0.0)),
    "ANK": ("knee", (0.042, -0.42, 0.0)),
    "HEE": ("foot", (0.0, -0.055, -0.07)),
    "TOE": ("foot", (0.01, -0.055, 0.14)),
    "SHO": ("collar", (0.15, 0.03, -0.06)),
    "UPA": ("shoulder", (0.15, 0.05, 0.02)),
    "ELB": ("shoulder", (0.29, 0.045, 0.0)),
    "FRM": ("elbow", (0.12, 0.04, 0.0)),
    "WRA": ("elbow", (0.25, 0.0, 0.035)),
    "WRB": ("elbow", (0.25, 0.0, -0.035)),
    "FIN": ("hand", (0.08, 0.02, 0.0)),
    "FHD": ("head", (0.07, 0.09, 0.08)),
    "BHD": ("head", (0.07, 0.09, -0.10)),
}
# how far joints rotate about x, y and z of their segment, and about what middle, degrees; of the left one of two
_RANGE = {
    "hips": ((12, 60, 8), (0, 0, 0)),
    "spine": ((12, 10, 8), (0, 0, 0)),
    "chest": ((10, 10, 8), (0, 0, 0)),
    "neck": ((12, 15, 8), (0, 0, 0)),
    "head": ((12, 15, 8), (0, 0, 0)),
    "hip": ((35, 10, 10), (-15, 0, 0)),
    "knee": ((40, 0, 0), (42, 0, 0)),
    "foot": ((20, 8, 5), (0, 0, 0)),
    "collar": ((0, 6, 6), (0, 0, 0)),
    "shoulder": ((25, 30, 30), (0, 0, -50)),
    "elbow": ((35, 45, 0), (0, -55, 0)),
    "hand": ((0, 15, 25), (0, 0, 0)),
}


def actor(seconds: float = 8.0, fps: float = 50.0, seed: int = 1) -> Motion:
    """A body that moves all its joints smoothly, as far as people do."""
    rng = np.random.default_rng(seed)
    skeleton = _skeleton()
    times = np.arange(int(seconds * fps)) / fps
    rotations = []
    for name in skeleton.names:
        side, _, part = name.rpartition("_")
        reach, middle = _RANGE[part]
        rates, phases = rng.uniform(0.25, 0.6, 3), rng.uniform(0, 2 * np.pi, 3)
        angles = np.array(middle) + np.array(reach) * np.sin(2 * np.pi * rates * times[:, None] + phases)
        mirrored = np.array([1, -1, -1]) if side == "right" else 1
        # the rotation about x innermost: forearms rotate about themselves, not elbows about the upper arm
        rotations.append(rot.from_euler(np.radians(angles * mirrored)[:, ::-1], "zyx"))
    path = np.stack([0.4 * np.sin(0.7 * times), 0.92 + 0.04 * np.sin(3 * times), 0.3 * times], axis=1)
    return Motion(skeleton, path, np.stack(rotations, axis=1), fps)


def markers(motion: Motion, prefix: str = "", shift: dict[str, FloatArray] | None = None) -> Signal:
    """Where the markers of the set are; shift: metres by which some are put elsewhere on their segments."""
    names, marks = [], []
    for name, (segment, place) in _MARKERS.items():
        single = name in ("C7", "T10", "CLAV", "STRN", "RBAK")
        for side, sign in (("", 1.0),) if single else (("left", 1.0), ("right", -1.0)):
            full = name if single else side[0].upper() + name
            joint = segment if segment in ("hips", "chest", "head") else f"{side}_{segment}"
            offset = np.array(place) * [sign, 1, 1] + (shift or {}).get(full, 0.0)
            names.append(prefix + full)
            marks.append(Landmark(motion.skeleton.index(joint), offset))
    return Signal(landmark_positions(motion, marks), tuple(names), "m", motion.fps)


def _skeleton() -> Skeleton:
    rows = [(name, parent, np.array(offset)) for name, parent, offset in _MIDDLE]
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for name, parent, offset in _SIDE:
            above = parent if parent in ("hips", "chest") else f"{side}_{parent}"
            rows.append((f"{side}_{name}", above, np.array(offset) * [sign, 1, 1]))
    names = [name for name, _, _ in rows]
    parents = np.array([names.index(parent) if parent else -1 for _, parent, _ in rows])
    return Skeleton(tuple(names), parents, np.array([offset for _, _, offset in rows]))
