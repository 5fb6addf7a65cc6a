"""
Name the moves of a control
===========================

Where recordings have moves annotated, a control can be read by them: the best interpretation says which move is seen
when, and a second one, without that move, says how sure this is.
"""

import matplotlib.pyplot as plt

import kinetograph as kg
from clips import WALKS, clip, library, save_figure
from kinetograph.motion import repeat
from kinetograph.pipeline import winding_path

# %%
# Annotate
# --------
#
# An annotation of kind ``move`` is a name for an interval of a track. Here every clip, played several times, is one
# move. On the command line they come from a table: ``kinetograph library annotate walks --from moves.csv``.

named = library("named", ())
for name in WALKS:
    motion = repeat(clip(name), 4)
    move = "left" if "left" in name else "right" if "right" in name else "straight"
    annotation = kg.Annotation("motion", "move", move, 0.0, motion.duration)
    named.add(kg.Take(name, {"motion": motion}, (annotation,)), replace=True)

# %%
# Transcribe
# ----------

path = winding_path()
model = kg.PerformanceControl().fit(named)
moves = model.transcribe(path)
for move in moves:
    print(f"{move.start:5.2f} to {move.stop:5.2f} s: {move.move:8} (without it the cost is {move.margin:.0%} higher)")

# %%
# The path, coloured by what it was seen to be.

figure, axes = plt.subplots(figsize=(7, 6), layout="constrained")
colours = {"left": "#0072b2", "straight": "#777777", "right": "#d55e00"}
ground = path.values[:, 0][:, [0, 2]]
for move in moves:
    part = ground[round(move.start * path.fps) : round(move.stop * path.fps) + 1]
    axes.plot(*part.T, color=colours[move.move], linewidth=4)
for name, colour in colours.items():
    axes.plot([], [], color=colour, linewidth=4, label=name)
axes.set(aspect="equal", xlabel="x (m)", ylabel="z (m)", title="the moves of a path, from above")
axes.invert_yaxis()
axes.legend()
save_figure(figure, "transcribe.png")
