"""Functions of arrays that the three methods share; nothing here knows what a motion is.

The segmental programme of performance control and its alignments; Markov chains, hidden Markov models and the timed
search of keyframe control; local models, mixtures and continuity of sensor control. A segmental search that goes on
while its control still arrives is used through its modules, ``segmental``, ``commitment`` and ``unfinished``. Modules
are imported on first use, so that ``import kinetograph.learn`` stays quick.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

_ROOMS = {
    "Affine": "alignment",
    "Alignment": "alignment",
    "Arrivals": "segmental",
    "Classes": "posterior",
    "ClosePairs": "linkage",
    "Commitment": "commitment",
    "Continued": "alignment",
    "Effort": "retrieval",
    "Fixed": "alignment",
    "FrameGraph": "frame_programme",
    "FrameRules": "frame_programme",
    "Gate": "gating",
    "Gaussian": "posterior",
    "Goal": "goals",
    "Graph": "transitions",
    "Ground": "alignment",
    "Hypotheses": "commitment",
    "KernelRegression": "kernel_ridge",
    "Lle": "embedding",
    "Margins": "margins",
    "Mixture": "mixture",
    "NearSearch": "retrieval",
    "NearState": "retrieval",
    "NeighbourLists": "retrieval",
    "PathSearch": "continuity",
    "PathState": "continuity",
    "Pca": "reduction",
    "Placement": "placement",
    "Plan": "frame_programme",
    "Playing": "frame_programme",
    "PreparedExamples": "alignment",
    "Passing": "margins",
    "PricedPath": "margins",
    "Prior": "gating",
    "Quantiser": "quantisation",
    "Rbf": "interpolation",
    "Reuse": "reuse",
    "Rigid": "alignment",
    "Route": "routes",
    "RouteSegment": "routes",
    "SearchOptions": "goals",
    "SearchState": "segmental",
    "SegmentalPath": "segmental",
    "SegmentalSearch": "segmental",
    "Similarity": "alignment",
    "Solution": "posterior",
    "Span": "retiming",
    "Spread": "spread",
    "StepCosts": "retrieval",
    "Tolls": "goals",
    "UnreachableError": "markov",
    "Way": "goals",
    "Windows": "windows",
    "advance_body": "frame_programme",
    "bar": "transitions",
    "best_near": "retrieval",
    "best_paths": "continuity",
    "blocks": "spread",
    "classes_of": "posterior",
    "complete_linkage": "linkage",
    "cost_of_changes": "segmental",
    "count_transitions": "markov",
    "discourage": "transitions",
    "fading": "reuse",
    "find_margins": "margins",
    "find_route": "timed_search",
    "find_transitions": "transitions",
    "fit_gaussian": "posterior",
    "fit_gate": "gating",
    "fit_kernel_ridge": "kernel_ridge",
    "fit_lists": "retrieval",
    "fit_lle": "embedding",
    "fit_mixture": "mixture",
    "fit_pca": "reduction",
    "fit_rbf": "interpolation",
    "gram_of": "kernel_ridge",
    "init_near": "retrieval",
    "init_paths": "continuity",
    "inverse_of": "kernel_ridge",
    "join_small": "mixture",
    "k_best_paths": "k_best",
    "keep_transitions": "transitions",
    "kernel_width": "kernel_ridge",
    "kmeans": "quantisation",
    "last_frames": "transitions",
    "learn_strengths": "trust",
    "least_interval": "goals",
    "least_steps": "goals",
    "left_out": "kernel_ridge",
    "levenberg_marquardt": "posterior",
    "likeliest_path": "markov",
    "linked": "linkage",
    "lists_without": "retrieval",
    "make_graph": "transitions",
    "mixed": "posterior",
    "nearest_columns": "continuity",
    "nearest_listed": "retrieval",
    "outputs_by_bayes": "hmm",
    "padded_width": "segmental",
    "plan_frames": "frame_programme",
    "price_path": "margins",
    "prove": "proving",
    "representatives": "linkage",
    "retime": "retiming",
    "shrinkage": "trust",
    "score_moments": "margins",
    "smooth_path": "smoothing",
    "solve": "segmental",
    "spread_of": "spread",
    "squared_distances": "distances",
    "squared_distances_to": "distances",
    "step_near": "retrieval",
    "step_paths": "continuity",
    "viterbi": "hmm",
}

__all__ = [
    "Affine",
    "Alignment",
    "Arrivals",
    "Classes",
    "ClosePairs",
    "Commitment",
    "Continued",
    "Effort",
    "Fixed",
    "FrameGraph",
    "FrameRules",
    "Gate",
    "Gaussian",
    "Goal",
    "Graph",
    "Ground",
    "Hypotheses",
    "KernelRegression",
    "Lle",
    "Margins",
    "Mixture",
    "NearSearch",
    "NearState",
    "NeighbourLists",
    "Passing",
    "PathSearch",
    "PathState",
    "Pca",
    "Placement",
    "Plan",
    "Playing",
    "PreparedExamples",
    "PricedPath",
    "Prior",
    "Quantiser",
    "Rbf",
    "Reuse",
    "Rigid",
    "Route",
    "RouteSegment",
    "SearchOptions",
    "SearchState",
    "SegmentalPath",
    "SegmentalSearch",
    "Similarity",
    "Solution",
    "Span",
    "Spread",
    "StepCosts",
    "Tolls",
    "UnreachableError",
    "Way",
    "Windows",
    "advance_body",
    "bar",
    "best_near",
    "best_paths",
    "blocks",
    "classes_of",
    "complete_linkage",
    "cost_of_changes",
    "count_transitions",
    "discourage",
    "fading",
    "find_margins",
    "find_route",
    "find_transitions",
    "fit_gate",
    "fit_gaussian",
    "fit_kernel_ridge",
    "fit_lists",
    "fit_lle",
    "fit_mixture",
    "fit_pca",
    "fit_rbf",
    "gram_of",
    "init_near",
    "init_paths",
    "inverse_of",
    "join_small",
    "k_best_paths",
    "keep_transitions",
    "kernel_width",
    "kmeans",
    "last_frames",
    "learn_strengths",
    "least_interval",
    "least_steps",
    "left_out",
    "levenberg_marquardt",
    "likeliest_path",
    "linked",
    "lists_without",
    "make_graph",
    "mixed",
    "nearest_columns",
    "nearest_listed",
    "outputs_by_bayes",
    "padded_width",
    "plan_frames",
    "price_path",
    "prove",
    "representatives",
    "retime",
    "score_moments",
    "shrinkage",
    "smooth_path",
    "solve",
    "spread_of",
    "squared_distances",
    "squared_distances_to",
    "step_near",
    "step_paths",
    "viterbi",
]


def __getattr__(name: str) -> Any:
    if name not in _ROOMS:
        raise AttributeError(f"module 'kinetograph.learn' has no attribute {name!r}")
    return getattr(importlib.import_module(f"kinetograph.learn.{_ROOMS[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)


if TYPE_CHECKING:
    from kinetograph.learn.alignment import (
        Affine,
        Alignment,
        Continued,
        Fixed,
        Ground,
        PreparedExamples,
        Rigid,
        Similarity,
    )
    from kinetograph.learn.commitment import Commitment, Hypotheses
    from kinetograph.learn.continuity import (
        PathSearch,
        PathState,
        best_paths,
        init_paths,
        nearest_columns,
        step_paths,
    )
    from kinetograph.learn.distances import squared_distances, squared_distances_to
    from kinetograph.learn.embedding import Lle, fit_lle
    from kinetograph.learn.frame_programme import FrameGraph, FrameRules, Plan, Playing, advance_body, plan_frames
    from kinetograph.learn.gating import Gate, Prior, fit_gate
    from kinetograph.learn.goals import Goal, SearchOptions, Tolls, Way, least_interval, least_steps
    from kinetograph.learn.hmm import outputs_by_bayes, viterbi
    from kinetograph.learn.interpolation import Rbf, fit_rbf
    from kinetograph.learn.k_best import k_best_paths
    from kinetograph.learn.kernel_ridge import (
        KernelRegression,
        fit_kernel_ridge,
        gram_of,
        inverse_of,
        kernel_width,
        left_out,
    )
    from kinetograph.learn.linkage import ClosePairs, complete_linkage, linked, representatives
    from kinetograph.learn.margins import Margins, Passing, PricedPath, find_margins, price_path, score_moments
    from kinetograph.learn.markov import UnreachableError, count_transitions, likeliest_path
    from kinetograph.learn.mixture import Mixture, fit_mixture, join_small
    from kinetograph.learn.placement import Placement
    from kinetograph.learn.posterior import (
        Classes,
        Gaussian,
        Solution,
        classes_of,
        fit_gaussian,
        levenberg_marquardt,
        mixed,
    )
    from kinetograph.learn.proving import prove
    from kinetograph.learn.quantisation import Quantiser, kmeans
    from kinetograph.learn.reduction import Pca, fit_pca
    from kinetograph.learn.retiming import Span, retime
    from kinetograph.learn.retrieval import (
        Effort,
        NearSearch,
        NearState,
        NeighbourLists,
        StepCosts,
        best_near,
        fit_lists,
        init_near,
        lists_without,
        nearest_listed,
        step_near,
    )
    from kinetograph.learn.reuse import Reuse, fading
    from kinetograph.learn.routes import Route, RouteSegment
    from kinetograph.learn.segmental import (
        Arrivals,
        SearchState,
        SegmentalPath,
        SegmentalSearch,
        cost_of_changes,
        padded_width,
        solve,
    )
    from kinetograph.learn.smoothing import smooth_path
    from kinetograph.learn.spread import Spread, blocks, spread_of
    from kinetograph.learn.timed_search import find_route
    from kinetograph.learn.transitions import (
        Graph,
        bar,
        discourage,
        find_transitions,
        keep_transitions,
        last_frames,
        make_graph,
    )
    from kinetograph.learn.trust import learn_strengths, shrinkage
    from kinetograph.learn.windows import Windows
