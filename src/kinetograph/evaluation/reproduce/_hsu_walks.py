"""Held-out walks, what they cost, and what each way to make them cheaper changes (Hsu 2004, sections 4.4 and 6.1)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.evaluation.metrics import control_error, joint_error
from kinetograph.evaluation.phase import foot_agreement
from kinetograph.evaluation.protocol import WalkRow, leave_one_take_out, mean_rows
from kinetograph.evaluation.reproduce import _hsu_figures as figures
from kinetograph.evaluation.reproduce._hsu_data import held_out, lasting
from kinetograph.evaluation.reproduce._page import Section, drawn, paragraph, picture, shown, table
from kinetograph.evaluation.reproduce._timing import processor_seconds, straight_line
from kinetograph.library import Library
from kinetograph.methods._instances import interpolate
from kinetograph.methods._realize import fine_borders, pieces_of, realize
from kinetograph.methods.performance import PerformanceControl, PerformanceModel
from kinetograph.motion import Motion, cut
from kinetograph.synthesis import Synthesis

Tick = Callable[[str], None]
SECONDS, SEGMENTS = 57.0, 70
"""The thesis' timing test: a control of 57 s, a library of 70 segments."""
BEAMS = (0.02, 0.05, 0.1, 0.2)
CONTINUITY = (0.0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
CLUSTERS = (None, 0.03, 0.05, 0.08, 0.12, 0.18)
RATES = (5.0, 7.5, 10.0, 15.0, 30.0)
LENGTHS = (15.0, 30.0, 60.0, 120.0, 180.0, 240.0, 300.0)
MEASURES = (
    "control cm",
    "joints cm",
    "root-relative cm",
    "planted feet m/s",
    "jerk, times recorded",
    "distinct source",
)


def held_out_section(library: Library, tick: Tick) -> Section:
    """Leave one take out, with the baselines."""
    rows = leave_one_take_out(PerformanceControl(), library, baselines=True)
    tick("held-out walks")
    columns = ("take", "method", *MEASURES, "largest acceleration near seams, recorded", "times real time")
    cells = [
        (
            *(r.take, r.method, r.control_cm, r.joint_cm, r.relative_cm, _both(r.slide, r.slide_recorded), r.jerk),
            *(r.distinct, _both(r.seam, r.seam_recorded), r.times_real_time),
        )
        for r in [*rows, *mean_rows(rows)]
    ]
    parts = (
        paragraph(
            "The thesis, 6.1: new walks, their hips on the ground as the control; the motion was judged by eye, highly "
            "realistic for short walks.",
            "paper",
        ),
        table("Leave one take out", columns, cells),
        paragraph(
            "Frame-by-frame methods stand on the control by construction, and an average of frames is near every frame: "
            "their joint error is small where their jerk tells that no one could move so. The nearest segments fit the "
            "control best and jump from one to the next."
        ),
        drawn(
            lambda path: _sheet(library, path),
            "12 s of the longest walk: generated (left colours of the first row's legend) and recorded.",
        ),
    )
    return Section("Walks, held out", parts, {"rows": [vars(r) for r in [*rows, *mean_rows(rows)]]})


def _both(ours: float, recorded: float) -> str:
    return f"{shown(ours)} ({shown(recorded)})" if ours == ours else "–"


def _sheet(library: Library, path: Path) -> None:
    from kinetograph.pictures import contact_sheet
    from kinetograph.post.contacts import contacts_of

    name, motion = held_out(library)[0]
    motion = cut(motion, 0, min(len(motion), round(12 * motion.fps)))
    result = PerformanceControl().fit(library, exclude=(name,)).synthesize(motion)
    contact_sheet(
        [result.motion, motion],
        path,
        contacts=contacts_of(result.annotations),
        seams=[piece.start for piece in result.pieces[1:]],
        title=f"{name}: generated from its hips, and recorded",
        frames=16,
    )


def clustered(
    method: PerformanceControl,
    library: Library,
    segments: int,
    *,
    exclude: tuple[str, ...] = (),
    track: str | None = None,
) -> PerformanceModel:
    """The model whose number of segments is nearest, by bisection of the clustering threshold; all where there are
    fewer."""
    model = method.fit(library, exclude=exclude, track=track)
    if len(model.instances.segments) <= segments:
        return model
    low, high, best = 0.0, 1.0, model
    for _ in range(9):
        middle = 0.5 * (low + high)
        model = replace(method, cluster=middle).fit(library, exclude=exclude, track=track)
        found = len(model.instances.segments)
        if abs(found - segments) < abs(len(best.instances.segments) - segments):
            best = model
        low, high = (middle, high) if found > segments else (low, middle)
    return best


def timing_section(library: Library, quick: bool, tick: Tick) -> Section:
    """A control of 57 s with and without beam, at the thesis' number of segments and with all of them."""
    name, motion = held_out(library)[0]
    control = lasting(motion, SECONDS)
    rows = []
    for label, segments in (("clustered", SEGMENTS), ("all", 10**9)):
        model = clustered(PerformanceControl(), library, segments, exclude=(name,))
        rows += _timed(model, control, label, 3 if quick else 7)
        tick(f"timings, {label} segments")
    columns = (
        *("library", "segments", "states", "search", "search ms", "upsampling ms", "postprocessing ms"),
        *("score over the optimum", "joints cm", "seconds of control a second of search"),
    )
    paper = (*("thesis, clustered", 70, None, "exact", 12500.0, 400.0, 1100.0, None, None, SECONDS / 12.5),)
    beam = ("thesis, clustered", 70, None, "beam", 1200.0, 400.0, 1100.0, None, None, 47.0)
    parts = (
        paragraph(
            "The thesis, 6.1: 57 s of control, 70 segments, two 2.4 GHz Xeons of 2003: 12.5 s for the dynamic programme, "
            "1.2 s with a beam, 0.4 s upsampling, 1.1 s postprocessing.",
            "paper",
        ),
        table(
            f"Processor time, median of turns taken by all jobs; control: {name}, {SECONDS:g} s",
            columns,
            [paper, beam, *rows],
        ),
        paragraph(
            "The thesis' times are the clock's, ours the processor's on one thread; the machines are twenty years apart. "
            "The exact search here leaves out only pairs that cannot win. The search includes scoring and placing every "
            "window against every segment, which a beam does not spare: the exact search costs little more than that."
        ),
    )
    return Section("Timings with and without beam", parts, {"rows": [dict(zip(columns, r, strict=True)) for r in rows]})


def _timed(
    model: PerformanceModel, control: Motion, label: str, repeats: int
) -> list[tuple[str | float | int | None, ...]]:
    points = model.control_points(control)
    x = model.at_search_rate(points, control.fps)
    fine = model.method.fine_rate or 30.0
    dense = interpolate(points, np.arange(int((len(points) - 1) / control.fps * fine + 1e-6) + 1) / fine * control.fps)
    kinds = {"exact": model, **{f"beam {w:g}": with_method(model, beam=w) for w in BEAMS}}
    jobs: dict[str, Callable[[], object]] = {name: (lambda m=m: m.interpret(x)) for name, m in kinds.items()}  # type: ignore[misc]
    best = model.interpret(x)
    jobs["upsampling"] = lambda: fine_borders(model, dense, fine, best)
    jobs["realize"] = lambda: realize(model, points, control.fps, best)
    taken = processor_seconds(jobs, repeats)
    rows: list[tuple[str | float | int | None, ...]] = []
    for name, kind in kinds.items():
        path = kind.interpret(x)
        made = realize(kind, points, control.fps, path)
        gap = f"{100 * (path.score / best.score - 1):.1f} %" if best.score > 0 else "–"
        rows.append(
            (
                *(label, len(model.instances.segments), len(model.instances.states), name, 1000 * taken[name]),
                *(1000 * taken["upsampling"], 1000 * (taken["realize"] - taken["upsampling"]), gap),
                *(100 * joint_error(made.motion, control), SECONDS / taken[name]),
            )
        )
    return rows


def with_method(model: PerformanceModel, **changes: object) -> PerformanceModel:
    """The model with settings changed that its instances do not depend on: continuity, beam, fine_rate, post."""
    return replace(model, method=replace(model.method, **changes))  # type: ignore[arg-type]


def growth_section(library: Library, quick: bool, tick: Tick) -> Section:
    """Time against length of the control."""
    name, motion = held_out(library)[0]
    model = PerformanceControl().fit(library, exclude=(name,))
    beam = with_method(model, beam=0.05)
    lengths = LENGTHS[:4] if quick else LENGTHS
    jobs: dict[str, Callable[[], object]] = {}
    for seconds in lengths:
        control = lasting(motion, seconds)
        x = model.at_search_rate(model.control_points(control), control.fps)
        jobs[f"exact {seconds}"] = lambda x=x: model.interpret(x)  # type: ignore[misc]
        jobs[f"beam {seconds}"] = lambda x=x: beam.interpret(x)  # type: ignore[misc]
    taken = processor_seconds(jobs, 3 if quick else 5)
    tick("time against length")
    times = {kind: [taken[f"{kind} {seconds}"] for seconds in lengths] for kind in ("exact", "beam")}
    fits = {kind: straight_line(lengths, values) for kind, values in times.items()}
    columns = ("seconds of control", *(f"{kind}, ms" for kind in times), *(f"{kind}, ms a second" for kind in times))
    rows = [
        (s, *(1000 * v[i] for v in times.values()), *(1000 * v[i] / s for v in times.values()))
        for i, s in enumerate(lengths)
    ]
    told = "; ".join(
        f"{kind}: {1000 * a:.2f} ms a second of control and {1000 * b:.1f} ms, R² = {r2:.4f}"
        for kind, (a, b, r2) in fits.items()
    )
    parts = (
        paragraph("The thesis, 4.4 and 6.1: O(P² T); confirmed to be linear in the length by experiment.", "paper"),
        table(
            f"Processor time of the search, {len(model.instances.states)} states; control: {name} over and over",
            columns,
            rows,
        ),
        paragraph(f"Lines fitted: {told}."),
        picture(
            figures.draw_growth(lengths, times, {k: (a, b) for k, (a, b, _) in fits.items()}),
            "Processor time against the control's length.",
        ),
    )
    fitted = {k: {"slope": a, "intercept": b, "r2": r} for k, (a, b, r) in fits.items()}
    return Section(
        "Time against length", parts, {"rows": [dict(zip(columns, r, strict=True)) for r in rows], "fits": fitted}
    )


def cluster_section(library: Library, quick: bool, tick: Tick) -> Section:
    """What clustering costs and saves, over all held-out takes."""
    takes = held_out(library)[: 1 if quick else None]
    rows = []
    for threshold in CLUSTERS:
        models = [(replace(PerformanceControl(), cluster=threshold).fit(library, exclude=(n,)), m) for n, m in takes]
        rows.append(("none" if threshold is None else f"{100 * threshold:g} cm", *_cost_and_error(models)))
    tick("clustering")
    columns = ("threshold", "segments", "states", "search ms", "score", "control cm", "joints cm", "distinct source")
    parts = (
        paragraph(
            "The thesis, 4.4.2 and 6.1: complete linkage, 200 segments to 70; none of its shortcuts improves the result, "
            "they only make it cheaper. What the result loses is not measured.",
            "paper",
        ),
        table("Clustering, means over the held-out takes; the score is that of equation 4.5", columns, rows),
        paragraph(
            "The threshold is the root mean square distance of control and target points together, and a cluster keeps "
            "its medoid; the thesis' distance is that of the control alone, its representative random."
        ),
    )
    return Section("Clustering", parts, {"rows": [dict(zip(columns, r, strict=True)) for r in rows]})


def _cost_and_error(models: Sequence[tuple[PerformanceModel, Motion]]) -> tuple[float, ...]:
    """Means over models and their held-out controls: segments, states, search ms, score, errors, distinct share."""
    from kinetograph.evaluation.metrics import distinct_share

    jobs: dict[str, Callable[[], object]] = {}
    results = []
    for i, (model, motion) in enumerate(models):
        x = model.at_search_rate(model.control_points(motion), motion.fps)
        jobs[str(i)] = lambda model=model, x=x: model.interpret(x)  # type: ignore[misc]
        results.append(model.synthesize(motion))
    taken = processor_seconds(jobs, 3)
    count = len(models)
    control, joints = zip(*(_errors(model, r, m) for (model, m), r in zip(models, results, strict=True)), strict=True)
    return (
        round(sum(len(m.instances.segments) for m, _ in models) / count),
        round(sum(len(m.instances.states) for m, _ in models) / count),
        1000 * sum(taken.values()) / count,
        sum(r.cost for r in results) / count,
        float(np.mean(control)),
        float(np.mean(joints)),
        float(np.mean([distinct_share(r) for r in results])),
    )


def _errors(model: PerformanceModel, result: Synthesis, motion: Motion) -> tuple[float, float]:
    """Control and joint error in cm."""
    control = control_error(result.motion, model.control_points(motion), motion.fps)
    return 100 * control, 100 * joint_error(result.motion, motion)


def rate_section(library: Library, quick: bool, tick: Tick) -> Section:
    """The rate of the search, and the constrained search that adjusts durations at 30 Hz."""
    takes = held_out(library)[: 1 if quick else None]
    rows = []
    for rate in RATES:
        for fine in (None, 30.0) if rate < 30 else (None,):
            method = PerformanceControl(rate=rate, fine_rate=fine)
            models = [(method.fit(library, exclude=(name,)), motion) for name, motion in takes]
            found = [_at_rate(model, motion) for model, motion in models]
            rows.append((f"{rate:g} Hz", "30 Hz" if fine else "none", *(float(v) for v in np.mean(found, axis=0))))
        tick(f"search at {rate:g} Hz")
    columns = ("search", "refinement", "search ms", "refinement ms", "score at 30 Hz", "control cm", "joints cm")
    parts = (
        paragraph(
            "The thesis, 4.4.3: search at 10 Hz (dance 7.5 Hz), then a constrained search at 30 Hz that keeps the segments "
            "and adjusts their durations, since plain upsampling leaves small errors of time. No comparison is given.",
            "paper",
        ),
        table("The rate of the search; every result scored by equation 4.5 at 30 Hz", columns, rows),
    )
    return Section("Search rate and refinement", parts, {"rows": [dict(zip(columns, r, strict=True)) for r in rows]})


def _at_rate(model: PerformanceModel, motion: Motion) -> tuple[float, ...]:
    points = model.control_points(motion)
    x = model.at_search_rate(points, motion.fps)
    path = model.interpret(x)
    dense = interpolate(points, np.arange(int((len(points) - 1) / motion.fps * 30 + 1e-6) + 1) / 30 * motion.fps)
    jobs: dict[str, Callable[[], object]] = {"search": lambda: model.interpret(x)}
    if model.method.fine_rate:
        jobs["refinement"] = lambda: fine_borders(model, dense, 30.0, path)
    taken = processor_seconds(jobs, 3)
    result = realize(model, points, motion.fps, path)
    return (
        *(1000 * taken["search"], 1000 * taken.get("refinement", 0.0), score_at(model, result, dense, 30.0)),
        *_errors(model, result, motion),
    )


def score_at(model: PerformanceModel, result: Synthesis, x: FloatArray, rate: float) -> float:
    """Equation 4.5 for a result's pieces, for control points ``x`` at ``rate``."""
    indices = {(model.sources[s.source].take, s.start): s for s in model.instances.segments}
    segments = [indices[piece.take, piece.source_start] for piece in result.pieces]
    borders = np.array([result.pieces[0].start, *(piece.stop for piece in result.pieces)])
    pieces = pieces_of(model, x, rate, segments, np.round(borders * rate))
    return sum(piece.cost + piece.seam for piece in pieces)


def continuity_section(library: Library, quick: bool, tick: Tick) -> Section:
    """The constant k, over all held-out takes."""
    takes = held_out(library)[: 1 if quick else None]
    models = [(PerformanceControl().fit(library, exclude=(name,)), motion) for name, motion in takes]
    values = CONTINUITY[::2] if quick else CONTINUITY
    rows = []
    for k in values:
        found = []
        for model, motion in models:
            changed = with_method(model, continuity=k)
            result = changed.synthesize(motion)
            gap = _seam_gap(changed, result, motion)
            found.append(
                (*_errors(changed, result, motion), gap, foot_agreement(result.motion, motion), len(result.pieces))
            )
        rows.append((k, *(float(v) for v in np.mean(found, axis=0))))
    tick("continuity")
    columns = ("k, seconds", "control cm", "joints cm", "gap at seams cm", "agreement of the feet", "pieces")
    curves = {columns[i]: [row[i] for row in rows] for i in (1, 2, 3)}
    parts = (
        paragraph(
            "The thesis, 6.1: larger values of the constant were more effective; chosen by experiment, not given.",
            "paper",
        ),
        table("The continuity constant, means over the held-out takes", columns, rows),
        picture(figures.draw_curves(values, curves, "k, seconds", log=True), "Errors over the continuity constant."),
    )
    return Section("Continuity constant", parts, {"rows": [dict(zip(columns, r, strict=True)) for r in rows]})


def _seam_gap(model: PerformanceModel, result: Synthesis, motion: Motion) -> float:
    """Root mean square distance in cm of the target points across seams, before they are blended."""
    points = model.control_points(motion)
    dense = interpolate(points, np.arange(int((len(points) - 1) / motion.fps * 30 + 1e-6) + 1) / 30 * motion.fps)
    unit = with_method(model, continuity=1.0)
    indices = {(unit.sources[s.source].take, s.start): s for s in unit.instances.segments}
    segments = [indices[piece.take, piece.source_start] for piece in result.pieces]
    borders = np.array([result.pieces[0].start, *(piece.stop for piece in result.pieces)])
    pieces = pieces_of(unit, dense, 30.0, segments, np.round(borders * 30))
    squares = [piece.seam for piece in pieces[1:]]
    return 100 * float(np.sqrt(np.mean(squares) / len(model.method.targets))) if squares else 0.0


def path_section(library: Library, tick: Tick) -> Section:
    """Figure 6-1: a walk along a drawn path."""
    from kinetograph.pictures import contact_sheet, strobe
    from kinetograph.pipeline import winding_path

    control = winding_path()
    result = PerformanceControl(mirror=True).fit(library).synthesize(control)
    model = PerformanceControl().fit(library)
    error = 100 * control_error(result.motion, model.control_points(control), control.fps)
    tick("drawn path")
    told = [f"The hips are {error:.1f} cm from the path on average, {len(result.pieces)} pieces.", *result.warnings]
    parts = (
        paragraph("The thesis, figure 6-1: mouse trajectories at 30 Hz, Frenet frames as the control.", "paper"),
        paragraph(" ".join(told)),
        drawn(
            lambda path: strobe(result.motion, path, path_signal=control), "A walk along a path that turns both ways."
        ),
        drawn(
            lambda path: contact_sheet(result.motion, path, path_signal=control, contacts=_contacts(result), frames=16),
            "The same, with the path from above.",
        ),
    )
    return Section("A drawn path", parts, {"control_cm": error, "pieces": len(result.pieces)})


def _contacts(result: Synthesis):  # type: ignore[no-untyped-def]
    from kinetograph.post.contacts import contacts_of

    return contacts_of(result.annotations)


def means(rows: Sequence[WalkRow]) -> list[WalkRow]:
    """See `protocol.mean_rows`."""
    return mean_rows(list(rows))
