"""
Hold a span and solve around it
===============================

A part of a result is right, the rest is not: the good span is held, frame by frame, and what is before and after
it is made anew.
"""

import matplotlib.pyplot as plt
import numpy as np

import kinetograph as kg
from clips import picture, rises, save_figure
from kinetograph.drawing import contact_sheet
from kinetograph.keys import key_at
from kinetograph.kinematics import joint_positions

HELD = 2.5  # seconds

library = rises()
lying, running, jumping = (library.take(f"humanoid3d_{name}").motion() for name in ("getup_facedown", "run", "jump"))
model = kg.KeyframeControl().fit(library)
before = model.synthesize((key_at(lying, 0.0), key_at(running, 0.4, time=(6.0, 6.0))))

# %%
# Hold the first two and a half seconds, in which the person gets up; afterwards, jump instead of running. Around a
# held span every key has a time, on the clock of the result.

after = model.synthesize_around(before, (0.0, HELD), (key_at(jumping, 1.0, time=(7.0, 7.0)),))
contact_sheet(after.motion, picture("hold_a_span.png"), title=f"held until {HELD:g} s, new from there", frames=16)

# %%
# The held frames are the same.

frames = min(len(before.motion), len(after.motion))
apart = np.linalg.norm(joint_positions(after.motion)[:frames] - joint_positions(before.motion)[:frames], axis=-1)
figure, axes = plt.subplots(figsize=(9, 2.6), layout="constrained")
axes.plot(np.arange(frames) / after.motion.fps, 100 * apart.mean(axis=1))
axes.axvspan(0, HELD, color="green", alpha=0.15, label="held")
axes.set(xlabel="seconds", ylabel="cm", title="mean joint distance between the two results")
axes.legend()
save_figure(figure, "hold_a_span_difference.png")
print(f"in the held span: {100 * apart[: round(HELD * after.motion.fps)].max():.6f} cm at most")
for result in (before, after):
    print(" -> ".join(piece.take.removeprefix("humanoid3d_") for piece in result.pieces))
