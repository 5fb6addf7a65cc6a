"""
Mirror a motion
===============

Left and right are exchanged on any skeleton whose roles are known: positions are reflected, and every joint takes the
rotation of its partner on the other side.
"""

from clips import clip, picture
from kinetograph.drawing import strobe
from kinetograph.mirroring import mirror
from kinetograph.motion import place, repeat

# %%
# A clip that turns left, and its mirror image, which turns right. Left limbs are blue and right limbs red.

left = repeat(clip("turn_left0"), 2)
right = mirror(left)
strobe([left, place(right, 0.0, (1.2, 0.0, 0.0))], picture("mirror.png"), title="a left turn, and its mirror image")

# %%
# Mirrored twice, a motion is itself again.

again = mirror(right)
print(f"largest difference in place: {abs(again.translation - left.translation).max():.1e} m")

# %%
# ``PerformanceControl(mirror=True)`` does this with every recording of the library: see :ref:`the walk along a path
# <sphx_glr_gallery_plot_walk_a_path.py>`.
