"""Performance control (Hsu 2004): a control is interpreted as stretched, placed segments of recordings.

A walk follows a drawn path or another walker's hips; a dance follower answers a leader. `PerformanceControl` is the
configuration, fitting it to a library gives a `PerformanceModel`, and that turns whole controls into motion, or one
frame of control after another. `Steering` follows a stick without one.
"""

from kinetograph.learn import Affine, Alignment, Continued, Fixed, Ground, Rigid, Similarity
from kinetograph.methods.performance.beginning import FIRST_FACING
from kinetograph.methods.performance.candidates import Candidate, next_best
from kinetograph.methods.performance.clustering import segment_distances
from kinetograph.methods.performance.control import Control, only_track, points_of, read_control
from kinetograph.methods.performance.control_points import (
    LIMB_ENDS,
    Channels,
    ControlPoints,
    GroundPath,
    PointsByRole,
)
from kinetograph.methods.performance.fitted import Fitted, fitted_for, recorded_speeds, with_settings
from kinetograph.methods.performance.frame_planner import FramePlanner, PlannerSettings, Playhead
from kinetograph.methods.performance.ground_path import (
    begin_facing,
    hips_on_ground,
    path_on_ground,
    path_speeds,
    smooth_path,
)
from kinetograph.methods.performance.growing import (
    GROWN,
    Grown,
    Growth,
    by_hand,
    cut_tracks,
    cuts_of,
    fit_examples,
    grow,
    grow_rest,
    grow_takes,
    growing_control,
)
from kinetograph.methods.performance.handholds import usual_grip
from kinetograph.methods.performance.interpretation import interpret, settle
from kinetograph.methods.performance.keyed import distances_to
from kinetograph.methods.performance.leaving_out import fit_without
from kinetograph.methods.performance.live import FARTHEST, Live
from kinetograph.methods.performance.live_frames import check_alike
from kinetograph.methods.performance.model import PerformanceControl, PerformanceModel, partner_control, short_pieces
from kinetograph.methods.performance.moments import Moment
from kinetograph.methods.performance.moves import called, contact_moments, foot_moments
from kinetograph.methods.performance.over_shards import ShardedModel, over_shards
from kinetograph.methods.performance.performing import perform_read, performances
from kinetograph.methods.performance.pieces import fine_borders, pieces_of
from kinetograph.methods.performance.realization import realize
from kinetograph.methods.performance.repetition import most_used, times_running
from kinetograph.methods.performance.rules import Demand, RecordedSpan, Rule
from kinetograph.methods.performance.scoring import arrivals, at_rate, left_early
from kinetograph.methods.performance.segments import (
    Instances,
    Segment,
    Source,
    build_instances,
    cut_segments,
    legal_steps,
)
from kinetograph.methods.performance.settings import PerformanceSettings
from kinetograph.methods.performance.steered_body import SteeringSettings
from kinetograph.methods.performance.steering import Chooser, Steering
from kinetograph.methods.performance.steering_frames import SteeringFrames
from kinetograph.methods.performance.transcription import Transcript, require_moves, transcribe
from kinetograph.methods.performance.why import Contender, PieceTerms, Reasons, Reversal, explain
from kinetograph.methods.recordings import LABELS

__all__ = [
    "FARTHEST",
    "FIRST_FACING",
    "GROWN",
    "LABELS",
    "LIMB_ENDS",
    "Affine",
    "Alignment",
    "Candidate",
    "Channels",
    "Chooser",
    "Contender",
    "Continued",
    "Control",
    "ControlPoints",
    "Demand",
    "Fitted",
    "Fixed",
    "FramePlanner",
    "Ground",
    "GroundPath",
    "Grown",
    "Growth",
    "Instances",
    "Live",
    "Moment",
    "PerformanceControl",
    "PerformanceModel",
    "PerformanceSettings",
    "PieceTerms",
    "PlannerSettings",
    "Playhead",
    "PointsByRole",
    "Reasons",
    "RecordedSpan",
    "Reversal",
    "Rigid",
    "Rule",
    "Segment",
    "ShardedModel",
    "Similarity",
    "Source",
    "Steering",
    "SteeringFrames",
    "SteeringSettings",
    "Transcript",
    "arrivals",
    "at_rate",
    "begin_facing",
    "build_instances",
    "by_hand",
    "called",
    "check_alike",
    "contact_moments",
    "cut_segments",
    "cut_tracks",
    "cuts_of",
    "distances_to",
    "explain",
    "fine_borders",
    "fit_examples",
    "fit_without",
    "fitted_for",
    "foot_moments",
    "grow",
    "grow_rest",
    "grow_takes",
    "growing_control",
    "hips_on_ground",
    "interpret",
    "left_early",
    "legal_steps",
    "most_used",
    "next_best",
    "only_track",
    "over_shards",
    "partner_control",
    "path_on_ground",
    "path_speeds",
    "perform_read",
    "performances",
    "pieces_of",
    "points_of",
    "read_control",
    "realize",
    "recorded_speeds",
    "require_moves",
    "segment_distances",
    "settle",
    "short_pieces",
    "smooth_path",
    "times_running",
    "transcribe",
    "usual_grip",
    "with_settings",
]
