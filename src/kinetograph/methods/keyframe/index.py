"""The index of a library for the timed search: features of every frame, and where recordings may be changed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import BoolArray, IntArray
from kinetograph.learn import Graph, find_transitions, keep_transitions, last_frames
from kinetograph.methods.keyframe.examples import Example
from kinetograph.methods.keyframe.falls import falls_freely
from kinetograph.methods.keyframe.features import PoseFeatures, fastest_step, pose_features
from kinetograph.methods.keyframe.quality import Ordinary, ordinary_of
from kinetograph.skeleton import Skeleton


@dataclass(frozen=True, eq=False)
class PoseIndex:
    """All frames of the examples, laid end to end.

    Parameters
    ----------
    examples : tuple of Example
    features : PoseFeatures
    graph : Graph
        Transitions between frames.
    offsets : ndarray of int, shape (E + 1,)
        Where each example begins.
    speed : float
        Metres that a recording moves in a frame at most.
    barred : ndarray of bool, shape (N,)
        The frames that are not used.
    ordinary : Ordinary
        What is ordinary in the examples, by which results are judged.
    """

    examples: tuple[Example, ...]
    features: PoseFeatures
    graph: Graph
    offsets: IntArray
    speed: float
    barred: BoolArray
    ordinary: Ordinary

    @property
    def fps(self) -> float:
        """Frames per second."""
        return self.examples[0].motion.fps

    @property
    def skeleton(self) -> Skeleton:
        """The skeleton of all examples."""
        return self.examples[0].motion.skeleton

    def locate(self, frame: int) -> tuple[int, int]:
        """The example that a frame of the index belongs to, and its frame there."""
        example = int(np.searchsorted(self.offsets, frame, side="right")) - 1
        return example, frame - int(self.offsets[example])


def build_index(examples: tuple[Example, ...], *, meet: float, shortest: float, scale: float, fee: float) -> PoseIndex:
    """Compare all frames and find the transitions; see `kinetograph.methods.keyframe.TimedSearch` for the arguments."""
    features = pose_features(examples)
    lengths = [len(example.motion) for example in examples]
    commit = max(round(shortest * examples[0].motion.fps), 1)
    graph = find_transitions(features.together(), last_frames(lengths), commit, meet, scale, fee)
    graph = keep_transitions(graph, falls_freely(examples, graph))
    offsets = np.concatenate([[0], np.cumsum(lengths)])
    barred = np.zeros(len(graph), dtype=np.bool_)
    return PoseIndex(examples, features, graph, offsets, fastest_step(examples), barred, ordinary_of(examples))
