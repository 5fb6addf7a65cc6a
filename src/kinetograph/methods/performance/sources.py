"""From a library to the sources and segments of a method."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.kinematics import joint_positions, on_ground, role_positions
from kinetograph.learn.alignment import align
from kinetograph.learn.linkage import complete_linkage, representatives
from kinetograph.methods.performance.handholds import grips
from kinetograph.methods.performance.segments import (
    Instances,
    Segment,
    Source,
    build_instances,
    cut_segments,
)
from kinetograph.motion import Motion, repeat, resample
from kinetograph.sampling import interpolate
from kinetograph.segmentation import detect_beats, detect_contacts, detect_handholds, footplant_cuts
from kinetograph.signal import Signal
from kinetograph.skeleton import Skeleton, opposite, same_shape
from kinetograph.take import Annotation, Take, Track

if TYPE_CHECKING:
    from kinetograph.arrays import FloatArray
    from kinetograph.library import Library
    from kinetograph.methods.performance.model import PerformanceControl

LABELS = ("move", "style")
"""Kinds of annotations by which people name what is done, and how."""

ALIKE = 0.05
"""Metres by which bones of two recordings of one library may differ."""

CYCLES = 4
"""How often a looping clip is played: the segments of its second cycle have real motion on both sides."""


def collect(
    method: PerformanceControl,
    library: Library,
    exclude: tuple[str, ...],
    track: str | None,
    rng: np.random.Generator | None,
) -> tuple[tuple[Source, ...], Instances, tuple[str, ...]]:
    """Sources, instances and notes of a library for one configuration; ``rng`` draws the clusters' representatives."""
    sources, notes = [], []
    if unknown := sorted(set(exclude) - set(library.names())):
        raise RequestError(f"no take {unknown[0]!r} to leave out; there are {', '.join(library.names()) or 'none'}")
    for name in library.names():
        if name in exclude:
            continue
        take = library.take(name)
        found, cut_at = _sources_of(method, take, track)
        sources += found
        if cut_at:
            notes.append(f"{name}: no cuts in the library; cut at {cut_at}")
    if not sources:
        raise RequestError("the library has no take to use; add recordings, or exclude fewer")
    sources = _on_one_skeleton(sources)
    segments = cut_segments(tuple(sources), method.longest, method.span)
    if method.cluster is not None:
        kept = cluster_segments(tuple(sources), segments, method, rng)
        notes.append(f"clustering kept {len(kept)} of {len(segments)} segments")
        segments = tuple(segments[i] for i in kept)
    instances = build_instances(tuple(sources), segments, method.rate, method.stretch)
    return tuple(sources), instances, tuple(notes)


def _sources_of(method: PerformanceControl, take: Take, track: str | None) -> tuple[list[Source], str]:
    """The sources of a take, and where it was cut if the library does not say.

    Partners are cut at their common beats, others at their footplants.
    """
    motion = take.motion(track)
    name = next(key for key, value in take.tracks.items() if value is motion)
    recorded = method.control.recorded(take, name)
    partner = None if recorded is motion else recorded
    loops = partner is None and any(note.kind == "loop" for note in take.annotated(name, "loop"))
    period = motion.duration if loops else 0.0
    long = repeat(motion, CYCLES) if loops else motion
    noted = () if loops else take.annotated(name, "contact")
    cuts = _annotated_cuts(take, name, period)
    contacts = noted or detect_contacts(long, track=name)
    cut_at = "" if cuts else "beats" if isinstance(partner, Motion) else "footplants"
    if cut_at == "footplants":
        cuts = footplant_cuts(long, contacts)
    elif isinstance(partner, Motion) and cut_at:
        cuts = detect_beats([motion, partner])
    holds = take.annotated(name, "handhold")
    if not holds and isinstance(partner, Motion):
        holds = detect_handholds(motion, resample(partner, motion.fps), track=name)
    marks = (*contacts, *holds, *(note for kind in LABELS for note in take.annotated(name, kind)))
    found = [_source(method, take.name, name, False, long, partner, marks, cuts, period)]
    if method.mirror:
        from kinetograph.mirroring import mirror

        if isinstance(partner, Signal):
            raise RequestError(f"take {take.name!r}: a signal cannot be mirrored; leave mirroring off")
        swapped = tuple(replace(note, label=opposite_label(note.label)) for note in marks)
        other = None if partner is None else mirror(partner)
        found.append(_source(method, take.name, name, True, mirror(long), other, swapped, cuts, period))
    return found, cut_at


def opposite_label(label: str) -> str:
    """A label with every role in it, ``left_hand:right_hand``, on the other side of the body."""
    return ":".join(opposite(role) for role in label.split(":"))


def _annotated_cuts(take: Take, track: str, period: float) -> tuple[float, ...]:
    """The cuts people can edit; those of a looping clip hold in each of its cycles."""
    cuts = sorted({note.start for note in take.annotated(track, "cut")})
    if period:
        once = [c for c in cuts if c < period - 1e-6]
        cuts = sorted(c + cycle * period for cycle in range(CYCLES) for c in once)
    return tuple(cuts)


def _source(
    method: PerformanceControl,
    take: str,
    track: str,
    mirrored: bool,
    motion: Motion,
    partner: Track | None,
    marks: tuple[Annotation, ...],
    cuts: tuple[float, ...],
    period: float,
) -> Source:
    try:
        control = method.control.points(motion if partner is None else partner)
    except RequestError as error:
        raise RequestError(f"take {take!r}: {error}") from error
    if partner is not None:
        control = interpolate(control, np.arange(len(motion)) / motion.fps * partner.fps)
    target = role_positions(motion, tuple(method.targets))
    if method.placing == "continued":  # C compares poses where bodies stand, wherever that is
        back = rot.about("y", -rot.heading(motion.rotations[:, 0]))
        target = rot.rotate(back[:, None], target - on_ground(motion.translation[:, None]))
    held = grips(motion, partner, marks) if isinstance(partner, Motion) else {}
    return Source(take, track, mirrored, motion, control, target, marks, cuts, period, held)


def _on_one_skeleton(sources: list[Source]) -> list[Source]:
    """All sources on the first one's skeleton, which may be another dancer's of nearly the same build.

    Local turns are kept, and the body is lifted to stand on the floor it stood on. Raises RequestError for
    skeletons of other joints, or of another build.
    """
    first = sources[0].motion.skeleton
    for other in sources[1:]:
        if not same_shape(first, other.motion.skeleton, tolerance=ALIKE):
            raise RequestError(
                f"takes {sources[0].take!r} ({len(first)} joints) and {other.take!r} "
                f"({len(other.motion.skeleton)} joints) have different skeletons; put them in libraries of their own"
            )
    return [replace(s, motion=_rebuilt(s.motion, first)) for s in sources]


def _rebuilt(motion: Motion, skeleton: Skeleton) -> Motion:
    if same_shape(motion.skeleton, skeleton, tolerance=1e-3):
        return motion
    rebuilt = replace(motion, skeleton=skeleton, bones=None)
    rise = np.array([0.0, _floor(motion) - _floor(rebuilt), 0.0])
    return replace(rebuilt, translation=rebuilt.translation + rise)


def _floor(motion: Motion) -> float:
    """The height in metres that a body stands on: of its lowest joint, in the frames where that is lowest."""
    return float(np.quantile(joint_positions(motion)[..., 1].min(axis=1), 0.05))


def segment_distances(
    sources: tuple[Source, ...], segments: tuple[Segment, ...], method: PerformanceControl
) -> FloatArray:
    """Root-mean-square distances in metres, ``(N, N)``, between instances: control and target points together, after
    the best alignment (4.1), both stretched to one length. Segments whose durations no stretch can bring together are
    infinitely far apart.
    """
    samples = 16
    rows = []
    for segment in segments:
        source = sources[segment.source]
        at = np.linspace(segment.start, segment.stop, samples) * source.motion.fps
        rows.append(np.concatenate([interpolate(source.control, at), interpolate(source.target, at)], axis=1))
    points = np.stack(rows)
    weights = np.full(points.shape[1:3], 1.0 / (samples * points.shape[2]))
    squares, _ = align(method.alignment, points, points, weights, method.scales)
    durations = np.array([s.duration for s in segments])
    apart = np.abs(durations[:, None] - durations) > max(method.stretch, 1e-9)
    distances = np.sqrt(0.5 * (squares + squares.T))
    np.fill_diagonal(distances, 0.0)
    return np.where(apart, np.inf, distances)


def cluster_segments(
    sources: tuple[Source, ...],
    segments: tuple[Segment, ...],
    method: PerformanceControl,
    rng: np.random.Generator | None = None,
) -> list[int]:
    """Indices of the segments that represent the clusters of section 4.4.2: medoids, or random ones given ``rng``."""
    distances = segment_distances(sources, segments, method)
    labels = complete_linkage(distances, method.cluster or 0.0)
    return [int(i) for i in representatives(distances, labels, rng)]
