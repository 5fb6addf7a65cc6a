"""What is left of a fit without some takes: the same as a fit of the others, without fitting them again."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.left_out import shortened
from kinetograph.library import Library
from kinetograph.methods.performance.fit import fit
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.model import PerformanceModel
from kinetograph.methods.performance.own_cost import own_cost
from kinetograph.methods.performance.segments import Instances, Segment, build_instances
from kinetograph.methods.performance.standing import calmest


def fit_without(
    model: PerformanceModel,
    library: Library,
    takes: Iterable[str],
    *,
    track: str | None = None,
    never: Iterable[str] = (),
) -> PerformanceModel:
    """The model that a fit without some takes would give, bit by bit.

    The library is fitted anew only where what is left cannot be told from a fit of all: clustered segments, takes that
    were brought over from another skeleton, and a library whose first take is left out and whose next is of another
    build.

    Parameters
    ----------
    model : PerformanceModel
        Fitted to the library.
    library : Library
    takes : iterable of str
        Names of takes to leave out.
    track : str, optional
        Name of the track that the model was fitted to.
    never : iterable of str
        Takes of the library that the model was fitted without.

    Returns
    -------
    PerformanceModel

    Raises
    ------
    RequestError
        For a take that is not there, and where no other take has a segment.
    """
    away = frozenset(takes)
    if unknown := sorted(away - set(names := library.names())):
        raise RequestError(f"no take {unknown[0]!r} to leave out; there are {shortened(names) or 'none'}")
    left = without(model.fitted, away)
    if left is None:
        left = fit(model.method, library, exclude=away.union(never), track=track)
    return PerformanceModel(left)


def without(fitted: Fitted, takes: Collection[str]) -> Fitted | None:
    """What is left of a fit without some takes; None where only a fit of the others can tell."""
    if fitted.read is None or fitted.read.brought or fitted.settings.cluster is not None:
        return None
    read = fitted.read.without(takes)
    first = next(iter(read.builds.values()), None)
    stays = np.array([source.take not in takes for source in fitted.sources])
    segments = fitted.instances.segments
    kept = np.array([bool(stays[s.source]) and not s.held for s in segments])
    if not kept.any() or first != next(iter(fitted.read.builds.values())):
        return None
    places = np.cumsum(stays) - 1
    sources = tuple(source for source, stay in zip(fitted.sources, stays, strict=True) if stay)
    read = replace(read, calm=tuple((calm, _moved(pose, places)) for calm, pose in read.calm if stays[pose.source]))
    poses = tuple(pose for _, pose in calmest(read.calm))
    every = (*(_moved(s, places) for s, keep in zip(segments, kept, strict=True) if keep), *poses)
    held = build_instances(sources, poses, fitted.settings.rate, fitted.settings.stretch) if poses else None
    instances = _instances(fitted.instances, kept, every, held)
    unusual = None if fitted.unusual is None else np.concatenate([fitted.unusual[kept], np.zeros(len(poses))])
    own = own_cost(fitted.settings, sources, instances)
    return Fitted(fitted.settings, sources, instances, read.notes, own, read.left_out, unusual, read)


def _moved(segment: Segment, places: np.ndarray) -> Segment:
    return replace(segment, source=int(places[segment.source]))


def _instances(whole: Instances, kept: BoolArray, segments: tuple[Segment, ...], held: Instances | None) -> Instances:
    """The instances of the segments that are kept, and after them those of held poses, which are new."""
    stay = kept[whole.states[:, 0]]
    count = int(kept.sum())
    states = np.stack([(np.cumsum(kept) - 1)[whole.states[stay, 0]], whole.states[stay, 1]], axis=1)
    if held is not None:
        states = np.concatenate([states, held.states + np.array([count, 0])])
        states = states[np.lexsort((states[:, 0], states[:, 1]))]
    controls: dict[int, FloatArray] = {}
    for steps in np.unique(states[:, 1]).tolist():
        parts = [whole.controls[steps][stay[whole.members(steps)]]] if steps in whole.controls else []
        parts += [held.controls[steps]] if held is not None and steps in held.controls else []
        controls[steps] = np.concatenate(parts)
    heads, tails = (
        np.concatenate([each[kept], *([] if held is None else [poses])])
        for each, poses in ((whole.heads, held and held.heads), (whole.tails, held and held.tails))
    )
    return Instances(segments, states, controls, heads, tails)
