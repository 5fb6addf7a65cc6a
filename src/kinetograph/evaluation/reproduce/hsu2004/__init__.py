"""Hsu 2004, chapters 4 to 6: the walk and the dance, on recordings at hand, as one page beside the thesis' numbers.

The thesis' recordings (2 minutes of walking, 5 minutes of Lindy Hop) are not published. What takes their place, what is
missing and what had to be chosen is said on the page.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from kinetograph.errors import KinetographError, RequestError
from kinetograph.evaluation.reproduce.hsu2004 import dances, search, walks
from kinetograph.evaluation.reproduce.hsu2004.data import DANCE_RATE, Recordings, collect, find_folder
from kinetograph.evaluation.reproduce.hsu2004.labels import label_section
from kinetograph.evaluation.reproduce.hsu2004.phase import phase_section
from kinetograph.evaluation.reproduce.page import Section, bullets, page, paragraph
from kinetograph.formats import atomic_path
from kinetograph.methods.performance import PerformanceControl, partner_control
from kinetograph.progress import Progress

Report = Callable[[str], None]
TITLE = "Hsu 2004, on recordings at hand"
NOT_COMPARABLE = (
    "Recordings: other people, other dances, other cameras. The thesis' walker and dancers are not published.",
    "Joints: the thesis' are estimated from markers by a commercial tool; ours come with the recordings, the walks as "
    "fits of a body model, which makes their hips smoother.",
    "The thesis judges motion by eye and gives no distances; ours have no counterpart there.",
    "Segment and pattern errors: the thesis' moves were named by a dancer watching; ours are named by rule or by file.",
    "Times: two 2.4 GHz Xeons of 2003 and the clock, against one thread of this machine and processor time.",
)


@dataclass(frozen=True)
class Step:
    """One section of the page, and how it is made of the recordings."""

    title: str
    make: Callable[[], Section]


def reproduce(
    folder: str | Path,
    data: Path | None = None,
    *,
    quick: bool = False,
    report: Report = lambda text: None,
    tick: Report = lambda text: None,
    progress: Progress = lambda done, total: None,
) -> dict[str, object]:
    """Write ``index.html`` and ``numbers.json`` to a new folder; returns the numbers by section.

    data: a folder with ``walks/`` or ``salsa/``; by default one that ``KINETOGRAPH_DATA`` names. The page is written
    anew after every section, so that what is done is kept when the work is interrupted. report is told what is missing
    or cannot be made, tick what was done last. Raises RequestError for a folder in use, or one without recordings.
    """
    output = Path(folder)
    if output.exists() and any(output.iterdir()):
        raise RequestError(f"{output} is not empty; name a new folder")
    chosen = find_folder(data)
    output.mkdir(parents=True, exist_ok=True)
    made: list[Section] = []
    with TemporaryDirectory() as scratch:
        found = collect(chosen, Path(scratch), quick)
        for text in found.missing:
            report(f"missing: {text}")
        steps = plan(found, quick, tick)
        _write(output, found, made, [s.title for s in steps], quick)
        for done, step in enumerate(steps):
            progress(done, len(steps))
            made.append(_made(step, report))
            _write(output, found, made, [s.title for s in steps[done + 1 :]], quick)
        progress(len(steps), len(steps))
    return {section.title: _plain(dict(section.numbers)) for section in made}


def plan(found: Recordings, quick: bool, tick: Report) -> list[Step]:
    """The sections that the recordings allow, in order."""
    steps = []
    if (library := found.walks) is not None:
        steps += [
            Step("Walks, held out", lambda: walks.held_out_section(library, tick)),
            Step("Phase", lambda: phase_section("Phase", library, quick, tick)),
        ]
        if (more := found.more_walks) is not None:
            title = "Phase, second set of walks"
            steps.append(Step(title, lambda: phase_section(title, more, quick, tick, first=False)))
        steps += [
            Step("Timings with and without beam", lambda: search.timing_section(library, quick, tick)),
            Step("Time against length", lambda: search.growth_section(library, quick, tick)),
            Step("Clustering", lambda: search.cluster_section(library, quick, tick)),
            Step("Search rate and refinement", lambda: search.rate_section(library, quick, tick)),
            Step("Continuity constant", lambda: search.continuity_section(library, quick, tick)),
            Step("Segment and pattern errors", lambda: label_section(found.walks, found.clips, tick)),
            Step("A drawn path", lambda: walks.path_section(found.clips or library, tick)),
        ]
    if (pairs := found.dances) is not None:
        steps += [
            Step("Dance, leader in and follower out", lambda: dances.dance_section(pairs, tick)),
            Step("Dance: units and clustering", lambda: dances.unit_section(pairs, quick, tick)),
            Step("Dance: timings", lambda: dances.dance_timing_section(pairs, quick, tick)),
        ]
    return steps


def _made(step: Step, report: Report) -> Section:
    """A section, or why there is none: recordings that one experiment cannot use leave the others alone."""
    try:
        return step.make()
    except KinetographError as error:
        report(f"{step.title}: not made: {error}")
        return Section(step.title, (paragraph(f"Not made: {error}", "missing"),), {"error": str(error)})


def _write(output: Path, found: Recordings, made: list[Section], waiting: list[str], quick: bool) -> None:
    sections = [
        _recordings(found, waiting, quick),
        *made,
        _settings(found),
        Section("Not comparable", (bullets(NOT_COMPARABLE),)),
    ]
    with atomic_path(output / "index.html", force=True) as draft:
        draft.write_text(page(TITLE, sections), encoding="utf-8")
    numbers = {section.title: _plain(dict(section.numbers)) for section in made}
    with atomic_path(output / "numbers.json", force=True) as draft:
        draft.write_text(json.dumps({"missing": found.missing, "not yet": waiting, **numbers}, indent=1))


def _recordings(found: Recordings, waiting: list[str], quick: bool) -> Section:
    parts = []
    if found.walks is not None:
        parts.append(paragraph(f"Walks: {found.walks_from}; takes {', '.join(found.walks.names())}."))
    if found.dances is not None:
        parts.append(paragraph(f"Dances: {len(found.dances.names())} takes of leader and follower."))
    parts += [paragraph(f"Missing: {text}.", "missing") for text in found.missing]
    if quick:
        parts.append(paragraph("Made with --quick: fewer takes, excerpts, settings and repeats.", "missing"))
    if waiting:
        parts.append(paragraph(f"Not made yet, or interrupted before: {', '.join(waiting)}.", "missing"))
    return Section("Recordings", tuple(parts))


def _settings(found: Recordings) -> Section:
    """Each setting that had to be chosen, with the thesis' where it gives one."""
    walk, dance = PerformanceControl(), partner_control()
    chosen = [
        f"k = {walk.continuity:g} s for walks, {dance.continuity:g} s for dances, D integrated over time; the thesis "
        "gives no value and says it was found by experiment.",
        f"Stretch: ±{walk.stretch:g} s and ±{dance.stretch:g} s, as in the thesis; never below half or above twice a "
        "segment's own duration.",
        f"Search at {walk.rate:g} and {dance.rate:g} Hz, as in the thesis; durations refined at {walk.fine_rate:g} Hz.",
        "Hip distance 0.3 m; the thesis normalises it and gives no value.",
        "Footplants and beats are found by rule; the thesis taps them by hand.",
        "Dance: segments of two beats as in the thesis, but one begins at every beat; chest and velocities join the "
        "control points, hips and chest weigh most in continuity.",
        "Clusters: root mean square over control and target points, complete linkage, medoids; the thesis: equation "
        "4.1 over the control, random representatives, no threshold given.",
        "Beam widths: a sweep; the thesis says modest parameters.",
        "Postprocessing: inertialised seams, planted feet held, hands brought to the partner's; the thesis adjusts "
        "curves linearly.",
        "Phase: Hilbert angle of how far one ankle is ahead of the other, 0.3 to 2.5 Hz; standing left out; sway "
        "smoothed away with a Gaussian of 0.6 s.",
    ]
    if found.dances is not None:
        chosen.append(f"Dances are resampled to {DANCE_RATE:g} Hz for this page; units inches, Z up.")
    return Section("Settings that were chosen", (bullets(chosen),))


def _plain(value: object) -> object:
    """Numbers that JSON has: nothing in place of what is not a number."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value


def lines(numbers: dict[str, object]) -> Iterator[tuple[str, float]]:
    """The figures that end the command: a few of each section, by name."""
    for title, found in numbers.items():
        rows = found.get("rows") if isinstance(found, dict) else None
        if title == "Walks, held out" or title.startswith("Dance, leader"):
            for row in rows or ():
                if row["take"] == "mean":
                    yield f"{title}: {row['method']}, joints cm", row["joint_cm"]
        elif title.startswith("Phase"):
            for row in rows or ():
                yield f"{title}: {row['take']}, {row['control']}, in phase %", row["in phase %"]
