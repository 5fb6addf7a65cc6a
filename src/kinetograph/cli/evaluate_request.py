"""The command evaluate request: what becomes of requests on paths of walks that are not in the library."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer

from kinetograph.cli.compilation import compilation_announced
from kinetograph.cli.options import AsJson, Chosen, Force, LibraryOption, Mirror, options
from kinetograph.cli.output import note, progress_bar, refuse_existing, result, table, write_text


@options()
class Asked(Chosen):
    """The recordings, and what is asked of them."""

    library: LibraryOption
    walks: Annotated[Path, typer.Option(help="A library whose walks are the paths; they are not in the other.")]
    requests: Annotated[int, typer.Option(help="How many requests.", min=1)] = 20
    seed: Annotated[int, typer.Option(help="Seed of the paths and keys.")] = 1
    move: Annotated[
        str | None, typer.Option(help="Ask instead for this move in the middle third of every path, without keys.")
    ] = None
    mirror: Mirror = False
    places: Annotated[
        bool, typer.Option("--places", help="Ask for keys at places of the paths, which wait, in place of times.")
    ] = False
    fill: Annotated[
        bool, typer.Option("--fill", help="Fill spans around keys at times too that no segment is like.")
    ] = False


@options("Output")
class Report:
    """Where figures go."""

    output: Annotated[Path | None, typer.Option("-o", "--output", help="Folder for requests.json.")] = None
    force: Force = False
    as_json: AsJson = False


def request(asked: Asked, report: Report) -> None:
    """Follow walks of others through poses of the library: waving, picking up, turning round.

    A path is a stretch of a walk of the other library, a key a moment of the library in which a hand is far above the
    head, near the ground, or the body turns round. Distances from the path and speeds are given beside those of the
    same path without keys.

    Example: kinetograph evaluate request -l corpus --walks walks --requests 20
    """
    import numpy as np

    from kinetograph.evaluation import evaluate_moves, evaluate_requests, path_requests
    from kinetograph.methods.performance import PerformanceControl
    from kinetograph.pipeline import filler, fit_performance, open_library

    files = [report.output / "requests.json"] if report.output else []
    if report.output:
        report.output.mkdir(exist_ok=True)
    refuse_existing(files, report.force)
    library, walks = open_library(asked.library, asked.selection), open_library(asked.walks)
    with compilation_announced(), progress_bar("asking") as progress:
        model = fit_performance(PerformanceControl(mirror=asked.mirror), library, note=note)
        rng = np.random.default_rng(asked.seed)
        made = path_requests(library, walks, asked.requests, rng, placed=asked.places)
        keyframes = filler(model, library, note=note) if asked.fill or asked.places else None
        each = (
            evaluate_requests(model, made, progress, keyframes, asked.fill or None)
            if asked.move is None
            else evaluate_moves(model, [one.path for one in made], asked.move, progress)
        )
    rows: list[dict[str, Any]] = [asdict(row) for row in each]
    if files:
        write_text(json.dumps(rows, indent=1) + "\n", files[0], report.force)
    table(rows, report.as_json)
    if not report.as_json:
        result(_summary(rows), as_json=False)


def _summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """The figures of all requests together."""
    import numpy as np

    if "share" in rows[0]:
        return {"least share": min(row["share"] for row in rows), "mean share": np.mean([r["share"] for r in rows])}
    made = [row for row in rows if not row["refused"]]
    if not made:
        return {"refused": len(rows)}
    return {
        "refused": len(rows) - len(made),
        "keys missed by at most, mm": max(row["miss_mm"] for row in made),
        "off the path at most, times that without keys": max(row["off"] / row["off_plain"] for row in made),
        "acceleration at most, of the recordings' 99.9th percentile": max(row["acceleration"] for row in made),
        "likewise, or of the recordings that play": max(row["beyond"] for row in made),
        "filled, s in all": sum(row["filled"] for row in made),
        "keys, and of them in filled spans": ", ".join(str(sum(row[k] for row in made)) for k in ("keys", "played")),
        "of it, s that paths waited": sum(row["waited"] for row in made),
        "skate at most, likewise": max(row["skate"] for row in made),
        "processor, median s": float(np.median([row["processor"] for row in made])),
    }
