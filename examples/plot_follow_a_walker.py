"""
Follow another walker
=====================

The control may be a motion: its hips on the ground are followed, the way they sway and turn with every step included.
Here one clip is left out of the library, repeated to a longer walk, and followed by the other clips.
"""

import matplotlib.pyplot as plt
import numpy as np

import kinetograph as kg
from clips import picture, save_figure, walks
from kinetograph.drawing import strobe
from kinetograph.kinematics import joint_positions
from kinetograph.motion import place, repeat, resample

# %%
# Leave it out
# ------------
#
# ``exclude`` leaves takes out of the library by name; a name that the library does not have is refused.

library = walks()
walker = repeat(library.take("turn_left0").motion(), 4)
model = kg.PerformanceControl(mirror=True).fit(library, exclude=("turn_left0",))
result = model.synthesize(walker)
strobe(
    [resample(walker, 30.0), place(result.motion, 0.0, (0.0, 0.0, 1.2))],
    picture("follow_a_walker.png"),
    title="the walker (grey), and the follower (brown), moved aside",
)

# %%
# How close
# ---------
#
# The hands and feet of the walker are no part of the control. The hips alone give much of the gait: its phase, its
# speed and its turns.

reference = resample(walker, result.motion.fps)
frames = min(len(reference), len(result.motion))
apart = 100 * (joint_positions(result.motion)[:frames] - joint_positions(reference)[:frames])
hips = np.linalg.norm(apart[:, 0, [0, 2]], axis=-1)
joints = np.linalg.norm(apart, axis=-1).mean(axis=1)
seconds = np.arange(frames) / result.motion.fps

figure, axes = plt.subplots(figsize=(9, 3), layout="constrained")
axes.plot(seconds, joints, label="all joints, mean")
axes.plot(seconds, hips, label="hips on the ground")
axes.set(xlabel="seconds", ylabel="cm", title="distance between the walker and the follower")
axes.legend()
save_figure(figure, "follow_a_walker_distance.png")
print(f"hips: {hips.mean():.1f} cm, all joints: {joints.mean():.1f} cm")
