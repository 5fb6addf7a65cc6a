"""Search over recorded frames: the index, the goals that keys stand for, and what is known before any search."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.learn.goals import Goal, SearchOptions, Walk, least_leg, least_steps
from kinetograph.learn.timed_search import search
from kinetograph.learn.transitions import Graph, discourage, find_transitions, lasts
from kinetograph.methods.keyframe.examples import Example
from kinetograph.methods.keyframe.features import PoseFeatures, fastest_step, key_distances, pose_features
from kinetograph.motion import headings

UNLIKE = 20.0
"""What a transition costs more in an alternative to a walk that has one like it: a quarter of a metre's gap."""


@dataclass(frozen=True)
class SearchSettings:
    """Parameters of the search.

    meet: metres, how far poses and velocities may be apart where one recording is left for another. shortest: seconds
    that a recording is played at least. scale: metres of distance at a seam that cost 1; fee: what a seam costs
    besides. pose_scale: metres between a key and a recorded frame that cost 1; candidates: frames tried for a key,
    none more than ``slack`` metres further off than the nearest. warp:
    how far a leg between two keys may be stretched or squeezed in time. longest: seconds of the longest leg.
    haste: cost of a second, where durations are free. beam: states kept at each step. off_place: metres, and off_share
    of the way, that a walk may end away from a pinned place before it is bent there. decay: seconds over which the
    edit that meets a key fades.
    """

    meet: float = 0.65
    shortest: float = 0.3
    scale: float = 0.08
    fee: float = 0.5
    pose_scale: float = 0.08
    candidates: int = 96
    slack: float = 0.1
    warp: float = 0.15
    longest: float = 12.0
    haste: float = 0.1
    beam: int = 3000
    off_place: float = 0.3
    off_share: float = 0.3
    decay: float = 0.5

    def __post_init__(self) -> None:
        for name in ("meet", "shortest", "scale", "pose_scale", "longest", "decay"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise RequestError(f"{name} must be a positive number, found {getattr(self, name)}")
        if not 0 <= self.warp < 0.5:
            raise RequestError(f"warp is a share of the time from 0 to below 0.5, found {self.warp}")
        if self.beam < 1 or self.candidates < 1:
            raise RequestError("expected a beam and candidates of 1 or more")


@dataclass(frozen=True, eq=False)
class SearchModel:
    """The index of a library: features and transitions of every frame. offsets ``(E + 1,)``: where examples begin."""

    settings: SearchSettings
    examples: tuple[Example, ...]
    features: PoseFeatures
    graph: Graph
    offsets: FloatArray
    speed: float

    @property
    def fps(self) -> float:
        """Frames a second."""
        return self.examples[0].motion.fps

    def locate(self, frame: int) -> tuple[int, int]:
        """The example and its frame of a frame of the index."""
        example = int(np.searchsorted(self.offsets, frame, side="right")) - 1
        return example, frame - int(self.offsets[example])


def fit_search(examples: tuple[Example, ...], settings: SearchSettings) -> SearchModel:
    """Build the index."""
    features = pose_features(examples)
    lengths = [len(example.motion) for example in examples]
    commit = max(round(settings.shortest * examples[0].motion.fps), 1)
    graph = find_transitions(features.together(), lasts(lengths), commit, settings.meet, settings.scale, settings.fee)
    offsets = np.concatenate([[0], np.cumsum(lengths)])
    model = SearchModel(settings, examples, features, graph, offsets, fastest_step(examples))
    # compiled kernels are loaded by their first call: not while someone waits for an answer
    goals_of(model, (Key(examples[0].motion),))
    least_steps(graph, Goal(np.zeros(1, dtype=np.int64), np.zeros(1)), most=0.0)
    return model


def goals_of(model: SearchModel, keys: tuple[Key, ...]) -> tuple[list[Goal], list[float]]:
    """What the keys ask of the search, and how far each is from the nearest recorded pose, metres."""
    goals, nearest = [], []
    skeleton = model.examples[0].motion.skeleton
    before: complex | None = None
    for number, key in enumerate(keys):
        distances = key_distances(model.features, key, skeleton)
        count = min(model.settings.candidates, len(distances))
        frames = np.argpartition(distances, count - 1)[:count].astype(np.int64)
        nearest.append(float(distances[frames].min()))
        place, heading = pinned(key, first=number == 0)
        way = 0.0 if place is None or before is None else abs(place - before)
        reach = model.settings.off_place + model.settings.off_share * way
        frames = frames[distances[frames] <= nearest[-1] + model.settings.slack]
        costs = (distances[frames] / model.settings.pose_scale) ** 2
        goals.append(Goal(frames, costs, _window(key, model.fps, first=number == 0), place, heading, reach))
        before = place if place is not None else before
    return goals, nearest


def pinned(key: Key, *, first: bool) -> tuple[complex | None, float | None]:
    """Where a key is on the ground and how it faces; a first key that says neither stands where it does in its clip."""
    place = None if key.position is None else complex(key.position[1], key.position[0])
    heading = key.heading
    if first:
        x, _, z = key.clip.translation[key.frame]
        place = complex(z, x) if place is None else place
        heading = float(headings(key.clip)[key.frame]) if heading is None else heading
    return place, heading


def _window(key: Key, fps: float, *, first: bool) -> tuple[float, float]:
    if first or key.time is None:
        return (0.0, 0.0) if first else (0.0, np.inf)
    low, high = key.time
    if low == high:
        return float(round(low * fps)), float(round(low * fps))
    return float(np.ceil(low * fps - 1e-6)), float(np.floor(high * fps + 1e-6))


def check_feasible(model: SearchModel, keys: tuple[Key, ...], goals: list[Goal]) -> list[float]:
    """The least seconds of every leg. Raises RequestError, with the figure, where one asks for less."""
    least = []
    earliest = 0.0
    for a, b, before, after in zip(goals[:-1], goals[1:], keys[:-1], keys[1:], strict=True):
        room = (b.window[1] - a.window[0]) * (1 + model.settings.warp)
        steps = least_leg(model.graph, a, b, room)
        if not np.isfinite(steps):  # it takes more than there is room for, if there is a way at all: how much?
            steps = least_leg(model.graph, a, b)
        if not np.isfinite(steps):
            raise RequestError(
                f"no recordings lead from {before.label} to {after.label}: nowhere do poses and velocities meet within "
                f"{model.settings.meet:g} m; add a recording that goes between, or raise meet"
            )
        quick = np.ceil(steps * (1 - model.settings.warp))
        if b.window[1] < earliest + quick - 1e-9:
            asked = (b.window[1] - earliest) / model.fps
            raise RequestError(
                f"from {before.label} to {after.label} takes {quick / model.fps:.2f} s at least "
                f"({steps / model.fps:.2f} s of recordings, {model.settings.warp:.0%} faster), and {asked:.2f} s are "
                "given; give it more time"
            )
        if steps > model.settings.longest * model.fps:
            raise RequestError(
                f"from {before.label} to {after.label} takes {steps / model.fps:.2f} s at least, and a leg may last "
                f"{model.settings.longest:g} s; raise longest"
            )
        earliest = max(earliest + quick, b.window[0])
        least.append(steps / model.fps)
    return least


def solve(model: SearchModel, keys: tuple[Key, ...], goals: list[Goal], count: int = 1) -> list[Walk]:
    """Up to ``count`` walks, the best first, each one discouraged from the transitions of those before.

    Raises RequestError where the times and places asked for leave none.
    """
    settings = model.settings
    free = any(goal.window[0] != goal.window[1] for goal in goals[1:])
    options = SearchOptions(
        beam=settings.beam,
        warp=settings.warp,
        step_fee=settings.haste / model.fps if free else 0.0,
        longest=round(settings.longest * model.fps),
        speed=model.speed,
    )
    graph, walks = model.graph, list[Walk]()
    for _ in range(count):
        walk = search(graph, goals, model.features.ground, model.features.facing, options)
        if walk is None or walk.stays in [other.stays for other in walks]:
            break
        walks.append(walk)
        used = np.array([stay.edge for stay in walk.stays if stay.edge >= 0], dtype=np.int64)
        graph = discourage(graph, used, UNLIKE, round(0.5 * model.fps)) if count > 1 else graph
    if not walks:
        pins = [key.label for key in keys[1:] if key.position is not None or key.heading is not None]
        what = f"the places of {', '.join(pins)} and the times" if pins else "the times"
        raise RequestError(
            f"no walk through the recordings meets {what} asked for; leave one of them free, give a window of time, "
            "or add recordings"
        )
    return walks
