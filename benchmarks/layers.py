"""Arms by sensors on legs by a path: ``python -m benchmarks.layers WALKS SPORTS``.

A walk of one library follows a path while the arms do what the upper four of eight sensors say of a take of the other
library, which is left out of what is learnt. Printed for every take: the error of the arms' joints, in their parents'
frames and, of elbows and hands, as seen from the chest and from the hips, when the same readings drive the whole body
and when they drive a layer; and how fast planted feet move in the walk without the layer and with it. A golfer leans
from the hips, which a walker's legs do not let it, so that arms that are right as seen from the chest are off as seen
from the hips.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.evaluation import contact_speed
from kinetograph.kinematics import role_positions, velocities
from kinetograph.library import Library
from kinetograph.methods.performance import PerformanceControl, PerformanceModel
from kinetograph.methods.sensor import SensorControl
from kinetograph.motion import Motion, cut, resample
from kinetograph.pipeline import fit_performance, winding_path
from kinetograph.post import contacts_of
from kinetograph.post.balance import facing_of, learn_following
from kinetograph.post.layering import Layer, LayerSettings, with_layer
from kinetograph.sensing import keep_sensors, preset, simulate
from kinetograph.synthesis import Synthesis

CHOSEN_ON = ("124_03_amass30", "135_02_amass30", "86_14_amass30")
"""Takes on which settings were chosen."""
REPORTED = ("06_15_amass30", "124_04_amass30", "124_07_amass30", "135_05_amass30", "144_13_amass30", "64_05_amass30")
SECONDS = 12.0
UPPER = ("left_upper_arm", "right_upper_arm", "left_forearm", "right_forearm")
ARMS = tuple(f"{side}_{part}" for side in ("left", "right") for part in ("shoulder", "elbow", "hand"))


@dataclass(frozen=True)
class Row:
    """Errors of arms in degrees and metres, the mean over frames; of planted feet, metres per second."""

    degrees: tuple[float, float]
    from_chest: tuple[float, float]
    from_hips: tuple[float, float]
    feet: tuple[float, float]
    accelerations: tuple[float, float]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("walks", type=Path)
    parser.add_argument("sports", type=Path)
    parser.add_argument("--chosen-on", action="store_true", help="the takes that settings were chosen on")
    parser.add_argument("--tilt", type=float, action="append")
    asked = parser.parse_args()
    walker = fit_performance(PerformanceControl(mirror=True), Library.open(asked.walks))
    sports = Library.open(asked.sports)
    walked = walker.synthesize(winding_path())
    print("alone / layered: degrees; elbows and hands from the chest, from the hips, cm; planted feet, cm/s, without /")
    print("with the layer; accelerations of hands, p99.9, m/s^2")
    for take in CHOSEN_ON if asked.chosen_on else REPORTED:
        truth = _beginning(sports.take(take).motion(), SECONDS)
        sensed = sense(sports, take, truth)
        for tilt in asked.tilt or (1.0,):
            _print(take, tilt, row(walker, walked, truth, sensed, tilt))


def _print(take: str, tilt: float, each: Row) -> None:
    pairs = (each.degrees, *((100 * a, 100 * b) for a, b in (each.from_chest, each.from_hips)))
    errors = "; ".join(f"{a:5.2f} / {b:5.2f}, x {b / a:.2f}" for a, b in pairs)
    feet, hands = each.feet, each.accelerations
    print(
        f"{take:16s} tilt {tilt:.1f}: {errors}; {100 * feet[0]:.2f} / {100 * feet[1]:.2f}; "
        f"{hands[0]:.0f} / {hands[1]:.0f}",
        flush=True,
    )


def _beginning(motion: Motion, seconds: float) -> Motion:
    return cut(motion, 0, min(round(seconds * motion.fps) + 1, len(motion)))


def sense(library: Library, take: str, truth: Motion) -> Motion:
    """The whole body by the upper four sensors, the take being left out."""
    layout = keep_sensors(preset("wii"), UPPER)
    model = SensorControl(layout=layout).fit(library, exclude=[take])
    made = model.synthesize(simulate(resample(truth, 60.0), layout, np.random.default_rng(0)))
    return resample(made.motion, truth.fps)


def row(walker: PerformanceModel, walked: Synthesis, truth: Motion, sensed: Motion, tilt: float) -> Row:
    """One take's figures."""
    following = learn_following([*(source.motion for source in walker.fitted.sources if not source.mirrored), sensed])
    settings = LayerSettings(following, tilt, walker.fitted.limits.joints)
    frames = min(len(truth), len(sensed), len(walked.motion))
    base = cut(walked.motion, 0, frames)
    layered = with_layer(base, Layer(cut(sensed, 0, frames), ("arms",)), settings)
    bodies = cut(sensed, 0, frames), layered
    true = cut(truth, 0, frames)
    planted = contacts_of(walked.annotations)
    planted = [replace(each, stop=min(each.stop, base.duration)) for each in planted if each.start < base.duration]
    facing = facing_of(bodies[0]), facing_of(base)
    degrees = [_degrees(true, body) for body in bodies]
    away = [[_away(true, facing_of(true), joint) for joint in ("chest", "hips")]]
    away += [[_away(body, own, joint) for joint in ("chest", "hips")] for body, own in zip(bodies, facing, strict=True)]
    chest, hips = ([float(np.linalg.norm(a[i] - away[0][i], axis=-1).mean()) for a in away[1:]] for i in (0, 1))
    return Row(
        (degrees[0], degrees[1]),
        (chest[0], chest[1]),
        (hips[0], hips[1]),
        (contact_speed(base, planted), contact_speed(layered, planted)),
        (_acceleration(bodies[0]), _acceleration(layered)),
    )


def _joints(motion: Motion) -> list[int]:
    return [motion.skeleton.landmark(role).joint for role in ARMS]


def _degrees(truth: Motion, motion: Motion) -> float:
    own = _joints(truth)
    return float(np.degrees(rot.angle_between(truth.rotations[:, own], motion.rotations[:, own])).mean())


def _away(motion: Motion, facing: FloatArray, joint: str) -> FloatArray:
    """Elbows and hands as seen from a joint and where the body faces."""
    ends = role_positions(motion, [role for role in ARMS if not role.endswith("shoulder")])
    return rot.rotate(rot.about("y", -facing)[:, None], ends - role_positions(motion, (joint,)))


def _acceleration(motion: Motion) -> float:
    hands = role_positions(motion, ("left_hand", "right_hand"))
    speeds = velocities(velocities(hands, motion.fps), motion.fps)
    return float(np.quantile(np.linalg.norm(speeds, axis=-1), 0.999))


if __name__ == "__main__":
    main()
