"""A follower for a leader: errors, baselines, units of beats, clustering, and what it looks like (Hsu 2004, 6.2)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from kinetograph.evaluation.dance import DanceRow, leave_one_dance_out, mean_rows
from kinetograph.evaluation.reproduce._hsu_data import lasting
from kinetograph.evaluation.reproduce._hsu_walks import clustered, with_method
from kinetograph.evaluation.reproduce._page import Section, drawn, paragraph, table
from kinetograph.evaluation.reproduce._timing import processor_seconds
from kinetograph.library import Library
from kinetograph.methods._instances import interpolate
from kinetograph.methods._realize import fine_borders, realize
from kinetograph.methods.performance import partner_control
from kinetograph.motion import Motion, concatenate, cut

Tick = Callable[[str], None]
SECONDS, FULL, SEGMENTS = 150.0, 364, 168
"""The thesis' dance: 150 s of control, 364 segments, 168 after clustering."""
_COLUMNS = (
    *("take", "method", "joints cm", "root-relative cm", "hands held: median cm", "95th percentile cm"),
    *("planted feet m/s (recorded)", "jerk, times recorded", "distinct source", "times real time"),
)
PAPER = """The thesis, 6.2: 12 short dances of Lindy Hop, 5 minutes, 364 two-beat segments; three test dances of 2 to 3 minutes by
the same dancers. Judged by eye: very near the real follower in closed stances, stylistically different in open ones,
almost always in rhythm. No distances are given."""
OURS = """Ours are 38 to 53 s of salsa by several couples, one dance held out, the follower compared joint by joint. Two dances
are by other dancers with moves that no other take has. No moves are named, so segment and pattern errors cannot be given
here."""


def dance_section(library: Library, tick: Tick) -> Section:
    """Leave one dance out, with the baselines, and pictures of the nearest and of the furthest dance."""
    rows = leave_one_dance_out(partner_control(), library, "follower")
    tick("held-out dances")
    means = mean_rows(rows)
    mine = [row for row in rows if row.method == "segments"]
    near, far = min(mine, key=lambda r: r.joint_cm), max(mine, key=lambda r: r.joint_cm)
    parts = (
        paragraph(" ".join(PAPER.split()), "paper"),
        paragraph(" ".join(OURS.split())),
        table("Means over the dances", _COLUMNS, [_cells(r) for r in means]),
        table("By dance", _COLUMNS, [_cells(r) for r in mine]),
        *(_compared(library, row) for row in dict.fromkeys((near, far))),
    )
    tick("pictures of dances")
    return Section("Dance, leader in and follower out", parts, {"rows": [vars(r) for r in [*rows, *means]]})


def _cells(row: DanceRow) -> tuple[str | float, ...]:
    slide = f"{row.slide:.3f} ({row.slide_recorded:.3f})" if row.slide == row.slide else "–"
    return (
        *(row.take, row.method, row.joint_cm, row.relative_cm, row.hold_median_cm, row.hold_p95_cm),
        *(slide, row.jerk, row.distinct, row.times_real_time),
    )


def _compared(library: Library, row: DanceRow) -> str:
    """The result and the recording, each with the leader, over the same seconds."""
    take = library.take(row.take)
    leader, recorded = take.motion("leader"), take.motion("follower")
    made = partner_control().fit(library, exclude=(row.take,), track="follower").synthesize(leader).motion
    first = round(0.4 * len(leader))
    last = min(first + round(4 * leader.fps), len(leader), len(made), len(recorded))
    shown = {f"{row.take}: recorded follower": recorded, f"{row.take}: generated follower, {row.joint_cm:.1f} cm": made}
    sheets = (
        drawn(lambda path, t=title, f=follower: _sheet(leader, f, first, last, t, path), title)  # type: ignore[misc]
        for title, follower in shown.items()
    )
    return "\n".join(sheets)


def _sheet(leader: Motion, follower: Motion, first: int, last: int, title: str, path: Path) -> None:
    from kinetograph.pictures import contact_sheet

    contact_sheet([cut(leader, first, last), cut(follower, first, last)], path, title=title, frames=10)


def unit_section(library: Library, quick: bool, tick: Tick) -> Section:
    """Segments of one beat, two, four; and clustering, as the thesis does it."""
    columns = (
        "segments",
        "count",
        "joints cm",
        "root-relative cm",
        "hands held: median cm",
        "95th percentile cm",
        "distinct source",
    )
    units = []
    for span in (1, 2, 3, 4):
        units.append(
            (
                f"{span} beats" if span > 1 else "1 beat",
                *_summary(library, replace(partner_control(), span=span, longest=4.0)),
            )
        )
        tick(f"segments of {span} beats")
    groups = []
    for threshold in (None, 0.1) if quick else (None, 0.06, 0.1, 0.15, 0.2):
        label = "none" if threshold is None else f"{100 * threshold:g} cm"
        groups.append((label, *_summary(library, replace(partner_control(), cluster=threshold))))
        tick("clustering of dances")
    parts = (
        paragraph(
            "The thesis, chapter 3: two-beat units, the basic unit of the dance; short segments lack coherence, long ones do not generalise.",
            "paper",
        ),
        table("Units of beats, segments that begin at every beat; means over the held-out dances", columns, units),
        paragraph(
            "The thesis, 6.2: 364 segments clustered to 168 for all its evaluations; what that changes is not given.",
            "paper",
        ),
        table("Clustering of two-beat segments, by threshold", ("threshold", *columns[1:]), groups),
    )
    rows = {
        "units": [dict(zip(columns, r, strict=True)) for r in units],
        "clusters": [dict(zip(("threshold", *columns[1:]), r, strict=True)) for r in groups],
    }
    return Section("Dance: units and clustering", parts, rows)


def _summary(library: Library, method) -> tuple[float, ...]:  # type: ignore[no-untyped-def]
    rows = leave_one_dance_out(method, library, "follower", baselines=False)
    mean = mean_rows(rows)[0]
    count = len(method.fit(library, exclude=library.names()[:1], track="follower").instances.segments)
    return count, mean.joint_cm, mean.relative_cm, mean.hold_median_cm, mean.hold_p95_cm, mean.distinct


def dance_timing_section(library: Library, quick: bool, tick: Tick) -> Section:
    """150 s of control at 7.5 Hz against 168 segments."""
    names = library.names()
    held = names[: max(len(names) // 2, 1)]
    leaders = [library.take(name).motion("leader") for name in held]
    control = lasting(concatenate([replace(m, skeleton=leaders[0].skeleton) for m in leaders]), SECONDS)
    model = clustered(partner_control(), library, SEGMENTS, exclude=held, track="follower")
    points = model.control_points(control)
    x = model.at_search_rate(points, control.fps)
    kinds = {"exact": model, "beam 0.5": with_method(model, beam=0.5), "beam 0.1": with_method(model, beam=0.1)}
    best = model.interpret(x)
    dense = interpolate(points, np.arange(int((len(points) - 1) / control.fps * 30 + 1e-6) + 1) / 30 * control.fps)
    jobs: dict[str, Callable[[], object]] = {n: (lambda m=m: m.interpret(x)) for n, m in kinds.items()}  # type: ignore[misc]
    jobs["upsampling"] = lambda: fine_borders(model, dense, 30.0, best)
    jobs["realize"] = lambda: realize(model, points, control.fps, best, control)
    taken = processor_seconds(jobs, 3 if quick else 5)
    tick("timings of dances")
    columns = (
        "search",
        "segments",
        "states",
        "search ms",
        "upsampling ms",
        "postprocessing ms",
        "score over the optimum",
    )
    rows: list[tuple[str | float | int | None, ...]] = [
        ("thesis, exact", SEGMENTS, None, 78000.0, 2000.0, 26000.0, None),
        ("thesis, beam", SEGMENTS, None, 10000.0, 2000.0, 26000.0, None),
    ]
    for name, kind in kinds.items():
        gap = f"{100 * (kind.interpret(x).score / best.score - 1):.1f} %"
        count = (len(model.instances.segments), len(model.instances.states))
        rows.append(
            (
                name,
                *count,
                *(1000 * taken[k] for k in (name, "upsampling")),
                1000 * (taken["realize"] - taken["upsampling"]),
                gap,
            )
        )
    parts = (
        paragraph(
            "The thesis, 6.2: 150 s at 7.5 Hz, 168 segments, ±0.15 s: 78 s, with a beam 10 s; upsampling 2 s, postprocessing 26 s.",
            "paper",
        ),
        table(f"Processor time, {SECONDS:g} s of leaders that are not in the library", columns, rows),
        paragraph(
            "The leaders follow one another without a join, which no time depends on. Postprocessing includes feet and hands."
        ),
    )
    return Section("Dance: timings", parts, {"rows": [dict(zip(columns, r, strict=True)) for r in rows]})
