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
from kinetograph.learn import SegmentalPath
from kinetograph.methods.performance.control import points_of
from kinetograph.methods.performance.control_points import PointsByRole
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.interpretation import interpret
from kinetograph.methods.performance.pieces import fine_borders
from kinetograph.methods.performance.scoring import at_rate
from kinetograph.methods.performance.segments import Segment, Source, build_instances, cut_segments
from kinetograph.methods.performance.settings import PerformanceSettings
from kinetograph.methods.recordings import LABELS
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
    """What examples make of one track of a take.

    Parameters
    ----------
    cuts, labels : tuple of Annotation
        A take shorter than any segment has no cuts.
    distance : float
        Root mean square distance in metres, over time and points, velocities included, between the take and the
        examples that explain it; infinite for a take shorter than any segment.
    """

    cuts: tuple[Annotation, ...]
    labels: tuple[Annotation, ...]
    distance: float


@dataclass(frozen=True, eq=False)
class Growth:
    """A take, what was grown for it, and how that agrees with a person's cuts where there are any.

    Parameters
    ----------
    take : str
    tracks : mapping of str to Grown
    agreement : CutAgreement, optional
        See `compare_cuts`.
    labels : float
        See `compare_labels`; not a number where a person has named none.
    rest : bool
        Whether only what a person has left uncut was grown.
    """

    take: str
    tracks: Mapping[str, Grown]
    agreement: CutAgreement | None = None
    labels: float = float("nan")
    rest: bool = False


def growing_control(partners: bool = False) -> PerformanceSettings:
    """The configuration for growing, chosen on walks and, with ``partners``, on dances."""
    plain = PerformanceSettings(rate=15.0)
    return replace(plain, continuity=0.1, stretch=0.1) if partners else plain


def fit_examples(settings: PerformanceSettings, takes: Sequence[Take], track: str) -> Fitted:
    """The segments of takes that have cuts on a track, by the points of all their characters.

    Parameters
    ----------
    settings : PerformanceSettings
        Those of the search are used, not the control points.
    takes : sequence of Take
    track : str

    Raises
    ------
    RequestError
        Where the takes have no segment, or motions of different names.
    """
    tracks = tuple(name for name, value in takes[0].tracks.items() if isinstance(value, Motion))
    motions = [_motion(take, name) for take in takes for name in tracks]
    roles = [role for role in BODY if all(role in m.skeleton.roles for m in motions)]
    if not roles:
        raise RequestError(f"the examples' characters have none of the roles {', '.join(BODY)}; name some (--role)")
    names = [f"{name}:{role}" for name in tracks for role in roles]
    points = PointsByRole(dict.fromkeys(names, _WEIGHT / len(names)), _VELOCITY)
    sources = tuple(_source(settings, points, take, track) for take in takes)
    segments = cut_segments(sources, settings.longest, settings.span)
    instances = build_instances(sources, segments, settings.rate, settings.stretch)
    return Fitted(replace(settings, control_points=points, reuse=0.0), sources, instances)


def _source(settings: PerformanceSettings, points: PointsByRole, take: Take, track: str) -> Source:
    motion = take.motion(track)
    control = points.points(_bodies(take, track, tuple(points.roles)))
    target = role_positions(motion, tuple(settings.targets))
    labels = tuple(note for kind in LABELS for note in take.annotated(track, kind))
    return Source(take.name, track, False, motion, control, target, labels, cuts_of(take, track))


def _motion(take: Take, track: str) -> Motion:
    motion = take.tracks.get(track)
    if not isinstance(motion, Motion):
        raise RequestError(f"take {take.name!r} has no motion {track!r}, which the examples have")
    return motion


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


def grow(fitted: Fitted, take: Take, progress: Progress | None = None) -> Grown:
    """Cuts and labels of a take, by examples that `fit_examples` has fitted, on the track they were cut on.

    Borders of segments, and cuts within those of several, become cuts where they lie in the take; a border is as fine
    as the constrained search of section 4.4.3 makes it.

    Parameters
    ----------
    fitted : Fitted
        The examples.
    take : Take
    progress : Progress, optional
        Called with the steps done and their number.
    """
    compared, track = fitted.settings.control_points, fitted.sources[0].track
    assert isinstance(compared, PointsByRole)
    bodies = _bodies(take, track, tuple(compared.roles))
    points = points_of(fitted.settings, bodies)
    x = at_rate(points, bodies.fps, fitted.settings.rate)
    if len(x) <= fitted.instances.states[0, 1]:
        return Grown((), (), np.inf)
    path = interpret(fitted, x, progress)
    segments = [fitted.segment_of(s) for s in path.states]
    borders = _borders(fitted, points, bodies.fps, path)
    cuts = _cuts(fitted, segments, borders, bodies.duration)
    distance = float(np.sqrt(path.score / (_WEIGHT * max(bodies.duration, 1e-9))))
    labels = _labels(fitted, segments, borders, bodies.duration)
    return Grown(tuple(Annotation(track, "cut", GROWN, t, t) for t in cuts), labels, distance)


def _borders(fitted: Fitted, points: FloatArray, fps: float, path: SegmentalPath) -> FloatArray:
    """Seconds of the borders ``(L + 1,)``, the first and last of which may lie outside the take."""
    rate = fitted.settings.fine_rate
    if rate is None:
        return np.concatenate([path.starts[:1], path.stops]) / fitted.settings.rate
    return fine_borders(fitted, at_rate(points, fps, rate), rate, path) / rate


def _cuts(fitted: Fitted, segments: list[Segment], borders: FloatArray, duration: float) -> list[float]:
    times = [float(borders[0])]
    for segment, start, stop in zip(segments, borders[:-1], borders[1:], strict=True):
        cuts = np.array(fitted.sources[segment.source].cuts)
        inside = cuts[(cuts > segment.start + 1e-9) & (cuts < segment.stop - 1e-9)]
        times += [float(t) for t in start + (inside - segment.start) / segment.duration * (stop - start)]
        times.append(float(stop))
    return [min(max(t, 0.0), duration) for t in times if -1e-6 <= t <= duration + 1e-6]


def _labels(fitted: Fitted, segments: list[Segment], borders: FloatArray, duration: float) -> tuple[Annotation, ...]:
    """What the segments are labelled with, over half of each or more; one annotation as long as a label goes on.

    A label that begins where a segment begins in its recording begins anew.
    """
    runs: list[Annotation] = []
    current: dict[tuple[str, str], int] = {}
    for segment, start, stop in zip(segments, borders[:-1], borders[1:], strict=True):
        source = fitted.sources[segment.source]
        begin, end = max(float(start), 0.0), min(float(stop), duration)
        last, current = current, {}
        for note in source.annotations:
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
    settings: PerformanceSettings,
    examples: Sequence[Take],
    takes: Sequence[Take],
    *,
    join: bool = False,
    tolerance: float = 0.1,
    progress: Progress | None = None,
) -> list[Growth]:
    """Cuts and labels of takes by those of examples, on every track that the examples are cut on.

    Parameters
    ----------
    settings : PerformanceSettings
    examples, takes : sequence of Take
    join : bool
        One by one, the take that is explained best becomes an example for the rest.
    tolerance : float
        Takes with a person's cuts are compared with them at this many seconds; their own cuts are not used.
    progress : Progress, optional
        Called with the takes done and their number.

    Returns
    -------
    list of Growth
        In the order of ``takes``.

    Raises
    ------
    RequestError
        Where no example has cuts.
    """
    done: dict[str, Growth] = {}
    known, left = list(examples), list(takes)
    while left:
        fits = _fits(settings, known)
        grown = [_compared(_grow_all(fits, take), take, tolerance) for take in left]
        for growth in [min(grown, key=_distance)] if join else grown:
            done[growth.take] = growth
            take = next(take for take in left if take.name == growth.take)
            known.append(_with(take, growth))
            left.remove(take)
        if progress:
            progress(len(done), len(takes))
    return [done[take.name] for take in takes]


def grow_rest(settings: PerformanceSettings, examples: Sequence[Take], take: Take) -> Growth:
    """Cuts and labels of what comes before a take's first and after its last cut, by examples of which it is one.

    The whole take is interpreted: where it is cut it explains itself, at no cost, and the rest joins on to that.

    Parameters
    ----------
    settings : PerformanceSettings
    examples : sequence of Take
        Takes with cuts, ``take`` among them.
    take : Take
    """
    grown = _grow_all(_fits(settings, list(examples)), take)
    tracks = {track: _outside(each, cuts_of(take, track)) for track, each in grown.tracks.items()}
    return replace(grown, tracks=MappingProxyType(tracks), rest=True)


def _outside(grown: Grown, cuts: Sequence[float]) -> Grown:
    """What was grown before the first and after the last of some cuts, half the shortest segment away or more."""
    if len(cuts) < 2:
        return grown
    away = 0.5 * float(np.diff(cuts).min())
    outside = tuple(note for note in grown.cuts if note.start < cuts[0] - away or note.start > cuts[-1] + away)
    before = (replace(note, stop=min(note.stop, cuts[0])) for note in grown.labels if note.start < cuts[0])
    after = (replace(note, start=max(note.start, cuts[-1])) for note in grown.labels if note.stop > cuts[-1])
    return replace(grown, cuts=outside, labels=(*before, *after))


def by_hand(take: Take) -> Take:
    """The take without cuts that were grown, where a person has made some as well; else as it is."""
    kept = tuple(note for note in take.annotations if note.kind != "cut" or note.label != GROWN)
    return Take(take.name, take.tracks, kept) if any(note.kind == "cut" for note in kept) else take


def _fits(settings: PerformanceSettings, examples: list[Take]) -> dict[str, Fitted]:
    """The examples of every track that they are cut on."""
    fits = {}
    for track in cut_tracks(examples):
        fits[track] = fit_examples(settings, [take for take in examples if cuts_of(take, track)], track)
    return fits


def _grow_all(fits: dict[str, Fitted], take: Take) -> Growth:
    return Growth(take.name, MappingProxyType({track: grow(fitted, take) for track, fitted in fits.items()}))


def cut_tracks(takes: Iterable[Take]) -> tuple[str, ...]:
    """The names of the motions on which any of the takes has cuts. Raises RequestError where none has."""
    tracks = dict.fromkeys(
        name for take in takes for name, t in take.tracks.items() if isinstance(t, Motion) and cuts_of(take, name)
    )
    if not tracks:
        raise RequestError("no take has cuts to grow from; cut a few by hand first (library tap, library annotate)")
    return tuple(tracks)


def _compared(growth: Growth, take: Take, tolerance: float) -> Growth:
    """The growth, compared with a person's cuts and labels on the first track that has them."""
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
