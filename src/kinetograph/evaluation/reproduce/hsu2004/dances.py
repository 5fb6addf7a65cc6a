"""A follower for a leader: errors, baselines, units of beats, clustering, and what it looks like (Hsu 2004, 6.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from kinetograph.evaluation.dance import COMMONEST, DanceRow, leave_one_dance_out
from kinetograph.evaluation.partner_names import Observer
from kinetograph.evaluation.repeats import near_repeats, repeat_distances
from kinetograph.evaluation.reproduce.hsu2004.data import lasting
from kinetograph.evaluation.reproduce.hsu2004.models import clustered, segments_in
from kinetograph.evaluation.reproduce.hsu2004.timings import COLUMNS as TIMED
from kinetograph.evaluation.reproduce.hsu2004.timings import timed
from kinetograph.evaluation.reproduce.page import Section, Value, drawn, paragraph, records, table, with_recorded
from kinetograph.evaluation.rows import mean_rows, means_with_and_without
from kinetograph.library import Library
from kinetograph.methods.performance import PerformanceControl, partner_control
from kinetograph.motion import Motion, concatenate, cut
from kinetograph.progress import Report

SECONDS, SEGMENTS = 150.0, 168
"""The thesis' dance: 150 s of control, 168 segments after clustering."""
BEAMS = (0.01, 0.1)
COLUMNS = (
    *("take", "method", "joints cm", "root-relative cm", "hands held: median cm", "95th percentile cm"),
    *("planted feet m/s (recorded)", "jerk, times recorded", "distinct source", "times real time"),
)
UNITS = (
    *("unit", "segments", "joints cm", "root-relative cm", "hands held: median cm", "95th percentile cm"),
    "distinct source",
)
GROUPS = ("threshold", *UNITS[1:])
PAPER = """The thesis, 6.2: 12 short dances of Lindy Hop, 5 minutes, 364 two-beat segments; three test dances of 2 to
3 minutes by the same dancers. Judged by eye: very near the real follower in closed stances, different in style in
open ones, nearly always in rhythm. No distances are given."""
OURS = """One dance is held out at a time and the follower compared joint by joint. A dance whose moves no other take
has cannot come out well: the library does not have what its follower does. Hands held is by how much the distance of
two hands differs from the recorded one where the recording holds hands; for "holds given" these and their times are
given. Means are given with and without dances that nearly repeat another one: held out, these are easy."""
NAMES = ("take", "method", "units", "wrong %", "patterns wrong %", "transitions wrong %")
TABLE = """The thesis, 6.2 and table 6.1: 5 of 364 two-beat segments (1.4 %) and 5 of 91 patterns of four (5.5 %) were
another than the real follower's, as a dancer saw it. One leader and one follower danced all dances, and the test dances
are made of the database's stances and transitions."""
SEEN = """Here the recorded and the made follower are named by one rule, with the same leader and at the same beats:
open or closed stance by distance and facing, crosshand or not by the hands that hold, and a step or a turn by the
follower's rotation. A unit is two beats, wrong where a stance or the transition differs; a pattern is four units in a
row, wrong where any of them is. "Commonest name" calls every unit what most units of the other dances are: a step in
open stance."""
UNIT = """The thesis, chapter 3: units of two beats, the basic one of the dance. Shorter ones may lack coherence,
longer ones may not generalise; other lengths are not compared."""
CLUSTERING = "The thesis, 6.2: 364 segments clustered to 168 for all its evaluations; what that changes is not given."
TIMES = """The thesis, 6.2: 150 s at 7.5 Hz, 168 segments, ±0.15 s: 78 s, with a beam 10 s; upsampling 2 s,
postprocessing 26 s."""
JOINED = "The leaders follow one another without a join, which no time depends on. Postprocessing is of feet and hands."


def dance_section(library: Library, tick: Report) -> Section:
    """Leave one dance out, with the baselines, and pictures of the nearest and of the furthest dance."""
    rows = leave_one_dance_out(partner_control(), library, "follower")
    tick("held-out dances")
    repeats = near_repeats(repeat_distances(library, "follower"))
    means = means_with_and_without(rows, repeats)
    ours = [row for row in rows if row.method == "segments"]
    near, far = min(ours, key=lambda row: row.joint_cm), max(ours, key=lambda row: row.joint_cm)
    parts = (
        paragraph(PAPER, "paper"),
        paragraph(OURS),
        table("Means over the dances", COLUMNS, [_cells(row) for row in means if row.method != COMMONEST]),
        table("By dance", COLUMNS, [_cells(row) for row in ours]),
        paragraph(f"Near-repeats: {', '.join(repeats) or 'none'}."),
        paragraph(TABLE, "paper"),
        paragraph(SEEN),
        table("Table 6.1: stances and transitions", NAMES, _named(library, [*rows, *means])),
        *(_compared(library, row) for row in dict.fromkeys((near, far))),
    )
    tick("pictures of dances")
    return Section("Dance, leader in and follower out", parts, {"rows": [vars(row) for row in [*rows, *means]]})


def _named(library: Library, rows: Sequence[DanceRow]) -> list[tuple[Value, ...]]:
    """The errors of names of the methods that make motion, and how many units there are."""
    observer = Observer.of(library, "follower", partner_control().span)
    units = {name: len(observer.recorded(library.take(name))) for name in library.names()} if observer else {}
    return [
        (
            *(row.take, row.method, units.get(row.take)),
            *(100 * row.seen_errors, 100 * row.seen_patterns, 100 * row.seen_transitions),
        )
        for row in rows
        if row.method in ("segments", "nearest segment", COMMONEST)
    ]


def _cells(row: DanceRow) -> tuple[Value, ...]:
    return (
        *(row.take, row.method, row.joint_cm, row.relative_cm, row.hold_median_cm, row.hold_p95_cm),
        *(with_recorded(row.slide, row.slide_recorded), row.jerk, row.distinct, row.times_real_time),
    )


def _compared(library: Library, row: DanceRow) -> str:
    """The recorded and the generated follower, each with the leader, over the same 4 s."""
    take = library.take(row.take)
    leader, recorded = take.motion("leader"), take.motion("follower")
    made = partner_control().fit(library, exclude=(row.take,), track="follower").synthesize(leader).motion
    first = round(0.4 * len(leader))
    last = min(first + round(4 * leader.fps), len(leader), len(made), len(recorded))
    sheets = []
    for title, follower in (
        (f"{row.take}: recorded follower (green, purple)", recorded),
        (f"{row.take}: generated follower (green, purple), {row.joint_cm:.1f} cm over the whole dance", made),
    ):
        pair = [cut(leader, first, last), cut(follower, first, last)]
        sheets.append(drawn(partial(_sheet, pair, title), title))
    return "\n".join(sheets)


def _sheet(pair: list[Motion], title: str, path: Path) -> None:
    from kinetograph.drawing import contact_sheet

    contact_sheet(pair, path, title=title, frames=10)


def unit_section(library: Library, quick: bool, tick: Report) -> Section:
    """Segments of one beat, two, three, four; and clustering of those of two."""
    units: list[tuple[Value, ...]] = []
    for span in (1, 2, 4) if quick else (1, 2, 3, 4):
        method = replace(partner_control(), span=span, longest=4.0)
        units.append((f"{span} beats" if span > 1 else "1 beat", *_summary(library, method)))
        tick(f"segments of {units[-1][0]}")
    groups: list[tuple[Value, ...]] = []
    for threshold in (None, 0.15) if quick else (None, 0.06, 0.1, 0.15, 0.2):
        label = "none" if threshold is None else f"{100 * threshold:g} cm"
        groups.append((label, *_summary(library, replace(partner_control(), cluster=threshold))))
        tick(f"clustering of dances, {label}")
    parts = (
        paragraph(UNIT, "paper"),
        table("Units of beats, one from every beat on; means over the held-out dances", UNITS, units),
        paragraph(CLUSTERING, "paper"),
        table("Clustering of units of two beats, by threshold", GROUPS, groups),
    )
    numbers = {"units": records(UNITS, units), "clusters": records(GROUPS, groups)}
    return Section("Dance: units and clustering", parts, numbers)


def _summary(library: Library, method: PerformanceControl) -> tuple[float, ...]:
    """Segments where the first dance is held out, and means over all that are."""
    mean = mean_rows(leave_one_dance_out(method, library, "follower", baselines=False))[0]
    model = method.fit(library, exclude=tuple(library.names()[:1]), track="follower")
    errors = (mean.joint_cm, mean.relative_cm, mean.hold_median_cm, mean.hold_p95_cm, mean.distinct)
    return segments_in(model), *errors


def dance_timing_section(library: Library, quick: bool, tick: Report) -> Section:
    """150 s of control at 7.5 Hz against 168 segments."""
    held = tuple(library.names()[: max(len(library.names()) // 2, 1)])
    leaders = [library.take(name).motion("leader") for name in held]
    whole = concatenate([replace(leader, skeleton=leaders[0].skeleton) for leader in leaders])
    model = clustered(partner_control(), library, SEGMENTS, exclude=held, track="follower")
    rows: list[tuple[Value, ...]] = [
        ("thesis, exact", SEGMENTS, None, 78000.0, None, 2000.0, 26000.0, None, SECONDS / 78),
        ("thesis, beam", SEGMENTS, None, 10000.0, None, 2000.0, 26000.0, None, SECONDS / 10),
        *timed(model, lasting(whole, SECONDS), "clustered", BEAMS, 3 if quick else 5),
    ]
    tick("timings of dances")
    caption = f"Processor time, medians, all jobs in turn; {SECONDS:g} s of leaders that are not in the library"
    parts = (paragraph(TIMES, "paper"), table(caption, TIMED, rows), paragraph(JOINED))
    return Section("Dance: timings", parts, {"rows": records(TIMED, rows)})
