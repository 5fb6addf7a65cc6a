"""Keyframe control from a library and keys to results: keys, method, motions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.library import Library, Selection, facts_of, kept, labels
from kinetograph.methods.keyframe import KeyframeControl, KeyframeModel, TimedSearch
from kinetograph.methods.naming import is_called
from kinetograph.methods.recordings import LABELS
from kinetograph.pipeline.libraries import open_library
from kinetograph.pipeline.noting import noted
from kinetograph.post import PostSettings
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


def fit_keyframe(
    method: KeyframeControl,
    library: Library,
    *,
    exclude: Iterable[str] = (),
    track: str | None = None,
    seed: int = 0,
    note: Callable[[str], None] | None = None,
) -> KeyframeModel:
    """As `KeyframeControl.fit`, but only where it has not been done before.

    Parameters
    ----------
    method : KeyframeControl
        How keys are gone between is no reason to fit again, and the index of the frames is the same for all moves.
    library : Library
    exclude : iterable of str
        Names of takes to leave out.
    track : str, optional
        Name of the motions' track; needed where takes have several motions.
    seed : int
        Of the cluster chain's clusters.
    note : callable, optional
        Called with one line where what was learned cannot be kept; see `kinetograph.library.kept`.

    Returns
    -------
    KeyframeModel

    Raises
    ------
    RequestError
        As `KeyframeControl.fit`.
    """
    left_out, solver = tuple(exclude), method.solver
    timed = isinstance(solver, TimedSearch)  # which leaves nothing to chance
    plain = replace(
        method, solver=solver.everyday() if isinstance(solver, TimedSearch) else solver, post=PostSettings()
    )

    def make() -> KeyframeModel:
        return plain.fit(library, exclude=left_out, track=track, rng=np.random.default_rng(seed))

    model = kept(library, "keyframe", (plain, left_out, track, 0 if timed else seed), make, note=note)
    fitted: Any = model.fitted
    if isinstance(solver, TimedSearch):
        fitted = solver.refit(model.examples, fitted)
    return replace(model, method=method, fitted=fitted)


def inbetween_with(model: KeyframeModel, keys: tuple[Key, ...], count: int = 1) -> tuple[Synthesis, ...]:
    """Motions through keys by a fitted model, whose notes are among the warnings; see `inbetween`."""
    if count < 1:
        raise RequestError(f"alternatives are 1 motion or more, found {count}")
    made = model.alternatives(keys, count) if count > 1 else (model.synthesize(keys),)
    return tuple(noted(each, model.notes, model.left_out) for each in made)


def open_without_labels(
    path: str | Path | Sequence[str | Path], selection: Selection
) -> tuple[Library, tuple[str, ...]]:
    """Open a library for a search that leaves out moves and styles as well as takes.

    Parameters
    ----------
    path : str or Path, or a sequence of them
        See `open_library`.
    selection : Selection
        What it leaves out may also be words of a take's name, or of a move or a style.

    Returns
    -------
    library : Library
        Without the takes that have one of the names or tags.
    without : tuple of str
        What the search itself leaves out: what is no name or tag, or also a move or a style of another take.
    """
    unknown = selection.unknown(facts_of(open_library(path)))
    takes = tuple(name for name in selection.without if name not in unknown)
    library = open_library(path, replace(selection, without=takes))
    notes = {label for of in labels(library).values() for kind, label in of if kind in LABELS}
    known = (*library.names(), *notes)
    return library, tuple(w for w in selection.without if w in unknown or any(is_called(name, w) for name in known))
