"""
Where every frame comes from
============================

A result says of every frame which recording it is from, at which second, what share of the frame that recording has
where two are blended, and how far editing has moved it.
"""

import matplotlib.pyplot as plt
import numpy as np

import kinetograph as kg
from clips import rises, save_figure, walks
from kinetograph.keys import key_at
from kinetograph.pipeline import winding_path

walk = kg.PerformanceControl(mirror=True).fit(walks()).synthesize(winding_path())

# %%
# Frame by frame
# --------------

sources = walk.provenance()
for frame in (0, 100, 200, 300):
    take, second = sources[frame]
    print(f"frame {frame:3}: {take} at {second:.2f} s")

# %%
# The second of the recording over the second of the result: a line for every piece, whose slope is the stretch. Looping
# clips run on past their end, cycle after cycle.

takes = sorted({take for take, _ in sources})
seconds = np.arange(len(sources)) / walk.motion.fps
figure, axes = plt.subplots(figsize=(10, 3.6), layout="constrained")
for i, take in enumerate(takes):
    mine = np.array([second if name == take else np.nan for name, second in sources])
    axes.plot(seconds, mine, color=f"C{i}", linewidth=2, label=take)
axes.set(xlabel="seconds of the result", ylabel="seconds of the recording", title="where every frame comes from")
axes.legend(fontsize=8, ncols=3)
save_figure(figure, "provenance.png")

# %%
# Edited frames
# -------------
#
# Keyframe control also says how far each frame is from the recording it came from: poses that are met, feet that are
# held.

library = rises()
lying, running = (library.take(f"humanoid3d_{name}").motion() for name in ("getup_facedown", "run"))
rise = kg.KeyframeControl().fit(library).synthesize((key_at(lying, 0.0), key_at(running, 0.4, time=(5.0, 5.0))))
figure, axes = plt.subplots(figsize=(10, 2.6), layout="constrained")
axes.fill_between(np.arange(len(rise.edited)) / rise.motion.fps, 100 * rise.edited, color="#0072b2", alpha=0.6)
for piece in rise.pieces[1:]:
    axes.axvline(piece.start, color="#c2185b", linewidth=1, linestyle="--")
axes.set(xlabel="seconds", ylabel="cm", title="how far a frame was edited (dashed: seams)")
save_figure(figure, "provenance_edited.png")
