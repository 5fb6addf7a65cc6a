"""Tips of the last bones, which no marker shows: shares of the leg's length."""

from __future__ import annotations

import numpy as np

from kinetograph.roles import with_found_roles
from kinetograph.skeleton import Skeleton

_TIPS = {"toe": (0.0, 0.0, 0.06), "head": (0.0, 0.21, 0.0), "hand": (0.2, 0.0, 0.0)}  # of the leg's length; the left's


def with_tips(skeleton: Skeleton, leg: float) -> Skeleton:
    """A skeleton with the tips of its toes, head and hands as end sites, and with its roles; leg: metres."""
    tips = [(i, name) for i, name in enumerate(skeleton.names) if name.rpartition("_")[2] in _TIPS]
    ends = np.array([_TIPS[name.rpartition("_")[2]] for _, name in tips]).reshape(-1, 3) * leg
    ends[:, 0] *= [-1.0 if name.startswith("right") else 1.0 for _, name in tips]
    parents = np.array([i for i, _ in tips], dtype=np.int64)
    return with_found_roles(Skeleton(skeleton.names, skeleton.parents, skeleton.offsets, parents, ends))
