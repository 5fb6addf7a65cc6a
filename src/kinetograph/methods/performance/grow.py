"""Growing a segmentation: takes that a person has cut explain the others (Hsu 2004, chapter 7).

The search of chapter 4 interprets a take that has no cuts by the segments of those that have; where segments meet, it
is cut. The whole motion is known, so the points of all characters are compared, and how they move; and the target's
points count twice, in D and, across borders, in C.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import role_positions
from kinetograph.learn.segmental import SegmentalPath
from kinetograph.methods.performance.control_points import PointsByRole
from kinetograph.methods.performance.model import PerformanceControl, PerformanceModel
from kinetograph.methods.performance.realize import fine_borders
from kinetograph.methods.performance.segments import Segment, Source, build_instances, cut_segments
from kinetograph.methods.performance.sources import LABELS
from kinetograph.motion import Motion
from kinetograph.progress import Progress
from kinetograph.sampling import interpolate
from kinetograph.segmentation.agreement import CutAgreement, compare_cuts, compare_labels
from kinetograph.signal import Signal
from kinetograph.take import Annotation, Take

_SIDED = ("hand", "elbow", "toe", "foot", "knee")
BODY = ("hips", "chest", "head", *(f"{side}_{part}" for part in _SIDED for side in ("left", "right")))
GROWN = "grown"
"""The label of cuts that were grown; other cuts are a person's."""
_WEIGHT = 6.0  # of all points together, as of a walk's two hips and four ends: k then weighs as it does there
_VELOCITY = 0.2  # seconds, see PointsByRole


@dataclass(frozen=True, eq=False)
class Grown:
    """What examples make of one track of a take: cuts and labels, and the distance in metres that is left.

    distance: root mean square over time and points, velocities included: the less, the better the take is understood.
    A take shorter than any segment has no cuts, and is infinitely far.
    """

    cuts: tuple[Annotation, ...]
    labels: tuple[Annotation, ...]
    distance: float


@dataclass(frozen=True, eq=False)
class Growth:
    """A take, what was grown for it by track, and how that agrees with a person's cuts where there are any.

    agreement, labels: see `compare_cuts` and `compare_labels`; labels is not a number without a person's. rest: whether
    only what a person has left uncut was grown.
    """

    take: str
    tracks: Mapping[str, Grown]
    agreement: CutAgreement | None = None
    labels: float = float("nan")
    rest: bool = False


def growing_control(partners: bool = False) -> PerformanceControl:
    """The configuration for growing, as it was found on walks and, with ``partners``, on dances."""
    plain = PerformanceControl(rate=15.0)
    return replace(plain, continuity=0.1, stretch=0.1) if partners else plain


def fit_examples(method: PerformanceControl, takes: Sequence[Take], track: str) -> PerformanceModel:
    """The segments of takes that have cuts on ``track``, by the points of all their characters.

    Of the method's configuration the search's counts, not how a control is read. Raises RequestError where the takes
    have no segment, or motions of different names.
    """
    tracks = tuple(name for name, value in takes[0].tracks.items() if isinstance(value, Motion))
    motions = [_motion(take, name) for take in takes for name in tracks]
    roles = [role for role in BODY if all(role in m.skeleton.roles for m in motions)]
    if not roles:
        raise RequestError(f"the examples' characters have none of the roles {', '.join(BODY)}; name some (--role)")
    names = [f"{name}:{role}" for name in tracks for role in roles]
    reading = PointsByRole(dict.fromkeys(names, _WEIGHT / len(names)), _VELOCITY)
    sources = tuple(_source(method, reading, take, track) for take in takes)
    segments = cut_segments(sources, method.longest, method.span)
    instances = build_instances(sources, segments, method.rate, method.stretch)
    return PerformanceModel(replace(method, control=reading), sources, instances)


def _source(method: PerformanceControl, reading: PointsByRole, take: Take, track: str) -> Source:
    motion = take.motion(track)
    control = reading.points(_bodies(take, track, tuple(reading.roles)))
    target = role_positions(motion, tuple(method.targets))
    marks = tuple(note for kind in LABELS for note in take.annotated(track, kind))
    return Source(take.name, track, False, motion, control, target, marks, cuts_of(take, track))


def _motion(take: Take, track: str) -> Motion:
    found = take.tracks.get(track)
    if not isinstance(found, Motion):
        raise RequestError(f"take {take.name!r} has no motion {track!r}, which the examples have")
    return found


def _bodies(take: Take, track: str, names: tuple[str, ...]) -> Signal:
    """The points ``track:role`` of a take's characters as one signal, at the rate of the motion on ``track``."""
    main = _motion(take, track)
    columns = []
    for name in dict.fromkeys(name.rpartition(":")[0] for name in names):
        motion = _motion(take, name)
        roles = [point.rpartition(":")[2] for point in names if point.rpartition(":")[0] == name]
        points = role_positions(motion, roles)
        columns.append(interpolate(points, np.arange(len(main)) / main.fps * motion.fps))
    return Signal(np.concatenate(columns, axis=1), names, "m", main.fps)


def cuts_of(take: Take, track: str) -> tuple[float, ...]:
    """Seconds of the cuts of a track."""
    return tuple(sorted({note.start for note in take.annotated(track, "cut")}))


def grow(model: PerformanceModel, take: Take, progress: Progress | None = None) -> Grown:
    """Cuts and labels of a take, by the examples of a model of `fit_examples`, on the track they were cut on.

    Borders of segments, and cuts within those of several, become cuts where they lie in the take; a border is as fine
    as the constrained search of section 4.4.3 makes it.
    """
    reading, track = model.method.control, model.sources[0].track
    assert isinstance(reading, PointsByRole)
    bodies = _bodies(take, track, tuple(reading.roles))
    points = model.control_points(bodies)
    x = model.at_search_rate(points, bodies.fps)
    if len(x) <= model.instances.states[0, 1]:
        return Grown((), (), np.inf)
    path = model.interpret(x, progress)
    segments = [model.instances.segments[model.instances.states[s, 0]] for s in path.states]
    borders = _borders(model, points, bodies.fps, path)
    cuts = _cuts(model, segments, borders, bodies.duration)
    distance = float(np.sqrt(path.score / (_WEIGHT * max(bodies.duration, 1e-9))))
    labels = _labels(model, segments, borders, bodies.duration)
    return Grown(tuple(Annotation(track, "cut", GROWN, t, t) for t in cuts), labels, distance)


def _borders(model: PerformanceModel, points: FloatArray, fps: float, path: SegmentalPath) -> FloatArray:
    """Seconds of the borders ``(L + 1,)``, the first and last of which may lie outside the take."""
    rate = model.method.fine_rate
    if rate is None:
        return np.concatenate([path.starts[:1], path.stops]) / model.method.rate
    count = int(np.floor((len(points) - 1) / fps * rate + 1e-6)) + 1
    return fine_borders(model, interpolate(points, np.arange(count) / rate * fps), rate, path) / rate


def _cuts(model: PerformanceModel, segments: list[Segment], borders: FloatArray, duration: float) -> list[float]:
    found = [float(borders[0])]
    for segment, start, stop in zip(segments, borders[:-1], borders[1:], strict=True):
        cuts = np.array(model.sources[segment.source].cuts)
        inside = cuts[(cuts > segment.start + 1e-9) & (cuts < segment.stop - 1e-9)]
        found += [float(t) for t in start + (inside - segment.start) / segment.duration * (stop - start)]
        found.append(float(stop))
    return [min(max(t, 0.0), duration) for t in found if -1e-6 <= t <= duration + 1e-6]


def _labels(
    model: PerformanceModel, segments: list[Segment], borders: FloatArray, duration: float
) -> tuple[Annotation, ...]:
    """What the segments are labelled with, over half of each or more; one annotation as long as a label goes on.

    A label that begins where a segment begins in its recording begins anew.
    """
    runs: list[Annotation] = []
    current: dict[tuple[str, str], int] = {}
    for segment, start, stop in zip(segments, borders[:-1], borders[1:], strict=True):
        source = model.sources[segment.source]
        begin, end = max(float(start), 0.0), min(float(stop), duration)
        last, current = current, {}
        for note in source.marks:
            if min(note.stop, segment.stop) - max(note.start, segment.start) < 0.5 * segment.duration or end <= begin:
                continue
            key = (note.kind, note.label)
            if key in last and note.start < segment.start - 1e-6:
                current[key] = last[key]
                runs[current[key]] = replace(runs[current[key]], stop=end)
            else:
                current[key] = len(runs)
                runs.append(Annotation(source.track, note.kind, note.label, begin, end))
    return tuple(sorted(runs, key=lambda note: (note.start, note.kind, note.label)))


def grow_takes(
    method: PerformanceControl,
    examples: Sequence[Take],
    takes: Sequence[Take],
    *,
    join: bool = False,
    tolerance: float = 0.1,
    progress: Progress | None = None,
) -> list[Growth]:
    """Cuts and labels of ``takes`` by those of ``examples``, on every track that the examples are cut on.

    join: one by one, the take that is understood best becomes an example for the rest. Takes with a person's cuts are
    compared with them at ``tolerance`` seconds; their own cuts are not used. Raises RequestError where no example has
    cuts.
    """
    found: dict[str, Growth] = {}
    known, left = list(examples), list(takes)
    while left:
        models = _models(method, known)
        grown = [_compared(_grow_all(models, take), take, tolerance) for take in left]
        for growth in [min(grown, key=_distance)] if join else grown:
            found[growth.take] = growth
            take = next(take for take in left if take.name == growth.take)
            known.append(_with(take, growth))
            left.remove(take)
        if progress:
            progress(len(found), len(takes))
    return [found[take.name] for take in takes]


def grow_rest(method: PerformanceControl, examples: Sequence[Take], take: Take) -> Growth:
    """Cuts and labels of what comes before a take's first and after its last cut, by examples of which it is one.

    The whole take is interpreted: where it is cut it explains itself, at no cost, and the rest joins on to that.
    """
    grown = _grow_all(_models(method, list(examples)), take)
    tracks = {track: _outside(found, cuts_of(take, track)) for track, found in grown.tracks.items()}
    return replace(grown, tracks=MappingProxyType(tracks), rest=True)


def _outside(grown: Grown, cuts: Sequence[float]) -> Grown:
    """What was grown before the first and after the last of some cuts, half the shortest segment away or more."""
    if len(cuts) < 2:
        return grown
    away = 0.5 * float(np.diff(cuts).min())
    found = tuple(note for note in grown.cuts if note.start < cuts[0] - away or note.start > cuts[-1] + away)
    before = (replace(note, stop=min(note.stop, cuts[0])) for note in grown.labels if note.start < cuts[0])
    after = (replace(note, start=max(note.start, cuts[-1])) for note in grown.labels if note.stop > cuts[-1])
    return replace(grown, cuts=found, labels=(*before, *after))


def by_hand(take: Take) -> Take:
    """The take without cuts that were grown, where a person has made some as well; else as it is."""
    kept = tuple(note for note in take.annotations if note.kind != "cut" or note.label != GROWN)
    return Take(take.name, take.tracks, kept) if any(note.kind == "cut" for note in kept) else take


def _models(method: PerformanceControl, examples: list[Take]) -> dict[str, PerformanceModel]:
    """A model for every track that the examples are cut on."""
    models = {}
    for track in cut_tracks(examples):
        models[track] = fit_examples(method, [take for take in examples if cuts_of(take, track)], track)
    return models


def _grow_all(models: dict[str, PerformanceModel], take: Take) -> Growth:
    return Growth(take.name, MappingProxyType({track: grow(model, take) for track, model in models.items()}))


def cut_tracks(takes: Iterable[Take]) -> tuple[str, ...]:
    """The names of the motions on which any of the takes has cuts. Raises RequestError where none has."""
    found = dict.fromkeys(
        name for take in takes for name, t in take.tracks.items() if isinstance(t, Motion) and cuts_of(take, name)
    )
    if not found:
        raise RequestError("no take has cuts to grow from; cut a few by hand first (library tap, library annotate)")
    return tuple(found)


def _compared(growth: Growth, take: Take, tolerance: float) -> Growth:
    """The growth beside the cuts and labels that a person has given the take, on the first track that has them."""
    for track, grown in growth.tracks.items():
        if hand := [note.start for note in take.annotated(track, "cut") if note.label != GROWN]:
            agreement = compare_cuts([note.start for note in grown.cuts], hand, tolerance)
            moves = [note for note in grown.labels if note.kind == "move"]
            return replace(growth, agreement=agreement, labels=compare_labels(moves, take.annotated(track, "move")))
    return growth


def _distance(growth: Growth) -> float:
    return float(np.mean([grown.distance for grown in growth.tracks.values()]))


def _with(take: Take, growth: Growth) -> Take:
    """The take with what was grown for it in place of what it had."""
    kept = [n for n in take.annotations if n.kind not in ("cut", *LABELS)]
    new = [note for grown in growth.tracks.values() for note in (*grown.cuts, *grown.labels)]
    return Take(take.name, take.tracks, (*kept, *new))
