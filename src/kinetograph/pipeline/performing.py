"""Performance control from a library and a control to a result: control, method, motion."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kinetograph.library import Library, kept
from kinetograph.methods.performance import (
    PerformanceControl,
    PerformanceModel,
    Rule,
    only_track,
    smooth_path,
    with_settings,
)
from kinetograph.motion import Motion
from kinetograph.pipeline.noting import noted
from kinetograph.post import PostSettings
from kinetograph.progress import Progress
from kinetograph.signal import Signal
from kinetograph.synthesis import Synthesis
from kinetograph.take import Take


@dataclass(frozen=True)
class Smoothing:
    """How a drawn path is smoothed before it is performed.

    Parameters
    ----------
    time : float
        Width of a Gaussian over time, seconds; 0 for none.
    space : float
        Width of a Gaussian over the shape, metres; 0 for none.
    """

    time: float = 0.0
    space: float = 0.0


def perform(
    control: Take | Signal | Motion,
    library: Library,
    method: PerformanceControl | None = None,
    *,
    smoothing: Smoothing | None = None,
    rules: Sequence[Rule] = (),
    progress: Progress | None = None,
) -> Synthesis:
    """The main job: a walker, made of the library's recordings, performs a control.

    To leave takes out, to make one of several tracks, or to use one model again, fit the method and see `perform_with`.

    Parameters
    ----------
    control : Take or Signal or Motion
        A path, or a walker's or partner's motion; a take has one track.
    library : Library
    method : PerformanceControl, optional
    smoothing : Smoothing, optional
        Of a drawn path.
    rules : sequence of Rule
        What is pinned or forbidden.
    progress : Progress, optional
        Called with the steps done and their number.

    Returns
    -------
    Synthesis

    Raises
    ------
    RequestError
        For a control that cannot be performed; see `PerformanceModel.synthesize`.
    """
    model = (method or PerformanceControl()).fit(library)
    return perform_with(model, control, smoothing=smoothing, rules=rules, progress=progress)


def fit_performance(
    method: PerformanceControl,
    library: Library,
    *,
    exclude: Iterable[str] = (),
    track: str | None = None,
    note: Callable[[str], None] | None = None,
) -> PerformanceModel:
    """As `PerformanceControl.fit`, but only where it has not been done before.

    Parameters
    ----------
    method : PerformanceControl
        What is done afterwards with the segments that are found is no reason to fit again.
    library : Library
    exclude : iterable of str
        Names of takes to leave out.
    track : str, optional
        Name of the track to make, where takes have several motions.
    note : callable, optional
        Called with one line where what was learned cannot be kept; see `kinetograph.library.kept`.

    Returns
    -------
    PerformanceModel

    Raises
    ------
    RequestError
        As `PerformanceControl.fit`.
    """
    left_out, plain = tuple(exclude), fit_settings(method)

    def make() -> PerformanceModel:
        return _with_properties(plain.fit(library, exclude=left_out, track=track))

    return with_method(kept(library, "performance", (plain, left_out, track), make, note=note), method)


def fit_settings(method: PerformanceControl) -> PerformanceControl:
    """The configuration that is fitted for another one: what is done with the fitted segments is as by default.

    Parameters
    ----------
    method : PerformanceControl
    """
    later = {name: getattr(PerformanceControl(), name) for name in ("beam", "fine_rate", "keep_time", "first_facing")}
    return replace(method, post=PostSettings(), **later)


def with_method(model: PerformanceModel, method: PerformanceControl) -> PerformanceModel:
    """A fitted model with another configuration of which `fit_settings` are the same.

    Parameters
    ----------
    model : PerformanceModel
    method : PerformanceControl
    """
    return replace(model, fitted=with_settings(model.fitted, method))


def _with_properties(model: PerformanceModel) -> PerformanceModel:
    """The model once all that its fit computes on first use has been computed."""
    for name, what in vars(type(model.fitted)).items():
        if isinstance(what, cached_property):
            getattr(model.fitted, name)
    return model


def perform_with(
    model: PerformanceModel,
    control: Take | Signal | Motion,
    *,
    smoothing: Smoothing | None = None,
    rules: Sequence[Rule] = (),
    progress: Progress | None = None,
) -> Synthesis:
    """Perform a control with a fitted model, whose notes are among the warnings; see `perform`."""
    return noted(model.synthesize(smoothed(control, smoothing), progress, rules), model.notes, model.fitted.left_out)


def perform_alternatives(
    model: PerformanceModel,
    control: Take | Signal | Motion,
    count: int,
    *,
    alike: bool = False,
    smoothing: Smoothing | None = None,
    rules: Sequence[Rule] = (),
) -> tuple[Synthesis, ...]:
    """The best performance of a control and up to ``count`` - 1 others.

    Parameters
    ----------
    model : PerformanceModel
    control : Take or Signal or Motion
    count : int
    alike : bool
        Whether the others may share pieces with the best; see `PerformanceModel.alternatives`.
    smoothing : Smoothing, optional
        Of a drawn path.
    rules : sequence of Rule
        What is pinned or forbidden.

    Returns
    -------
    tuple of Synthesis

    Raises
    ------
    RequestError
        For a control that cannot be performed.
    """
    results = model.alternatives(smoothed(control, smoothing), count, rules, alike=alike)
    return tuple(noted(each, model.notes, model.fitted.left_out) for each in results)


def smoothed(control: Take | Signal | Motion, smoothing: Smoothing | None) -> Take | Signal | Motion:
    """The control that is performed: a drawn path is smoothed, anything else stays as it is."""
    wanted = only_track(control) if isinstance(control, Take) else control
    if isinstance(wanted, Signal) and smoothing:
        return smooth_path(wanted, smoothing.time, smoothing.space)
    return control


def winding_path(speed: float = 0.95, fps: float = 30.0) -> Signal:
    """The demo's path, which turns left and right and is about 18 m long.

    Parameters
    ----------
    speed : float
        Metres per second.
    fps : float

    Returns
    -------
    Signal
    """
    from scipy.interpolate import CubicSpline

    corners = np.array([(0, 0), (2, 0.3), (3.5, 2), (2.5, 4), (0.5, 4.5), (-1, 6), (0, 8), (2.5, 8.5)], dtype=float)
    dense = CubicSpline(np.arange(len(corners)), corners)(np.linspace(0, len(corners) - 1, 4000))
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(dense, axis=0), axis=1))])
    even = np.linspace(0, along[-1], int(along[-1] / speed * fps) + 1)
    x, z = (np.interp(even, along, dense[:, i]) for i in (0, 1))
    return Signal(np.stack([x, np.zeros_like(x), z], axis=-1)[:, None], ("path",), "m", fps)
