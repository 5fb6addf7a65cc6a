"""What the search costs, and what each way to make it cheaper changes (Hsu 2004, sections 4.4 and 6.1)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.metrics import control_error, distinct_share, joint_error
from kinetograph.evaluation.phase import foot_agreement
from kinetograph.evaluation.reproduce.hsu2004 import figures
from kinetograph.evaluation.reproduce.hsu2004.data import held_out, lasting
from kinetograph.evaluation.reproduce.page import Section, Value, paragraph, picture, records, table
from kinetograph.evaluation.reproduce.timing import Jobs, processor_seconds, straight_line
from kinetograph.learn.segmental import solve
from kinetograph.library import Library
from kinetograph.methods.performance import (
    PerformanceControl,
    PerformanceModel,
    Segment,
    at_rate,
    fine_borders,
    interpret,
    left_early,
    pieces_of,
    points_of,
    read_control,
    realize,
)
from kinetograph.methods.performance.scoring import arrivals_at
from kinetograph.motion import Motion
from kinetograph.synthesis import Piece, Synthesis

Tick = Callable[[str], None]
Held = tuple[PerformanceModel, Motion]
SECONDS, SEGMENTS = 57.0, 70
"""The thesis' timing test: a control of 57 s, a library of 70 segments."""
BEAMS = (0.001, 0.01, 0.1)
CONTINUITY = (0.0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
CLUSTERS = (None, 0.03, 0.05, 0.08, 0.12, 0.18)
RATES = (5.0, 7.5, 10.0, 15.0, 30.0)
FINE = 30.0
LENGTHS = (15.0, 30.0, 60.0, 120.0, 180.0, 240.0, 300.0)
TIMED = (
    *("search", "segments", "states", "dynamic programme ms", "with scoring and placing ms", "upsampling ms"),
    *("postprocessing ms", "score over the optimum", "seconds of control a second"),
)
CLUSTERED = (
    *("threshold", "segments", "states", "search ms", "score", "control cm", "joints cm"),
    *("agreement of the feet", "distinct source"),
)
RATED = ("search", "refinement", "search ms", "refinement ms", "score at 30 Hz", "control cm", "joints cm")
SWEPT = ("k, seconds", "control cm", "joints cm", "gap at seams cm", "agreement of the feet", "pieces")
WALK_TIMES = """The thesis, 6.1: 57 s of control, 70 segments, two 2.4 GHz Xeons of 2003: 12.5 s for the dynamic
programme, 1.2 s with a beam, 0.4 s upsampling, 1.1 s postprocessing; the result with the beam was visually perfect."""
SAME = """The thesis' times are the clock's, ours the processor's on one thread; the machines are twenty years apart.
The exact search leaves out only pairs that cannot win, which is what a beam was for; what is left goes into scoring
and placing every window against every segment, which a beam does not spare."""
GROWTH = "The thesis, 4.4 and 6.1: O(P² T), P states and T steps; linear in the length by experiment, no figures given."
CLUSTERING = """The thesis, 4.4.2 and 6.1: complete linkage, 200 segments to 70; none of its shortcuts improves a
result, they only make it cheaper. What the result loses is not measured."""
THRESHOLD = """The threshold is a root mean square over control and target points, and a cluster keeps its medoid;
the thesis' distance is that of the control alone, and its representative is drawn."""
SAMPLING = """The thesis, 4.4.3: search at 10 Hz (dances at 7.5), then a constrained search at 30 Hz that keeps the
segments and adjusts their durations, since plain upsampling leaves small errors of time. No comparison is given."""
LARGER = "The thesis, 6.1: larger values of the constant were more effective; found by experiment, not given."


def timing_section(library: Library, quick: bool, tick: Tick) -> Section:
    """A control of 57 s with and without beam, at the thesis' number of segments and with all of them."""
    name, motion = held_out(library)[0]
    control = lasting(motion, SECONDS)
    rows: list[tuple[Value, ...]] = [
        ("thesis, exact", SEGMENTS, None, 12500.0, None, 400.0, 1100.0, None, SECONDS / 12.5),
        ("thesis, beam", SEGMENTS, None, 1200.0, None, 400.0, 1100.0, None, 47.0),
    ]
    for label, segments in (("clustered", SEGMENTS), ("all segments", 10**9)):
        model = clustered(PerformanceControl(), library, segments, exclude=(name,))
        rows += timed(model, control, label, BEAMS, 3 if quick else 7)
        tick(f"timings, {label}")
    caption = f"Processor time, medians, all jobs in turn; control: {name}, {SECONDS:g} s"
    parts = (paragraph(WALK_TIMES, "paper"), table(caption, TIMED, rows), paragraph(SAME))
    return Section("Timings with and without beam", parts, {"rows": records(TIMED, rows)})


def timed(
    model: PerformanceModel, control: Motion, label: str, beams: Sequence[float], repeats: int
) -> list[tuple[Value, ...]]:
    """One row for the exact search and for each beam."""
    fitted, read = model.fitted, read_control(model.method, control)
    x, dense = (at_rate(read.points, read.fps, rate) for rate in (model.method.rate, FINE))
    reach = fitted.instances.longest + 1
    arrivals = [arrivals_at(fitted, x[max(t + 1 - reach, 0) : t + 1]) for t in range(1, len(x))]
    ends = left_early(fitted, x)
    kinds = {"exact": model, **{f"beam {w:g}": with_method(model, beam=w) for w in beams}}
    paths = {name: interpret(kind.fitted, x) for name, kind in kinds.items()}
    best = paths["exact"]
    jobs: Jobs = {
        "upsampling": lambda: fine_borders(fitted, dense, FINE, best),
        "realize": lambda: realize(fitted, read, best),
    }
    for name, kind in kinds.items():
        jobs[f"solve {name}"] = partial(solve, kind.fitted.search, arrivals, ends)
        jobs[f"search {name}"] = partial(interpret, kind.fitted, x)
    ms = {name: 1000 * seconds for name, seconds in processor_seconds(jobs, repeats).items()}
    sizes = (len(fitted.instances.segments), len(fitted.instances.states))
    post = ms["realize"] - ms["upsampling"]
    return [
        (
            *(f"{label}, {name}", *sizes, ms[f"solve {name}"], ms[f"search {name}"], ms["upsampling"], post),
            *(_over(paths[name].score, best.score), 1000 * control.duration / ms[f"search {name}"]),
        )
        for name in kinds
    ]


def _over(score: float, best: float) -> str:
    return f"{100 * (score / best - 1):.2f} %" if best > 0 else f"{score:.3g}"


def clustered(
    method: PerformanceControl,
    library: Library,
    segments: int,
    *,
    exclude: tuple[str, ...] = (),
    track: str | None = None,
) -> PerformanceModel:
    """The model whose number of segments is nearest, by bisection of the threshold; all where there are fewer."""
    best = method.fit(library, exclude=exclude, track=track)
    if segments_in(best) <= segments:
        return best
    low, high = 0.0, 1.0
    for _ in range(9):
        middle = 0.5 * (low + high)
        model = replace(method, cluster=middle).fit(library, exclude=exclude, track=track)
        count = segments_in(model)
        if abs(count - segments) < abs(segments_in(best) - segments):
            best = model
        low, high = (middle, high) if count > segments else (low, middle)
    return best


def segments_in(model: PerformanceModel) -> int:
    """The number of a model's segments."""
    return len(model.fitted.instances.segments)


def with_method(
    model: PerformanceModel, *, beam: float | None = None, continuity: float | None = None
) -> PerformanceModel:
    """The model with another beam or k, on which its instances do not depend."""
    k = model.method.continuity if continuity is None else continuity
    settings = replace(model.method, beam=beam, continuity=k)
    return PerformanceModel(replace(model.fitted, settings=settings))


def search_points(model: PerformanceModel, control: Motion) -> FloatArray:
    """The control points of a motion at the search's rate, ``(T + 1, P, 3)``."""
    return at_rate(points_of(model.method, control), control.fps, model.method.rate)


def growth_section(library: Library, quick: bool, tick: Tick) -> Section:
    """Time against length of the control."""
    name, motion = held_out(library)[0]
    model = PerformanceControl().fit(library, exclude=(name,))
    kinds = {"exact": model, "beam": with_method(model, beam=0.01)}
    lengths = LENGTHS[:4] if quick else LENGTHS
    jobs: Jobs = {}
    for seconds in lengths:
        control = lasting(motion, seconds)
        x = search_points(model, control)
        for kind, searched in kinds.items():
            jobs[f"{kind} {seconds}"] = partial(interpret, searched.fitted, x)
    taken = processor_seconds(jobs, 3 if quick else 5)
    tick("time against length")
    times = {kind: [taken[f"{kind} {seconds}"] for seconds in lengths] for kind in kinds}
    fits = {kind: straight_line(lengths, values) for kind, values in times.items()}
    columns = ("seconds of control", *(f"{kind}, ms" for kind in times), *(f"{kind}, ms a second" for kind in times))
    rows: list[tuple[Value, ...]] = [
        (s, *(1000 * v[i] for v in times.values()), *(1000 * v[i] / s for v in times.values()))
        for i, s in enumerate(lengths)
    ]
    lines = (
        f"{kind}: {1000 * a:.2f} ms a second of control and {1000 * b:.1f} ms, R² = {r2:.4f}"
        for kind, (a, b, r2) in fits.items()
    )
    caption = (
        f"Processor time of the search, {len(model.fitted.instances.states)} states; control: {name}, over and over"
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


def cluster_section(library: Library, quick: bool, tick: Tick) -> Section:
    """What clustering costs and saves, over all held-out takes."""
    rows: list[tuple[Value, ...]] = []
    for threshold in CLUSTERS:
        held = held_models(library, PerformanceControl(cluster=threshold), quick)
        rows.append(("none" if threshold is None else f"{100 * threshold:g} cm", *_cost_and_error(held)))
    tick("clustering")
    caption = "Clustering, means over the held-out takes; the score is that of equation 4.5"
    parts = (paragraph(CLUSTERING, "paper"), table(caption, CLUSTERED, rows), paragraph(THRESHOLD))
    return Section("Clustering", parts, {"rows": records(CLUSTERED, rows)})


def held_models(library: Library, method: PerformanceControl, quick: bool) -> list[Held]:
    """Each take and a model of the others; only the longest take where it must be quick."""
    takes = held_out(library)[: 1 if quick else None]
    return [(method.fit(library, exclude=(name,)), motion) for name, motion in takes]


def _cost_and_error(held: Sequence[Held]) -> tuple[float, ...]:
    """Means: segments, states, search ms, score, control and joint error, agreement of the feet, distinct share."""
    jobs: Jobs = {}
    figures_of = []
    for i, (model, motion) in enumerate(held):
        jobs[str(i)] = partial(interpret, model.fitted, search_points(model, motion))
        result = model.synthesize(motion)
        feet = foot_agreement(result.motion, motion)
        figures_of.append((result.cost, *errors(model, result, motion), feet, distinct_share(result)))
    taken = sum(processor_seconds(jobs, 3).values()) / len(held)
    segments = round(sum(segments_in(model) for model, _ in held) / len(held))
    states = round(sum(len(model.fitted.instances.states) for model, _ in held) / len(held))
    return segments, states, 1000 * taken, *(float(value) for value in np.mean(figures_of, axis=0))


def errors(model: PerformanceModel, result: Synthesis, motion: Motion) -> tuple[float, float]:
    """Control and joint error in cm."""
    control = control_error(result.motion, points_of(model.method, motion), motion.fps)
    return 100 * control, 100 * joint_error(result.motion, motion)


def rate_section(library: Library, quick: bool, tick: Tick) -> Section:
    """The rate of the search, and the constrained search that adjusts durations at 30 Hz."""
    rows: list[tuple[Value, ...]] = []
    for rate in RATES:
        for fine in (None, FINE) if rate < FINE else (None,):
            held = held_models(library, PerformanceControl(rate=rate, fine_rate=fine), quick)
            means = np.mean([_at_rate(model, motion) for model, motion in held], axis=0)
            rows.append((f"{rate:g} Hz", f"{fine:g} Hz" if fine else "none", *(float(value) for value in means)))
        tick(f"search at {rate:g} Hz")
    caption = "The rate of the search; every result is scored by equation 4.5 at 30 Hz"
    parts = (paragraph(SAMPLING, "paper"), table(caption, RATED, rows))
    return Section("Search rate and refinement", parts, {"rows": records(RATED, rows)})


def _at_rate(model: PerformanceModel, motion: Motion) -> tuple[float, ...]:
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


def placed_again(model: PerformanceModel, result: Synthesis, x: FloatArray, rate: float) -> list[Piece]:
    """A result's pieces, placed and costed for control points ``x`` at another rate: the terms of equation 4.5."""
    known: dict[tuple[str, bool, float], Segment] = {}
    for segment in model.fitted.instances.segments:
        source = model.fitted.sources[segment.source]
        known[source.take, source.mirrored, segment.start] = segment
    segments = [known[piece.take, piece.mirrored, piece.source_start] for piece in result.pieces]
    borders = np.array([result.pieces[0].start, *(piece.stop for piece in result.pieces)])
    return pieces_of(model.fitted, x, rate, segments, np.round(borders * rate))


def continuity_section(library: Library, quick: bool, tick: Tick) -> Section:
    """The constant k, over all held-out takes."""
    held = held_models(library, PerformanceControl(), quick)
    values = CONTINUITY[::2] if quick else CONTINUITY
    rows: list[tuple[float, ...]] = []
    for k in values:
        means = np.mean([_with_continuity(model, motion, k) for model, motion in held], axis=0)
        rows.append((k, *(float(value) for value in means)))
    tick("continuity")
    curves = {SWEPT[i]: [row[i] for row in rows] for i in (1, 2, 3)}
    near, smooth = (min(rows, key=lambda row: row[i])[0] for i in (2, 3))
    text = f"""The joints are nearest the recording at k = {near:g}, the gaps at seams smallest at k = {smooth:g}:
    what a larger constant gains is smoothness before blending, what it costs is the control."""
    parts = (
        paragraph(LARGER, "paper"),
        table("The continuity constant, means over the held-out takes", SWEPT, rows),
        paragraph(text),
        picture(figures.draw_curves(values, curves, "k, seconds"), "Errors over the continuity constant."),
    )
    return Section("Continuity constant", parts, {"rows": records(SWEPT, rows)})


def _with_continuity(model: PerformanceModel, motion: Motion, k: float) -> tuple[float, ...]:
    changed = with_method(model, continuity=k)
    result = changed.synthesize(motion)
    gap, feet = seam_gap(changed, result, motion), foot_agreement(result.motion, motion)
    return (*errors(changed, result, motion), gap, feet, len(result.pieces))


def seam_gap(model: PerformanceModel, result: Synthesis, motion: Motion) -> float:
    """Root mean square distance in cm of the target points across seams, before they are blended."""
    dense = at_rate(points_of(model.method, motion), motion.fps, FINE)
    pieces = placed_again(with_method(model, continuity=1.0), result, dense, FINE)
    weight = sum(model.method.targets.values())
    squares = [piece.seam / weight for piece in pieces[1:]]
    return 100 * float(np.sqrt(np.mean(squares))) if squares else 0.0
