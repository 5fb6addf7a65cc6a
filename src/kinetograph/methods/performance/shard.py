"""One shard of a library, in a process of its own: its segments are held and scored, its recordings only read.

Every function is pure but for what it keeps: a shard's segments at every stretch, until they are let go of.
"""

from __future__ import annotations

import itertools
from collections import OrderedDict
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.learn import Placement
from kinetograph.library import Facts, Library, facts_of
from kinetograph.methods.performance.belonging import drawn, unusual_shares
from kinetograph.methods.performance.control_points import GroundPath
from kinetograph.methods.performance.fitted import Fitted, recorded_speeds
from kinetograph.methods.performance.scoring import aligned
from kinetograph.methods.performance.segments import Instances, Segment, Source, build_instances, cut_segments
from kinetograph.methods.performance.settings import PerformanceSettings
from kinetograph.methods.performance.sources import sources_of
from kinetograph.methods.performance.standing import calm_moments, calmest
from kinetograph.methods.performance.weights import weights
from kinetograph.methods.recordings import Recording
from kinetograph.motion import Motion, cut
from kinetograph.post.clearance import toe_heights
from kinetograph.post.elbows import elbow_speed
from kinetograph.post.limits import extremes, joint_moments, joint_products, limbs_of
from kinetograph.post.turning import turning_speed
from kinetograph.skeleton import Skeleton
from kinetograph.work import require_seen

HELD_AT_ONCE = 16
"""Shards of which a process keeps the segments."""


@dataclass(frozen=True, eq=False)
class Shard:
    """A shard, and how it is to be read.

    Parameters
    ----------
    token : str
        Says which shard of which model it is.
    library : Library
    names : tuple of str
        Its takes that are used.
    settings : PerformanceSettings
    track : str, optional
        The track to make.
    skeleton : Skeleton, optional
        That of the first recording of all shards.
    poses : tuple of Segment
        The poses of it that are held.
    """

    token: str
    library: Library
    names: tuple[str, ...]
    settings: PerformanceSettings
    track: str | None = None
    skeleton: Skeleton | None = None
    poses: tuple[Segment, ...] = ()


@dataclass(frozen=True, eq=False)
class Described:
    """What the others need to know of a shard's recordings.

    Parameters
    ----------
    sources : tuple of Source
        Without their frames, but for the first.
    segments : tuple of Segment
    heads, tails : ndarray, shape (N, Q, 3)
    poses : tuple of (float, Segment)
        The calmest, with how calm they are.
    pose_ends : ndarray, shape (M, Q, 3)
        Their target points.
    recorded : ndarray, shape (N,)
        Mean ground speeds of the segments.
    joints : tuple of ndarray
        Of each recording the `joint_products`.
    heights : ndarray, shape (K, 2)
        See `kinetograph.post.clearance.toe_heights`.
    fastest : tuple of float
        How fast bodies turn and elbows bend at most.
    cut_at : tuple of (str, str)
        Takes that had no cuts, and what they are cut at.
    failed : dict of str to RequestError
        Takes that are left out, and why.
    unusual : ndarray, shape (N,)
        The share of each segment that is not everyday.
    """

    sources: tuple[Source, ...]
    segments: tuple[Segment, ...]
    heads: FloatArray
    tails: FloatArray
    poses: tuple[tuple[float, Segment], ...]
    pose_ends: FloatArray
    recorded: FloatArray
    joints: tuple[FloatArray, ...]
    heights: FloatArray
    fastest: tuple[float, float]
    cut_at: tuple[tuple[str, str], ...]
    failed: dict[str, RequestError]
    unusual: FloatArray


@dataclass(eq=False)
class _Kept:
    """What is kept of a shard.

    Parameters
    ----------
    takes : list of (str, bool)
        The take of each source, and whether it is mirrored.
    segments : list of Segment
    parts : list of (int, Instances)
        The instances of each source, with the place of its first segment.
    instances : Instances, optional
        All of them, and the poses that are held.
    """

    takes: list[tuple[str, bool]] = field(default_factory=list)
    segments: list[Segment] = field(default_factory=list)
    parts: list[tuple[int, Instances]] = field(default_factory=list)
    instances: Instances | None = None


_KEPT: OrderedDict[str, _Kept] = OrderedDict()


def first_skeleton(shard: Shard) -> Skeleton | None:
    """The skeleton of the first take; None without takes."""
    require_seen(shard.library.path)
    if not shard.names:
        return None
    return shard.library.take(shard.names[0]).named_motion(shard.track)[1].skeleton


def describe(shard: Shard) -> Described:
    """Read the recordings one after the other, and say what they are."""
    settings, told, parts, kept = shard.settings, _Told([], {}), list[_Part](), _Kept()
    for each in _recordings(shard, told):
        parts.append(_described(settings, each, kept))
    _keep(shard, kept)
    heads, tails = (np.concatenate([_none(settings), *(getattr(p, e) for p in parts)]) for e in ("heads", "tails"))
    poses = calmest(itertools.chain.from_iterable(part.poses for part in parts))
    ends = {pose: part.pose_ends[i] for part in parts for i, (_, pose) in enumerate(part.poses)}
    return Described(
        tuple(part.source for part in parts),
        tuple(itertools.chain.from_iterable(part.segments for part in parts)),
        heads,
        tails,
        tuple(poses),
        np.array([ends[pose] for _, pose in poses]).reshape(-1, *heads.shape[1:]),
        np.concatenate([np.zeros(0), *(part.recorded for part in parts)]),
        tuple(part.joints for part in parts),
        np.concatenate([np.zeros((0, 2)), *(part.heights for part in parts)]),
        (max((p.turning for p in parts), default=0.0), max((p.elbows for p in parts), default=0.0)),
        tuple(told.cut_at),
        told.failed,
        np.concatenate([np.zeros(0), *(part.unusual for part in parts)]),
    )


def hold(shard: Shard) -> IntArray:
    """Keep the segments, and the poses that are held, at every legal stretch; give the states ``(S, 2)``."""
    return _instances(shard).states


def let_go(shard: Shard) -> None:
    """Keep a shard no longer."""
    _KEPT.pop(shard.token, None)


def speeds(shard: Shard) -> tuple[float, float]:
    """The slowest and the fastest mean ground speed of the states."""
    return _view(shard).speeds if len(_instances(shard).states) else (np.inf, -np.inf)


@dataclass(frozen=True, eq=False)
class Block:
    """Windows of a control that end at neighbouring steps, or at the end of one.

    Parameters
    ----------
    shard : Shard
    windows : ndarray, shape (B, W, P, 3)
    part : slice
        The samples of the states that are compared with the latest samples of the windows.
    """

    shard: Shard
    windows: FloatArray
    part: slice


def score(block: Block) -> tuple[FloatArray, Placement] | None:
    """D ``(B, S)`` of the states and where they are placed; None without states."""
    view = _view(block.shard)
    return aligned(view, block.windows, block.part) if view.instances.controls else None


@dataclass(frozen=True, eq=False)
class Asked:
    """Segments that others are to explain.

    Parameters
    ----------
    shard : Shard
    steps : int
    examples : ndarray, shape (A, steps + 1, P, 3)
    legal : ndarray of bool, shape (A, N)
        Whether the shard's states of so many steps may explain them.
    """

    shard: Shard
    steps: int
    examples: FloatArray
    legal: BoolArray


def explain(asked: Asked) -> FloatArray:
    """The least D ``(A,)`` with which the shard's states explain segments; infinite where none may."""
    others = _instances(asked.shard).controls.get(asked.steps)
    if others is None:
        return np.full(len(asked.examples), np.inf)
    settings = asked.shard.settings
    costs, _ = settings.alignment.align(asked.examples, others, weights(settings, asked.steps + 1))
    return np.asarray(np.where(asked.legal, costs, np.inf).min(axis=1))


@dataclass(frozen=True, eq=False)
class Chosen:
    """Some states of a shard.

    Parameters
    ----------
    shard : Shard
    states : tuple of int
    """

    shard: Shard
    states: tuple[int, ...]


def examples_of(chosen: Chosen) -> list[FloatArray]:
    """The control samples of states."""
    instances = _instances(chosen.shard)
    found = []
    for state in chosen.states:
        steps = int(instances.states[state, 1])
        found.append(instances.controls[steps][state - instances.members(steps).start])
    return found


def fetch(shard: Shard) -> list[Source]:
    """Its recordings as a whole: of a shard with few names."""
    return list(_recordings(shard, _Told([], {})))


@dataclass(frozen=True, eq=False)
class Measuring:
    """What joints are measured by; see `kinetograph.post.limits`.

    Parameters
    ----------
    shard : Shard
    means : ndarray, shape (R, 4)
    axes : ndarray, shape (R, 3, 3), optional
    """

    shard: Shard
    means: FloatArray
    axes: FloatArray | None = None


def measure(measuring: Measuring) -> list[FloatArray]:
    """The `joint_moments` of every recording or, once the axes are known, the `extremes`."""
    found = []
    for source in _recordings(measuring.shard, _Told([], {})):
        joints = _limbs(source.motion)
        if measuring.axes is None:
            found.append(joint_moments(source.motion, joints, measuring.means))
        else:
            found.append(extremes(source.motion, joints, measuring.means, measuring.axes))
    return found


@dataclass(frozen=True, eq=False)
class _Told:
    cut_at: list[tuple[str, str]]
    failed: dict[str, RequestError]


@dataclass(frozen=True, eq=False)
class _Part:
    source: Source
    segments: tuple[Segment, ...]
    heads: FloatArray
    tails: FloatArray
    poses: list[tuple[float, Segment]]
    pose_ends: FloatArray
    recorded: FloatArray
    joints: FloatArray
    heights: FloatArray
    turning: float
    elbows: float
    unusual: FloatArray


def _recordings(shard: Shard, told: _Told) -> Iterator[Source]:
    """The recordings one after the other."""
    require_seen(shard.library.path)
    facts = facts_of(shard.library)
    for name in shard.names:
        take = shard.library.take(name)
        recording = Recording(take, *take.named_motion(shard.track), facts=facts.get(name, Facts()))
        try:
            sources, cut_at = sources_of(shard.settings, recording, shard.skeleton or recording.motion.skeleton)
        except RequestError as error:
            told.failed[name] = error
            continue
        if cut_at:
            told.cut_at.append((name, cut_at))
        yield from sources


def _limbs(motion: Motion) -> tuple[int, ...]:
    return tuple(itertools.chain(*limbs_of(motion.skeleton)))


def _none(settings: PerformanceSettings) -> FloatArray:
    return np.zeros((0, len(settings.targets), 3))


def _segments(settings: PerformanceSettings, source: Source) -> tuple[Segment, ...]:
    try:
        return cut_segments((source,), settings.longest, settings.span)
    except RequestError:  # none of them is short enough
        return ()


def _described(settings: PerformanceSettings, source: Source, kept: _Kept) -> _Part:
    """What is told of a source; what is kept of it is added to that of the others."""
    number, segments = len(kept.takes), _segments(settings, source)
    stands = settings.stand and isinstance(settings.control_points, GroundPath) and settings.alignment.moves
    poses = [(calm, Segment(0, second, second)) for calm, second in calm_moments(source)] if stands else []
    ends = [_none(settings)] * 3
    recorded = np.zeros(0)
    if segments:
        made = build_instances((source,), segments, settings.rate, settings.stretch)
        ends[:2] = made.heads, made.tails
        recorded = recorded_speeds(Fitted(settings, (source,), made))
        kept.parts.append((len(kept.segments), made))
    if poses:
        ends[2] = build_instances((source,), tuple(p for _, p in poses), settings.rate, settings.stretch).heads
    placed = tuple(replace(segment, source=number) for segment in segments)
    kept.takes.append((source.take, source.mirrored))
    kept.segments += placed
    motion = source.motion
    return _Part(
        _without_frames(source),
        placed,
        ends[0],
        ends[1],
        [(calm, replace(pose, source=number)) for calm, pose in poses],
        ends[2],
        recorded,
        joint_products(motion, _limbs(motion)),
        toe_heights(motion),
        turning_speed(motion),
        elbow_speed(motion),
        unusual_shares((source,), segments) if drawn(settings) else np.zeros(len(segments)),
    )


def _without_frames(source: Source) -> Source:
    """A source of which one frame is left, and nothing of the others is held."""
    first = cut(source.motion, 0, 1)
    motion = replace(first, translation=first.translation.copy(), rotations=first.rotations.copy())
    points = {name: getattr(source, name)[:1].copy() for name in ("control_points", "target_points")}
    return replace(source, motion=motion, grips={}, **points)


def _keep(shard: Shard, kept: _Kept) -> None:
    while len(_KEPT) >= HELD_AT_ONCE:
        _KEPT.popitem(last=False)
    _KEPT[shard.token] = kept


def _instances(shard: Shard) -> Instances:
    """The segments of a shard, kept or made again from its recordings, and the poses that are held."""
    if shard.token not in _KEPT:
        describe(shard)
    kept = _KEPT[shard.token]
    if kept.instances is None:
        last = [(len(kept.segments) + i, made) for i, made in enumerate(_poses(shard, kept))]
        every = (*kept.segments, *shard.poses)
        kept.instances = joined(every, [*kept.parts, *last], len(shard.settings.targets))
        kept.parts.clear()
    return kept.instances


def _poses(shard: Shard, kept: _Kept) -> list[Instances]:
    """Each pose that is held, as a segment of its own."""
    settings, takes = shard.settings, {kept.takes[pose.source][0] for pose in shard.poses}
    few = replace(shard, names=tuple(name for name in shard.names if name in takes))
    sources = {(source.take, source.mirrored): source for source in fetch(few)}
    return [
        build_instances(
            (sources[kept.takes[pose.source]],), (replace(pose, source=0),), settings.rate, settings.stretch
        )
        for pose in shard.poses
    ]


def joined(segments: tuple[Segment, ...], parts: list[tuple[int, Instances]], points: int) -> Instances:
    """Instances of segments from those of parts of them, each with the place of its first segment."""
    controls: dict[int, FloatArray] = {}
    for steps in sorted({steps for _, part in parts for steps in part.controls}):
        controls[steps] = np.concatenate([part.controls[steps] for _, part in parts if steps in part.controls])
    states = [part.states + np.array([first, 0]) for first, part in parts]
    every = np.concatenate([np.zeros((0, 2), dtype=np.int64), *states])
    ends = [np.concatenate([np.zeros((0, points, 3)), *(getattr(p, e) for _, p in parts)]) for e in ("heads", "tails")]
    return Instances(segments, every[np.lexsort((every[:, 0], every[:, 1]))], controls, ends[0], ends[1])


def _view(shard: Shard) -> Fitted:
    """The segments as what scores them takes; without recordings."""
    return Fitted(shard.settings, (), _instances(shard))
