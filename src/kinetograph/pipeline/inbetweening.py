"""Keyframe control from a library and keys to results: keys, method, motions."""

from __future__ import annotations

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.library import Library
from kinetograph.methods.keyframe import KeyframeControl, KeyframeModel
from kinetograph.pipeline.noting import noted
from kinetograph.synthesis import Synthesis


def inbetween(
    keys: tuple[Key, ...], library: Library, method: KeyframeControl | None = None, count: int = 1
) -> tuple[Synthesis, ...]:
    """Motions through keys, made of a library's recordings.

    To leave takes out, or to use one model again, fit the method and see `inbetween_with`.

    Parameters
    ----------
    keys : tuple of Key
    library : Library
    method : KeyframeControl, optional
    count : int
        How many motions.

    Returns
    -------
    tuple of Synthesis
        The best, and up to ``count`` - 1 that differ from it.

    Raises
    ------
    RequestError
        For keys that cannot be met.
    """
    return inbetween_with((method or KeyframeControl()).fit(library, rng=np.random.default_rng(0)), keys, count)


def inbetween_with(model: KeyframeModel, keys: tuple[Key, ...], count: int = 1) -> tuple[Synthesis, ...]:
    """Motions through keys by a fitted model, whose notes are among the warnings; see `inbetween`."""
    if count < 1:
        raise RequestError(f"alternatives are 1 motion or more, found {count}")
    made = model.alternatives(keys, count) if count > 1 else (model.synthesize(keys),)
    return tuple(noted(each, model.notes, model.left_out) for each in made)
