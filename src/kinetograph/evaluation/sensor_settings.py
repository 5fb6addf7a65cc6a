"""What the figures of an evaluation of sensor control depend on, and which recordings its settings were chosen on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from kinetograph.evaluation.sensor_folds import HeldOut
from kinetograph.methods.sensor import PoseSynthesis, SensorControl

SPORTS = "the sports of docs/results/sensor.md (CMU 06, 64, 86, 124, 135, 144)"
_PROTOTYPE = f"on {SPORTS} and neura's walk, in a prototype; the ridge by leaving out people of each library"
CHOSEN: Mapping[str, str] = {
    "guided": (
        f"weight and smoothing {_PROTOTYPE}; the kinds of estimates, and what shares are drawn to, on {SPORTS}, "
        "utd-mhad and neura's walk; shares inside the library"
    ),
    "ridge": f"window and kernel {_PROTOTYPE}",
    "continuity": f"weights on {SPORTS}; shrinkage inside the library",
    "interpolation": f"share of variance and choice of clusters on {SPORTS}",
    "optimisation": f"weights on {SPORTS}; ahead = 0.15 s on three of them: 64_01, 124_03, 135_10",
}
"""By synthesis, what its settings were chosen on: where that is in the table, only ``--nested`` rows are free of it."""


def settings_of(method: SensorControl, syntheses: Mapping[str, PoseSynthesis], held: HeldOut) -> dict[str, Any]:
    """What figures depend on, as texts and numbers.

    Parameters
    ----------
    method : SensorControl
    syntheses : mapping
        By name.
    held : HeldOut

    Returns
    -------
    dict
    """
    return {
        "layout": method.layout.name,
        "sensors": list(method.layout.names),
        "kinds": list(method.kinds),
        "rate": method.rate,
        "seed": method.seed,
        "left_out": held.leave,
        "only": list(held.only),
        "people": dict(held.people),
        "copies_left_out": {take: list(copies) for take, copies in held.copies.items()},
        "syntheses": {name: repr(synthesis) for name, synthesis in syntheses.items()},
        "settings_chosen_on": {name: CHOSEN[name] for name in syntheses if name in CHOSEN},
    }
