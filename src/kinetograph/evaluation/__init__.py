"""How good results are: metrics of motions, simpler methods to compare with, and held-out protocols.

A protocol leaves one take out, makes it again from the others and gives one row of figures per take and method:
`leave_one_take_out` for walks, `leave_one_dance_out` for partners, `inbetween_held_out` for keyframes, `evaluate` for
sensors. The papers' tables and figures are in ``kinetograph.evaluation.reproduce``. Modules are imported on first use,
so that ``import kinetograph.evaluation`` stays quick.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

_ROOMS = {
    "DanceRow": "dance",
    "Guide": "baselines",
    "HeldOut": "sensor",
    "LabelErrors": "labels",
    "Locking": "phase",
    "MatchingWeights": "motion_matching",
    "MotionMatching": "motion_matching",
    "PairFigures": "keyframe",
    "Phase": "phase",
    "RealRow": "real_sensors",
    "SWEEPS": "sensor_sweep",
    "Score": "inbetweening",
    "SensorRow": "sensor_scores",
    "Steered": "steering",
    "SteeringScores": "steering",
    "StickScript": "steering",
    "SweepRow": "sensor_sweep",
    "WalkRow": "protocol",
    "accelerations": "metrics",
    "ankles_apart": "phase",
    "averaged": "sensor_scores",
    "cadence_ratio": "phase",
    "constant_pose": "baselines",
    "contact_speed": "metrics",
    "control_error": "metrics",
    "distinct_share": "metrics",
    "evaluate": "sensor",
    "evaluate_recordings": "real_sensors",
    "foot_agreement": "phase",
    "gait_phase": "phase",
    "grouped": "sensor",
    "guide_of_partner": "baselines",
    "guide_of_path": "baselines",
    "held_out_motion": "protocol",
    "hold_errors": "metrics",
    "inbetween_held_out": "keyframe",
    "jerk": "metrics",
    "joint_error": "metrics",
    "judge_pair": "keyframe",
    "key_miss": "keyframe",
    "label_errors": "labels",
    "leave_one_dance_out": "dance",
    "leave_one_take_out": "protocol",
    "locking": "phase",
    "main_move": "labels",
    "mean_known": "rows",
    "mean_rows": "rows",
    "mean_walks": "protocol",
    "near_seams": "metrics",
    "nearest_frames": "baselines",
    "normalised_rms": "sensor_scores",
    "npss": "inbetweening",
    "phase_difference": "phase",
    "plant_phase": "phase",
    "pose_errors": "sensor_scores",
    "position_errors": "metrics",
    "recorded_jumps": "keyframe",
    "ridge_regression": "baselines",
    "score_steering": "steering",
    "seam_jump": "keyframe",
    "skate_ratio": "keyframe",
    "slips": "phase",
    "speed_jumps": "keyframe",
    "steer_by": "steering",
    "sticks": "steering",
    "sweep": "sensor_sweep",
    "take_errors": "labels",
    "timed": "sensor",
    "walk_row": "protocol",
}

__all__ = [
    "SWEEPS",
    "DanceRow",
    "Guide",
    "HeldOut",
    "LabelErrors",
    "Locking",
    "MatchingWeights",
    "MotionMatching",
    "PairFigures",
    "Phase",
    "RealRow",
    "Score",
    "SensorRow",
    "Steered",
    "SteeringScores",
    "StickScript",
    "SweepRow",
    "WalkRow",
    "accelerations",
    "ankles_apart",
    "averaged",
    "cadence_ratio",
    "constant_pose",
    "contact_speed",
    "control_error",
    "distinct_share",
    "evaluate",
    "evaluate_recordings",
    "foot_agreement",
    "gait_phase",
    "grouped",
    "guide_of_partner",
    "guide_of_path",
    "held_out_motion",
    "hold_errors",
    "inbetween_held_out",
    "jerk",
    "joint_error",
    "judge_pair",
    "key_miss",
    "label_errors",
    "leave_one_dance_out",
    "leave_one_take_out",
    "locking",
    "main_move",
    "mean_known",
    "mean_rows",
    "mean_walks",
    "near_seams",
    "nearest_frames",
    "normalised_rms",
    "npss",
    "phase_difference",
    "plant_phase",
    "pose_errors",
    "position_errors",
    "recorded_jumps",
    "ridge_regression",
    "score_steering",
    "seam_jump",
    "skate_ratio",
    "slips",
    "speed_jumps",
    "steer_by",
    "sticks",
    "sweep",
    "take_errors",
    "timed",
    "walk_row",
]


def __getattr__(name: str) -> Any:
    if name not in _ROOMS:
        raise AttributeError(f"module 'kinetograph.evaluation' has no attribute {name!r}")
    return getattr(importlib.import_module(f"kinetograph.evaluation.{_ROOMS[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)


if TYPE_CHECKING:
    from kinetograph.evaluation.baselines import (
        Guide,
        constant_pose,
        guide_of_partner,
        guide_of_path,
        nearest_frames,
        ridge_regression,
    )
    from kinetograph.evaluation.dance import DanceRow, leave_one_dance_out
    from kinetograph.evaluation.inbetweening import Score, npss
    from kinetograph.evaluation.keyframe import (
        PairFigures,
        inbetween_held_out,
        judge_pair,
        key_miss,
        recorded_jumps,
        seam_jump,
        skate_ratio,
        speed_jumps,
    )
    from kinetograph.evaluation.labels import LabelErrors, label_errors, main_move, take_errors
    from kinetograph.evaluation.metrics import (
        accelerations,
        contact_speed,
        control_error,
        distinct_share,
        hold_errors,
        jerk,
        joint_error,
        near_seams,
        position_errors,
    )
    from kinetograph.evaluation.motion_matching import MatchingWeights, MotionMatching
    from kinetograph.evaluation.phase import (
        Locking,
        Phase,
        ankles_apart,
        cadence_ratio,
        foot_agreement,
        gait_phase,
        locking,
        phase_difference,
        plant_phase,
        slips,
    )
    from kinetograph.evaluation.protocol import WalkRow, held_out_motion, leave_one_take_out, mean_walks, walk_row
    from kinetograph.evaluation.real_sensors import RealRow, evaluate_recordings
    from kinetograph.evaluation.rows import mean_known, mean_rows
    from kinetograph.evaluation.sensor import HeldOut, evaluate, grouped, timed
    from kinetograph.evaluation.sensor_scores import SensorRow, averaged, normalised_rms, pose_errors
    from kinetograph.evaluation.sensor_sweep import SWEEPS, SweepRow, sweep
    from kinetograph.evaluation.steering import Steered, SteeringScores, StickScript, score_steering, steer_by, sticks
