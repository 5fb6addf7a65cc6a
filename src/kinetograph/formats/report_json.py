"""The report of a synthesis as JSON: its pieces, its costs, and where every frame comes from."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from kinetograph.formats.atomic import atomic_path
from kinetograph.synthesis import Synthesis


def write_report(
    synthesis: Synthesis, path: str | Path, *, force: bool = True, more: Mapping[str, object] | None = None
) -> None:
    """Write pieces, costs, contacts and warnings as JSON; the file appears whole or not at all.

    Parameters
    ----------
    synthesis : Synthesis
    path : str or Path
    force : bool
        Overwrite a file that exists.
    more : mapping of str to object, optional
        What else is known of the result, by name.

    Raises
    ------
    RequestError
        The file exists and ``force`` is false, or its folder cannot be written to.
    """
    content = {
        "cost": synthesis.cost,
        "costs": dict(synthesis.costs),
        "statistics": dict(synthesis.statistics),
        "warnings": synthesis.warnings,
        "left_out": {why: list(takes) for why, takes in synthesis.left_out.items()},
        "pieces": [
            {**asdict(piece), "held": piece.held, "stretch": None if piece.held else piece.stretch}
            for piece in synthesis.pieces
        ],
        "annotations": [asdict(annotation) for annotation in synthesis.annotations],
        **_keys(synthesis),
        **_layers(synthesis),
        **(more or {}),
        "frames": _frames(synthesis),
    }
    with atomic_path(path, force=force) as draft:
        draft.write_text(json.dumps(content, indent=1))


def _keys(synthesis: Synthesis) -> dict[str, Any]:
    """When keys are met, and the spans around them that recordings fill; none without keys."""
    if not synthesis.met:
        return {}
    spans = [{"start": start, "stop": stop} for start, stop in synthesis.filled]
    return {"met": list(synthesis.met), "filled": spans}


def _layers(synthesis: Synthesis) -> dict[str, Any]:
    """The layers, and for every joint from which one its rotations come in which frames; none without layers."""
    if not synthesis.layers:
        return {}
    joints: dict[str, list[dict[str, Any]]] = {}
    for joint in synthesis.motion.skeleton.names:
        runs: list[dict[str, Any]] = []
        for frame in range(len(synthesis.motion)):
            layer = synthesis.layer_at(joint, frame)
            name = None if layer is None else layer.name
            if runs and runs[-1]["layer"] == name:
                runs[-1]["last"] = frame
            else:
                runs.append({"layer": name, "first": frame, "last": frame})
        joints[joint] = runs
    return {"layers": [asdict(layer) for layer in synthesis.layers], "joints": joints}


def _frames(synthesis: Synthesis) -> list[dict[str, Any]]:
    """One row per frame: where it came from, its weight, the metres it was edited by, and the control's second then.

    The last two where the method says, and where the control waits.
    """
    rows: list[dict[str, Any]] = [
        {"take": take, "second": second, "weight": 1.0} for take, second in synthesis.provenance()
    ]
    for frame, row in enumerate(rows):
        if synthesis.piece_at(frame).held:
            row["held"] = True
    for row, second in zip(rows, synthesis.clock, strict=False):
        row["control"] = float(second)
    for row, weight in zip(rows, synthesis.weights, strict=False):
        row["weight"] = float(weight)
    for row, edited in zip(rows, synthesis.edited, strict=False):
        row["edited"] = float(edited)
    return rows
