"""Configurations by the words that command lines use for them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TypeVar

from kinetograph.errors import RequestError
from kinetograph.methods.sensor.guiding import Guided, KernelRidge, PoseSynthesis
from kinetograph.methods.sensor.settings import LleReduction, LocalModelSettings, PcaReduction
from kinetograph.methods.sensor.smoothing import CausalSmoothing, NoSmoothing, Smoothing, WindowSmoothing
from kinetograph.methods.sensor.syntheses import Continuity, Interpolation, Optimisation

_T = TypeVar("_T")

SYNTHESES: Mapping[str, PoseSynthesis] = {
    "guided": Guided(),
    "ridge": KernelRidge(),
    "continuity": Continuity(),
    "interpolation": Interpolation(),
    "optimisation": Optimisation(),
}
"""The syntheses by name."""
REDUCTIONS: Mapping[str, PcaReduction | LleReduction] = {"pca": PcaReduction(), "lle": LleReduction()}
"""The reductions of local models by name."""
SMOOTHINGS: Mapping[str, Smoothing] = {
    "window": WindowSmoothing(),
    "causal": CausalSmoothing(),
    "none": NoSmoothing(),
}
"""The smoothings by name."""


def synthesis_named(name: str, reduction: str = "pca") -> PoseSynthesis:
    """The synthesis of a name, with a reduction for the local models where it has them.

    Parameters
    ----------
    name : str
        ``"guided"``, ``"ridge"``, ``"continuity"``, ``"interpolation"`` or ``"optimisation"``.
    reduction : str
        ``"pca"`` or ``"lle"``.

    Returns
    -------
    Guided, KernelRidge, Continuity, Interpolation or Optimisation

    Raises
    ------
    RequestError
        For another name.

    Examples
    --------
    >>> synthesis_named("interpolation", "lle").local.reduction.most
    12
    """
    synthesis = _named(SYNTHESES, "synthesis", name)
    local = LocalModelSettings(reduction=_named(REDUCTIONS, "reduction", reduction))
    return replace(synthesis, local=local) if isinstance(synthesis, Interpolation | Optimisation) else synthesis


def smoothing_named(name: str | None) -> Smoothing | None:
    """The smoothing of a name, ``"window"``, ``"causal"`` or ``"none"``. Raises RequestError for another one."""
    return None if name is None else _named(SMOOTHINGS, "smoothing", name)


def _named(table: Mapping[str, _T], what: str, name: str) -> _T:
    if name not in table:
        raise RequestError(f"{what} must be one of {', '.join(table)}, found {name!r}")
    return table[name]
