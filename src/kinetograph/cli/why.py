"""Why something is at a moment of a result, as rows and sentences."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from kinetograph.cli.output import table
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.methods.performance import Reasons
    from kinetograph.motion import Motion
    from kinetograph.pipeline import Answer, Rendered
    from kinetograph.signal import Signal
    from kinetograph.synthesis import DrivenPart, Piece

TINY = 1e-7
"""What costs no more costs nothing; the search is in single precision."""


def require_within(seconds: Sequence[float], control: Signal | Motion, *, waits: bool = False) -> None:
    """Raise RequestError for a moment that is outside the control; what waits on the way may last longer."""
    for second in seconds:
        if second < 0 or (second > control.duration and not waits):
            raise RequestError(f"--why: the control lasts {control.duration:.2f} s, found a time of {second:g} s")


def answers_at(made: Rendered, seconds: Sequence[float]) -> list[Answer]:
    """What is at some moments, seconds of the result, and why."""
    from kinetograph.pipeline import why_at

    return [why_at(made, second) for second in seconds]


def as_data(answers: Sequence[Answer]) -> list[dict[str, Any]]:
    """Answers as JSON has them."""
    return [
        {
            "second": each.second,
            **(_spanned(each) if each.reasons is None else _reasoned(each.reasons)),
            "layers": [asdict(layer) for layer in each.layers],
            "edited": each.edited,
        }
        for each in answers
    ]


def _spanned(answer: Answer) -> dict[str, Any]:
    return {"span": answer.span, "keys": answer.keys, "recordings": [asdict(piece) for piece in answer.pieces]}


def _reasoned(reasons: Reasons) -> dict[str, Any]:
    return {
        "cost": reasons.cost,
        "optimum": reasons.optimum,
        "pieces": [
            {
                **asdict(one.piece),
                "chosen": one.chosen,
                "margin": one.margin,
                "terms": asdict(one.terms),
                "total": one.terms.total,
                "without": list(one.without),
            }
            for one in reasons.contenders
        ],
        "without": [
            {"constraint": other.constraint, "piece": asdict(other.piece), "saved": other.saved}
            for other in reasons.reversals
        ],
    }


def say_answers(answers: Sequence[Answer]) -> None:
    """Print them for people: a table of pieces, what would have to go for another to be there, and the layers."""
    for each in answers:
        if each.reasons is None:
            table(_recordings(each.pieces), as_json=False, title=_title_of_span(each))
        else:
            _say(each.reasons, each.second)
        for layer in each.layers:
            sys.stdout.write(f"  {_layer(layer, each.second)}\n")


def _say(reasons: Reasons, second: float) -> None:
    table(_rows(reasons), as_json=False, title=_title(reasons, second))
    for other in reasons.reversals:
        sys.stdout.write(
            f"  without {other.constraint}: {_named(other.piece)}; the whole would cost {other.saved:.3g} less\n"
        )
    if not reasons.reversals:
        sys.stdout.write("  no single constraint or cost, taken away, would put another piece there\n")


def _title_of_span(answer: Answer) -> str:
    assert answer.span is not None
    keys = ", ".join(f"{time:.2f}" for time in answer.keys)
    return (
        f"at {answer.second:g} s the timed search plays, from {answer.span[0]:.2f} to {answer.span[1]:.2f} s, to meet "
        f"the key{'s' if len(answer.keys) > 1 else ''} at {keys} s; its recordings there:"
    )


def _recordings(pieces: Sequence[Piece]) -> list[dict[str, Any]]:
    return [
        {
            "take": f"{piece.take}, mirrored" if piece.mirrored else piece.take,
            "start": piece.start,
            "stop": piece.stop,
            "from": piece.source_start,
            "to": piece.source_stop,
        }
        for piece in pieces
    ]


def _layer(layer: DrivenPart, second: float) -> str:
    piece = next((each for each in layer.pieces if each.start <= second <= each.stop), None)
    source = f", from {piece.take} at {float(piece.source_time(second)):.2f} s" if piece and not piece.held else ""
    return f"layer {layer.name} drives {', '.join(layer.joints)}, {layer.start:.2f} to {layer.stop:.2f} s{source}"


def _title(reasons: Reasons, second: float) -> str:
    of_path = "" if abs(second - reasons.second) < 0.01 else f", {reasons.second:.2f} s of the path"
    return (
        f"why {_named(reasons.chosen.piece)} at {second:g} s{of_path}; margin: what the best whole sequence with a "
        "piece costs above the optimum, reuse being free; its terms:"
    )


def _rows(reasons: Reasons) -> list[dict[str, Any]]:
    """One row a piece; terms that cost nothing anywhere are left out."""
    terms = [asdict(one.terms) for one in reasons.contenders]
    used = [name for name in terms[0] if any(abs(each[name]) > TINY for each in terms)]
    return [
        {
            "": "*" if one.chosen else "",
            "piece": _named(one.piece),
            "start": one.piece.start,
            "stop": one.piece.stop,
            "margin": _rounded(one.margin),
            **{name: _rounded(each[name]) for name in used},
        }
        for one, each in zip(reasons.contenders, terms, strict=True)
    ]


def _rounded(cost: float) -> float:
    return 0.0 if abs(cost) <= TINY else float(f"{cost:.3g}")


def _named(piece: Piece) -> str:
    side = ", mirrored" if piece.mirrored else ""
    return f"{piece.take} {piece.source_start:.2f}-{piece.source_stop:.2f} s{side}"
