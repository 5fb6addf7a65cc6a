"""What settings change in held-out walks: clustering, rate of the search, continuity (Hsu 2004, sections 4.4, 6.1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from kinetograph.evaluation.metrics import distinct_share
from kinetograph.evaluation.phase import foot_agreement
from kinetograph.evaluation.reproduce.hsu2004 import figures
from kinetograph.evaluation.reproduce.hsu2004.models import (
    FINE,
    Held,
    errors,
    held_models,
    placed_again,
    seam_gap,
    search_points,
    segments_in,
    with_method,
)
from kinetograph.evaluation.reproduce.page import Section, Value, paragraph, picture, records, table
from kinetograph.evaluation.reproduce.timing import Jobs, processor_seconds
from kinetograph.library import Library
from kinetograph.methods.performance import (
    PerformanceControl,
    PerformanceModel,
    at_rate,
    fine_borders,
    interpret,
    read_control,
    realize,
)
from kinetograph.motion import Motion
from kinetograph.progress import Report

CLUSTERS = (None, 0.03, 0.05, 0.08, 0.12, 0.18)
"""Thresholds, metres."""
RATES = (5.0, 7.5, 10.0, 15.0, 30.0)
CONTINUITY = (0.0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)

CLUSTERED = (
    *("threshold", "segments", "states", "search ms", "score", "control cm", "joints cm"),
    *("agreement of the feet", "distinct source"),
)
RATED = ("search", "refinement", "search ms", "refinement ms", "score at 30 Hz", "control cm", "joints cm")
SWEPT = ("k, seconds", "control cm", "joints cm", "gap at seams cm", "agreement of the feet", "pieces")
CLUSTERING = """The thesis, 4.4.2 and 6.1: complete linkage, 200 segments to 70; none of its shortcuts improves a
result, they only make it cheaper. What the result loses is not measured."""
THRESHOLD = """The threshold is a root mean square over control and target points, and a cluster keeps its medoid;
the thesis' distance is that of the control alone, and its representative is drawn."""
SAMPLING = """The thesis, 4.4.3: search at 10 Hz (dances at 7.5), then a constrained search at 30 Hz that keeps the
segments and adjusts their durations, since plain upsampling leaves small errors of time. No comparison is given."""
LARGER = "The thesis, 6.1: larger values of the constant were more effective; found by experiment, not given."


def cluster_section(library: Library, quick: bool, tick: Report) -> Section:
    """What clustering costs and saves, over all held-out takes."""
    rows: list[tuple[Value, ...]] = []
    for threshold in CLUSTERS:
        held = held_models(library, PerformanceControl(reuse=0.0, stand=False, cluster=threshold), quick)
        rows.append(("none" if threshold is None else f"{100 * threshold:g} cm", *_cost_and_error(held)))
    tick("clustering")
    caption = "Clustering, means over the held-out takes; the score is that of equation 4.5"
    parts = (paragraph(CLUSTERING, "paper"), table(caption, CLUSTERED, rows), paragraph(THRESHOLD))
    return Section("Clustering", parts, {"rows": records(CLUSTERED, rows)})


def _cost_and_error(held: Sequence[Held]) -> tuple[float, ...]:
    """Means: segments, states, search ms, score, control and joint error, agreement of the feet, distinct share."""
    jobs: Jobs = {}
    measured = []
    for i, (model, motion) in enumerate(held):
        jobs[str(i)] = partial(interpret, model.fitted, search_points(model, motion))
        result = model.synthesize(motion)
        feet = foot_agreement(result.motion, motion)
        measured.append((result.cost, *errors(model, result, motion), feet, distinct_share(result)))
    taken = sum(processor_seconds(jobs, 3).values()) / len(held)
    segments = round(sum(segments_in(model) for model, _ in held) / len(held))
    states = round(sum(len(model.fitted.instances.states) for model, _ in held) / len(held))
    return segments, states, 1000 * taken, *(float(value) for value in np.mean(measured, axis=0))


def rate_section(library: Library, quick: bool, tick: Report) -> Section:
    """The rate of the search, and the constrained search that adjusts durations at 30 Hz."""
    rows: list[tuple[Value, ...]] = []
    for rate in RATES:
        for fine in (None, FINE) if rate < FINE else (None,):
            held = held_models(library, PerformanceControl(reuse=0.0, stand=False, rate=rate, fine_rate=fine), quick)
            means = np.mean([_at_rate(model, motion) for model, motion in held], axis=0)
            rows.append((f"{rate:g} Hz", f"{fine:g} Hz" if fine else "none", *(float(value) for value in means)))
        tick(f"search at {rate:g} Hz")
    caption = "The rate of the search; every result is scored by equation 4.5 at 30 Hz"
    parts = (paragraph(SAMPLING, "paper"), table(caption, RATED, rows))
    return Section("Search rate and refinement", parts, {"rows": records(RATED, rows)})


def _at_rate(model: PerformanceModel, motion: Motion) -> tuple[float, ...]:
    """Search and refinement in ms, score at 30 Hz, control and joint error."""
    read = read_control(model.method, motion)
    x, dense = (at_rate(read.points, read.fps, rate) for rate in (model.method.rate, FINE))
    path = interpret(model.fitted, x)
    jobs: Jobs = {"search": lambda: interpret(model.fitted, x)}
    if model.method.fine_rate:
        jobs["refinement"] = lambda: fine_borders(model.fitted, dense, FINE, path)
    taken = processor_seconds(jobs, 3)
    result = realize(model.fitted, replace(read, partner=None), path)
    score = sum(piece.cost + piece.seam for piece in placed_again(model, result, dense, FINE))
    return (
        *(1000 * taken["search"], 1000 * taken.get("refinement", 0.0), score),
        *errors(model, result, motion),
    )


def continuity_section(library: Library, quick: bool, tick: Report) -> Section:
    """The constant k, over all held-out takes."""
    held = held_models(library, PerformanceControl(reuse=0.0, stand=False), quick)
    values = CONTINUITY[::2] if quick else CONTINUITY
    rows: list[tuple[float, ...]] = []
    for k in values:
        means = np.mean([_with_continuity(model, motion, k) for model, motion in held], axis=0)
        rows.append((k, *(float(value) for value in means)))
    tick("continuity")
    curves = {SWEPT[i]: [row[i] for row in rows] for i in (1, 2, 3)}
    near, smooth = (min(rows, key=lambda row: row[i])[0] for i in (2, 3))
    text = f"""The joints are nearest the recording at k = {near:g}, the gaps at seams smallest at k = {smooth:g}:
    a larger constant makes the motion smoother before blending, and follows the control less closely."""
    parts = (
        paragraph(LARGER, "paper"),
        table("The continuity constant, means over the held-out takes", SWEPT, rows),
        paragraph(text),
        picture(figures.draw_curves(values, curves, "k, seconds"), "Errors over the continuity constant."),
    )
    return Section("Continuity constant", parts, {"rows": records(SWEPT, rows)})


def _with_continuity(model: PerformanceModel, motion: Motion, k: float) -> tuple[float, ...]:
    """Control and joint error, gap at seams, agreement of the feet, number of pieces."""
    changed = with_method(model, continuity=k)
    result = changed.synthesize(motion)
    gap, feet = seam_gap(changed, result, motion), foot_agreement(result.motion, motion)
    return (*errors(changed, result, motion), gap, feet, len(result.pieces))
