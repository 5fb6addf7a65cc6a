"""Why a piece is where it is, as rows and sentences."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from kinetograph.cli.output import table
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.methods.performance import PerformanceModel, Reasons
    from kinetograph.methods.together import Asked
    from kinetograph.motion import Motion
    from kinetograph.signal import Signal
    from kinetograph.synthesis import Piece

TINY = 1e-7
"""What costs no more costs nothing; the search is in single precision."""


def require_within(seconds: Sequence[float], control: Signal | Motion) -> None:
    """Raise RequestError for a moment that is outside the control."""
    for second in seconds:
        if not 0 <= second <= control.duration:
            raise RequestError(f"--why: the control lasts {control.duration:.2f} s, found a time of {second:g} s")


def reasons_at(
    model: PerformanceModel, control: Signal | Motion, seconds: Sequence[float], asked: Asked
) -> list[Reasons]:
    """Why the pieces at some moments, seconds of the control, are there."""
    from kinetograph.methods.together import explained

    return [explained(model, control, asked, second) for second in seconds]


def as_data(reasons: Sequence[Reasons]) -> list[dict[str, Any]]:
    """Reasons as JSON has them."""
    return [
        {
            "second": each.second,
            "cost": each.cost,
            "optimum": each.optimum,
            "pieces": [
                {
                    **asdict(one.piece),
                    "chosen": one.chosen,
                    "margin": one.margin,
                    "terms": asdict(one.terms),
                    "total": one.terms.total,
                    "without": list(one.without),
                }
                for one in each.contenders
            ],
            "without": [
                {"constraint": other.constraint, "piece": asdict(other.piece), "saved": other.saved}
                for other in each.reversals
            ],
        }
        for each in reasons
    ]


def say_reasons(reasons: Sequence[Reasons]) -> None:
    """Print them for people: a table of pieces, and what would have to go for another to be there."""
    for each in reasons:
        table(_rows(each), as_json=False, title=_title(each))
        for other in each.reversals:
            sys.stdout.write(
                f"  without {other.constraint}: {_named(other.piece)}; the whole would cost {other.saved:.3g} less\n"
            )
        if not each.reversals:
            sys.stdout.write("  no single constraint or cost, taken away, would put another piece there\n")


def _title(reasons: Reasons) -> str:
    return (
        f"why {_named(reasons.chosen.piece)} at {reasons.second:g} s; margin: what the best whole sequence with a "
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
