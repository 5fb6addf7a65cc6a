"""
Simulate and calibrate a sensor
===============================

A sensor strapped to a limb is never turned exactly as a layout says. A few seconds of movement show how it is worn:
its rotation on the bone, its bias, and how far its clock is ahead.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

from clips import clip, save_figure
from kinetograph import rotations as rot
from kinetograph.motion import repeat
from kinetograph.sensing import calibrate_on_motion, mounted, preset, simulate, specific_force

# %%
# Worn wrongly
# ------------
#
# The six sensors of the preset ``imu``, each turned at random and with a bias of its own, are simulated on a dance.

rng = np.random.default_rng(4)
nominal = preset("imu")
worn = replace(
    nominal,
    sensors=tuple(
        replace(sensor, rotation=rot.normalize(rng.normal(size=4)), bias=rng.uniform(-0.3, 0.3, 3))
        for sensor in nominal.sensors
    ),
)
motion = repeat(clip("humanoid3d_dance_a"), 2)
readings = simulate(motion, worn, rng)

# %%
# Calibrate
# ---------
#
# The motion that was performed is known, so virtual sensors on it say what a sensor worn as the layout says would have
# read. With readings only, `kinetograph.sensing.calibrate_on_library` does it by a library.

calibration, clock = calibrate_on_motion(readings, nominal, motion)
found = mounted(nominal, calibration)
for i, (real, ours) in enumerate(zip(worn.sensors, found.sensors, strict=True)):
    off = np.degrees(rot.angle_between(real.rotation, ours.rotation))
    was = np.degrees(rot.angle_between(real.rotation, nominal.sensors[i].rotation))
    print(
        f"{real.name:16}: turned by {was:5.1f} degrees, found to within {off:4.2f}; residual "
        f"{calibration.before[i]:5.2f} before, {calibration.residuals[i]:4.2f} m/s² after"
    )
print(f"clock offset: {1000 * clock.seconds:.1f} ms")

# %%
# The readings before and after, and what a virtual sensor reads.

name = "left_forearm"
i = nominal.names.index(name)
rows = readings.sensors == readings.names.index(name)
applied = calibration.apply(readings)
exact = specific_force(motion, nominal)[:, i]
figure, panels = plt.subplots(1, 2, figsize=(10, 3), sharey=True, layout="constrained")
for axes, force, title in zip(panels, (readings.force, applied.force), ("as read", "calibrated"), strict=True):
    axes.plot(np.arange(len(exact)) / motion.fps, exact, color="black", linewidth=0.8, alpha=0.5)
    axes.plot(readings.times[rows], force[rows], linewidth=0.8)
    axes.set(title=f"{name}, {title} (black: virtual)", xlabel="seconds", xlim=(0, motion.duration))
panels[0].set_ylabel("m/s²")
save_figure(figure, "simulate_and_calibrate.png")
