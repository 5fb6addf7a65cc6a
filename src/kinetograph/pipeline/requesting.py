"""A request from its document to a result: control, keys, moves, method, motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

import msgspec

from kinetograph.errors import RequestError
from kinetograph.formats import KeySources
from kinetograph.formats.csv import path_of
from kinetograph.formats.keys_json import key_of_row
from kinetograph.formats.request_json import ContactRow, LayerRow, MoveRow, OnPathRow, Request
from kinetograph.library import Library
from kinetograph.methods.keyframe import KeyframeControl, KeyframeModel, TimedSearch
from kinetograph.methods.performance import (
    FIRST_FACING,
    PerformanceControl,
    PerformanceModel,
    Rule,
    begin_facing,
    partner_control,
    read_control,
    smooth_path,
)
from kinetograph.methods.together import (
    Asked,
    AskedKey,
    Keyframes,
    Several,
    Span,
    performed,
    performed_several,
)
from kinetograph.motion import Motion
from kinetograph.pipeline.inbetweening import fit_keyframe, inbetween_with
from kinetograph.pipeline.layer_rows import layer_of, motion_or_path
from kinetograph.pipeline.layering import layered, recordings_of
from kinetograph.pipeline.libraries import has_partners
from kinetograph.pipeline.likeness import spans_like
from kinetograph.pipeline.noting import noted
from kinetograph.pipeline.performing import fit_performance
from kinetograph.post import Layer, OntoPath
from kinetograph.progress import Progress
from kinetograph.signal import Signal
from kinetograph.synthesis import Synthesis
from kinetograph.take import Annotation

Note = Callable[[str], None]
"""Is called with one line for each thing that a person should know."""


@dataclass(frozen=True, eq=False)
class Rendered:
    """What was made of a request.

    Parameters
    ----------
    synthesis : Synthesis
    control : Signal or Motion, optional
        What was performed; None where keys alone were gone between.
    model : PerformanceModel or KeyframeModel
        What made it.
    asked : Asked
        What was asked for along the control.
    """

    synthesis: Synthesis
    control: Signal | Motion | None
    model: PerformanceModel | KeyframeModel
    asked: Asked = field(default_factory=Asked)


@dataclass(frozen=True)
class Fitting:
    """What fits the models that make requests; a program that goes on running keeps what it has fitted.

    Parameters
    ----------
    performance : callable
        Called as `fit_performance`.
    keyframe : callable
        Called as `fit_keyframe`.
    layer : callable
        Called as ``kinetograph.pipeline.layer_rows.layer_of``.
    """

    performance: Callable[..., PerformanceModel] = fit_performance
    keyframe: Callable[..., KeyframeModel] = fit_keyframe
    layer: Callable[[LayerRow, Library, KeySources], Layer] = layer_of


FITTING = Fitting()


def perform_asked(
    model: PerformanceModel,
    control: Signal | Motion,
    asked: Asked,
    progress: Progress | None = None,
    keyframes: Keyframes | None = None,
) -> Synthesis:
    """Perform a control through keys and by moves with a fitted model, whose notes are among the warnings.

    Parameters
    ----------
    model : PerformanceModel
    control : Signal or Motion
    asked : Asked
        Nothing gives what `perform_with` does.
    progress : Progress, optional
        Called with the steps done and their number.
    keyframes : callable, optional
        For spans around keys that no segment is like; see `filler`.

    Raises
    ------
    RequestError
        See `kinetograph.methods.together.performed`.
    """
    return noted(performed(model, control, asked, progress, keyframes), model.notes, model.fitted.left_out)


def perform_several(
    model: PerformanceModel,
    control: Signal | Motion,
    asked: Asked,
    several: Several,
    keyframes: Keyframes | None = None,
) -> tuple[Synthesis, ...]:
    """The best motion of `perform_asked`, and others that meet the same keys.

    Parameters
    ----------
    model : PerformanceModel
    control : Signal or Motion
    asked : Asked
    several : Several
    keyframes : callable, optional
        See `perform_asked`.

    Raises
    ------
    RequestError
        See `kinetograph.methods.together.performed`.
    """
    found = performed_several(model, control, asked, several, keyframes)
    return tuple(noted(each, model.notes, model.fitted.left_out) for each in found)


def filler(
    model: PerformanceModel,
    library: Library,
    *,
    exclude: Iterable[str] = (),
    track: str | None = None,
    note: Note | None = None,
    fit: Callable[..., KeyframeModel] = fit_keyframe,
) -> Keyframes:
    """What fits keyframe control to the library of a performance, once it is needed to fill spans around keys.

    Parameters
    ----------
    model : PerformanceModel
        The performance.
    library : Library
    exclude : iterable of str
        Names of takes to leave out.
    track : str, optional
        Name of the motions' track; needed where takes have several motions.
    note : callable, optional
        Called with one line where what was learned cannot be kept.
    fit : callable
        Called as `fit_keyframe`.

    Returns
    -------
    callable
    """
    method = KeyframeControl(mirror=model.method.mirror, bodies=model.method.bodies)
    left_out = tuple(exclude)
    return lambda: fit(method, library, exclude=left_out, track=track, note=note)


def render_request(
    request: Request,
    library: Library,
    sources: KeySources,
    progress: Progress | None = None,
    fitting: Fitting = FITTING,
) -> Rendered:
    """Make what a request asks for.

    Parameters
    ----------
    request : Request
    library : Library
    sources : KeySources
        Where files are, and how they are read.
    progress : Progress, optional
        Called with the steps done and their number.
    fitting : Fitting
        What fits the models.

    Raises
    ------
    RequestError
        For what cannot be made, with what could.
    FormatError
        For a file that cannot be read.
    """
    return _made(request, library, sources, Several(), progress, fitting)[0]


def render_alternatives(
    request: Request, library: Library, sources: KeySources, several: Several, fitting: Fitting = FITTING
) -> tuple[Rendered, ...]:
    """The best motion that a request asks for, and others that meet the same keys.

    Parameters
    ----------
    request : Request
    library : Library
    sources : KeySources
        Where files are, and how they are read.
    several : Several
    fitting : Fitting
        What fits the models.

    Returns
    -------
    tuple of Rendered
        The best first; fewer than were asked for where there are no others.

    Raises
    ------
    RequestError, FormatError
        As `render_request`.
    """
    return _made(request, library, sources, several, None, fitting)


def _made(
    request: Request,
    library: Library,
    sources: KeySources,
    several: Several,
    progress: Progress | None,
    fitting: Fitting,
) -> tuple[Rendered, ...]:
    layers = [fitting.layer(row, library, sources) for row in request.layers]
    if request.path is None and request.partner is None:
        made = _keys_only(request, library, sources, several, fitting)
    else:
        made = _on_control(request, library, sources, several, progress, fitting)
    return tuple(_with_layers(each, layers) for each in made)


def _with_layers(made: Rendered, layers: Sequence[Layer]) -> Rendered:
    if not layers:
        return made
    return replace(made, synthesis=layered(made.synthesis, layers, recordings_of(made.model, made.synthesis)))


def _on_control(
    request: Request,
    library: Library,
    sources: KeySources,
    several: Several,
    progress: Progress | None,
    fitting: Fitting,
) -> tuple[Rendered, ...]:
    """What follows a path or a partner."""
    control, track = control_of(request, sources), request.target or None
    method = method_of(request, has_partners(library, track))
    asked = asked_of(request, sources)
    read_control(method, control)  # what cannot be performed is refused before the library is read
    model = fitting.performance(method, library, track=track, note=sources.note)
    keyframes = filler(model, library, track=track, note=sources.note, fit=fitting.keyframe)
    if several.count == 1:
        found: tuple[Synthesis, ...] = (perform_asked(model, control, asked, progress, keyframes),)
    else:
        found = perform_several(model, control, asked, several, keyframes)
    return tuple(Rendered(each, control, model, asked) for each in found)


def control_of(request: Request, sources: KeySources) -> Signal | Motion:
    """The path or the partner of a request, as it is performed.

    Parameters
    ----------
    request : Request
    sources : KeySources
        Where its files are, and how they are read.

    Raises
    ------
    RequestError
        For a request that has both, and for points that are no path.
    FormatError
        For a file that cannot be read.
    """
    if request.path is not None and request.partner is not None:
        raise RequestError("a request has a path or a partner, found both; leave one out")
    given = request.path if request.partner is None else request.partner
    assert given is not None
    control = motion_or_path(given, sources) if isinstance(given, str) else path_of(given, "the path")
    if not isinstance(control, Signal):
        if request.facing is not None:
            raise RequestError("facing is for a drawn path; a motion faces by itself")
        return control
    path = smooth_path(control, request.smooth_time, request.smooth_space)
    return path if request.facing is None else begin_facing(path, math.radians(request.facing))


def method_of(request: Request, partners: bool) -> PerformanceControl:
    """The configuration of a request.

    Parameters
    ----------
    request : Request
    partners : bool
        Whether the library's takes have partners.
    """
    method = partner_control() if partners else PerformanceControl()
    search = msgspec.structs.asdict(request.search)
    given = {name: value for name, value in search.items() if value is not None}
    post = method.post if request.onto_path is None else replace(method.post, onto_path=OntoPath(request.onto_path))
    return replace(
        method,
        post=post,
        **given,
        mirror=request.mirror,
        stand=request.standing,
        keep_time=request.keep_time,
        first_facing=0.0 if request.facing is None else FIRST_FACING,
    )


def between_method(request: Request) -> KeyframeControl:
    """The configuration by which a request's keys are gone between: that of ``inbetween``.

    Parameters
    ----------
    request : Request
    """
    row = request.between
    search = TimedSearch(moves=row.moves, without=row.without, force_timing=row.force)
    search = replace(search, begin_unasked=0.0, unasked=0.0) if row.filler else search
    return KeyframeControl(solver=search, mirror=request.mirror)


def asked_of(request: Request, sources: KeySources) -> Asked:
    """What a request asks for along its control.

    Parameters
    ----------
    request : Request
    sources : KeySources
        Where the poses of its keys are.

    Raises
    ------
    RequestError
        For poses that are not there, and for values out of range.
    """
    pins = tuple(Rule(p.start, p.stop, take=p.take, source=p.source, forbid=p.forbid) for p in request.pieces)
    return Asked(
        tuple(asked_key(row, f"key {number}", sources) for number, row in enumerate(request.keys, start=1)),
        (*pins, *(rule for row in request.moves for rule in rules_of(row, sources, mirror=request.mirror))),
        tuple(Span(row.start, row.stop, row.first, row.last) for row in request.moves if row.first or row.last),
        tuple(_contact(row) for row in request.contacts),
        fill=request.fill,
    )


def asked_key(row: OnPathRow, label: str, sources: KeySources) -> AskedKey:
    """The key of a row, and where on the path it is.

    Parameters
    ----------
    row : OnPathRow
    label : str
        What messages call it unless it has a name.
    sources : KeySources
    """
    return AskedKey(key_of_row(row, row.name or label, sources), row.along, row.near, row.weight)


def rules_of(row: MoveRow, sources: KeySources, *, mirror: bool = False) -> tuple[Rule, ...]:
    """What a row asks of the moves in its span, besides its feet.

    Parameters
    ----------
    row : MoveRow
    sources : KeySources
        The library in which windows are like an example, and where its file is.
    mirror : bool
        Whether mirrored recordings are used.

    Raises
    ------
    RequestError
        For a row that asks for nothing, or for a name and an example; and where nothing is like an example.
    """
    if row.name and row.like:
        raise RequestError(f"a move has a name or an example, found {row.name!r} and {row.like!r}; ask twice for both")
    if row.within is not None and not row.like:
        raise RequestError(f"within is of a move with an example; the one from {row.start:g} s has none")
    if row.like:
        return (_rule_like(row, sources, mirror),)
    if not row.name:
        if not (row.first or row.last):
            raise RequestError(f"a move has a name, or a first or last foot; the one from {row.start:g} s has none")
        return ()
    return (Rule(row.start, row.stop, called=row.name, forbid=row.forbid, weight=row.weight),)


def _rule_like(row: MoveRow, sources: KeySources, mirror: bool) -> Rule:
    """The rule of a row that has an example."""
    library = sources.library
    if not isinstance(library, Library):
        raise RequestError(f"like {row.like}: what is like an example is found in a library, and none was given")
    rule = Rule(row.start, row.stop, forbid=row.forbid, weight=row.weight, like=row.like)
    text = row.like if row.like.startswith("take:") else str(sources.folder / row.like)
    found = spans_like(text, library, row.within, mirrored=mirror, options=sources.options)
    return replace(rule, spans=found)


def _contact(row: ContactRow) -> Annotation:
    if not 0 <= row.start < row.stop:
        raise RequestError(f"a contact runs from a start to a later stop, found {row.start:g} and {row.stop:g}")
    return Annotation("motion", "contact", row.part, row.start, row.stop)


def _keys_only(
    request: Request, library: Library, sources: KeySources, several: Several, fitting: Fitting
) -> tuple[Rendered, ...]:
    """Keys without a control are gone between, as the command inbetween does."""
    for name in ("moves", "pieces", "contacts"):
        if getattr(request, name):
            raise RequestError(f"{name} are in spans of a path or a partner, and the request has neither")
    for number, row in enumerate(request.keys, start=1):
        if row.along is not None or row.near is not None:
            raise RequestError(f"{row.name or f'key {number}'}: a place along the path, and the request has no path")
    if not request.keys:
        raise RequestError("the request asks for nothing: give it a path, a partner or keys")
    keys = tuple(key_of_row(row, row.name or f"key {number}", sources) for number, row in enumerate(request.keys, 1))
    method = between_method(request)
    model = fitting.keyframe(method, library, track=request.target or None, note=sources.note)
    return tuple(Rendered(each, None, model) for each in inbetween_with(model, keys, several.count))
