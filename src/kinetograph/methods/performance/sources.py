"""From a library to the recordings that segments are cut from (Hsu 2004, chapter 3)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import on_ground, role_positions
from kinetograph.methods.performance.handholds import grips
from kinetograph.methods.performance.segments import Source
from kinetograph.methods.performance.settings import PerformanceSettings
from kinetograph.methods.recordings import CYCLES, LABELS, Recording, adopt, looped, mirrored_annotations, person_of
from kinetograph.mirroring import mirror
from kinetograph.motion import Motion, headings, resample, sample
from kinetograph.post.torsos import has_torso, overlaps, torso_of
from kinetograph.sampling import interpolate
from kinetograph.segmentation import UncutError, detect_beats, detect_handholds, footplant_cuts
from kinetograph.signal import Signal
from kinetograph.skeleton import Skeleton
from kinetograph.take import Annotation


def sources_of(settings: PerformanceSettings, recording: Recording, skeleton: Skeleton) -> tuple[list[Source], str]:
    """A recording and, where settings say so, its mirror image, on a skeleton of the same joints.

    Parameters
    ----------
    settings : PerformanceSettings
    recording : Recording
    skeleton : Skeleton
        That of the library's first recording.

    Returns
    -------
    sources : list of Source
    cut_at : str
        What it was cut at, if the library has no cuts for it: partners at their common beats, others at their
        footplants.

    Raises
    ------
    UncutError
        For a take in which no cuts are found.
    RequestError
        For a take that lacks what the settings compare, and for a signal that would have to be mirrored.
    """
    partner = _partner(settings, recording)
    if partner is None:  # nobody to stay with: a walker of another build walks on legs of the first one's length
        recording = looped(replace(recording, motion=adopt(recording.motion, skeleton)))
    cuts, contacts, cut_at = _cuts(recording, partner)
    holds = _handholds(recording, partner)
    labels = [note for kind in LABELS for note in recording.take.annotated(recording.track, kind)]
    annotations = (*contacts, *holds, *labels)
    sources = [_source(settings, recording, partner, annotations, cuts, mirrored=False)]
    if settings.mirror:
        if isinstance(partner, Signal):
            raise RequestError(f"take {recording.name!r}: a signal cannot be mirrored; leave mirroring off")
        image = replace(recording, motion=mirror(recording.motion))
        other = None if partner is None else mirror(partner)
        swapped = tuple(mirrored_annotations(annotations, settings.sides))
        sources.append(_source(settings, image, other, swapped, cuts, mirrored=True))
    return [replace(source, motion=adopt(source.motion, skeleton, scaled=False)) for source in sources], cut_at


def _partner(settings: PerformanceSettings, recording: Recording) -> Motion | Signal | None:
    """The track that was the recording's control, where it is not the recording itself."""
    control = settings.control_points.recorded(recording.take, recording.track)
    return None if control is recording.motion else control


def _cuts(
    recording: Recording, partner: Motion | Signal | None
) -> tuple[tuple[float, ...], tuple[Annotation, ...], str]:
    """Cuts, contacts, and what it was cut at if the library does not say."""
    cuts, contacts = annotated_cuts(recording), recording.contacts()
    if cuts:
        return cuts, contacts, ""
    try:
        if isinstance(partner, Motion):
            return detect_beats([recording.motion, partner]), contacts, "beats"
        return footplant_cuts(recording.motion, contacts), contacts, "footplants"
    except UncutError as error:
        mend = (
            f"cut it by hand or by fixed length (kinetograph library segment LIB --by fixed --take {recording.name!r})"
        )
        raise UncutError(f"take {recording.name!r} cannot be cut: {error.why}; {mend}", error.why) from error


def annotated_cuts(recording: Recording) -> tuple[float, ...]:
    """The cuts that a recording is annotated with, in seconds; those of a looping clip hold in each of its cycles."""
    cuts = sorted({note.start for note in recording.take.annotated(recording.track, "cut")})
    if period := recording.period:
        once = [c for c in cuts if c < period - 1e-6]
        cuts = sorted(c + cycle * period for cycle in range(CYCLES) for c in once)
    return tuple(cuts)


def _handholds(recording: Recording, partner: Motion | Signal | None) -> tuple[Annotation, ...]:
    noted = recording.take.annotated(recording.track, "handhold")
    if noted or not isinstance(partner, Motion):
        return noted
    motion = recording.motion
    return detect_handholds(motion, resample(partner, motion.fps), track=recording.track)


def _source(
    settings: PerformanceSettings,
    recording: Recording,
    partner: Motion | Signal | None,
    annotations: tuple[Annotation, ...],
    cuts: tuple[float, ...],
    *,
    mirrored: bool,
) -> Source:
    motion = recording.motion
    return Source(
        recording.name,
        recording.track,
        mirrored,
        motion,
        _control_points(settings, recording, partner),
        target_points(settings, motion),
        annotations,
        cuts,
        recording.period,
        grips(motion, partner, annotations) if isinstance(partner, Motion) else {},
        _overlap(motion, partner) if isinstance(partner, Motion) else None,
        person_of(recording),
        recording.facts.tags,
    )


def _overlap(motion: Motion, partner: Motion) -> float | None:
    """How deep two torsos are in one another at most; None where either body has none."""
    if not (has_torso(motion.skeleton) and has_torso(partner.skeleton)):
        return None
    resampled = sample(partner, np.arange(len(motion)) / motion.fps, motion.fps)
    return float(overlaps(torso_of(motion), torso_of(resampled)).max())


def _control_points(settings: PerformanceSettings, recording: Recording, partner: Motion | Signal | None) -> FloatArray:
    """The points of what was the control, ``(F, P, 3)``, at the frames of the motion."""
    motion = recording.motion
    try:
        points = settings.control_points.points(motion if partner is None else partner)
    except RequestError as error:
        raise RequestError(f"take {recording.name!r}: {error}") from error
    if partner is None:
        return points
    return interpolate(points, np.arange(len(motion)) / motion.fps * partner.fps)


def target_points(settings: PerformanceSettings, motion: Motion) -> FloatArray:
    """The points of a motion that are compared across seams, ``(F, Q, 3)``: in place, or about the root."""
    points = role_positions(motion, tuple(settings.targets))
    if not settings.alignment.continues:
        return points
    # poses are compared where bodies stand, wherever that is
    back = rot.about("y", -headings(motion))
    return rot.rotate(back[:, None], points - on_ground(motion.translation[:, None]))
