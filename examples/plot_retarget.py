"""
Retarget to another skeleton
============================

Joints are paired by their roles, so that a motion goes onto any skeleton whose hips, knees and elbows are known. The
hips' height and path are scaled by the legs, and planted feet stay planted.
"""

from dataclasses import replace

import numpy as np

from clips import clip, picture
from kinetograph.drawing import strobe
from kinetograph.kinematics import role_positions
from kinetograph.motion import place, repeat
from kinetograph.post import retarget
from kinetograph.segmentation import detect_contacts
from kinetograph.skeleton import Skeleton

# %%
# A child's skeleton
# ------------------
#
# Bones of the clip's skeleton made shorter, the legs more than the rest. Any other skeleton will do: that of a file, or
# of the sample ``character``.

walk = repeat(clip("0walk_forward"), 3)
adult = walk.skeleton


def shrunk(skeleton: Skeleton, trunk: float, legs: float) -> Skeleton:
    """The skeleton with other lengths of its bones."""
    share = np.full((len(skeleton), 1), trunk)
    for side in ("left", "right"):
        for role in ("knee", "foot"):
            share[skeleton.roles[f"{side}_{role}"].joint] = legs
    roles = {
        name: replace(mark, offset=np.asarray(mark.offset) * (legs if "toe" in name else trunk))
        for name, mark in skeleton.roles.items()
    }
    return replace(skeleton, offsets=skeleton.offsets * share, end_offsets=skeleton.end_offsets * trunk, roles=roles)


child = shrunk(adult, 0.72, 0.6)
made = retarget(walk, child)
print(f"the path is scaled by {made.scale:.2f}")
strobe([walk, place(made.motion, 0.0, (0.9, 0.0, 0.0))], picture("retarget.png"), title="a walk, and a child's")

# %%
# Feet that stand
# ---------------
#
# How fast a foot moves while it is planted, in the source and in the result on its scale:

contacts = [note for note in detect_contacts(walk, track="motion") if note.label in ("left_foot", "right_foot")]
for name, motion, scale in (("source", walk, 1.0), ("child", made.motion, made.scale)):
    speeds = []
    for note in contacts:
        first, last = round(note.start * motion.fps), round(note.stop * motion.fps)
        ankle = role_positions(motion, (note.label,))[first : last + 1, 0]
        speeds.append(np.linalg.norm(np.diff(ankle, axis=0), axis=1) * motion.fps / scale)
    print(f"{name}: {np.concatenate(speeds).mean():.3f} m/s on the scale of the source")
