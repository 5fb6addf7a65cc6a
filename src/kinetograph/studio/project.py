"""A project: what a person has asked for, as one small JSON document.

It holds no motion: the same motions are made from it again, in the studio or by ``kinetograph render``.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import msgspec

from kinetograph.formats.atomic import atomic_path
from kinetograph.formats.request_json import ContactRow, MoveRow, OnPathRow
from kinetograph.formats.texts import read_json

VERSION: Literal[1] = 1

Mode = Literal["walk", "keys", "duet", "sensors"]
"""The sections of a project, one for every kind of control."""


class _Part(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    pass


class RuleRow(_Part, frozen=True):
    """What is pinned or forbidden in a span of a control; see `kinetograph.methods.performance.Rule`."""

    start: float
    stop: float
    take: str | None = None
    source: float | tuple[float, float] | None = None
    forbid: bool = False


class LayerRow(_Part, frozen=True):
    """A part of a walk's body that something else drives.

    Parameters
    ----------
    parts : tuple of str
        See `kinetograph.post.Layer`.
    source : str
        ``"take:NAME"``, or a file of the project: a motion, or readings.
    library : str
        Name of the library that the take, or poses for readings, are in; the first unless given.
    start : float
        Seconds of the walk.
    second : float
        Second of the source that it begins with.
    seconds : float, optional
        How long it is; to the source's end unless given.
    ease : float
        Seconds over which it comes and goes.
    hold : bool
        Whether its first and last pose are held instead.
    """

    parts: tuple[str, ...]
    source: str
    library: str = ""
    start: float = 0.0
    second: float = 0.0
    seconds: float | None = None
    ease: float = 0.3
    hold: bool = False


class Walk(_Part, frozen=True):
    """A drawn path, and how it is walked.

    Parameters
    ----------
    library : str
        Name of one of the project's libraries; the first unless given.
    path : tuple of (float, float, float)
        Seconds, and metres x and z, in order of time.
    smooth_time, smooth_space : float
        Widths of the Gaussians that smooth it, seconds and metres.
    mirror : bool
        Use recordings with left and right exchanged as well.
    keep_time : bool
        Keep its times where it is faster than the recordings.
    facing : float, optional
        Degrees from z to x that the walk begins facing.
    rules : tuple of RuleRow
        What is pinned and forbidden, in seconds of the path.
    layers : tuple of LayerRow
        Parts of the body that something else drives; later ones are on top.
    keys : tuple of OnPathRow
        Poses to pass through on the path; as those of a request, with files of the project.
    moves : tuple of MoveRow
        Moves that are asked for, or ruled out, in spans of the path.
    contacts : tuple of ContactRow
        Feet that stay where they are for a span.
    fill : bool, optional
        Whether spans around keys that no segment is like are filled by recordings that have them: those of keys at
        places unless given.
    """

    library: str = ""
    path: tuple[tuple[float, float, float], ...] = ()
    smooth_time: float = 0.0
    smooth_space: float = 0.0
    mirror: bool = True
    keep_time: bool = False
    facing: float | None = None
    rules: tuple[RuleRow, ...] = ()
    layers: tuple[LayerRow, ...] = ()
    keys: tuple[OnPathRow, ...] = ()
    moves: tuple[MoveRow, ...] = ()
    contacts: tuple[ContactRow, ...] = ()
    fill: bool | None = None


class PartRow(_Part, frozen=True):
    """Where a part of a key's body is to be, as `kinetograph.keys.PartFromRoot` and `PartInWorld` have it.

    Parameters
    ----------
    role : str
    within : str
        What its place is seen from: ``"root"`` or ``"world"``; ``in`` in the document.
    position : (float, float, float), optional
        Metres; as in the pose unless given.
    orientation : (float, float, float, float), optional
        Unit quaternion w, x, y, z of the part's joint; free unless given.
    """

    role: str
    within: Literal["root", "world"] = msgspec.field(name="in")
    position: tuple[float, float, float] | None = None
    orientation: tuple[float, float, float, float] | None = None


class KeyRow(_Part, frozen=True):
    """A key, with the fields of `kinetograph.formats.keys_json`.

    Parameters
    ----------
    pose : str
        ``"take:NAME@SECOND"``, or ``"FILE@SECOND"`` with a file of the project.
    time : float or (float, float), optional
        Seconds after the first key, or a window; free unless given.
    position : (float, float), optional
        Metres x and z of the root.
    heading : float, optional
        Degrees.
    roles : tuple of str, optional
        The parts of the body that count.
    moved : dict of str to (float, float, float)
        Where hands and feet, by role, are put by inverse kinematics: metres from the root's place on the ground, in the
        frame of the root's heading.
    name : str, optional
        What messages call it.
    parts : tuple of PartRow
        Parts that are to be elsewhere than in the pose, each met within 1 mm and half a degree.
    """

    pose: str
    time: float | tuple[float, float] | None = None
    position: tuple[float, float] | None = None
    heading: float | None = None
    roles: tuple[str, ...] | None = None
    moved: dict[str, tuple[float, float, float]] = {}
    name: str | None = None
    parts: tuple[PartRow, ...] = ()


class Lock(_Part, frozen=True):
    """A span of an earlier result that is kept, and what that result was made of."""

    span: tuple[float, float]
    of: Keys


class Keys(_Part, frozen=True):
    """Poses to go through.

    Parameters
    ----------
    library : str
        Name of one of the project's libraries; the first unless given.
    rows : tuple of KeyRow
        In order of time.
    moves, without : tuple of str
        Go by way of these; use nothing that is called so.
    filler : bool
        Let any recording fill in.
    mirror : bool
        Use recordings with left and right exchanged as well.
    alternatives : int
        How many motions are made at most.
    chosen : int
        Which of them is shown and exported, from 0.
    lock : Lock, optional
        What is kept of an earlier result.
    force : bool
        Make what is worse than recordings are, as timings that are too quick make it, all the same.
    """

    library: str = ""
    rows: tuple[KeyRow, ...] = ()
    moves: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    filler: bool = False
    mirror: bool = False
    alternatives: int = 1
    chosen: int = 0
    lock: Lock | None = None
    force: bool = False


class Duet(_Part, frozen=True):
    """A leader, who is answered.

    Parameters
    ----------
    library : str
        Name of one of the project's libraries; the first with partners unless given.
    leader : str
        ``"take:NAME"``, a take of the library, which is then left out of what the follower is made of; or the name of a
        file of the project.
    target : str
        The track of the library that is made.
    mirror : bool
        Use recordings with left and right exchanged as well.
    person : str
        The track that leads, where the take or the file has several people.
    units, up : str
        What a file's lengths are in, and its upward axis; guessed unless given.
    rules : tuple of RuleRow
        What is pinned and forbidden.
    """

    library: str = ""
    leader: str = ""
    target: str = ""
    mirror: bool = False
    person: str = ""
    units: str = ""
    up: str = ""
    rules: tuple[RuleRow, ...] = ()


class Sensors(_Part, frozen=True):
    """Readings of worn sensors.

    Parameters
    ----------
    library : str
        Name of one of the project's libraries; the first unless given.
    readings : str
        The name of a file of the project, or ``"take:NAME"``: readings simulated on a take of the library, which is
        then left out of what the motion is made of.
    layout : str
        ``wii``, ``phone``, ``imu``, ``ideal``, or the name of a file of the project.
    use : tuple of str
        Kinds of columns to use.
    synthesis : str
        ``guided``, ``ridge``, ``continuity``, ``interpolation`` or ``optimisation``.
    track : str
        The library's track to use, where takes have several.
    source : str
        What is listened to live, as ``kinetograph live sense --from`` names it; ``replay:`` with a file of the project.
    names : dict of str to str
        Names of the layout by the names under which sensors are heard.
    """

    library: str = ""
    readings: str = ""
    layout: str = "wii"
    use: tuple[str, ...] = ()
    synthesis: Literal["guided", "ridge", "continuity", "interpolation", "optimisation"] = "guided"
    track: str = ""
    source: str = ""
    names: dict[str, str] = {}


class Project(_Part, frozen=True):
    """What a person has asked for.

    Parameters
    ----------
    version : int
        Of this form.
    mode : str
        The section that is shown.
    libraries : dict of str to str
        Their folders by name, from the project's folder where they are not absolute.
    character : str
        ``""`` for capsules, ``"human"``, or the name of a file of the project.
    walk, keys, duet, sensors
        The sections.
    """

    version: Literal[1] = VERSION
    mode: Mode = "walk"
    libraries: dict[str, str] = {}
    character: str = ""
    walk: Walk = Walk()
    keys: Keys = Keys()
    duet: Duet = Duet()
    sensors: Sensors = Sensors()


def read_project(path: str | Path) -> Project:
    """Read a project.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Project

    Raises
    ------
    FormatError
        The file cannot be opened, or is no project.
    """
    return read_json(Path(path), Project, "a project of the studio")


def write_project(project: Project, path: str | Path) -> None:
    """Write a project: the file appears whole or not at all.

    Parameters
    ----------
    project : Project
    path : str or Path
        Its folder exists.
    """
    with atomic_path(path) as draft:
        draft.write_bytes(msgspec.json.format(msgspec.json.encode(project), indent=1) + b"\n")
