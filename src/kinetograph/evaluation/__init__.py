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
    "Against": "sensor_against",
    "CalibrationRow": "sensor_calibrations",
    "Candidate": "nested",
    "DanceRow": "dance",
    "Guide": "baselines",
    "HeldOut": "sensor_folds",
    "Interval": "intervals",
    "LabelErrors": "labels",
    "Locking": "phase",
    "MatchingWeights": "motion_matching",
    "MotionMatching": "motion_matching",
    "Nested": "nested",
    "Observer": "partner_names",
    "OwnFrames": "recorded_keys",
    "PairFigures": "keyframe",
    "RequestFigures": "requested_keys",
    "Phase": "phase",
    "RealRow": "real_rows",
    "Run": "leaving_out",
    "SWEEPS": "sensor_sweep",
    "Score": "inbetweening",
    "SeenErrors": "partner_names",
    "SensorMean": "sensor_means",
    "SensorRow": "sensor_scores",
    "SensorScores": "sensor",
    "Steered": "steering",
    "SteeringScores": "steering",
    "StickScript": "steering",
    "SweepRow": "sensor_sweep",
    "WalkRow": "protocol",
    "accelerations": "metrics",
    "ankles_apart": "phase",
    "below_pieces": "plausibility",
    "below_recordings": "plausibility",
    "cadence_ratio": "phase",
    "candidates_around": "nested",
    "constant_pose": "baselines",
    "contact_speed": "metrics",
    "control_distances": "metrics",
    "control_error": "metrics",
    "deepest_overlap": "metrics",
    "distinct_share": "metrics",
    "evaluate": "sensor",
    "evaluate_calibrations": "sensor_calibrations",
    "evaluate_recordings": "real_sensors",
    "fall_ratio": "plausibility",
    "fastest_fall": "plausibility",
    "fastest_low_toe": "metrics",
    "foot_agreement": "phase",
    "gait_phase": "phase",
    "group_means": "sensor_means",
    "grouped": "sensor_folds",
    "guide_of_partner": "baselines",
    "guide_of_path": "baselines",
    "held_out_motion": "protocol",
    "hold_errors": "metrics",
    "inbetween_held_out": "keyframe",
    "interval": "intervals",
    "jerk": "metrics",
    "joint_error": "metrics",
    "judge_pair": "keyframe",
    "key_requests": "requested_keys",
    "key_miss": "keyframe",
    "label_errors": "labels",
    "leave_one_dance_out": "dance",
    "leave_one_take_out": "protocol",
    "locking": "phase",
    "low_toe_speed": "metrics",
    "main_move": "labels",
    "mean_known": "rows",
    "mean_rows": "rows",
    "mean_walks": "protocol",
    "means_with_and_without": "rows",
    "near_repeats": "repeats",
    "near_seams": "metrics",
    "nearest_frames": "baselines",
    "nested_dances": "nested",
    "nested_walks": "nested",
    "normalised_rms": "sensor_scores",
    "npss": "inbetweening",
    "own_frames": "recorded_keys",
    "people_among": "sensor_folds",
    "phase_difference": "phase",
    "plant_phase": "phase",
    "pose_errors": "sensor_scores",
    "position_errors": "metrics",
    "recorded_jumps": "keyframe",
    "repeat_distances": "repeats",
    "ridge_regression": "baselines",
    "score_against": "sensor_against",
    "score_steering": "steering",
    "seam_falls": "plausibility",
    "seam_jump": "keyframe",
    "skate_ratio": "keyframe",
    "slips": "phase",
    "sole_level": "metrics",
    "speed_jumps": "keyframe",
    "steer_by": "steering",
    "sticks": "steering",
    "sweep": "sensor_sweep",
    "take_errors": "labels",
    "timed": "sensor",
    "together": "sensor",
    "walk_row": "protocol",
}

__all__ = [
    "SWEEPS",
    "Against",
    "CalibrationRow",
    "Candidate",
    "DanceRow",
    "Guide",
    "HeldOut",
    "Interval",
    "LabelErrors",
    "Locking",
    "MatchingWeights",
    "MotionMatching",
    "Nested",
    "Observer",
    "OwnFrames",
    "PairFigures",
    "Phase",
    "RealRow",
    "RequestFigures",
    "Run",
    "Score",
    "SeenErrors",
    "SensorMean",
    "SensorRow",
    "SensorScores",
    "Steered",
    "SteeringScores",
    "StickScript",
    "SweepRow",
    "WalkRow",
    "accelerations",
    "ankles_apart",
    "below_pieces",
    "below_recordings",
    "cadence_ratio",
    "candidates_around",
    "constant_pose",
    "contact_speed",
    "control_distances",
    "control_error",
    "deepest_overlap",
    "distinct_share",
    "evaluate",
    "evaluate_calibrations",
    "evaluate_recordings",
    "fall_ratio",
    "fastest_fall",
    "fastest_low_toe",
    "foot_agreement",
    "gait_phase",
    "group_means",
    "grouped",
    "guide_of_partner",
    "guide_of_path",
    "held_out_motion",
    "hold_errors",
    "inbetween_held_out",
    "interval",
    "jerk",
    "joint_error",
    "judge_pair",
    "key_miss",
    "key_requests",
    "label_errors",
    "leave_one_dance_out",
    "leave_one_take_out",
    "locking",
    "low_toe_speed",
    "main_move",
    "mean_known",
    "mean_rows",
    "mean_walks",
    "means_with_and_without",
    "near_repeats",
    "near_seams",
    "nearest_frames",
    "nested_dances",
    "nested_walks",
    "normalised_rms",
    "npss",
    "own_frames",
    "people_among",
    "phase_difference",
    "plant_phase",
    "pose_errors",
    "position_errors",
    "recorded_jumps",
    "repeat_distances",
    "ridge_regression",
    "score_against",
    "score_steering",
    "seam_falls",
    "seam_jump",
    "skate_ratio",
    "slips",
    "sole_level",
    "speed_jumps",
    "steer_by",
    "sticks",
    "sweep",
    "take_errors",
    "timed",
    "together",
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
    from kinetograph.evaluation.intervals import Interval, interval
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
    from kinetograph.evaluation.leaving_out import Run
    from kinetograph.evaluation.metrics import (
        accelerations,
        contact_speed,
        control_distances,
        control_error,
        deepest_overlap,
        distinct_share,
        fastest_low_toe,
        hold_errors,
        jerk,
        joint_error,
        low_toe_speed,
        near_seams,
        position_errors,
        sole_level,
    )
    from kinetograph.evaluation.motion_matching import MatchingWeights, MotionMatching
    from kinetograph.evaluation.nested import Candidate, Nested, candidates_around, nested_dances, nested_walks
    from kinetograph.evaluation.partner_names import Observer, SeenErrors
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
    from kinetograph.evaluation.plausibility import (
        below_pieces,
        below_recordings,
        fall_ratio,
        fastest_fall,
        seam_falls,
    )
    from kinetograph.evaluation.protocol import WalkRow, held_out_motion, leave_one_take_out, mean_walks, walk_row
    from kinetograph.evaluation.real_rows import RealRow
    from kinetograph.evaluation.real_sensors import evaluate_recordings
    from kinetograph.evaluation.recorded_keys import OwnFrames, own_frames
    from kinetograph.evaluation.repeats import near_repeats, repeat_distances
    from kinetograph.evaluation.requested_keys import RequestFigures, key_requests
    from kinetograph.evaluation.rows import mean_known, mean_rows, means_with_and_without
    from kinetograph.evaluation.sensor import SensorScores, evaluate, timed, together
    from kinetograph.evaluation.sensor_against import Against, score_against
    from kinetograph.evaluation.sensor_calibrations import CalibrationRow, evaluate_calibrations
    from kinetograph.evaluation.sensor_folds import HeldOut, grouped, people_among
    from kinetograph.evaluation.sensor_means import SensorMean, group_means
    from kinetograph.evaluation.sensor_scores import SensorRow, normalised_rms, pose_errors
    from kinetograph.evaluation.sensor_sweep import SWEEPS, SweepRow, sweep
    from kinetograph.evaluation.steering import Steered, SteeringScores, StickScript, score_steering, steer_by, sticks
