"""Whether a library's own frames are held where they are keys: the least that a solver of keyframe control must do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.evaluation.keyframe import key_miss
from kinetograph.keys import Key, key_at
from kinetograph.library import Library
from kinetograph.methods.keyframe import ClusterChain, KeyframeControl, KeyframeModel
from kinetograph.progress import Progress

HELD = 0.01
"""Metres of mean joint distance up to which a key counts as held."""


@dataclass(frozen=True)
class OwnFrames:
    """How recorded frames are held as keys.

    Parameters
    ----------
    place : str
        Where they are keys: ``"first"`` or ``"last"`` of two, or ``"both"``.
    pairs : int
        Each is a frame with another one.
    refused : int
        Pairs without a motion.
    missed : float
        Share of the others in which the frame is missed by more than ``HELD``.
    median_mm, worst_mm : float
        The frame's mean joint distance from the result, in millimetres.
    """

    place: str
    pairs: int
    refused: int
    missed: float
    median_mm: float
    worst_mm: float


def own_frames(
    library: Library,
    count: int = 200,
    *,
    method: KeyframeControl | None = None,
    rng: np.random.Generator | None = None,
    progress: Progress | None = None,
) -> list[OwnFrames]:
    """Random frames of a library, each as the first and as the last key of a pair with another one.

    Parameters
    ----------
    library : Library
    count : int
        How many frames.
    method : KeyframeControl, optional
        Of the cluster chain unless given.
    rng : numpy.random.Generator, optional
        Draws frames; the same ones without it.
    progress : Progress, optional
        Called for every frame.

    Returns
    -------
    list of OwnFrames
        As first key, as last key, and both.

    Raises
    ------
    RequestError
        For a library of a single frame, or none that are asked for.
    """
    model = (method or KeyframeControl(solver=ClusterChain())).fit(library)
    rng = rng or np.random.default_rng(0)
    lengths = [len(example.motion) for example in model.examples]
    total = sum(lengths)
    if total < 2 or count < 1:
        raise RequestError(f"expected 1 frame or more out of 2 or more, found {count} out of {total}")
    misses: tuple[list[float | None], list[float | None]] = ([], [])
    for number, frame in enumerate(rng.choice(total, min(count, total), replace=False)):
        for place, found in enumerate(misses):
            other = (frame + rng.integers(1, total)) % total
            keys = [_key(model, lengths, int(f)) for f in ((frame, other), (other, frame))[place]]
            found.append(_miss(model, keys, place))
        if progress:
            progress(number + 1, count)
    first, last = misses
    return [_figures("first", first), _figures("last", last), _figures("both", first + last)]


def _key(model: KeyframeModel, lengths: Sequence[int], frame: int) -> Key:
    """A key of a frame of the examples, counted from the first on."""
    ends = np.cumsum(lengths)
    number = int(np.searchsorted(ends, frame, side="right"))
    example = model.examples[number]
    second = (frame - int(ends[number]) + lengths[number]) / example.motion.fps
    return key_at(example.motion, second, label=f"{example.take}@{second:.2f}")


def _miss(model: KeyframeModel, keys: Sequence[Key], place: int) -> float | None:
    """How far the frame at a place is missed, metres; None where the pair is refused."""
    try:
        result = model.synthesize(keys)
    except RequestError:
        return None
    return key_miss(result, keys[place], (0, len(result.motion) - 1)[place])


def _figures(place: str, misses: Sequence[float | None]) -> OwnFrames:
    made = np.array([miss for miss in misses if miss is not None])
    refused = len(misses) - len(made)
    if not len(made):
        return OwnFrames(place, len(misses), refused, np.nan, np.nan, np.nan)
    # a nanometre is as far as rounding goes
    median, worst = (round(1000 * float(f(made)), 6) for f in (np.median, np.max))
    return OwnFrames(place, len(misses), refused, float((made > HELD).mean()), median, worst)
