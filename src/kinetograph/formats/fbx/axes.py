"""The axes of an FBX file, which may point up, to the right and to the front in any way."""

from __future__ import annotations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.formats.fbx.scene import Scene

_DEFAULTS = {"CoordAxis": 0, "UpAxis": 1, "FrontAxis": 2}


def upright(scene: Scene) -> FloatArray:
    """The rotation that turns a scene's axes so that Y is up, shape ``(4,)``; notes are added to the scene's.

    Its right becomes X and its front Z. Where its axes are left-handed, or no axes, only its upward axis counts.
    """
    rows = []
    for key, default in _DEFAULTS.items():
        axis, sign = scene.setting(key, default), scene.setting(f"{key}Sign", 1)
        rows.append((-1.0 if sign < 0 else 1.0) * np.eye(3)[int(axis) if axis in (0, 1, 2) else default])
    axes = np.array(rows)
    turn = np.linalg.det(axes)
    if turn > 0.5:
        return rot.from_matrix(axes)
    if turn < -0.5:
        scene.notes.append("the file says that its axes are left-handed: nothing is mirrored; check left and right")
    up = rows[1]
    return rot.about("x", np.pi) if up[1] < -0.5 else rot.between(up, np.array([0.0, 1.0, 0.0]))
