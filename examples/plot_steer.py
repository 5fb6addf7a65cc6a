"""
Steer a body by a stick
=======================

A body follows a stick frame by frame: every tenth of a second it is planned 1.5 s ahead over single frames of the
recordings, and what is played is joined, corrected towards the path that is wished, and kept from sliding on its
planted feet.
"""

import matplotlib.pyplot as plt
import numpy as np

import kinetograph as kg
from clips import OUT, save_figure, walks

model = kg.PerformanceControl(mirror=True).fit(walks())
steering = model.steer()

# %%
# The stick is a velocity along the ground, x and z in metres per second. Without a facing the body faces where it goes.

FPS = 60.0
STICK = [((0.0, 0.9), 3.0), ((0.7, 0.5), 3.0), ((0.0, 0.9), 2.0), ((-0.7, 0.5), 3.0)]
poses, wished = [], []
for velocity, seconds in STICK:
    for _ in range(round(seconds * FPS)):
        poses.append(steering.step(velocity, None, 1 / FPS))
        wished.append((steering.path.place.imag, steering.path.place.real))

# %%
# The poses make a motion; a live session sends them on one by one instead.

skeleton = steering.frames.repertoire.skeleton
motion = kg.Motion(skeleton, np.stack([p.translation for p in poses]), np.stack([p.rotations for p in poses]), FPS)
kg.save(motion, OUT / "steered.bvh", force=True)
places = motion.translation[:, [0, 2]]
away = np.linalg.norm(places - wished, axis=1)
print(f"{steering.jumps} jumps in {motion.duration:.0f} s; {100 * away.mean():.1f} cm from the wished path on average")

figure, axes = plt.subplots(figsize=(5, 6), layout="constrained")
axes.plot(*np.array(wished).T, color="0.7", linewidth=5, label="wished")
axes.plot(*places.T, color="C0", label="the hips")
axes.set(xlabel="x (m)", ylabel="z (m)", aspect="equal")
axes.legend()
save_figure(figure, "steer.png")
