"""Keyframe control from a library and keys to results."""

from __future__ import annotations

import numpy as np

from kinetograph.keys import Key
from kinetograph.library import Library
from kinetograph.methods.keyframe import KeyframeControl
from kinetograph.synthesis import Synthesis


def inbetween(
    keys: tuple[Key, ...],
    library: Library,
    method: KeyframeControl | None = None,
    *,
    count: int = 1,
    exclude: tuple[str, ...] = (),
    track: str | None = None,
    seed: int = 0,
) -> tuple[Synthesis, ...]:
    """Motions through keys, made of a library's recordings.

    Parameters
    ----------
    keys : tuple of Key
        Two or more, in order of time.
    library : Library
    method : KeyframeControl, optional
    count : int
        How many motions at most: the best, and others that differ from it.
    exclude : tuple of str
        Names of takes to leave out.
    track : str, optional
        Name of the motions' track; needed where takes have several motions.
    seed : int
        Of the cluster chain's clusters.

    Raises
    ------
    RequestError
        Where there is no motion, with the reason.
    """
    method = method or KeyframeControl()
    model = method.fit(library, exclude=exclude, track=track, rng=np.random.default_rng(seed))
    return model.alternatives(keys, count) if count > 1 else (model.synthesize(keys),)
