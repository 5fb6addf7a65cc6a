"""Draw a path with a few points, walk it, and look at the result.

Run after ``make demo``:  python examples/walk_a_path.py
"""

import numpy as np

import kinetograph as kg
from kinetograph.drawing import contact_sheet
from kinetograph.signal import Signal

# a quarter circle of 3 m radius, walked at 1 m/s
angle = np.linspace(0.0, np.pi / 2, 142)
points = np.stack([3 * np.sin(angle), 0 * angle, 3 - 3 * np.cos(angle)], axis=-1)
path = Signal(points[:, None], ("path",), "m", fps=30.0)

model = kg.PerformanceControl(mirror=True).fit(kg.Library.open("out/walks.library"))
result = model.synthesize(path)

kg.save(result.motion, "out/quarter_circle.glb")
contact_sheet(result.motion, "out/quarter_circle.png", contacts=result.annotations, path_signal=path)
for piece in result.pieces:
    source = f"{piece.take} {piece.source_start:.2f} to {piece.source_stop:.2f} s"
    print(f"{piece.start:5.2f} s: {source}, stretched by {piece.stretch:.2f}")
