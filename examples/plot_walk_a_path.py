"""
Walk along a path
=================

A path with timing is the control; a library of walks is what the motion is made of. This is the whole of it: draw
points, fit the method to the library, synthesize, write a file.
"""

# %%
# The path
# --------
#
# A control of this kind is a `kinetograph.Signal` of one point in metres on the ground, Y up. Here it is an S of two
# half circles, walked at 0.95 m/s.

import numpy as np

import kinetograph as kg
from clips import picture, walks
from kinetograph.drawing import contact_sheet, strobe

RADIUS, SPEED, FPS = 2.0, 0.95, 30.0

length = 2 * np.pi * RADIUS
angle = np.arange(int(length / SPEED * FPS) + 1) * SPEED / FPS / RADIUS
first = angle < np.pi
x = np.where(first, RADIUS * np.sin(angle), -RADIUS * np.sin(angle - np.pi))
z = np.where(first, RADIUS * (1 - np.cos(angle)), RADIUS * (3 - np.cos(angle - np.pi)))
path = kg.Signal(np.stack([x, 0 * x, z], axis=-1)[:, None], ("path",), "m", FPS)

# %%
# The walk
# --------
#
# ``mirror`` uses every recording mirrored as well, so that the four turning clips turn both ways equally well.

model = kg.PerformanceControl(mirror=True).fit(walks())
result = model.synthesize(path)
kg.save(result.motion, picture("walk_a_path.bvh"))
strobe(result.motion, picture("walk_a_path.png"), path_signal=path)

# %%
# What it is made of
# ------------------
#
# Every piece says which seconds of which recording it is, and how much they were stretched.

for piece in result.pieces[:6]:
    source = f"{piece.take} {piece.source_start:.2f} to {piece.source_stop:.2f} s"
    print(f"{piece.start:5.2f} s: {source}, stretched by {piece.stretch:.2f}{', mirrored' * piece.mirrored}")

# %%
# A contact sheet shows poses, the path from above (yellow: asked for; black: walked), and the heights of the feet with
# the times at which they are planted.

contact_sheet(result.motion, picture("walk_a_path_sheet.png"), contacts=result.annotations, path_signal=path, frames=12)
