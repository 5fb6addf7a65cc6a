"""
Curve analogies
===============

Performance control is not about bodies: here a drawn line and the same line with curls are the example, and another
line is the control. Pieces of the curly line, turned, moved and scaled on the plane, are laid along the new one
(Hsu 2004, the remark in chapter 7).
"""

import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import CubicSpline

import kinetograph as kg
from kinetograph.methods.performance import PointsByRole, Similarity
from kinetograph.post import PostSettings
from kinetograph.skeleton import Landmark

RATE = 40.0  # samples per unit of length: what is a second of a motion is a unit of a curve here
CURL = 0.5  # length of line from curl to curl

# %%
# The method
# ----------
#
# A pen is a skeleton of one joint. Alignments may scale what lies on the plane, within bounds.

PEN = kg.Skeleton(("pen",), np.array([-1]), np.zeros((1, 3)), roles={"hips": Landmark(0)})
METHOD = kg.PerformanceControl(
    alignment=Similarity(0.7, 1.4),
    control_points=PointsByRole({"line": 1.0}),
    targets={"hips": 1.0},
    continuity=1.0,
    stretch=0.2,
    rate=20.0,
    span=2,
    post=PostSettings(blend_duration=0.1),
)

# %%
# The curves
# ----------


def line(points):
    """A smooth line through points, shape (N, 2), sampled evenly along its length: (F, 2)."""
    fine = CubicSpline(np.arange(len(points)), points)(np.linspace(0, len(points) - 1, 5000))
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(fine, axis=0), axis=1))])
    even = np.arange(int(length[-1] * RATE) + 1) / RATE
    return np.stack([np.interp(even, length, fine[:, i]) for i in (0, 1)], axis=1)


def curly(plain, height=0.16):
    """The line with a curl every CURL of its length."""
    along = np.gradient(plain, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    phase = (2 * np.pi / CURL * np.arange(len(plain)) / RATE)[:, None]
    return plain - height * np.sin(phase) * along + height * (1 - np.cos(phase)) * across


def on_the_plane(curve):
    """A curve (F, 2) as points on the ground, (F, 3)."""
    return np.stack([curve[:, 0], np.zeros(len(curve)), curve[:, 1]], axis=1)


def signal(curve):
    """A curve as a control."""
    return kg.Signal(on_the_plane(curve)[:, None], ("line",), "m", RATE)


def drawing(curve):
    """A curve as the motion of the pen."""
    still = np.tile([1.0, 0.0, 0.0, 0.0], (len(curve), 1, 1))
    return kg.Motion(PEN, on_the_plane(curve), still, RATE)


# %%
# The analogy
# -----------
#
# The plain line is the control track of the only take, the curly one its target track, cut at every curl.


def analogy(plain, styled, new):
    """What is to ``new`` as ``styled`` is to ``plain``, shape (F, 2), and the pieces that it is made of."""
    with tempfile.TemporaryDirectory() as folder:
        library = kg.Library.create(Path(folder) / "curves")
        cuts = np.arange(0, (len(plain) - 1) / RATE, CURL)
        annotations = tuple(kg.Annotation("styled", "cut", "", t, t) for t in cuts)
        library.add(kg.Take("example", {"plain": signal(plain), "styled": drawing(styled)}, annotations))
        result = METHOD.fit(library, track="styled").synthesize(signal(new))
    return result.motion.translation[:, [0, 2]], result.pieces


if __name__ == "__main__":
    from clips import save_figure

    plain = line([(0, 0), (1.5, 0.6), (3, -0.4), (4.5, 0.8), (6.5, 0.5), (6.8, -1.2), (5, -1.6), (3, -1.4), (1, -1.8)])
    new = line([(0, 0), (1, 1.2), (2.5, 1), (2.2, -0.4), (3.4, -1.2), (5, 0), (6, 1.3), (7.4, 0.2)])
    styled = curly(plain)
    answer, pieces = analogy(plain, styled, new)

    figure, axes = plt.subplots(2, 2, figsize=(11, 7), layout="constrained")
    titles = ("a line", "the same with curls", "another line", "the same with curls")
    for place, curve, title in zip(axes.ravel(), (plain, styled, new, answer), titles, strict=True):
        place.plot(*curve.T, color="#222222", linewidth=1.4)
        place.set_title(title)
        place.set_aspect("equal")
        place.axis("off")
    save_figure(figure, "curve_analogies.png")
    for piece in pieces[:5]:
        print(f"{piece.start:5.2f}: {piece.source_start:.2f} to {piece.source_stop:.2f}, scaled by {piece.scale:.2f}")
