"""HumanML3D's features of a frame, and the positions of joints that they hold.

A frame has the root's angular velocity about the vertical, its velocity along the floor's x and z in its own heading,
its height, and the other joints' positions relative to the root in that heading; rotations, velocities and contacts
follow, which repeat this and are not read. The angle is half of the heading's, as in the quaternions that it was taken
from. Velocities lead from a frame to the next.
"""

from __future__ import annotations

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray

WIDTHS = {263: 22, 251: 21}
"""Numbers in a frame, and the joints that they are of."""


def positions_of_features(features: FloatArray) -> FloatArray:
    """Positions of the joints in the world.

    Parameters
    ----------
    features : ndarray, shape (F, 263) or (F, 251)

    Returns
    -------
    ndarray, shape (F, 22, 3) or (F, 21, 3)
        Y up, the root's first frame at x = z = 0.
    """
    joints = WIDTHS[features.shape[1]]
    half = np.concatenate([[0.0], np.cumsum(features[:-1, 0])])
    # the features hold what takes the world to the heading: the inverse brings it back
    heading = rot.about("y", -2.0 * half)
    steps = np.zeros((len(features), 3))
    steps[1:, [0, 2]] = features[:-1, 1:3]
    root = np.cumsum(rot.rotate(heading, steps), axis=0)
    root[:, 1] = features[:, 3]
    local = features[:, 4 : 4 + 3 * (joints - 1)].reshape(len(features), joints - 1, 3)
    others = rot.rotate(heading[:, None], local)
    others[..., [0, 2]] += root[:, None, [0, 2]]
    return np.concatenate([root[:, None], others], axis=1)
