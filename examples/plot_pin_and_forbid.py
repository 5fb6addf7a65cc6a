"""
Pin and forbid pieces
=====================

A result is rarely right at once. A rule says which recordings may be used during a part of the control, and which may
not; the rest is solved anew around it.
"""

import matplotlib.pyplot as plt

import kinetograph as kg
from clips import draw_pieces, save_figure, walks
from kinetograph.methods.performance import Rule
from kinetograph.pipeline import winding_path

path = winding_path()
model = kg.PerformanceControl(mirror=True).fit(walks())
free = model.synthesize(path)

# %%
# Two rules
# ---------
#
# From 4 to 6 seconds, only pieces of ``humanoid3d_walk``; from 9 to 13 seconds, nothing of ``turn_left0``. On the
# command line these are ``--pin humanoid3d_walk@4-6`` and ``--forbid turn_left0@9-13``.

rules = (
    Rule(4.0, 6.0, take="humanoid3d_walk"),
    Rule(9.0, 13.0, take="turn_left0", forbid=True),
)
ruled = model.synthesize(path, rules=rules)
print(f"score without rules {free.cost:.4f}, with them {ruled.cost:.4f}")

# %%
# Which recording is used when; mirrored ones are hatched. A rule costs what the score shows: the free answer is the
# optimum.

takes = sorted({piece.take for result in (free, ruled) for piece in result.pieces})
figure, rows = plt.subplots(2, 1, figsize=(10, 4), sharex=True, layout="constrained")
for axes, result, title in zip(rows, (free, ruled), ("free", "with rules"), strict=True):
    draw_pieces(axes, result, takes)
    axes.set_title(title, loc="left")
rows[1].axvspan(4, 6, color="green", alpha=0.15)
rows[1].axvspan(9, 13, color="red", alpha=0.12)
rows[1].set_xlabel("seconds")
save_figure(figure, "pin_and_forbid.png")
