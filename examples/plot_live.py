"""
Follow a control that still arrives
===================================

The control comes frame by frame, and pieces are decided a fixed lag later. The longer the lag, the more the choice
knows of what comes; without one the result is that of the whole control at once.
"""

import matplotlib.pyplot as plt

import kinetograph as kg
from clips import draw_pieces, save_figure, walks
from kinetograph.methods.performance import read_control
from kinetograph.pipeline import winding_path

path = winding_path()
model = kg.PerformanceControl(mirror=True).fit(walks())
whole = model.synthesize(path)
points = read_control(model.method, path).points

# %%
# ``step`` takes a frame of control points, and gives the pieces that have been decided since; ``finish`` gives the
# result. The control points of a path are two points, left and right of it on the ground.

results = {}
for lag in (0.5, 1.0, 2.0):
    live = model.start(path.fps, lag)
    pieces = sum(len(live.step(frame)) for frame in points)
    results[lag] = live.finish()
    print(f"lag {lag:g} s: {pieces} pieces before the end, score {results[lag].cost:.3f} (whole: {whole.cost:.3f})")

# %%
# Which recordings are used (mirrored ones are hatched): the longer the lag, the longer the choice is that of the whole
# path.

shown = [(f"decided {lag:g} s later", result) for lag, result in results.items()] + [("the whole path known", whole)]
takes = sorted({piece.take for _, result in shown for piece in result.pieces})
figure, rows = plt.subplots(len(shown), 1, figsize=(10, 6.5), sharex=True, layout="constrained")
for axes, (title, result) in zip(rows, shown, strict=True):
    draw_pieces(axes, result, takes)
    axes.set_title(title, loc="left")
rows[-1].set_xlabel("seconds")
save_figure(figure, "live.png")
