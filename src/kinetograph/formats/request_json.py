"""A request as JSON: a control, and all that is asked of a motion along it.

``{"path": "path.csv", "keys": [...], "moves": [...]}``. Times are seconds of the control, places metres in its world
(Y up). A request has

- ``path``: a file of a path (CSV with t, x, z), or its points ``[[t, x, z], ...]``; or ``partner``: a motion file that
  is followed, a walker or a leader; without both, ``keys`` alone are gone between, as the command ``inbetween`` does;
- ``keys``: as in a file of keys (`kinetograph.formats.keys_json`), in order of time. On a control each has a ``time``
  (a second or ``[earliest, latest]``), or a place along the path: ``along``, metres, or ``near``, ``[x, z]``; its own
  ``position`` and ``heading`` are off the path, without them they are those of the path; ``weight`` is what it costs to
  show a recording that differs from it;
- ``moves``: ``{"start": 4, "stop": 7, "name": "run"}``, a name of a take, a tag or a label; or, in place of ``name``,
  ``like``, an example of the motion, ``"take:NAME@2-3.5"`` or ``"FILE@2-3.5"``, and ``within``, metres from it;
  ``forbid`` rules it out;
  with ``weight`` another move costs so much a second; ``first`` and ``last`` are the feet, ``left`` or ``right``, that
  are set down first and last in the span;
- ``pieces``: ``{"start": 1, "stop": 3, "take": "15_03"}``, pinned, or with ``forbid`` ruled out; ``source`` is a second
  of the take that the piece holds, or ``[from, to]`` of the one piece that is meant;
- ``contacts``: ``{"part": "left_foot", "start": 2, "stop": 3}``, a foot or toe that stays where it is;
- ``layers``: parts of the body that something else drives: ``{"parts": ["arms"], "motion": "wave.bvh", "start": 2.5}``;
  in place of the file ``take:NAME``, a take of the library; in place of ``motion`` a file of ``readings``, with the
  ``layout`` of the sensors, or ``keys`` that are gone between; ``library`` where takes and poses come from another one;
  ``second`` and ``seconds``, the part that is used; ``ease``, ``hold``, see `kinetograph.post.Layer`;
- ``library``: its folder, or several; the command's own goes first. ``target``: the track that is made;
- ``mirror``, ``standing``, ``keep_time``, ``smooth_time``, ``smooth_space``, ``facing``, ``onto_path``: as the options
  of ``perform``;
- ``fill``: around keys that no segment is like, recordings are played that have them: where keys ask for places, and
  the path waits meanwhile; with true also for those that ask for times, away from the path; with false for none;
- ``between``: of keys alone, ``moves``, ``without``, ``filler`` and ``force``, as the options of ``inbetween``;
- ``search``: ``continuity``, ``stretch``, ``rate``, ``span``, ``reuse``, ``change``, ``unusual``, ``beam``, likewise.

Files are looked for in the folder of the request.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import msgspec

from kinetograph.formats.atomic import atomic_path
from kinetograph.formats.keys_json import KeyRow
from kinetograph.formats.texts import read_json

EXPECTED = 'a request: {"path": "path.csv", "keys": [{"pose": "take:NAME@SECOND", "time": 4}], ...}'


class _Part(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    pass


class OnPathRow(KeyRow, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A key of a request.

    Parameters
    ----------
    along : float, optional
        Metres along the path at which it is to be met.
    near : tuple of float, (x, z), optional
        It is to be met where the path is nearest to this place.
    weight : float
        What a squared metre costs by which the recording that is shown differs from it.
    """

    along: float | None = None
    near: tuple[float, float] | None = None
    weight: float = 0.2


class MoveRow(_Part, frozen=True):
    """A move that is asked for, or ruled out, in a span.

    Parameters
    ----------
    start, stop : float
        Seconds of the control.
    name : str
        Of a take, a tag or a label, or words or a pattern of one; several with commas between.
    like : str
        An example of it in place of a name: ``"take:NAME@2-3.5"`` or ``"FILE@2-3.5"``, in seconds.
    within : float, optional
        Metres from the example; half the median distance of the library's windows unless given.
    forbid : bool
        Rule it out.
    weight : float, optional
        What a second of something else costs; without it, there is nothing else.
    first, last : str
        The feet that are set down first and last: ``left`` or ``right``; empty where either may be.
    """

    start: float
    stop: float
    name: str = ""
    forbid: bool = False
    weight: float | None = None
    first: Literal["", "left", "right"] = ""
    last: Literal["", "left", "right"] = ""
    like: str = ""
    within: float | None = None


class PieceRow(_Part, frozen=True):
    """A take that is pinned, or ruled out, in a span.

    Parameters
    ----------
    start, stop : float
        Seconds of the control.
    take : str, optional
    source : float or (float, float), optional
        Second of the recording that the piece holds, whichever pieces do; or the seconds that it is from and to.
    forbid : bool
        Rule it out.
    """

    start: float
    stop: float
    take: str | None = None
    source: float | tuple[float, float] | None = None
    forbid: bool = False


class ContactRow(_Part, frozen=True):
    """A foot that stays where it is for a span.

    Parameters
    ----------
    part : str
    start, stop : float
        Seconds of the control.
    """

    part: Literal["left_foot", "right_foot", "left_toe", "right_toe"]
    start: float
    stop: float


class LayerRow(_Part, frozen=True):
    """A part of the body that another control drives: a motion, readings or keys, one of them.

    Parameters
    ----------
    parts : tuple of str
        See `kinetograph.post.Layer`.
    motion : str
        A motion file, or ``"take:NAME"``.
    readings : str
        A file of readings.
    layout : str
        That of the sensors: a preset's name, or a file.
    keys : tuple of KeyRow
        Poses that are gone between, from the layer's start on.
    library : str or tuple of str
        Folders of the library that takes, and poses for readings and keys, are in; the request's unless given.
    start : float
        Seconds of the control.
    second : float
        Second of the motion, the readings or the keys that it begins with.
    seconds : float, optional
        How long it is; to the end unless given.
    ease : float
        Seconds over which it comes and goes.
    hold : bool
        Whether its first and last pose are held instead.
    """

    parts: tuple[str, ...]
    motion: str = ""
    readings: str = ""
    layout: str = "wii"
    keys: tuple[KeyRow, ...] = ()
    library: str | tuple[str, ...] = ()
    start: float = 0.0
    second: float = 0.0
    seconds: float | None = None
    ease: float = 0.3
    hold: bool = False


class BetweenRow(_Part, frozen=True):
    """How keys without a control are gone between.

    Parameters
    ----------
    moves, without : tuple of str
        Go by way of these; use nothing that is called so.
    filler : bool
        Let any recording fill in.
    force : bool
        Make what is worse than recordings are all the same.
    """

    moves: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    filler: bool = False
    force: bool = False


class SearchRow(_Part, frozen=True):
    """The search for segments: what is not given is as by default.

    Parameters
    ----------
    continuity, stretch, rate, span, reuse, change, unusual, beam
        As those of `kinetograph.methods.performance.PerformanceSettings`.
    """

    continuity: float | None = None
    stretch: float | None = None
    rate: float | None = None
    span: int | None = None
    reuse: float | None = None
    change: float | None = None
    unusual: float | None = None
    beam: float | None = None


class Request(_Part, frozen=True):
    """All that is asked of a motion; see this module for the fields.

    Parameters
    ----------
    version : int
        Of this form.
    library : str or tuple of str
        Folders, from that of the request where they are not absolute.
    path : str or tuple of (float, float, float), optional
    partner : str, optional
    target : str
        The library's track that is made.
    keys, moves, pieces, contacts
        What is asked for along the control.
    layers : tuple of LayerRow
        Parts of the body that other controls drive; later ones are on top.
    mirror, standing, keep_time, smooth_time, smooth_space, facing, onto_path
        How the control is followed.
    search : SearchRow
    fill : bool, optional
        Whether spans around keys that no segment is like are filled by the timed search: those of places unless given.
    between : BetweenRow
        How keys alone are gone between.
    """

    version: Literal[1] = 1
    library: str | tuple[str, ...] = ()
    path: str | tuple[tuple[float, float, float], ...] | None = None
    partner: str | None = None
    target: str = ""
    keys: tuple[OnPathRow, ...] = ()
    moves: tuple[MoveRow, ...] = ()
    pieces: tuple[PieceRow, ...] = ()
    contacts: tuple[ContactRow, ...] = ()
    layers: tuple[LayerRow, ...] = ()
    mirror: bool = False
    standing: bool = True
    keep_time: bool = False
    smooth_time: float = 0.0
    smooth_space: float = 0.0
    facing: float | None = None
    onto_path: float | None = None
    search: SearchRow = SearchRow()
    fill: bool | None = None
    between: BetweenRow = BetweenRow()


def read_request(path: str | Path) -> Request:
    """Read a request.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Request

    Raises
    ------
    FormatError
        The file cannot be opened, is not JSON, or has other fields.
    """
    return read_json(Path(path), Request, EXPECTED)


def write_request(request: Request, path: str | Path, *, force: bool = True) -> None:
    """Write a request: the file appears whole or not at all.

    Parameters
    ----------
    request : Request
    path : str or Path
        Its folder exists.
    force : bool
        Write over a file that is there.
    """
    with atomic_path(path, force=force) as draft:
        draft.write_bytes(msgspec.json.format(msgspec.json.encode(request), indent=1) + b"\n")


SECTIONS = frozenset({"mode", "libraries", "walk", "duet", "sensors", "character"})
"""Fields that only projects of the studio have."""


def is_project(path: str | Path) -> bool:
    """Whether a JSON file is a project of the studio and no request: it has sections, or nothing yet."""
    fields = read_json(Path(path), dict, "a project of the studio, or a request")
    return bool(SECTIONS & set(fields)) or isinstance(fields.get("keys"), dict) or not set(fields) - {"version"}
