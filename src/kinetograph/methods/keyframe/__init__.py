"""Keyframe control: recordings lead from one pose to the next (Molina-Tanco & Hilton 2000, and beyond).

One method, `KeyframeControl`, and two solvers. `TimedSearch` goes over the recorded frames themselves: it meets every
key exactly, at the time and place asked for, and changes recordings only where poses and velocities meet.
`ClusterChain` is the paper: clusters of poses, their Markov chain, and a hidden Markov model whose states are the
examples.
"""

from kinetograph.methods.keyframe.cluster_chain import ClusterChain, FittedClusterChain
from kinetograph.methods.keyframe.examples import Example, adopt_named, collect_examples
from kinetograph.methods.keyframe.key_states import nearest_frame, state_sequence
from kinetograph.methods.keyframe.model import KeyframeControl, KeyframeModel
from kinetograph.methods.keyframe.motion_segments import Excerpt, excerpts_through
from kinetograph.methods.keyframe.solver import FittedSolver, Solver
from kinetograph.methods.keyframe.timed_search import FittedTimedSearch, TimedSearch
from kinetograph.methods.keyframe.two_levels import TwoLevelModel, pose_vectors

__all__ = [
    "ClusterChain",
    "Example",
    "Excerpt",
    "FittedClusterChain",
    "FittedSolver",
    "FittedTimedSearch",
    "KeyframeControl",
    "KeyframeModel",
    "Solver",
    "TimedSearch",
    "TwoLevelModel",
    "adopt_named",
    "collect_examples",
    "excerpts_through",
    "nearest_frame",
    "pose_vectors",
    "state_sequence",
]
