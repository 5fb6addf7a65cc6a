"""
Controls together
=================

Follow this path, crouch on it, turn by these recordings there, and box while walking on: one search carries the path,
the key and the move, and a layer drives the arms. Kick in the air six metres on: the path waits for it.
"""

import matplotlib.pyplot as plt

import kinetograph as kg
from clips import WALKS, clip, draw_pieces, library, picture, save_figure, walks
from kinetograph.drawing import contact_sheet
from kinetograph.keys import key_at
from kinetograph.methods.performance import Rule
from kinetograph.methods.together import Asked, AskedKey, performed
from kinetograph.motion import cut
from kinetograph.pipeline import layered, recordings_of, winding_path
from kinetograph.post import Layer

path = winding_path()
model = kg.PerformanceControl(mirror=True).fit(walks())

# %%
# A key and a move
# ----------------
#
# The key is met at the best time of a window of two seconds. The move is asked for by name: mirrored recordings of left
# turns are right turns. On the command line these are ``--key "humanoid3d_jump.txt@0.4; time=5..7"`` and
# ``--move "10.5-12.5=turn_right*"``.

crouch = key_at(clip("humanoid3d_jump"), 0.4, time=(5.0, 7.0), label="crouch")
turn = Rule(10.5, 12.5, called="turn_right*")
free = model.synthesize(path)
asked = performed(model, path, Asked(keys=(AskedKey(crouch),), rules=(turn,)))
print(f"the key is met at {asked.met[0]:.2f} s; {asked.cost:.4f} instead of {free.cost:.4f}")

# %%
# Which recording is used when; mirrored ones are hatched, the time of the key is black, the span of the move green.
# Borders move by less than a step of the search when they are adjusted at full rate.

takes = sorted({piece.take for result in (free, asked) for piece in result.pieces})
figure, rows = plt.subplots(2, 1, figsize=(10, 4), sharex=True, layout="constrained")
for axes, result, title in zip(rows, (free, asked), ("path alone", "with a key and a move"), strict=True):
    draw_pieces(axes, result, takes)
    axes.set_title(title, loc="left")
rows[1].axvline(asked.met[0], color="black", lw=1)
rows[1].axvspan(turn.start, turn.stop, color="green", alpha=0.15)
rows[1].set_xlabel("seconds")
save_figure(figure, "controls_together_pieces.png")

# %%
# A layer
# -------
#
# From 14 seconds on the arms are those of a boxer. Legs and path stay as they are, and hips follow as far as recordings
# show.

boxing = Layer(clip("humanoid3d_punch"), ("arms",), start=14.0, name="boxing")
result = layered(asked, (boxing,), recordings_of(model, asked))
for part in result.layers:
    print(f"{part.name}: {len(part.joints)} joints from {part.start:.2f} to {part.stop:.2f} s")
kg.save(result.motion, picture("controls_together.bvh"))
contact_sheet(result.motion, picture("controls_together.png"), contacts=result.annotations, path_signal=path, frames=24)

# %%
# A key at a place
# ----------------
#
# Nothing that walks is like a kick in the air. Where a key is asked for at a place of the path, the recording that has
# it plays, and the path waits for as long as that takes: here six metres along it. On the command line this is
# ``--key "humanoid3d_spinkick.txt@0.6; along=6"``.

gestures = library("gestures", (*WALKS, "humanoid3d_jump", "humanoid3d_kick", "humanoid3d_spinkick"))
keyframes = kg.KeyframeControl(mirror=True).fit(gestures)
kick = AskedKey(key_at(clip("humanoid3d_spinkick"), 0.6, label="kick"), along=6.0)
kicked = performed(model, path, Asked(keys=(kick,)), keyframes=lambda: keyframes)
((start, stop),) = kicked.filled
print(f"from {start:.1f} to {stop:.1f} s, the path waits {kicked.statistics['waited_seconds']:.1f} s of it:")
for piece in kicked.pieces:
    if start <= piece.start < stop:
        print(f"  {piece.take} from {piece.source_start:.2f} to {piece.source_stop:.2f} s")

# %%
# From two seconds before the kick to two after it.

fps = kicked.motion.fps
around = cut(kicked.motion, round((kicked.met[0] - 2.0) * fps), round((kicked.met[0] + 2.0) * fps))
contact_sheet(around, picture("controls_together_kick.png"), frames=16)
