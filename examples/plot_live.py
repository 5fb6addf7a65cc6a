"""
Follow a control that still arrives
===================================

The control comes frame by frame, and motion is decided a fixed lag later. The longer the lag, the more the choice
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
# ``step`` takes a frame of control points, and gives the frames of motion that it settles, which are never revised;
# ``finish`` gives the whole, made once more with all that is known by then. The control points of a path are two: left
# and right of it on the ground. What is known to come may be given with them.

results = {}
for lag in (0.5, 1.0, 2.0):
    live = model.start(path.fps, lag)
    frames = sum(len(live.step(frame)) for frame in points)
    results[lag] = live.finish()
    print(f"lag {lag:g} s: {frames} frames before the end, score {results[lag].cost:.3f} (whole: {whole.cost:.3f})")

live = model.start(path.fps, lag=0.5)
for i, frame in enumerate(points):
    live.step(frame, ahead=points[i + 1 : i + 60])
print(f"lag 0.5 s, the rest of the path known: score {live.finish().cost:.3f}")

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
