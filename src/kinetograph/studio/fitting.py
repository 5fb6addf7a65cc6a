"""How a request is made in a room: its files, and its models, which are fitted once."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from kinetograph.formats.request_json import LayerRow, Request
from kinetograph.studio.room import FILES, Room

if TYPE_CHECKING:
    from kinetograph.formats import KeySources
    from kinetograph.library import Library
    from kinetograph.methods.performance import PerformanceControl, PerformanceModel
    from kinetograph.pipeline import Fitting
    from kinetograph.post import Layer

_TAKE = "take:"


def require_files(request: Request, room: Room) -> None:
    """Raise RequestError for a file of a request that the project does not have.

    Parameters
    ----------
    request : Request
        Of a section.
    room : Room
    """
    names = [row.pose.rpartition("@")[0] for row in request.keys if not row.pose.startswith(_TAKE)]
    names += [row.motion or row.readings for row in request.layers if not row.motion.startswith(_TAKE)]
    for name in names:
        room.file(name.removeprefix(f"{FILES}/"))


def sources_of(room: Room, library: Library) -> KeySources:
    """Where the files of a request are.

    Parameters
    ----------
    room : Room
    library : Library
    """
    from kinetograph.formats import KeySources

    return KeySources(library, folder=room.folder)


def fitting_of(room: Room) -> Fitting:
    """What fits the models of requests, once.

    Parameters
    ----------
    room : Room
    """
    from kinetograph.pipeline import Fitting, fit_keyframe

    def keyframe(method: Any, library: Library, **given: Any) -> Any:
        return room.fitted(library, ("keyframe", repr(method)), partial(fit_keyframe, method, library, **given))

    return Fitting(partial(_performance, room), keyframe, partial(_layer_of, room))


def _performance(room: Room, method: PerformanceControl, library: Library, **given: Any) -> PerformanceModel:
    """A model, of which all that differ only in what is done with the fitted segments share one fit."""
    from kinetograph.pipeline import fit_performance
    from kinetograph.pipeline.performing import fit_settings, with_method

    plain = fit_settings(method)
    named = ("performance", given.get("track"))
    base = room.fitted(library, (*named, repr(plain)), partial(fit_performance, plain, library, **given))
    if plain == method:
        return base
    return room.fitted(library, (*named, repr(method)), lambda: with_method(base, method))


def _layer_of(room: Room, row: LayerRow, library: Library, sources: KeySources) -> Layer:
    """A layer; what readings sense is sensed once."""
    from kinetograph.pipeline.layer_rows import layer_of

    if not row.readings:
        return layer_of(row, library, sources)
    key = ("layer", row, (sources.folder / row.readings).stat().st_mtime_ns)
    return room.fitted(library, key, lambda: layer_of(row, library, sources))
