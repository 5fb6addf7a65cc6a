"""Moves and styles by name: the frames of recordings that a person's words pick out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from kinetograph.arrays import BoolArray
from kinetograph.errors import RequestError
from kinetograph.methods.keyframe.examples import Example
from kinetograph.methods.naming import is_called, listed


def named_frames(examples: Sequence[Example], names: Iterable[str]) -> BoolArray:
    """The frames of all examples, laid end to end, that are called by one of some names.

    Parameters
    ----------
    examples : sequence of Example
    names : iterable of str
        Each the name of a take, the label of a move or a style, words of one of these, or a pattern (``turn*``),
        whatever the case. A take's name picks out all of it, a label the span that it is given to.

    Returns
    -------
    ndarray of bool, shape (N,)

    Raises
    ------
    RequestError
        For a name that nothing is called by; the message has what there is.
    """
    wanted = tuple(names)
    for name in wanted:
        if not any(is_called(known, name) for known in known_names(examples)):
            raise RequestError(f"nothing is called {name!r}; there are {listed(known_names(examples))}")
    return np.concatenate([_named_in(example, wanted) for example in examples])


def known_names(examples: Iterable[Example]) -> list[str]:
    """The names of takes, and the labels of moves and styles, sorted."""
    return sorted({name for e in examples for name in (e.take, *(note.label for note in e.labels))})


def _named_in(example: Example, names: Sequence[str]) -> BoolArray:
    """The frames of an example, ``(F,)``, that are called by one of some names."""
    frames = np.arange(len(example.motion)) / example.motion.fps
    if any(is_called(example.take, name) for name in names):
        return np.ones(len(frames), dtype=np.bool_)
    seconds = frames % example.period if example.period else frames
    mask = np.zeros(len(frames), dtype=np.bool_)
    for note in example.labels:
        if any(is_called(note.label, name) for name in names):
            mask |= (seconds >= note.start - 1e-6) & (seconds <= note.stop + 1e-6)
    return mask
