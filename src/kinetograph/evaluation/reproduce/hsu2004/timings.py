"""What the search costs, with and without a beam, and by the length of the control (Hsu 2004, sections 4.4 and 6.1)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from kinetograph.evaluation.reproduce.hsu2004 import figures
from kinetograph.evaluation.reproduce.hsu2004.data import held_out, lasting
from kinetograph.evaluation.reproduce.hsu2004.models import FINE, clustered, search_points, segments_in, with_method
from kinetograph.evaluation.reproduce.page import Section, Value, paragraph, picture, records, table
from kinetograph.evaluation.reproduce.timing import Jobs, processor_seconds, straight_line
from kinetograph.learn import SegmentalPath, solve
from kinetograph.library import Library
from kinetograph.methods.performance import (
    PerformanceControl,
    PerformanceModel,
    arrivals,
    at_rate,
    fine_borders,
    interpret,
    left_early,
    read_control,
    realize,
)
from kinetograph.motion import Motion
from kinetograph.progress import Report

SECONDS, SEGMENTS = 57.0, 70
"""The thesis' timing test: a control of 57 s, a library of 70 segments."""
BEAMS = (0.001, 0.01, 0.1)
LENGTHS = (15.0, 30.0, 60.0, 120.0, 180.0, 240.0, 300.0)
"""Seconds of control."""

COLUMNS = (
    *("search", "segments", "states", "dynamic programme ms", "with scoring and placing ms", "upsampling ms"),
    *("postprocessing ms", "score over the optimum", "seconds of control a second"),
)
PAPER = """The thesis, 6.1: 57 s of control, 70 segments, two 2.4 GHz Xeons of 2003: 12.5 s for the dynamic
programme, 1.2 s with a beam, 0.4 s upsampling, 1.1 s postprocessing; the result with the beam was visually perfect."""
SAME = """The thesis' times are the clock's, ours the processor's on one thread; the machines are twenty years apart.
The exact search leaves out only pairs that cannot win, which is what a beam was for; what is left is scoring and
placing every window against every segment, on which a beam saves nothing."""
GROWTH = "The thesis, 4.4 and 6.1: O(P² T), P states and T steps; linear in the length by experiment, no figures given."


def timing_section(library: Library, quick: bool, tick: Report) -> Section:
    """A control of 57 s with and without beam, at the thesis' number of segments and with all of them."""
    name, motion = held_out(library)[0]
    control = lasting(motion, SECONDS)
    rows: list[tuple[Value, ...]] = [
        ("thesis, exact", SEGMENTS, None, 12500.0, None, 400.0, 1100.0, None, SECONDS / 12.5),
        ("thesis, beam", SEGMENTS, None, 1200.0, None, 400.0, 1100.0, None, 47.0),
    ]
    for label, segments in (("clustered", SEGMENTS), ("all segments", 10**9)):
        model = clustered(PerformanceControl(reuse=0.0, stand=False), library, segments, exclude=(name,))
        rows += timed(model, control, label, BEAMS, 3 if quick else 7)
        tick(f"timings, {label}")
    caption = f"Processor time, medians, all jobs in turn; control: {name}, {SECONDS:g} s"
    parts = (paragraph(PAPER, "paper"), table(caption, COLUMNS, rows), paragraph(SAME))
    return Section("Timings with and without beam", parts, {"rows": records(COLUMNS, rows)})


def timed(
    model: PerformanceModel, control: Motion, label: str, beams: Sequence[float], repeats: int
) -> list[tuple[Value, ...]]:
    """Time the exact search and those with a beam.

    Parameters
    ----------
    model : PerformanceModel
    control : Motion
    label : str
        Begins the name of every row.
    beams : sequence of float
        Widths.
    repeats : int
        Of every job.

    Returns
    -------
    list of tuple
        One row per search, see `COLUMNS`.
    """
    kinds = {"exact": model, **{f"beam {w:g}": with_method(model, beam=w) for w in beams}}
    x = search_points(model, control)
    paths = {name: interpret(kind.fitted, x) for name, kind in kinds.items()}
    best = paths["exact"]
    jobs = _jobs(model, control, kinds, best)
    ms = {name: 1000 * seconds for name, seconds in processor_seconds(jobs, repeats).items()}
    sizes = (segments_in(model), len(model.fitted.instances.states))
    post = ms["realize"] - ms["upsampling"]
    return [
        (
            *(f"{label}, {name}", *sizes, ms[f"solve {name}"], ms[f"search {name}"], ms["upsampling"], post),
            *(_over(paths[name].score, best.score), 1000 * control.duration / ms[f"search {name}"]),
        )
        for name in kinds
    ]


def _jobs(model: PerformanceModel, control: Motion, kinds: dict[str, PerformanceModel], best: SegmentalPath) -> Jobs:
    """What is timed: the searches, alone and with scoring, and what turns the best sequence into a motion."""
    fitted, read = model.fitted, read_control(model.method, control)
    x, dense = (at_rate(read.points, read.fps, rate) for rate in (model.method.rate, FINE))
    steps, ends = list(arrivals(fitted, x)), left_early(fitted, x)
    jobs: Jobs = {
        "upsampling": lambda: fine_borders(fitted, dense, FINE, best),
        "realize": lambda: realize(fitted, read, best),
    }
    for name, kind in kinds.items():
        jobs[f"solve {name}"] = partial(solve, kind.fitted.search, steps, ends)
        jobs[f"search {name}"] = partial(interpret, kind.fitted, x)
    return jobs


def _over(score: float, best: float) -> str:
    return f"{100 * (score / best - 1):.2f} %" if best > 0 else f"{score:.3g}"


def growth_section(library: Library, quick: bool, tick: Report) -> Section:
    """Time against length of the control."""
    name, motion = held_out(library)[0]
    model = PerformanceControl(reuse=0.0, stand=False).fit(library, exclude=(name,))
    kinds = {"exact": model, "beam": with_method(model, beam=0.01)}
    lengths = LENGTHS[:4] if quick else LENGTHS
    jobs: Jobs = {}
    for seconds in lengths:
        x = search_points(model, lasting(motion, seconds))
        for kind, searched in kinds.items():
            jobs[f"{kind} {seconds}"] = partial(interpret, searched.fitted, x)
    taken = processor_seconds(jobs, 3 if quick else 5)
    tick("time against length")
    times = {kind: [taken[f"{kind} {seconds}"] for seconds in lengths] for kind in kinds}
    states = len(model.fitted.instances.states)
    return _growth(lengths, times, f"Processor time of the search, {states} states; control: {name}, over and over")


def _growth(lengths: Sequence[float], times: dict[str, list[float]], caption: str) -> Section:
    fits = {kind: straight_line(lengths, values) for kind, values in times.items()}
    columns = ("seconds of control", *(f"{kind}, ms" for kind in times), *(f"{kind}, ms a second" for kind in times))
    rows: list[tuple[Value, ...]] = [
        (s, *(1000 * v[i] for v in times.values()), *(1000 * v[i] / s for v in times.values()))
        for i, s in enumerate(lengths)
    ]
    lines = (
        f"{kind}: {1000 * a:.2f} ms per second of control and {1000 * b:.1f} ms, R² = {r2:.4f}"
        for kind, (a, b, r2) in fits.items()
    )
    drawing = figures.draw_growth(lengths, times, {k: (a, b) for k, (a, b, _) in fits.items()})
    parts = (
        paragraph(GROWTH, "paper"),
        table(caption, columns, rows),
        paragraph(f"Lines fitted: {'; '.join(lines)}."),
        picture(drawing, "Processor time against the control's length."),
    )
    fitted = {k: {"slope": a, "intercept": b, "r2": r} for k, (a, b, r) in fits.items()}
    return Section("Time against length", parts, {"rows": records(columns, rows), "fits": fitted})
