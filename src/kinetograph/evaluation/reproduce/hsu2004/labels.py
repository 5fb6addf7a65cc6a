"""Segment and pattern error rates on walks whose steps have names (Hsu 2004, section 6.2)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from kinetograph.errors import KinetographError
from kinetograph.evaluation.labels import LabelErrors, take_errors
from kinetograph.evaluation.protocol import held_out_motion
from kinetograph.evaluation.reproduce.hsu2004.sway import turning
from kinetograph.evaluation.reproduce.page import Section, Value, paragraph, records, table
from kinetograph.library import Library
from kinetograph.methods.performance import PerformanceControl
from kinetograph.motion import Motion
from kinetograph.progress import Report
from kinetograph.segmentation import detect_contacts, footplant_cuts
from kinetograph.take import Annotation, Take

Namer = Callable[[Motion, Sequence[float]], list[str]]
"""Names the steps of a motion between its cuts, in seconds."""
TURN = np.deg2rad(15.0)
"""How far a person turns within a step that is called a turn."""
COLUMNS = (
    *("recordings", "names", "method", "segments", "wrong %", "patterns", "wrong patterns %"),
    *("always the commonest: wrong %",),
)
PAPER = """The thesis, 6.2: in three test dances the follower's pattern was another than the real one's in 5 of 91
(5.5 %), each by one of its four two-beat segments: 5 of 364 (1.4 %). The names were given by eye. (Figure 6-2 counts
380 segments, and the text 13 new patterns of the 14 in table 6.1.)"""
OURS = """Dances are in the section on dances. Here walks are named by rule: every step between two footplants by the
foot that begins it, and by how far the hips turn within it (left or right from 15° on, else straight); the clips of
the sample by their own names. A segment is wrong where the pieces that fill most of it carry another name; a pattern
is four segments in a row, wrong if any is."""


def label_section(walks: Library | None, clips: Library | None, tick: Report) -> Section:
    """Error rates on all walks that can be named."""
    rows: list[tuple[Value, ...]] = []
    if walks is not None and walks is not clips:
        for names, namer in (("foot", steps_by_foot), ("turn", steps_by_turn)):
            name_steps(walks, namer)
            rows += _rows(walks, "walks", names)
    if clips is not None:
        rows += _rows(clips, "sample", "clip")
    tick("moves")
    parts = [paragraph(PAPER, "paper"), paragraph(OURS)]
    parts.append(table("Segments and patterns that come out as another move, held-out takes together", COLUMNS, rows))
    return Section("Segment and pattern errors", tuple(parts), {"rows": records(COLUMNS, rows)})


def _rows(library: Library, recordings: str, names: str) -> list[tuple[Value, ...]]:
    rows: list[tuple[Value, ...]] = []
    for label, k in (("segments", None), ("nearest segment", 0.0)):
        method = (
            PerformanceControl(reuse=0.0, stand=False)
            if k is None
            else PerformanceControl(reuse=0.0, stand=False, continuity=k)
        )
        rates, truth = held_out_errors(library, method)
        commonest = max(Counter(truth).values()) / len(truth) if truth else float("nan")
        rows.append(
            (
                *(recordings, names, label, rates.segments, 100 * rates.segment_rate),
                *(rates.patterns, 100 * rates.pattern_rate, 100 * (1 - commonest)),
            )
        )
    return rows


def held_out_errors(library: Library, method: PerformanceControl) -> tuple[LabelErrors, list[str]]:
    """The errors of all takes together, each held out in turn.

    Parameters
    ----------
    library : Library
    method : PerformanceControl

    Returns
    -------
    errors : LabelErrors
    names : list of str
        The names of the segments that were judged.
    """
    total, names = LabelErrors(0, 0, 0, 0), []
    for name in library.names():
        take = library.take(name)
        motion = held_out_motion(take)
        result = method.fit(library, exclude=(name,)).synthesize(motion)
        played = as_played(take, motion)
        total += take_errors(played, "motion", result.annotations, method.span)
        names += [note.label for note in played.annotated("motion", "move")]
    return total, names


def as_played(take: Take, motion: Motion) -> Take:
    """A take as it is held out: a looping clip cut at the footplants of all its cycles, one move from cut to cut."""
    track, _ = take.named_motion()
    moves, cuts = take.annotated(track, "move"), take.annotated(track, "cut")
    if not cuts:
        times = footplant_cuts(motion, detect_contacts(motion))
        cuts = tuple(Annotation("motion", "cut", "", t, t) for t in times)
        moves = tuple(Annotation("motion", "move", moves[0].label, a, b) for a, b in pairwise(times)) if moves else ()
    return Take(take.name, {"motion": motion}, tuple(replace(n, track="motion") for n in (*cuts, *moves)))


def name_steps(library: Library, namer: Namer) -> None:
    """Annotate every step between two cuts of a library's takes with the name that ``namer`` gives."""
    for name in library.names():
        take = library.take(name)
        track, _ = take.named_motion()
        cuts = sorted({note.start for note in take.annotated(track, "cut")})
        names = namer(take.motion(), cuts)
        notes = tuple(Annotation(track, "move", n, a, b) for n, (a, b) in zip(names, pairwise(cuts), strict=True))
        library.annotate(name, notes, kind="move", track=track)


def steps_by_foot(motion: Motion, cuts: Sequence[float]) -> list[str]:
    """The foot that is planted at the beginning of each step."""
    contacts = detect_contacts(motion)
    if not contacts:
        raise KinetographError("no foot is ever planted")
    names = []
    for start in cuts[:-1]:
        nearest = min(contacts, key=lambda note: abs(note.start - start))
        names.append(nearest.label.split("_")[0])
    return names


def steps_by_turn(motion: Motion, cuts: Sequence[float]) -> list[str]:
    """How the hips turn within each step: left, right or straight."""
    angle = np.cumsum(turning(motion)) / motion.fps
    frames = np.clip(np.round(np.array(cuts) * motion.fps).astype(int), 0, len(angle) - 1)
    turned = np.diff(angle[frames])
    return ["left" if t > TURN else "right" if t < -TURN else "straight" for t in turned]
