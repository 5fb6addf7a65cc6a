"""
Alternatives
============

Besides the best motion for a control there are others nearly as good. Each alternative is the best that shares no
piece with those before it.
"""

import matplotlib.pyplot as plt
import numpy as np

import kinetograph as kg
from clips import draw_pieces, save_figure, walks
from kinetograph.pipeline import winding_path

path = winding_path()
model = kg.PerformanceControl(mirror=True).fit(walks())
found = model.alternatives(path, 3)

# %%
# The costs say how much worse the others are. With ``alike=True`` the k best of all are given instead; these may
# differ by a border only.

for number, result in enumerate(found, start=1):
    takes = len({(piece.take, piece.mirrored) for piece in result.pieces})
    print(f"{number}: score {result.cost:.3f}, {len(result.pieces)} pieces of {takes} recordings")
best = model.alternatives(path, 3, alike=True)
print("the three best of all:", ", ".join(f"{result.cost:.4f}" for result in best))

# %%
# Which recordings they use (mirrored ones are hatched): the second and the third have fewer to choose from.

takes = sorted({piece.take for result in found for piece in result.pieces})
figure, rows = plt.subplots(3, 1, figsize=(10, 5.5), sharex=True, layout="constrained")
for number, (axes, result) in enumerate(zip(rows, found, strict=True), start=1):
    draw_pieces(axes, result, takes)
    axes.set_title(f"motion {number}", loc="left")
rows[-1].set_xlabel("seconds")
save_figure(figure, "alternatives.png")

# %%
# All three follow the path.

ground = path.values[:, 0][:, [0, 2]]
for number, result in enumerate(found, start=1):
    frames = min(len(ground), len(result.motion))
    apart = np.linalg.norm(result.motion.translation[:frames, [0, 2]] - ground[:frames], axis=1)
    print(f"motion {number}: the root is {100 * apart.mean():.1f} cm from the path in the mean")
