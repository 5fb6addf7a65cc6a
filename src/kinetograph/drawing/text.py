"""Stick figures in a terminal, drawn with braille patterns: two dots by four in a letter."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.kinematics import joint_positions, on_ground
from kinetograph.motion import Motion, sample

_DOTS = np.array([[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]])
_ALONG = np.linspace(0.0, 1.0, 24)


def bones_over_time(motions: Sequence[Motion], rate: float) -> FloatArray:
    """Both ends of every bone of synchronised characters over time.

    Parameters
    ----------
    motions : sequence of Motion
    rate : float
        Frames per second.

    Returns
    -------
    ndarray, shape (F, B, 2, 3)
        Metres. The characters are moved together so that their mean root is above the origin in every frame.
    """
    seconds = np.arange(int(max(m.duration for m in motions) * rate) + 1) / rate
    bones, roots = [], []
    for motion in motions:
        joints = joint_positions(sample(motion, np.minimum(seconds, motion.duration), rate))
        parents = motion.skeleton.parents
        bones.append(np.stack([joints[:, 1:], joints[:, parents[1:]]], axis=2))
        roots.append(joints[:, 0])
    middle = on_ground(np.mean(roots, axis=0))
    return np.asarray(np.concatenate(bones, axis=1) - middle[:, None, None])


def draw_bones(bones: FloatArray, width: int = 48, height: int = 14, metres: float = 2.1) -> tuple[str, ...]:
    """Bones seen along -z, as lines of braille letters.

    Parameters
    ----------
    bones : ndarray, shape (B, 2, 3)
        Both ends of each bone, metres.
    width, height : int
        Letters.
    metres : float
        What ``height`` letters show, from the ground up.

    Returns
    -------
    tuple of str
        The lines, from the top.

    Examples
    --------
    >>> draw_bones(np.array([[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]), width=2, height=2, metres=1.0)
    ('⠀⡇', '⠀⡇')
    """
    scale = 4 * height / metres
    points = bones[:, 0, None] * (1 - _ALONG[:, None]) + bones[:, 1, None] * _ALONG[:, None]
    column = np.floor(points[..., 0] * scale).astype(np.int64) + width
    row = 4 * height - 1 - np.floor(points[..., 1] * scale).astype(np.int64)
    seen = (column >= 0) & (column < 2 * width) & (row >= 0) & (row < 4 * height)
    cells = np.zeros((height, width), dtype=np.int64)
    column, row = column[seen], row[seen]
    np.bitwise_or.at(cells, (row // 4, column // 2), _DOTS[row % 4, column % 2])
    return tuple("".join(chr(0x2800 + cell) for cell in line) for line in cells)
