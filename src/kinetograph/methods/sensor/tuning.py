"""Settings of syntheses by name, for those who choose a synthesis by its name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar

from kinetograph.errors import RequestError
from kinetograph.methods.sensor.settings import ByDensity, ByMean

_T = TypeVar("_T")

CHOICES: Mapping[str, ByDensity | ByMean] = {"density": ByDensity(), "mean": ByMean()}
"""Choices of the cluster of local models by name."""


def tuned(synthesis: _T, settings: Mapping[str, Any]) -> _T:
    """A synthesis with some of its settings, or of those of its local models, in place of the defaults.

    Parameters
    ----------
    synthesis : dataclass
    settings : mapping
        Values by name; a ``choice`` is a name of `CHOICES`.

    Returns
    -------
    dataclass
        Of the same class.

    Raises
    ------
    RequestError
        For a setting that the synthesis does not have, and a value out of range.

    Examples
    --------
    >>> from kinetograph.methods.sensor import Optimisation
    >>> made = tuned(Optimisation(), {"ahead": 0.0, "choice": "mean"})
    >>> made.ahead, made.local.choice
    (0.0, ByMean())
    """
    own = _names(synthesis)
    local = getattr(synthesis, "local", None)
    inner = _names(local)
    changed: dict[str, Any] = {}
    changed_local: dict[str, Any] = {}
    for name, value in settings.items():
        if name not in own | inner:
            known = ", ".join(sorted((own | inner) - {"local"}))
            raise RequestError(f"{type(synthesis).__name__.lower()} has no setting {name!r}; it has {known}")
        if name == "choice" and value not in CHOICES:
            raise RequestError(f"choice must be one of {', '.join(CHOICES)}, found {value!r}")
        (changed if name in own else changed_local)[name] = CHOICES[value] if name == "choice" else value
    if changed_local:
        changed["local"] = replace(local, **changed_local)  # type: ignore[type-var]
    return replace(synthesis, **changed) if changed else synthesis  # type: ignore[type-var]


def _names(settings: object) -> set[str]:
    return {field.name for field in fields(settings)} if is_dataclass(settings) else set()
