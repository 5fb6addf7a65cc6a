"""The page on Hsu 2004: its sections, one after another, and their numbers."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from kinetograph.errors import KinetographError, RequestError
from kinetograph.evaluation.reproduce.hsu2004 import dances, sweeps, timings, walks
from kinetograph.evaluation.reproduce.hsu2004.data import DANCE_RATE, Recordings, collect, find_folder
from kinetograph.evaluation.reproduce.hsu2004.labels import label_section
from kinetograph.evaluation.reproduce.hsu2004.phase import phase_section
from kinetograph.evaluation.reproduce.page import Section, bullets, page, paragraph
from kinetograph.formats import atomic_path
from kinetograph.methods.performance import PerformanceControl, partner_control
from kinetograph.progress import Progress, Report

TITLE = "Hsu 2004, on recordings at hand"
NOT_COMPARABLE = (
    "Recordings: other people, other dances, other cameras. The thesis' walker and dancers are not published.",
    "Joints: the thesis' are estimated from markers by a commercial tool; ours come with the recordings, the walks as "
    "fits of a body model, which makes their hips smoother.",
    "The thesis judges motion by eye and gives no distances; ours have no counterpart there.",
    "Segment and pattern errors: the thesis' moves were named by a dancer who watched; ours by rule or by file.",
    "Times: two 2.4 GHz Xeons of 2003 and the clock, against one thread of this machine and processor time.",
)


@dataclass(frozen=True)
class Step:
    """One section of the page.

    Parameters
    ----------
    title : str
    make : callable
        Makes the section.
    """

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
    """Write ``index.html`` and ``numbers.json`` to a new folder.

    The page is written anew after every section, so that what is done is kept when the work is interrupted.

    Parameters
    ----------
    folder : str or Path
    data : Path, optional
        A folder with ``walks/`` or ``salsa/``; by default one that ``KINETOGRAPH_DATA`` names.
    quick : bool
        Fewer takes, excerpts, settings and repeats.
    report : Report
        Called with what is missing or cannot be made.
    tick : Report
        Called with what was done last.
    progress : Progress
        Called with the sections done and their number.

    Returns
    -------
    dict
        The numbers by section.

    Raises
    ------
    RequestError
        For a folder in use, or data without recordings.
    """
    output = Path(folder)
    if output.exists() and any(output.iterdir()):
        raise RequestError(f"{output} is not empty; name a new folder")
    chosen = find_folder(data)
    output.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as scratch:
        recordings = collect(chosen, Path(scratch), quick)
        for text in recordings.missing:
            report(f"missing: {text}")
        made = _write_sections(output, recordings, plan(recordings, quick, tick), quick, report, progress)
    return {section.title: _plain(dict(section.numbers)) for section in made}


def plan(recordings: Recordings, quick: bool, tick: Report) -> list[Step]:
    """The sections that the recordings allow, in order.

    Parameters
    ----------
    recordings : Recordings
    quick : bool
        Fewer takes, excerpts, settings and repeats.
    tick : Report
        Called with what was done last.

    Returns
    -------
    list of Step
    """
    steps = []
    if (library := recordings.walks) is not None:
        steps += [
            Step("Walks, held out", lambda: walks.held_out_section(library, tick)),
            Step("Phase", lambda: phase_section("Phase", library, quick, tick)),
        ]
        if (more := recordings.more_walks) is not None:
            title = "Phase, second set of walks"
            steps.append(Step(title, lambda: phase_section(title, more, quick, tick, first=False)))
        steps += [
            Step("Timings with and without beam", lambda: timings.timing_section(library, quick, tick)),
            Step("Time against length", lambda: timings.growth_section(library, quick, tick)),
            Step("Clustering", lambda: sweeps.cluster_section(library, quick, tick)),
            Step("Search rate and refinement", lambda: sweeps.rate_section(library, quick, tick)),
            Step("Continuity constant", lambda: sweeps.continuity_section(library, quick, tick)),
            Step("Segment and pattern errors", lambda: label_section(library, recordings.clips, tick)),
            Step("A drawn path", lambda: walks.path_section(recordings.clips or library, tick)),
        ]
    if (pairs := recordings.dances) is not None:
        steps += [
            Step("Dance, leader in and follower out", lambda: dances.dance_section(pairs, tick)),
            Step("Dance: units and clustering", lambda: dances.unit_section(pairs, quick, tick)),
            Step("Dance: timings", lambda: dances.dance_timing_section(pairs, quick, tick)),
        ]
    return steps


def _write_sections(
    output: Path, recordings: Recordings, steps: list[Step], quick: bool, report: Report, progress: Progress
) -> list[Section]:
    """Make one section after another, and write what there is after each."""
    made: list[Section] = []
    for done in range(len(steps) + 1):
        _write(output, recordings, made, [step.title for step in steps[done:]], quick)
        progress(done, len(steps))
        if done < len(steps):
            made.append(_made(steps[done], report))
    return made


def _made(step: Step, report: Report) -> Section:
    """A section, or why there is none: an experiment that cannot use the recordings does not stop the others."""
    try:
        return step.make()
    except KinetographError as error:
        report(f"{step.title}: not made: {error}")
        return Section(step.title, (paragraph(f"Not made: {error}", "missing"),), {"error": str(error)})


def _write(output: Path, recordings: Recordings, made: list[Section], waiting: list[str], quick: bool) -> None:
    sections = [
        _recordings(recordings, waiting, quick),
        *made,
        _settings(recordings),
        Section("Not comparable", (bullets(NOT_COMPARABLE),)),
    ]
    with atomic_path(output / "index.html", force=True) as draft:
        draft.write_text(page(TITLE, sections), encoding="utf-8")
    numbers = {section.title: _plain(dict(section.numbers)) for section in made}
    with atomic_path(output / "numbers.json", force=True) as draft:
        draft.write_text(json.dumps({"missing": recordings.missing, "not yet": waiting, **numbers}, indent=1))


def _recordings(recordings: Recordings, waiting: list[str], quick: bool) -> Section:
    parts = []
    if recordings.walks is not None:
        parts.append(paragraph(f"Walks: {recordings.walks_from}; takes {', '.join(recordings.walks.names())}."))
    if recordings.dances is not None:
        parts.append(paragraph(f"Dances: {len(recordings.dances.names())} takes of leader and follower."))
    parts += [paragraph(f"Missing: {text}.", "missing") for text in recordings.missing]
    if quick:
        parts.append(paragraph("Made with --quick: fewer takes, excerpts, settings and repeats.", "missing"))
    if waiting:
        parts.append(paragraph(f"Not made yet, or interrupted before: {', '.join(waiting)}.", "missing"))
    return Section("Recordings", tuple(parts))


def _settings(recordings: Recordings) -> Section:
    """Each setting that had to be chosen, with the thesis' where it gives one."""
    walk, dance = PerformanceControl(reuse=0.0, stand=False), partner_control()
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
    if recordings.dances is not None:
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
    """A few figures of each section, by name, for the end of the command.

    Parameters
    ----------
    numbers : dict
        What `reproduce` returns.

    Yields
    ------
    name : str
    figure : float
    """
    for title, values in numbers.items():
        rows = values.get("rows") if isinstance(values, dict) else None
        if title == "Walks, held out" or title.startswith("Dance, leader"):
            for row in rows or ():
                if row["take"] == "mean":
                    yield f"{title}: {row['method']}, joints cm", row["joint_cm"]
        elif title.startswith("Phase"):
            for row in rows or ():
                yield f"{title}: {row['take']}, {row['control']}, in phase %", row["in phase %"]
