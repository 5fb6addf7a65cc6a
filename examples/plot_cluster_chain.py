"""
The paper's cluster chain
=========================

Molina-Tanco and Hilton (2000) answer two keys with a Markov chain over clusters of poses: the likeliest path from
cluster to cluster, and then, by a hidden Markov model, the recordings that go that way. It is quick, and it is the
method to compare others with; between keys that are far apart it shows where clusters know no velocity.
"""

import matplotlib.pyplot as plt
import numpy as np

import kinetograph as kg
from clips import picture, rises, save_figure
from kinetograph.drawing import contact_sheet
from kinetograph.keys import key_at
from kinetograph.kinematics import joint_positions, velocities
from kinetograph.methods.keyframe import ClusterChain

library = rises()
lying, running = (library.take(f"humanoid3d_{name}").motion() for name in ("getup_facedown", "run"))
keys = (key_at(lying, 0.0), key_at(running, 0.4))

# %%
# The same two keys, by the paper's method and by the search
# ----------------------------------------------------------

chain = kg.KeyframeControl(solver=ClusterChain()).fit(library, rng=np.random.default_rng(0)).synthesize(keys)
search = kg.KeyframeControl().fit(library).synthesize(keys)
contact_sheet(chain.motion, picture("cluster_chain.png"), title="by the paper's cluster chain", frames=12)

# %%
# How fast the body moves
# -----------------------
#
# The mean speed of all joints: where the chain crosses from one recording to another it blends them over three tenths
# of a second, whatever their speeds.

figure, axes = plt.subplots(figsize=(9, 3), layout="constrained")
for result, name in ((chain, "cluster chain"), (search, "timed search")):
    speed = np.linalg.norm(velocities(joint_positions(result.motion), result.motion.fps), axis=-1).mean(axis=1)
    axes.plot(np.arange(len(speed)) / result.motion.fps, speed, label=name)
    print(f"{name}: {result.motion.duration:.2f} s of {len({p.take for p in result.pieces})} recordings")
axes.set(xlabel="seconds", ylabel="m/s", title="mean speed of the joints")
axes.legend()
save_figure(figure, "cluster_chain_speed.png")
