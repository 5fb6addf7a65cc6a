"""What a person should know of how a library was read, among the warnings of what was made of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

from kinetograph.left_out import LeftOut
from kinetograph.synthesis import Synthesis

Made = TypeVar("Made", bound=Synthesis)


def noted(made: Made, notes: Sequence[str], left_out: LeftOut) -> Made:
    """A synthesis with the notes of the model that made it first among its warnings, and the takes that it left out.

    Parameters
    ----------
    made : Synthesis
    notes : sequence of str
    left_out : mapping of str to tuple of str
        Takes by reason.
    """
    return replace(made, warnings=(*notes, *made.warnings), left_out=left_out)
