"""The whole reproduction: figures and numbers in a folder."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from kinetograph.evaluation.reproduce.molina_tanco2000 import figures
from kinetograph.evaluation.reproduce.molina_tanco2000.database import key_within, takes
from kinetograph.evaluation.reproduce.molina_tanco2000.next_stage import next_stage
from kinetograph.evaluation.reproduce.molina_tanco2000.section4 import (
    FirstSolved,
    first_solved,
    numbers_of,
    quantisation_errors,
    two_facings,
)
from kinetograph.library import Library
from kinetograph.methods.keyframe import KeyframeControl, collect_examples, pose_vectors
from kinetograph.synthesis import Synthesis


def reproduce(
    folder: Path,
    data: Path | None = None,
    report: Callable[[str], None] | None = None,
    *,
    seeds: int = 20,
    runs: int = 110,
) -> dict[str, object]:
    """Write the figures and ``numbers.json`` to a folder.

    Parameters
    ----------
    folder : Path
    data : Path, optional
        A folder with ``actions/`` and, for the next stage, ``walks/``; the sample without it.
    report : callable, optional
        Called with one line about what is done.
    seeds : int
        Seeds of K-means that are tried for a path from key to key.
    runs : int
        Runs of K-means in figure 6.

    Returns
    -------
    dict
        What is written to ``numbers.json``: the figures of sections 4 and 5.

    Raises
    ------
    RequestError
        Where no seed gives a path.
    """
    folder.mkdir(parents=True, exist_ok=True)
    say = report or (lambda text: None)
    library = Library.create(folder / "library")
    for take in takes(data):
        library.add(take)
    names = library.names()
    keys = (key_within(library, names[0], 0.0), key_within(library, names[1], 0.5))
    solved = first_solved(collect_examples(library, KeyframeControl().rate), keys, seeds)
    numbers = numbers_of(solved, keys)
    say(f"{numbers.clusters_passed} clusters, {numbers.frames} frames, {', '.join(numbers.examples_used)}")
    _draw(solved, list(names), runs, folder)
    results: dict[str, object] = {"section 4": asdict(numbers)}
    if data is not None:
        results["section 5"] = [asdict(stage) for stage in next_stage(folder, data, say)]
    (folder / "numbers.json").write_text(json.dumps(results, indent=1))
    return results


def _draw(solved: FirstSolved, names: list[str], runs: int, folder: Path) -> None:
    model, result = solved.chain.model, solved.result
    before, after = two_facings(model.examples)
    figures.draw_alignment(before, after, names, folder / "figure2.png")
    figures.draw_space(model.coordinates, names, folder / "figure5.png")
    figures.draw_errors(quantisation_errors(model, runs), folder / "figure6.png")
    path = model.reduction.encode(pose_vectors(result.motion))
    figures.draw_space(model.coordinates, names, folder / "figure8.png", result=path)
    _contact_sheet(result, folder / "figure9.png")


def _contact_sheet(result: Synthesis, path: Path) -> None:
    from kinetograph.drawing import contact_sheet

    seams = [piece.start for piece in result.pieces[1:]]
    contact_sheet(result.motion, path, contacts=result.annotations, seams=seams, title="figure 9: the transition")
