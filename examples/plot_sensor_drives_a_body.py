"""
A wrist sensor drives a body
============================

An accelerometer measures one limb. What the rest of the body does comes from recordings: the path through the library
whose virtual sensors would have read the same. Here one to eight sensors of the preset ``wii`` are simulated on a walk
that the library does not have.
"""

# sphinx_gallery_thumbnail_number = -1

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import kinetograph as kg
from clips import library, picture, save_figure
from kinetograph import rotations as rot
from kinetograph.drawing import contact_sheet
from kinetograph.motion import repeat, resample
from kinetograph.sensing import preset, simulate

CLIPS = ("humanoid3d_walk", "humanoid3d_run", "humanoid3d_jump", "humanoid3d_punch", "humanoid3d_kick", "0walk_forward")

# %%
# Readings of a walk
# ------------------
#
# ``0walk_forward`` is held out. `kinetograph.sensing.simulate` gives what the sensors would have read, with the noise,
# the rounding and the lost packets of the device.

recordings = library("sensed", CLIPS)
truth = repeat(recordings.take("0walk_forward").motion(), 4)
wii = preset("wii")
readings = simulate(truth, wii, np.random.default_rng(1))

figure, axes = plt.subplots(figsize=(9, 2.6), layout="constrained")
wrist = readings.sensors == readings.names.index("right_forearm")
axes.plot(readings.times[wrist], readings.force[wrist], linewidth=0.8)
axes.set(xlabel="seconds", ylabel="m/s²", title="what the sensor on the right forearm reads")
save_figure(figure, "sensor_readings.png")

# %%
# One, two, four, eight sensors
# -----------------------------
#
# A model is fitted to a layout: fewer sensors, another model. Errors are angles between the joints' rotations and the
# true ones, the heading left out, since an accelerometer does not measure it.


def error(made: kg.Motion) -> float:
    """Mean angle in degrees between the joints of a result and of the truth."""
    wanted = resample(truth, made.fps)
    frames = min(len(wanted), len(made))
    return float(np.degrees(rot.angle_between(made.rotations[:frames, 1:], wanted.rotations[:frames, 1:]).mean()))


order = ("right_forearm", "left_shank", "left_forearm", "right_shank")
for names in (order[:1], order[:2], order, wii.names):
    layout = replace(wii, sensors=tuple(sensor for sensor in wii.sensors if sensor.name in names))
    model = kg.SensorControl(layout=layout).fit(recordings, exclude=("0walk_forward",))
    result = model.synthesize(simulate(truth, layout, np.random.default_rng(1)))
    print(
        f"{len(names)} sensors: {error(result.motion):5.2f} degrees, "
        f"uncertainty {np.degrees(result.uncertainty.mean()):5.2f} degrees"
    )

# %%
# The result with all eight:

contact_sheet(result.motion, picture("sensor_drives_a_body.png"), contacts=result.annotations, frames=12)
