"""Functions of arrays that the three methods share; nothing here knows what a motion is.

The segmental programme of performance control and its alignments; Markov chains, hidden Markov models and the timed
search of keyframe control; local models, mixtures and continuity of sensor control. Searches that go step by step
(``init``, ``step``, ``finish``) are used through their modules: ``kinetograph.learn.segmental``,
``kinetograph.learn.continuity``. Modules are imported on first use, so that ``import kinetograph.learn`` stays quick.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

_ROOMS = {
    "Alignment": "alignment",
    "Arrivals": "segmental",
    "Classes": "posterior",
    "Commitment": "commitment",
    "Continued": "alignment",
    "Fixed": "alignment",
    "Gaussian": "posterior",
    "Goal": "goals",
    "Graph": "transitions",
    "Ground": "alignment",
    "Hypotheses": "commitment",
    "Lle": "embedding",
    "Mixture": "mixture",
    "PathSearch": "continuity",
    "PathState": "continuity",
    "Pca": "reduction",
    "Placement": "placement",
    "PreparedExamples": "alignment",
    "Quantiser": "kmeans",
    "Rbf": "interpolation",
    "Rigid": "alignment",
    "SearchOptions": "goals",
    "SearchState": "segmental",
    "SegmentalPath": "segmental",
    "SegmentalSearch": "segmental",
    "Similarity": "alignment",
    "Solution": "posterior",
    "Span": "retiming",
    "Stay": "goals",
    "UnreachableError": "markov",
    "Walk": "goals",
    "classes_of": "posterior",
    "complete_linkage": "linkage",
    "count_transitions": "markov",
    "find_transitions": "transitions",
    "fit_gaussian": "posterior",
    "fit_lle": "embedding",
    "fit_mixture": "mixture",
    "fit_pca": "reduction",
    "fit_rbf": "interpolation",
    "join_small": "mixture",
    "k_best_paths": "k_best",
    "learn_strengths": "trust",
    "levenberg_marquardt": "posterior",
    "likeliest_path": "markov",
    "make_graph": "transitions",
    "mixed": "posterior",
    "outputs_by_bayes": "hmm",
    "padded_width": "segmental",
    "prove": "segmental",
    "representatives": "linkage",
    "retime": "retiming",
    "search": "timed_search",
    "smooth_path": "smoothing",
    "solve": "segmental",
    "viterbi": "hmm",
    "withdrawal": "trust",
}

__all__ = [
    "Alignment",
    "Arrivals",
    "Classes",
    "Commitment",
    "Continued",
    "Fixed",
    "Gaussian",
    "Goal",
    "Graph",
    "Ground",
    "Hypotheses",
    "Lle",
    "Mixture",
    "PathSearch",
    "PathState",
    "Pca",
    "Placement",
    "PreparedExamples",
    "Quantiser",
    "Rbf",
    "Rigid",
    "SearchOptions",
    "SearchState",
    "SegmentalPath",
    "SegmentalSearch",
    "Similarity",
    "Solution",
    "Span",
    "Stay",
    "UnreachableError",
    "Walk",
    "classes_of",
    "complete_linkage",
    "count_transitions",
    "find_transitions",
    "fit_gaussian",
    "fit_lle",
    "fit_mixture",
    "fit_pca",
    "fit_rbf",
    "join_small",
    "k_best_paths",
    "learn_strengths",
    "levenberg_marquardt",
    "likeliest_path",
    "make_graph",
    "mixed",
    "outputs_by_bayes",
    "padded_width",
    "prove",
    "representatives",
    "retime",
    "search",
    "smooth_path",
    "solve",
    "viterbi",
    "withdrawal",
]


def __getattr__(name: str) -> Any:
    if name not in _ROOMS:
        raise AttributeError(f"module 'kinetograph.learn' has no attribute {name!r}")
    return getattr(importlib.import_module(f"kinetograph.learn.{_ROOMS[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)


if TYPE_CHECKING:
    from kinetograph.learn.alignment import Alignment, Continued, Fixed, Ground, PreparedExamples, Rigid, Similarity
    from kinetograph.learn.commitment import Commitment, Hypotheses
    from kinetograph.learn.continuity import PathSearch, PathState
    from kinetograph.learn.embedding import Lle, fit_lle
    from kinetograph.learn.goals import Goal, SearchOptions, Stay, Walk
    from kinetograph.learn.hmm import outputs_by_bayes, viterbi
    from kinetograph.learn.interpolation import Rbf, fit_rbf
    from kinetograph.learn.k_best import k_best_paths
    from kinetograph.learn.kmeans import Quantiser
    from kinetograph.learn.linkage import complete_linkage, representatives
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
    from kinetograph.learn.reduction import Pca, fit_pca
    from kinetograph.learn.retiming import Span, retime
    from kinetograph.learn.segmental import (
        Arrivals,
        SearchState,
        SegmentalPath,
        SegmentalSearch,
        padded_width,
        prove,
        solve,
    )
    from kinetograph.learn.smoothing import smooth_path
    from kinetograph.learn.timed_search import search
    from kinetograph.learn.transitions import Graph, find_transitions, make_graph
    from kinetograph.learn.trust import learn_strengths, withdrawal
