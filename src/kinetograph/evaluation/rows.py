"""Means over the rows of a table: what was one row per take and method becomes one row per method."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import Field, replace
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np

NOT_A_NUMBER = float("nan")
"""A figure that a method or a take does not have."""


class MethodRow(Protocol):
    """A dataclass with the figures of one method on one take."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    @property
    def take(self) -> str:
        """The name of the take."""

    @property
    def method(self) -> str:
        """The name of the method."""


Row = TypeVar("Row", bound=MethodRow)


def mean_known(values: Sequence[float]) -> float:
    """The mean of the values that are numbers; not a number where none is."""
    known = [value for value in values if not np.isnan(value)]
    return float(np.mean(known)) if known else NOT_A_NUMBER


def mean_rows(rows: Sequence[Row], summed: Sequence[str] = ()) -> list[Row]:
    """The means over the takes of all fields that hold floats.

    Parameters
    ----------
    rows : sequence of dataclass
        One row per take and method, with fields ``take`` and ``method``.
    summed : sequence of str
        Fields that are summed instead.

    Returns
    -------
    list of dataclass
        One row per method, whose take is ``"mean"``. What is not a number is left out of the means.
    """
    means = []
    for method in dict.fromkeys(row.method for row in rows):
        mine = [row for row in rows if row.method == method]
        averaged = [name for name, value in vars(mine[0]).items() if isinstance(value, float) and name not in summed]
        figures = {name: mean_known([getattr(row, name) for row in mine]) for name in averaged}
        sums = {name: sum(getattr(row, name) for row in mine) for name in summed}
        means.append(replace(mine[0], take="mean", **figures, **sums))
    return means


def means_with_and_without(rows: Sequence[Row], repeats: Collection[str], summed: Sequence[str] = ()) -> list[Row]:
    """The means over all takes and, where some are near-repeats of others, over those that are not.

    Parameters
    ----------
    rows : sequence of dataclass
        One row per take and method, with fields ``take`` and ``method``.
    repeats : collection of str
        Takes that are near-repeats, as `near_repeats` gives them.
    summed : sequence of str
        Fields that are summed instead.

    Returns
    -------
    list of dataclass
        One or two rows per method, whose takes are ``"mean"`` and ``"mean without repeats"``.
    """
    others = [row for row in rows if row.take not in repeats]
    apart = mean_rows(others, summed) if len(others) < len(rows) else []
    return [*mean_rows(rows, summed), *(replace(row, take="mean without repeats") for row in apart)]
