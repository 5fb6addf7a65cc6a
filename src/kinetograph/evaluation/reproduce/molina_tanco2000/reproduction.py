"""The page on Molina-Tanco & Hilton 2000: its sections, one after another, their figures and their numbers."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from kinetograph.evaluation.recorded_keys import HELD, own_frames
from kinetograph.evaluation.reproduce.molina_tanco2000 import figures
from kinetograph.evaluation.reproduce.molina_tanco2000.database import key_within, takes
from kinetograph.evaluation.reproduce.molina_tanco2000.next_stage import Stage, next_stage
from kinetograph.evaluation.reproduce.molina_tanco2000.section4 import (
    FirstSolved,
    Numbers,
    first_solved,
    numbers_of,
    quantisation_errors,
    two_facings,
)
from kinetograph.evaluation.reproduce.page import Section, Value, drawn, page, paragraph, table
from kinetograph.formats import atomic_path
from kinetograph.keys import Key
from kinetograph.library import Library
from kinetograph.methods.keyframe import (
    KeyframeControl,
    collect_examples,
    excerpts_through,
    pose_vectors,
    state_sequence,
)

TITLE = "Molina-Tanco and Hilton 2000, on recordings at hand"
PAPER = {
    "frames in the library": "465",
    "components, share of variance": "about 15, > 97 %",
    "K": "15",
    "clusters passed": "10",
    "frames of the result": "71",
    "examples used": "2",
}
"""What section 4 of the paper gives."""


@dataclass(frozen=True)
class Effort:
    """How much is tried.

    Parameters
    ----------
    seeds : int
        Seeds of K-means that are tried for a path from key to key.
    runs : int
        Runs of K-means in figure 6.
    frames : int
        Frames of the database that are tried as keys.
    """

    seeds: int = 20
    runs: int = 110
    frames: int = 200


@dataclass(eq=False)
class Page:
    """The page under way; it is written anew, with its numbers, after every section.

    Parameters
    ----------
    folder : Path
        Where it is written.
    waiting : list of str
        Titles of the sections that are to come.
    """

    folder: Path
    waiting: list[str]
    _made: list[Section] = field(default_factory=list)

    @property
    def numbers(self) -> dict[str, object]:
        """The numbers of all sections that have some."""
        return {name: value for section in self._made for name, value in section.numbers.items()}

    def add(self, section: Section) -> None:
        """Add a section."""
        self._made.append(section)
        self.waiting.remove(section.title)
        left = [paragraph(f"Not made yet, or interrupted before: {', '.join(self.waiting)}.", "missing")]
        rest = [Section("To come", tuple(left))] if self.waiting else []
        with atomic_path(self.folder / "index.html", force=True) as draft:
            draft.write_text(page(TITLE, [*self._made, *rest]), encoding="utf-8")
        with atomic_path(self.folder / "numbers.json", force=True) as draft:
            draft.write_text(json.dumps(self.numbers, indent=1))

    def figure(self, number: int, caption: str, draw: Callable[[Path], object]) -> str:
        """Draw a figure to a file of its own; its HTML."""
        path = self.folder / f"figure{number}.png"
        draw(path)
        return drawn(lambda copy: shutil.copy(path, copy), f"Figure {number}: {caption}")


def reproduce(
    folder: Path,
    data: Path | None = None,
    report: Callable[[str], None] | None = None,
    *,
    effort: Effort | None = None,
) -> dict[str, object]:
    """Write ``index.html``, the figures and ``numbers.json`` to a folder, section by section.

    Parameters
    ----------
    folder : Path
    data : Path, optional
        A folder with ``actions/`` and, for the next stage, ``corpus/``; the sample without it.
    report : callable, optional
        Called with one line about what is done.
    effort : Effort, optional
        How much is tried.

    Returns
    -------
    dict
        What is written to ``numbers.json``: the figures of sections 4 and 5, and of the database's own frames as keys.

    Raises
    ------
    RequestError
        Where no seed gives a path.
    """
    effort, say = effort or Effort(), report or (lambda text: None)
    folder.mkdir(parents=True, exist_ok=True)
    library = Library.create(folder / "library")
    for take in takes(data):
        library.add(take)
    names = library.names()
    keys = (key_within(library, names[0], 0.0), key_within(library, names[1], 0.5))
    solved = first_solved(collect_examples(library, KeyframeControl().rate), keys, effort.seeds)
    steps: dict[str, Callable[[], Section]] = {
        "Section 4: the numbers": lambda: _numbers(solved, keys, say),
        "Level 1": lambda: _level_1(sheet, solved, keys, effort.runs),
        "Level 2": lambda: _level_2(sheet, solved, keys),
        "Synthesis": lambda: _synthesis(sheet, solved, keys),
        "The database's own frames as keys": lambda: _own_frames(library, effort.frames),
    }
    if data is not None:
        steps["Section 5: the next stage"] = lambda: _stages(next_stage(folder, data, say))
    sheet = Page(folder, list(steps))
    for make in steps.values():
        sheet.add(make())
    return sheet.numbers


def _numbers(solved: FirstSolved, keys: tuple[Key, Key], say: Callable[[str], None]) -> Section:
    numbers = numbers_of(solved, keys)
    say(f"{numbers.clusters_passed} clusters, {numbers.frames} frames, {', '.join(numbers.examples_used)}")
    rows = [[name, PAPER.get(name, ""), value] for name, value in _in_words(numbers).items()]
    parts = (table("Section 4, the paper's database and this one", ("", "paper", "here"), rows),)
    return Section("Section 4: the numbers", parts, {"section 4": asdict(numbers)})


def _in_words(numbers: Numbers) -> dict[str, str]:
    kept = f"{numbers.components}, {numbers.share:.1%}"
    return {
        "frames in the library": str(numbers.frames_in_library),
        "components, share of variance": f"{kept} (15: {numbers.share_at_15:.1%})",
        "K": str(numbers.clusters),
        "clusters passed": str(numbers.clusters_passed),
        "frames of the result": str(numbers.frames),
        "examples used": f"{len(numbers.examples_used)}: {', '.join(numbers.examples_used)}",
        "worst seam's jump": f"{numbers.seam_jump:.2f}",
        "seeds of K-means with a path": f"{numbers.seeds_solved:.0%}",
    }


def _level_1(sheet: Page, solved: FirstSolved, keys: tuple[Key, Key], runs: int) -> Section:
    model = solved.chain.model
    names = [example.take for example in model.examples]
    before, after = two_facings(model.examples)
    errors = quantisation_errors(model, runs)
    passed = state_sequence(model, *keys).clusters.tolist()
    caption = "alignment; the second example faces another way by a right angle"
    states = "the states of level 1; in colour, those that the synthesis passes"
    parts = (
        sheet.figure(2, caption, partial(figures.draw_alignment, before, after, names)),
        sheet.figure(3, states, partial(_states, solved, passed)),
        sheet.figure(5, "the examples in PCA space", partial(figures.draw_space, model.coordinates, names)),
        sheet.figure(
            6, f"quantisation error by K, {sum(map(len, errors.values()))} runs", partial(figures.draw_errors, errors)
        ),
    )
    mean = {str(k): float(np.mean(found)) for k, found in errors.items()}
    spread = {str(k): float(np.std(found)) for k, found in errors.items()}
    numbers = {"runs": sum(map(len, errors.values())), "mean": mean, "standard deviation": spread}
    return Section("Level 1", parts, {"figure 6": numbers})


def _states(solved: FirstSolved, passed: list[int], path: Path) -> None:
    figures.draw_states(solved.chain.model, path, passed=passed)


def _level_2(sheet: Page, solved: FirstSolved, keys: tuple[Key, Key]) -> Section:
    model = solved.chain.model
    names = [example.take for example in model.examples]
    used = excerpts_through(model, [state_sequence(model, *keys)])
    draw = partial(figures.draw_examples, model, names, used=used)
    return Section("Level 2", (sheet.figure(4, "the examples as hidden states, and their motion segments", draw),))


def _synthesis(sheet: Page, solved: FirstSolved, keys: tuple[Key, Key]) -> Section:
    model, result = solved.chain.model, solved.result
    names = [example.take for example in model.examples]
    path = model.reduction.encode(pose_vectors(result.motion))
    parts = (
        sheet.figure(7, "the keys", partial(figures.draw_keys, keys)),
        sheet.figure(8, "the result in PCA space", partial(figures.draw_space, model.coordinates, names, result=path)),
        sheet.figure(9, "the transition", partial(figures.draw_transition, result)),
    )
    return Section("Synthesis", parts)


def _own_frames(library: Library, count: int) -> Section:
    rows = own_frames(library, count)
    columns = ("key", "pairs", "refused", f"missed by over {1000 * HELD:.0f} mm", "median, mm", "worst, mm")
    cells: list[list[Value]] = [[r.place, r.pairs, r.refused, f"{r.missed:.1%}", r.median_mm, r.worst_mm] for r in rows]
    caption = "Random frames of the database, each with another one, as first and as last key"
    numbers = {"own frames as keys": [asdict(row) for row in rows]}
    return Section("The database's own frames as keys", (table(caption, columns, cells),), numbers)


def _stages(stages: list[Stage]) -> Section:
    title = "Section 5: the next stage"
    if not stages:
        return Section(title, (paragraph("Not made: too few recordings.", "missing"),))
    columns = ("examples", "frames", "K", "solved", "seam's jump, median", "key missed by, mm", "fit, s", "a pair, s")
    cells: list[list[Value]] = [
        [
            s.examples,
            s.frames,
            s.clusters,
            f"{s.solved:.0%}",
            s.seam_jump,
            s.worst_miss_mm,
            s.fit_seconds,
            s.pair_seconds,
        ]
        for s in stages
    ]
    caption = f"More examples, each a whole recording; {stages[0].pairs} random pairs of poses; processor time"
    return Section(title, (table(caption, columns, cells),), {"section 5": [asdict(stage) for stage in stages]})
