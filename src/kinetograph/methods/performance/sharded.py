"""Performance control over libraries in shards: each is held and scored by a process of its own, the merge searches.

What the merge knows is what one library would have told: the ends of all segments and, block of steps by block, what
each state costs and where it is placed. So it finds the same optimum and proves it in the same way. Recordings stay
where they are, but for those that the motion is made of.
"""

from __future__ import annotations

import itertools
import uuid
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.learn import Arrivals, Placement, SegmentalPath, padded_width
from kinetograph.left_out import LeftOut, by_reason
from kinetograph.library import Library
from kinetograph.methods.performance import interpretation, shard
from kinetograph.methods.performance.belonging import drawn
from kinetograph.methods.performance.fit import nothing_left, why_left
from kinetograph.methods.performance.fitted import BENDING, HURRY, BodyLimits, Fitted
from kinetograph.methods.performance.ground_path import TURNING
from kinetograph.methods.performance.own_cost import is_natural, mean_of_known, spread_over, strangers
from kinetograph.methods.performance.scoring import priced
from kinetograph.methods.performance.segments import Instances, Segment, Source
from kinetograph.methods.performance.settings import PerformanceSettings
from kinetograph.methods.performance.shard import Asked, Block, Chosen, Described, Measuring, Shard
from kinetograph.methods.performance.standing import calmest
from kinetograph.methods.performance.takes_read import cut_here, left_here
from kinetograph.post.clearance import clearance_from
from kinetograph.post.limits import limbs_of, mean_rotations, principal_axes, ranges_of
from kinetograph.progress import Progress
from kinetograph.work import HERE, Room, Workers, rooms

STEPS = 8
"""Steps of a control that a shard scores at once."""
AHEAD = 2
"""Blocks of steps that every shard is asked for before the first of them is awaited."""


@dataclass(frozen=True, eq=False)
class Merged(Fitted):
    """What shards have told, as if it were one library.

    Parameters
    ----------
    told : Told
        What the whole is measured to be.
    """

    told: Told | None = None

    @cached_property
    def limits(self) -> BodyLimits:
        """See `Fitted`."""
        return self._told.limits()

    @cached_property
    def speeds(self) -> tuple[float, float]:
        """See `Fitted`."""
        return self._told.speeds

    @cached_property
    def fastest(self) -> float:
        """See `Fitted`."""
        return min(HURRY * self._told.recorded, self.speeds[1])

    @property
    def _told(self) -> Told:
        assert self.told is not None
        return self.told


@dataclass(frozen=True, eq=False)
class Told:
    """What the whole of the shards is measured to be.

    Parameters
    ----------
    limits : callable
        Measures the bodies.
    speeds : tuple of float
    recorded : float
        The greatest mean speed of a segment as it was recorded.
    """

    limits: Callable[[], BodyLimits]
    speeds: tuple[float, float]
    recorded: float


@dataclass(frozen=True, eq=False)
class Several:
    """Shards and the rooms that hold them.

    Parameters
    ----------
    rooms : sequence of Room
    shards : sequence of Shard
    names : sequence of dict
        By a take's name in its shard, its name in the whole.
    """

    rooms: Sequence[Room]
    shards: Sequence[Shard]
    names: Sequence[Mapping[str, str]]

    def each(self, function: Callable[[Any], Any], items: Sequence[Any] | None = None) -> list[Any]:
        """What a function gives for every shard, or for an item of each."""
        calls = [room.submit(function, item) for room, item in zip(self.rooms, items or list(self.shards), strict=True)]
        return [call.result() for call in calls]

    def fetch(self, takes: Iterable[str]) -> dict[tuple[str, bool], Source]:
        """Whole recordings of takes, by name and side."""
        wanted, found = set(takes), {}
        for room, one, names in zip(self.rooms, self.shards, self.names, strict=True):
            few = tuple(name for name in one.names if names[name] in wanted)
            for source in room.submit(shard.fetch, replace(one, names=few)).result() if few else ():
                whole = replace(source, take=names[source.take])
                found[whole.take, whole.mirrored] = whole
        return found


@dataclass(frozen=True, eq=False)
class ShardedFit:
    """Shards made ready for one configuration.

    Parameters
    ----------
    fitted : Merged
    several : Several
    order : ndarray of int, shape (S,)
        Where each state of the shards, one shard after the other, is among all states.
    """

    fitted: Merged
    several: Several
    order: IntArray

    def interpret(self, x: FloatArray, progress: Progress | None = None, rules: Sequence[Any] = ()) -> SegmentalPath:
        """The best sequence of states of all shards; see `interpretation.interpret`."""
        return interpretation.interpret(self.fitted, x, progress, rules, self)

    def with_recordings(self, path: SegmentalPath) -> Merged:
        """What is fitted, with the recordings that a sequence is made of."""
        used = {self.fitted.segment_of(state).source for state in path.states}
        return self.with_takes(self.fitted.sources[i].take for i in used)

    def with_takes(self, takes: Iterable[str]) -> Merged:
        """What is fitted, with the recordings of some takes."""
        whole, sources = self.several.fetch(takes), self.fitted.sources
        return replace(
            self.fitted, sources=tuple(whole.get((source.take, source.mirrored), source) for source in sources)
        )

    def arrivals(self, fitted: Fitted, x: FloatArray, progress: Progress | None = None) -> Iterator[Arrivals]:
        """See `interpretation.Scores`: blocks of steps are scored by all shards at once, ahead of the search."""
        steps, waiting = len(x) - 1, deque[tuple[int, list[Any], slice]]()
        blocks = _blocks(x, fitted.instances.longest)
        mixed = self._mixed(fitted)
        while True:
            for last, windows, part in itertools.islice(blocks, AHEAD - len(waiting)):
                waiting.append((last, self._asked(windows, part), part))
            if not waiting:
                return
            last, calls, part = waiting.popleft()
            yield from self._arrived(fitted, [call.result() for call in calls], mixed, part)
            if progress:
                progress(last, steps)

    def left_early(self, fitted: Fitted, x: FloatArray) -> dict[int, Arrivals]:
        """See `interpretation.Scores`."""
        mixed, found = self._mixed(fitted), {}
        for used in range(1, min(fitted.instances.longest, len(x))):
            part = slice(used + 1)
            calls = self._asked(x[None, -used - 1 :], part)
            found[used] = next(self._arrived(fitted, [call.result() for call in calls], mixed, part))
        return found

    def _asked(self, windows: FloatArray, part: slice) -> list[Any]:
        pairs = zip(self.several.rooms, self.several.shards, strict=True)
        return [room.submit(shard.score, Block(one, windows, part)) for room, one in pairs]

    def _mixed(self, fitted: Fitted) -> tuple[FloatArray, FloatArray]:
        """The ends of the states in the order of the shards."""
        heads, tails = fitted.state_ends
        return heads[self.order], tails[self.order]

    def _arrived(
        self, fitted: Fitted, scored: list[Any], mixed: tuple[FloatArray, FloatArray], part: slice
    ) -> Iterator[Arrivals]:
        """Every step of a block from what the shards have scored."""
        known: list[tuple[FloatArray, Placement]] = [each for each in scored if each is not None]
        placement = known[0][1].join([placed for _, placed in known[1:]])
        together = np.empty((len(known[0][0]), len(self.order)))
        together[:, self.order] = np.concatenate([costs for costs, _ in known], axis=1)
        together = priced(fitted, together, part)
        width = padded_width(3 * len(fitted.basis))
        for i in range(len(together)):
            ends = []
            for each in mixed:
                placed = placement.ends(i, each, fitted.basis_sums, width)
                ends.append(np.empty_like(placed))
                ends[-1][self.order] = placed
            yield Arrivals(together[i], *ends)


@contextmanager
def fit_shards(
    settings: PerformanceSettings,
    libraries: Sequence[Library],
    workers: Workers | Executor = HERE,
    *,
    names: Sequence[Mapping[str, str]],
    track: str | None = None,
) -> Iterator[ShardedFit]:
    """Make shards ready, each in a process of its own for the block.

    Parameters
    ----------
    settings : PerformanceSettings
    libraries : sequence of Library
    workers : Workers or Executor
    names : sequence of mapping of str to str
        For each library, by the names of the takes that are used, their names in the whole.
    track : str, optional
        Name of the track to make.

    Yields
    ------
    ShardedFit

    Raises
    ------
    RequestError
        Where no take has a segment, and for settings that need all recordings at once.
    """
    if settings.cluster is not None:
        raise RequestError("segments of several shards cannot be clustered; leave the clustering of segments out")
    with rooms(workers, [library.path.absolute() for library in libraries]) as places:
        shards = [
            Shard(uuid.uuid4().hex, library, tuple(own), settings, track)
            for library, own in zip(libraries, names, strict=True)
        ]
        several = Several(places, shards, names)
        skeletons = [each for each in several.each(shard.first_skeleton) if each is not None]
        if not skeletons:
            raise RequestError("the library has no take to use; add recordings, or exclude fewer")
        several = replace(several, shards=[replace(each, skeleton=skeletons[0]) for each in shards])
        try:
            yield _merged(settings, several)
        finally:
            several.each(shard.let_go)


def _merged(settings: PerformanceSettings, several: Several) -> ShardedFit:
    """What the shards tell of themselves, put together as one library would tell it."""
    told: list[Described] = several.each(shard.describe)
    notes, left = _left_out(told, several.names)
    firsts = np.cumsum([0, *(len(d.sources) for d in told)])
    before = np.cumsum([0, *(len(d.segments) for d in told)])
    if before[-1] == 0:
        longest = settings.longest
        raise RequestError(f"the shards' cuts give no segment of at most {longest} s; cut them with library segment")
    sources = tuple(
        replace(source, take=names[source.take])
        for d, names in zip(told, several.names, strict=True)
        for source in d.sources
    )
    held = _held(told)
    poses = [tuple(pose for place, pose, _ in held if place == i) for i in range(len(told))]
    several = replace(several, shards=[replace(s, poses=p) for s, p in zip(several.shards, poses, strict=True)])
    segments = tuple(
        replace(segment, source=int(first) + segment.source)
        for d, first in zip(told, firsts, strict=False)
        for segment in d.segments
    )
    every = (*segments, *(replace(pose, source=int(firsts[i]) + pose.source) for i, pose, _ in held))
    ends = np.array([end for _, _, end in held]).reshape(-1, *told[0].heads.shape[1:])
    heads, tails = (np.concatenate([*(getattr(d, name) for d in told), ends]) for name in ("heads", "tails"))
    states, order = _states(several, before, [i for i, _, _ in held])
    instances = Instances(every, states, {}, heads, tails)
    slowest, fastest = zip(*several.each(shard.speeds), strict=True)
    recorded = float(max(d.recorded.max() for d in told if len(d.recorded)))
    measured = Told(lambda: _limits(several, told, sources), (min(slowest), max(fastest)), recorded)
    own = _own_cost(settings, several, (sources, instances), order)
    shares = np.concatenate([*(d.unusual for d in told), np.zeros(len(held))]) if drawn(settings) else None
    merged = Merged(settings, sources, instances, notes, own, left, shares, told=measured)
    return ShardedFit(merged, several, order)


def _left_out(told: Sequence[Described], names: Sequence[Mapping[str, str]]) -> tuple[tuple[str, ...], LeftOut]:
    """Notes on takes without cuts, and those that are left out, by reason. Raises RequestError where none is left."""
    failed = {own[name]: e for d, own in zip(told, names, strict=True) for name, e in d.failed.items()}
    cut_at = [(own[name], cuts) for d, own in zip(told, names, strict=True) for name, cuts in d.cut_at]
    uncut = by_reason((name, why_left(name, error)) for name, error in failed.items())
    if failed and not any(d.sources for d in told):
        raise nothing_left(failed, uncut)
    return (*cut_here(cut_at), *left_here(uncut)), uncut


def _held(told: Sequence[Described]) -> list[tuple[int, Segment, FloatArray]]:
    """The calmest poses of all shards: of which shard, the pose and its target points."""
    every = [(i, j, calm, pose) for i, d in enumerate(told) for j, (calm, pose) in enumerate(d.poses)]
    numbered = ((calm, Segment(number, 0.0, 0.0)) for number, (_, _, calm, _) in enumerate(every))
    chosen = [every[marker.source] for _, marker in calmest(numbered)]
    return [(i, pose, told[i].pose_ends[j]) for i, j, _, pose in chosen]


def _states(several: Several, before: IntArray, held: Sequence[int]) -> tuple[IntArray, IntArray]:
    """All states as one library has them, and where those of the shards, one after the other, are among them."""
    rows = []
    for i, states in enumerate(several.each(shard.hold)):
        own = int(before[i + 1] - before[i])
        poses = np.array([int(before[-1]) + place for place, of in enumerate(held) if of == i], dtype=np.int64)
        places = np.concatenate([np.arange(own) + int(before[i]), poses])
        rows.append(np.stack([places[states[:, 0]], states[:, 1]], axis=1))
    together = np.concatenate(rows)
    sequence = np.lexsort((together[:, 0], together[:, 1]))
    order = np.empty(len(sequence), dtype=np.int64)
    order[sequence] = np.arange(len(sequence))
    return together[sequence], order


def _blocks(x: FloatArray, longest: int) -> Iterator[tuple[int, FloatArray, slice]]:
    """Last steps, windows and parts: first the steps at which some states are partial, then whole blocks."""
    steps = len(x) - 1
    for t in range(1, min(longest, steps + 1)):
        yield t, x[None, : t + 1], slice(-t - 1, None)
    for low in range(longest, steps + 1, STEPS):
        high = min(low + STEPS, steps + 1)
        windows = np.lib.stride_tricks.sliding_window_view(x[low - longest : high], longest + 1, axis=0)
        yield high - 1, np.ascontiguousarray(np.moveaxis(windows, -1, 1)), slice(None)


def _own_cost(
    settings: PerformanceSettings, several: Several, whole: tuple[tuple[Source, ...], Instances], order: IntArray
) -> float | None:
    """See `kinetograph.methods.performance.own_cost.own_cost`."""
    sources, instances = whole
    chosen = spread_over(len(instances.segments))
    takes = np.unique([sources[segment.source].take for segment in instances.segments], return_inverse=True)[1]
    borders = np.cumsum([0, *(len(states) for states in several.each(shard.hold))])
    of_shards = [order[a:b] for a, b in itertools.pairwise(borders)]
    rates = [np.zeros(0)]
    for steps in np.unique(instances.states[:, 1]).tolist():
        members = np.arange(len(instances.states))[instances.members(steps)]
        natural = [is_natural(instances.segments[instances.states[s, 0]], settings.rate, steps) for s in members]
        asked = members[np.isin(instances.states[members, 0], chosen) & natural]
        if len(asked) == 0:
            continue
        examples = _examples(several, of_shards, asked)
        items = []
        for one, own in zip(several.shards, of_shards, strict=True):
            others = instances.states[own[instances.states[own, 1] == steps], 0]
            legal = strangers(instances.segments, takes, instances.states[asked, 0], others)
            items.append(Asked(one, steps, examples, legal))
        least = np.min(several.each(shard.explain, items), axis=0)
        rates.append(least * settings.rate / steps)
    return mean_of_known(settings, np.concatenate(rates))


def _examples(several: Several, of_shards: Sequence[IntArray], asked: IntArray) -> FloatArray:
    """The control samples of some states, all of as many steps, from the shards that hold them."""
    items = [
        Chosen(one, tuple(np.flatnonzero(np.isin(own, asked)).tolist()))
        for one, own in zip(several.shards, of_shards, strict=True)
    ]
    found = {
        int(own[state]): samples
        for item, own, each in zip(items, of_shards, several.each(shard.examples_of, items), strict=True)
        for state, samples in zip(item.states, each, strict=True)
    }
    return np.stack([found[state] for state in asked.tolist()])


def _limits(several: Several, told: Sequence[Described], sources: Sequence[Source]) -> BodyLimits:
    """See `Fitted.limits`: sums over all recordings in their order, by three readings of each shard."""
    joints = tuple(itertools.chain(*limbs_of(sources[0].motion.skeleton)))
    means = mean_rotations(itertools.chain.from_iterable(d.joints for d in told))
    moments = several.each(shard.measure, [Measuring(one, means) for one in several.shards])
    axes = principal_axes(itertools.chain.from_iterable(moments))
    extremes = several.each(shard.measure, [Measuring(one, means, axes) for one in several.shards])
    return BodyLimits(
        ranges_of(joints, means, axes, itertools.chain.from_iterable(extremes)),
        max(TURNING, *(d.fastest[0] for d in told)),
        max(BENDING, *(d.fastest[1] for d in told)),
        clearance_from(d.heights for d in told),
        max((source.overlap for source in sources if source.overlap is not None), default=None),
    )
