"""
Read and write formats
======================

What is read is in metres, Y up, whatever a file says; what is written can be read by other programs. Here one clip goes
through every format that holds a motion, and comes back.
"""

import numpy as np

import kinetograph as kg
from clips import clip_file, picture
from kinetograph.drawing import strobe
from kinetograph.formats import ReadOptions, WriteOptions, read
from kinetograph.kinematics import joint_positions

# %%
# Read
# ----
#
# `kinetograph.load` gives a take; `kinetograph.formats.read` also says what was guessed on the way.

loaded = read(clip_file("humanoid3d_cartwheel"))
motion = loaded.take.motion()
print(f"{len(motion)} frames at {motion.fps:g} Hz, {len(motion.skeleton)} joints; notes: {loaded.notes or 'none'}")
strobe(motion, picture("formats.png"))

# %%
# There and back
# --------------

for suffix in (".bvh", ".glb", ".fbx", ".npz"):
    path = picture(f"cartwheel{suffix}")
    kg.save(motion, path)
    back = kg.load(path).motion()
    names = [name for name in motion.skeleton.names if name in back.skeleton.names]
    ours = joint_positions(motion)[:, [motion.skeleton.index(name) for name in names]]
    theirs = joint_positions(back)[:, [back.skeleton.index(name) for name in names]]
    apart = np.linalg.norm(ours - theirs, axis=-1).max()
    print(f"{suffix}: {path.stat().st_size / 1000:6.0f} kB, {len(names)} joints, {1000 * apart:.4f} mm at most")

# %%
# Units, axes and orders
# ----------------------
#
# Where a format leaves a choice, `kinetograph.formats.WriteOptions` makes it; where a file does not say what its
# numbers mean, `kinetograph.formats.ReadOptions` does.

path = picture("cartwheel_centimetres.bvh")
kg.save(motion, path, options=WriteOptions(units="centimetre", up="z", order="xyz"))
print("\n".join(line.strip() for line in path.read_text().splitlines()[:6]))
back = read(path, ReadOptions(units="centimetre", up="z"))
print(f"height of the hips: {back.take.motion().translation[0, 1]:.3f} m")
