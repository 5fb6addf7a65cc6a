"""Performance control (Hsu 2004): a control motion is interpreted as stretched, placed segments of recordings.

Notation: ``x`` is the control, ``a`` a control segment, ``b`` its target segment, ``s, d`` a segment and its number of
steps, ``M`` the transform that aligns ``a`` with ``x``, ``k`` the continuity constant.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.learn.alignment import GROUPS, SCALES, Placement, align, unknown_group
from kinetograph.learn.segmental import Arrivals, SegmentalPath, SegmentalSearch, padded_width, prove
from kinetograph.methods.performance.control_points import ControlReading, GroundPath, PointsByRole
from kinetograph.methods.performance.realize import realize
from kinetograph.methods.performance.segments import Instances, Source
from kinetograph.methods.performance.sources import collect
from kinetograph.motion import Motion
from kinetograph.post.assemble import PostSettings
from kinetograph.post.limits import JointRange, limbs_of, seen_ranges
from kinetograph.progress import Progress
from kinetograph.sampling import interpolate
from kinetograph.signal import Signal
from kinetograph.synthesis import Synthesis
from kinetograph.take import Take

if TYPE_CHECKING:
    from kinetograph.library import Library
    from kinetograph.methods.performance.live import Live
    from kinetograph.methods.performance.rules import Rule

PLACEMENTS = 1 << 21
"""Placements of segments that are worked out at once; each takes some hundred bytes."""

END_EFFECTORS: Mapping[str, float] = MappingProxyType(
    {"left_toe": 1.0, "right_toe": 1.0, "left_hand": 1.0, "right_hand": 1.0}
)
BODY: Mapping[str, float] = MappingProxyType(
    {"hips": 2.0, "chest": 2.0, "left_toe": 0.5, "right_toe": 0.5, "left_hand": 0.5, "right_hand": 0.5}
)


@dataclass(frozen=True)
class PerformanceControl:
    """Configuration of performance control.

    continuity: k, the weight of continuity against interpretation, in seconds (D is integrated over time).
    stretch: how far a segment may be stretched or squeezed, seconds. rate: of the search, Hz; fine_rate: of the
    constrained search that adjusts durations, Hz, or None to leave them. alignment: ``"ground"``, ``"similarity"``,
    ``"rigid"``, or ``"fixed"`` or ``"none"``, which are one; scales: least and greatest, for similarity; placing: where
    segments go without an alignment, ``"recorded"`` or ``"continued"``, on from where the one before ends. control: how
    control points are read: `GroundPath` for walks, `PointsByRole` for partners, `Channels` for what is not spatial.
    span: cuts that a segment goes on for; from 2 on, segments begin at every cut and overlap. targets: weights of the
    roles whose positions are compared across seams. beam: width of the beam search, or None for the exact one.
    cluster: metres; segments closer than this to one another are represented by one of them, or None. mirror: also
    use every recording mirrored. longest: seconds of the longest segment used. post: what happens to the chosen
    segments afterwards.
    """

    continuity: float = 0.1
    stretch: float = 0.2
    rate: float = 10.0
    fine_rate: float | None = 30.0
    alignment: str = "ground"
    scales: tuple[float, float] = SCALES
    placing: str = "recorded"
    control: ControlReading = field(default_factory=GroundPath)
    span: int = 1
    targets: Mapping[str, float] = field(default_factory=lambda: END_EFFECTORS)
    beam: float | None = None
    cluster: float | None = None
    mirror: bool = False
    longest: float = 2.5
    post: PostSettings = field(default_factory=PostSettings)

    def __post_init__(self) -> None:
        if not self.targets:
            raise RequestError("targets must name at least one role, found none")
        for name in ("continuity", "stretch"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise RequestError(f"{name} must be 0 or more, found {getattr(self, name)}")
        for name in ("rate", "longest"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise RequestError(f"{name} must be a positive number, found {getattr(self, name)}")
        if self.alignment not in GROUPS:
            raise unknown_group(self.alignment)
        if self.placing not in ("recorded", "continued"):
            raise RequestError(f"placing must be recorded or continued, found {self.placing!r}")
        if self.placing == "continued" and self.alignment not in ("fixed", "none"):
            raise RequestError(f"segments are continued without alignment only; found {self.alignment!r}, not none")
        if not self.control.spatial and self.alignment not in ("fixed", "none"):
            raise RequestError(f"channels are in no space: alignment must be none, found {self.alignment!r}")
        if not 0 < self.scales[0] <= 1 <= self.scales[1] < np.inf:
            raise RequestError(f"scales run from one in (0, 1] to one of 1 or more, found {self.scales}")
        if self.span < 1:
            raise RequestError(f"span must be 1 cut or more, found {self.span}")
        object.__setattr__(self, "targets", MappingProxyType(dict(self.targets)))

    def fit(
        self,
        library: Library,
        *,
        exclude: tuple[str, ...] = (),
        track: str | None = None,
        rng: np.random.Generator | None = None,
    ) -> PerformanceModel:
        """Cut the library's takes into mapping instances (chapter 3).

        exclude leaves takes out, by name. rng draws the segments that represent clusters, as the thesis does; without
        it they are the medoids. Raises RequestError where takes have different skeletons, or no segment is found.
        """
        return PerformanceModel(self, *collect(self, library, exclude, track, rng))


@dataclass(frozen=True, eq=False)
class PerformanceModel:
    """A library made ready for one configuration: sources, instances and the search over them."""

    method: PerformanceControl
    sources: tuple[Source, ...]
    instances: Instances
    notes: tuple[str, ...] = ()

    @property
    def search(self) -> SegmentalSearch:
        """The segmental search of section 4.3 over this model's states."""
        return SegmentalSearch(self.instances.states[:, 1], self.method.continuity, self.method.beam)

    @cached_property
    def basis(self) -> FloatArray:
        """Mixtures of the target points, shape ``(Q, Q)``, whose squared distances add up to the weighted ones.

        They are the principal ones of how ends of segments differ on the ground: most of any distance lies in the
        first ones, by which the search rules most predecessors out.
        """
        scale = np.sqrt(np.array(list(self.method.targets.values()), dtype=np.float64))
        ends = np.concatenate([self.instances.heads, self.instances.tails]) * scale[:, None]
        ground = ends[..., [0, 2]] - ends[..., [0, 2]].mean(axis=1, keepdims=True)
        _, vectors = np.linalg.eigh(np.einsum("npi,nqi->pq", ground, ground))
        return np.asarray(vectors.T[::-1] * scale)

    @cached_property
    def mixed_ends(self) -> tuple[FloatArray, FloatArray]:
        """The basis' mixtures of the target points ``(N, Q, 3)`` at the head and the tail of every segment."""
        return self.basis @ self.instances.heads, self.basis @ self.instances.tails

    @cached_property
    def state_ends(self) -> tuple[FloatArray, FloatArray]:
        """The same for every state, ``(S, Q, 3)``."""
        segments = self.instances.states[:, 0]
        heads, tails = self.mixed_ends
        return heads[segments], tails[segments]

    @cached_property
    def basis_sums(self) -> FloatArray:
        """How much of a shift each mixture takes, shape ``(Q,)``."""
        return np.asarray(self.basis.sum(axis=1))

    @cached_property
    def joint_ranges(self) -> tuple[JointRange, ...]:
        """How far the recordings turn the joints of arms and legs."""
        motions = [source.motion for source in self.sources]
        return seen_ranges(motions, itertools.chain(*limbs_of(motions[0].skeleton)))

    def control_points(self, control: Signal | Motion) -> FloatArray:
        """The control points of a control, shape ``(F, P, 3)``, at its own rate.

        Raises RequestError for a signal with samples missing.
        """
        if isinstance(control, Signal) and not control.valid.all():
            frame = int(np.flatnonzero(~control.valid.all(axis=1))[0])
            raise RequestError(
                f"the control misses {int((~control.valid).sum())} samples, the first at {frame / control.fps:.2f} s; "
                "fill them in first"
            )
        return self.method.control.points(control)

    def at_search_rate(self, points: FloatArray, fps: float) -> FloatArray:
        """Control points ``(F, P, 3)`` at ``fps``, resampled to the rate of the search: ``(T + 1, P, 3)``."""
        count = int(np.floor((len(points) - 1) / fps * self.method.rate + 1e-6)) + 1
        return interpolate(points, np.arange(count) / self.method.rate * fps)

    def interpret(self, x: FloatArray, progress: Progress | None = None, rules: Sequence[Rule] = ()) -> SegmentalPath:
        """The best sequence of states for control points ``x``, shape ``(T + 1, P, 3)`` at the search's rate.

        rules: what is pinned or forbidden. Raises RequestError for a control shorter than any segment can be made.
        """
        steps, rate, shortest = len(x) - 1, self.method.rate, int(self.instances.states[0, 1])
        if steps < 1:
            raise RequestError(f"the control is too short: expected 2 samples at {rate:g} Hz or more")
        if steps < shortest:
            raise RequestError(
                f"the control is too short: it lasts {steps / rate:.2f} s, the library's shortest segment, squeezed, "
                f"{shortest / rate:.2f} s; record more of it, or cut the library finer (library segment)"
            )
        partial = self.left_early(x)
        if not rules:
            return prove(self.search, lambda: self.arrivals(x, progress), partial)
        from kinetograph.methods.performance.rules import bind, bind_partial

        bound = bind_partial(self, rules, partial, steps)
        return prove(self.search, lambda: bind(self, rules, self.arrivals(x, progress)), bound)

    def start(self, fps: float, lag: float | None = None) -> Live:
        """Begin a control that arrives frame by frame at ``fps``; pieces are decided ``lag`` seconds later at most.

        Where velocities are among the control points, they are known a frame later.
        """
        from kinetograph.methods.performance.live import Live

        if not (np.isfinite(fps) and fps > 0) or (lag is not None and not lag >= 0):
            raise RequestError(f"fps must be positive and lag 0 or more, found {fps} and {lag}")
        return Live(self, fps, lag)

    def synthesize(
        self, control: Take | Signal | Motion, progress: Progress | None = None, rules: Sequence[Rule] = ()
    ) -> Synthesis:
        """A motion that performs the control (chapters 4 and 5): a path, a walker's motion, or a take that is one.

        Handholds that a take has annotated, ``own hand:partner's hand``, are met in place of those that the
        recordings carry over. progress is called with the steps done and their number. rules: what is pinned or
        forbidden. Raises RequestError for a control without direction, or too short for the search's rate.
        """
        track = only_track(control) if isinstance(control, Take) else control
        notes = control.annotations if isinstance(control, Take) else ()
        told = tuple(note for note in notes if note.kind == "handhold")
        points = self.control_points(track)
        path = self.interpret(self.at_search_rate(points, track.fps), progress, rules)
        return realize(self, points, track.fps, path, track if isinstance(track, Motion) else None, told)

    def alternatives(
        self, control: Take | Signal | Motion, count: int = 3, rules: Sequence[Rule] = (), *, alike: bool = False
    ) -> tuple[Synthesis, ...]:
        """The best motion for a control and up to ``count`` - 1 others.

        Each is the best that shares no piece with those before. alike: the best of all instead, which may differ by a
        border only. Raises RequestError as `synthesize` does.
        """
        from kinetograph.methods.performance.rules import alternatives, best_sequences

        track = only_track(control) if isinstance(control, Take) else control
        points = self.control_points(track)
        x = self.at_search_rate(points, track.fps)
        paths = (best_sequences if alike else alternatives)(self, x, count, rules)
        partner = track if isinstance(track, Motion) else None
        return tuple(realize(self, points, track.fps, path, partner) for path in paths)

    def beam_gap(self, control: Signal | Motion) -> float:
        """How much worse than the optimum the configured beam scores on a control, as a share of the optimum."""
        x = self.at_search_rate(self.control_points(control), control.fps)
        exact = replace(self, method=replace(self.method, beam=None)).interpret(x).score
        return self.interpret(x).score / exact - 1.0 if exact > 0 else 0.0

    def arrivals(self, x: FloatArray, progress: Progress | None = None) -> Iterator[Arrivals]:
        """Every step's input to the search: first the steps at which some states are partial, then whole chunks."""
        steps, longest = len(x) - 1, self.instances.longest
        chunk = max(min(256, PLACEMENTS // len(self.instances.states)), 1)
        for t in range(1, min(longest, steps + 1)):
            yield self.arrivals_at(x[: t + 1])
        for low in range(longest, steps + 1, chunk):
            high = min(low + chunk, steps + 1)
            windows = np.lib.stride_tricks.sliding_window_view(x[low - longest : high], longest + 1, axis=0)
            costs, placement = self._align(np.moveaxis(windows, -1, 1), slice(None))
            for i in range(high - low):
                yield self._arrival(costs, placement, i)
            if progress:
                progress(high - 1, steps)

    def arrivals_at(self, x: FloatArray) -> Arrivals:
        """The input of the step at the last of the samples ``x``: at most the longest state's, fewer at the start."""
        costs, placement = self._align(x[None], slice(-len(x), None))
        return self._arrival(costs, placement, 0)

    def left_early(self, x: FloatArray, used: Sequence[int] | None = None) -> dict[int, Arrivals]:
        """By number of steps used, all or some, the states that are left before their end where ``x`` ends."""
        steps = range(1, min(self.instances.longest, len(x))) if used is None else used
        return {e: self._left_early(x, e) for e in steps}

    def _left_early(self, x: FloatArray, used: int) -> Arrivals:
        """The states of which only the first ``used`` steps fit before the control's end."""
        costs, placement = self._align(x[None, -used - 1 :], slice(used + 1))
        return self._arrival(costs, placement, 0)

    def _align(self, windows: FloatArray, part: slice) -> tuple[FloatArray, Placement]:
        """D and placements of all states, ``part`` of their samples, against windows ``(B, W, P, 3)``."""
        costs, placements = [], []
        for examples in self.instances.controls.values():
            used = examples[:, part]
            samples = used.shape[1]
            group, scales = self.method.alignment, self.method.scales
            d, placed = align(group, windows[:, -samples:], used, self.weights(samples), scales)
            costs.append(d)
            placements.append(placed)
        return np.concatenate(costs, axis=1), placements[0].join(placements[1:])

    def weights(self, samples: int, rate: float | None = None) -> FloatArray:
        """Weights ``(samples, P)`` of the trapezium rule in seconds: neighbours share the sample on their border."""
        w = np.full(samples, 1.0 / (rate or self.method.rate))
        w[[0, -1]] *= 0.5
        return np.outer(w, self.method.control.weights())

    def _arrival(self, costs: FloatArray, placement: Placement, window: int) -> Arrivals:
        width = padded_width(3 * len(self.basis))
        heads, tails = (placement.ends(window, ends, self.basis_sums, width) for ends in self.state_ends)
        return Arrivals(costs[window], heads, tails)

    def speed_range(self) -> tuple[float, float]:
        """Slowest and fastest mean ground speed of the segments, metres a second, at the stretches allowed."""
        speeds = []
        for steps, controls in self.instances.controls.items():
            middle = controls.mean(axis=2)
            length = np.linalg.norm(np.diff(middle, axis=1), axis=-1).sum(axis=1)
            speeds.append(length * self.method.rate / steps)
        together = np.concatenate(speeds)
        return float(together.min()), float(together.max())


def partner_control() -> PerformanceControl:
    """The configuration for partner dance, as it was found on held-out dances: two-beat segments that overlap."""
    return PerformanceControl(
        continuity=0.1,
        stretch=0.15,
        rate=7.5,
        control=PointsByRole(velocity=0.2),
        span=2,
        targets=BODY,
    )


def only_track(take: Take) -> Signal | Motion:
    """The one track of a take. Raises RequestError where there are several."""
    if len(take.tracks) != 1:
        raise RequestError(f"take {take.name!r} has tracks {', '.join(take.tracks)}; choose the one to follow")
    return next(iter(take.tracks.values()))
