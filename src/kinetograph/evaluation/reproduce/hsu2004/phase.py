"""Does a generated gait keep the phase of the real one, and what of the control does that take? (Hsu 2004, 6.1)"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.metrics import joint_error
from kinetograph.evaluation.phase import cadence_ratio, phase_difference
from kinetograph.evaluation.reproduce.hsu2004 import figures
from kinetograph.evaluation.reproduce.hsu2004.data import held_out
from kinetograph.evaluation.reproduce.hsu2004.gaits import (
    HIPS,
    PATH,
    Walked,
    fit_all,
    in_phase_by_footplants,
    in_phase_by_smoothing,
    in_step_by_length,
    methods,
    walk_again,
)
from kinetograph.evaluation.reproduce.hsu2004.sway import Footwork, Sway, sway_by_phase, turn_footwork
from kinetograph.evaluation.reproduce.page import Section, Value, paragraph, picture, records, table
from kinetograph.library import Library
from kinetograph.progress import Report

LENGTHS = (2.0, 4.0, 8.0, 16.0, 32.0)
"""Seconds of the excerpts."""

CLAIM = """The thesis, 6.1: on short walks the gait had nearly the source's frequency but not its phase, which the
control does not determine; on longer ones, to the author's surprise, it was often nearly in phase. The explanation
given is that the subject turned sharply with the same footwork each time, and that the global optimum carries the phase
at a turn over the whole walk. No figure is given."""
HIPS_AND_PATH = """The control is the two hip joints on the ground. Their distance is set to one value, but where their
middle goes and how their line turns is kept, and a walking pelvis sways sideways and turns with every stride. So the
experiment is run twice: with the hips as in the thesis, and with the path alone, where sway and rotation of the hips
within a stride are smoothed away on both sides, the control and the library (Gaussian of 0.6 s)."""
NULL = """In phase means within a quarter of a cycle; a gait that does not depend on the control is in phase half of the
time. The null moves the generated gait round in time by 5 s or more, 999 times: the same gait, started elsewhere."""
SMOOTHED = """How much sway is needed: the share in phase as the hips are smoothed more, on both sides. A stride a
second keeps exp(-2 π² s²) of its sway."""

COLUMNS = (
    *("take", "control", "seconds walking", "in phase %", "by footplants %", "mean cosine", "resultant"),
    *("mean difference °", "slips", "cadence, times real", "null's 95th percentile", "p", "joints cm"),
)
EXCERPTS = ("seconds", "excerpts", f"{HIPS}: in step %", f"{PATH}: in step %")
SMOOTHING = ("Gaussian, seconds", "sway kept at a stride a second %", "in phase %", "joints cm")
TURNS = ("turns", "count", "mean phase °", "resultant", "Rayleigh p")


def phase_section(title: str, library: Library, quick: bool, tick: Report, *, first: bool = True) -> Section:
    """All figures on phase from one library of walks.

    Parameters
    ----------
    title : str
    library : Library
    quick : bool
        Fewer excerpts and takes.
    tick : Report
        Called with what was done last.
    first : bool
        Whether what the thesis says comes first.
    """
    models, takes = fit_all(library), held_out(library)
    walked = [w for name, motion in takes for c in methods() if (w := walk_again(models[name, c], name, c, motion))]
    tick("whole walks")
    if not walked:
        text = "No take walks for long enough, or with steps wide enough, to have a phase."
        return Section(title, (paragraph(text, "missing"),))
    rows, sway = [_row(w) for w in walked], sway_by_phase(takes[0][1])
    excerpts = in_step_by_length(takes, models, 3 if quick else 8, LENGTHS[:3] if quick else LENGTHS)
    tick("excerpts")
    turns = turn_footwork([motion for _, motion in takes])
    smoothed = in_phase_by_smoothing(library, takes[:1] if quick else takes)
    tick("smoothing")
    parts = (
        *((paragraph(CLAIM, "paper"), paragraph(HIPS_AND_PATH)) if first else ()),
        *(*_whole_walks(walked, rows), *_sway(sway), *_excerpts(excerpts), *_turns(turns)),
        *(paragraph(SMOOTHED), table("Share in phase by smoothing", SMOOTHING, smoothed)),
    )
    numbers = {"rows": records(COLUMNS, rows), "excerpts": excerpts, "turns": turns, "smoothed": smoothed}
    return Section(title, parts, numbers)


def _row(walked: Walked) -> tuple[Value, ...]:
    kept = walked.kept
    return (
        *(walked.take, walked.control, kept.seconds, 100 * kept.in_phase, 100 * in_phase_by_footplants(walked)),
        *(kept.agreement, kept.resultant, float(np.rad2deg(kept.mean)), kept.slips, cadence_ratio(*walked.phases)),
        *(kept.null_p95, kept.p, 100 * joint_error(walked.made, walked.real)),
    )


def _whole_walks(walked: Sequence[Walked], rows: Sequence[tuple[Value, ...]]) -> tuple[str, ...]:
    return (
        table("Phase of the generated gait less that of the real one, held-out takes", COLUMNS, rows),
        paragraph(_verdict(walked)),
        picture(figures.draw_differences(_tracks(walked)), "The difference of phase over time, longest take."),
    )


def _tracks(walked: Sequence[Walked]) -> list[tuple[str, FloatArray, FloatArray]]:
    """Of the first take: by control, times and differences where both walk."""
    tracks = []
    for one in (w for w in walked if w.take == walked[0].take):
        difference, both = phase_difference(*one.phases)
        times = np.flatnonzero(both) / one.real.fps
        tracks.append((f"{one.take}, {one.control}", times, difference[both]))
    return tracks


def _verdict(walked: Sequence[Walked]) -> str:
    verdicts = []
    for control in dict.fromkeys(w.control for w in walked):
        mine = [w.kept for w in walked if w.control == control]
        seconds = sum(k.seconds for k in mine)
        share = 100 * sum(k.in_phase * k.seconds for k in mine) / seconds
        significant = sum(k.p < 0.05 for k in mine)
        tested = sum(not np.isnan(k.p) for k in mine)
        beyond = f"beyond chance (p < 0.05) in {significant} of {tested} takes that are long enough for the test"
        verdicts.append(f"{control}: {share:.0f} % of {seconds:.0f} s in phase, {beyond}")
    return f"{NULL} {'; '.join(verdicts)}."


def _sway(sway: Sway) -> tuple[str, str]:
    _, mean, spread = sway
    swing = np.nanmax(mean, axis=0) - np.nanmin(mean, axis=0)
    rest = np.nanmean(spread, axis=0)
    text = (
        f"Within a stride the middle of the hips goes {swing[0]:.1f} cm from side to side and their line turns by "
        f"{swing[1]:.1f}°, where the walk is straight; about that mean single strides spread by {rest[0]:.1f} cm and "
        f"{rest[1]:.1f}°. Projecting the hips and setting their distance leaves both in the control."
    )
    caption = "How the hips depend on the phase: mean and spread over the strides."
    return picture(figures.draw_sway(*sway), caption), paragraph(text)


def _excerpts(rows: Sequence[tuple[float, int, float, float]]) -> tuple[str, str]:
    return (
        table("Excerpts that come out on the right foot, by their length", EXCERPTS, rows),
        picture(figures.draw_excerpts(rows), "Excerpts in step by length, 95 % intervals (Wilson)."),
    )


def _turns(rows: Sequence[Footwork]) -> tuple[str, str]:
    resultants = [f"{side}: {r:.2f} over {n} turns" for side, n, _, r, _ in rows]
    text = (
        "The thesis' explanation can be tested by itself: if turns are made with the same footwork, the gait is at "
        f"one phase whenever a turn is sharpest. Resultant of these phases, 1 for always the same: "
        f"{'; '.join(resultants)}."
    )
    return paragraph(text), table("Gait phase where turns are sharpest", TURNS, rows)
