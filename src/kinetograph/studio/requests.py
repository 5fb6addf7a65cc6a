"""Sections of a project as requests, and requests as sections."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

from kinetograph.errors import RequestError
from kinetograph.formats.keys_json import PartRow
from kinetograph.formats.request_json import BetweenRow, LayerRow, OnPathRow, PieceRow, Request
from kinetograph.studio.project import KeyRow, Keys, Project, RuleRow, Walk
from kinetograph.studio.project import LayerRow as StudioLayer
from kinetograph.studio.project import PartRow as StudioPart
from kinetograph.studio.room import FILES, plain_name

_TAKE = "take:"


def request_of(project: Project) -> Request:
    """The section that is shown as a request, whose folder is that of the project.

    Parameters
    ----------
    project : Project

    Returns
    -------
    Request

    Raises
    ------
    RequestError
        For what no request can ask for.
    """
    if project.mode == "walk":
        return walk_request(project)
    if project.mode == "keys":
        return keys_request(project)
    raise RequestError(f"the section {project.mode} cannot be written as a request; walk and keys can")


def walk_request(project: Project) -> Request:
    """The walk of a project as a request.

    Parameters
    ----------
    project : Project
    """
    walk = project.walk
    library = _folder(project, walk.library)
    return Request(
        library=library,
        path=walk.path,
        keys=tuple(_posed(row) for row in walk.keys),
        moves=walk.moves,
        pieces=tuple(PieceRow(r.start, r.stop, r.take, r.source, r.forbid) for r in walk.rules),
        contacts=walk.contacts,
        layers=tuple(_layer(row, project, library) for row in walk.layers),
        mirror=walk.mirror,
        keep_time=walk.keep_time,
        smooth_time=walk.smooth_time,
        smooth_space=walk.smooth_space,
        facing=walk.facing,
        fill=walk.fill,
    )


def keys_request(project: Project) -> Request:
    """The keys of a project as a request; its alternatives are what ``render --alternatives`` makes of it.

    Parameters
    ----------
    project : Project

    Raises
    ------
    RequestError
        For a span that is locked, and for hands and feet that are moved, which no request has.
    """
    keys = project.keys
    if keys.lock is not None:
        raise RequestError("a request has no locked span; unlock it first")
    return Request(
        library=_folder(project, keys.library),
        keys=tuple(_key(row) for row in keys.rows),
        mirror=keys.mirror,
        between=BetweenRow(keys.moves, keys.without, keys.filler, keys.force),
    )


def _folder(project: Project, name: str) -> str:
    """The folder of a library of a project. Raises RequestError where there is none of that name."""
    libraries = project.libraries
    if not libraries:
        raise RequestError("the project has no library; name one: kinetograph studio LIBRARY")
    if name and name not in libraries:
        raise RequestError(f"the project has no library {name!r}; it has {', '.join(sorted(libraries))}")
    return libraries[name or next(iter(libraries))]


def _posed(row: OnPathRow) -> OnPathRow:
    return msgspec.structs.replace(row, pose=_pose(row.pose))


def _pose(pose: str) -> str:
    """A pose in a file of the project, from the project's folder."""
    name, at, second = pose.rpartition("@")
    return pose if not at or pose.startswith(_TAKE) else f"{FILES}/{plain_name(name)}@{second}"


def _key(row: KeyRow) -> OnPathRow:
    if row.moved:
        raise RequestError(
            f"{row.name or row.pose}: a request has no hands and feet that are moved; put them elsewhere as parts"
        )
    parts = tuple(PartRow(p.role, p.within, p.position, p.orientation) for p in row.parts)
    return OnPathRow(_pose(row.pose), row.time, row.position, row.heading, row.roles, parts, name=row.name)


def _layer(row: StudioLayer, project: Project, own: str) -> LayerRow:
    library = _folder(project, row.library)
    source = row.source if row.source.startswith(_TAKE) else f"{FILES}/{plain_name(row.source)}"
    sensed = row.source.lower().endswith(".csv")
    return LayerRow(
        row.parts,
        motion="" if sensed else source,
        readings=source if sensed else "",
        library=() if library == own else library,
        start=row.start,
        second=row.second,
        seconds=row.seconds,
        ease=row.ease,
        hold=row.hold,
    )


# ---- requests as sections ----


@dataclass(frozen=True)
class Taken:
    """A request that becomes a section of a project.

    Parameters
    ----------
    request : Request
    folder : Path
        Of the request: its files are looked for there.
    base : Path
        Of the project: they are copied into its files.
    """

    request: Request
    folder: Path
    base: Path

    def file(self, name: str) -> str:
        """The name under which a file is one of the project's."""
        source, target = self.folder / name, self.base / FILES / plain_name(Path(name).name)
        if not source.is_file():
            raise RequestError(f"{source}: there is no such file")
        if target.exists() and target.read_bytes() != source.read_bytes():
            raise RequestError(f"the project has another file {target.name!r}; rename one of them")
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists():
            shutil.copyfile(source, target)
        return target.name

    def pose(self, pose: str) -> str:
        """A pose, in a file of the project."""
        name, at, second = pose.rpartition("@")
        return pose if not at or pose.startswith(_TAKE) else f"{self.file(name)}@{second}"


def with_request(project: Project, taken: Taken) -> Project:
    """A project whose walk, or whose keys, are those of a request, and are shown.

    Parameters
    ----------
    project : Project
    taken : Taken

    Returns
    -------
    Project
        Its first library is that of the request.

    Raises
    ------
    RequestError
        For what the studio has no place for, and for files that are not there.
    FormatError
        For a path that cannot be read.
    """
    request = taken.request
    _require_known(request)
    libraries, names = _with_folders(project, taken)
    if request.path is None:
        keys = tuple(_studio_key(row, taken) for row in request.keys)
        row = request.between
        section = Keys(names[0], keys, row.moves, row.without, row.filler, request.mirror, force=row.force)
        return msgspec.structs.replace(project, mode="keys", libraries=libraries, keys=section)
    return msgspec.structs.replace(project, mode="walk", libraries=libraries, walk=_walk(taken, names))


def _walk(taken: Taken, names: Sequence[str]) -> Walk:
    request = taken.request
    assert request.path is not None
    return Walk(
        library=names[0],
        path=_points(request.path, taken.folder),
        smooth_time=request.smooth_time,
        smooth_space=request.smooth_space,
        mirror=request.mirror,
        keep_time=request.keep_time,
        facing=request.facing,
        rules=tuple(RuleRow(p.start, p.stop, p.take, p.source, p.forbid) for p in request.pieces),
        layers=tuple(_studio_layer(row, name, taken) for row, name in zip(request.layers, names[1:], strict=True)),
        keys=tuple(msgspec.structs.replace(row, pose=taken.pose(row.pose)) for row in request.keys),
        moves=request.moves,
        contacts=request.contacts,
        fill=request.fill,
    )


def _require_known(request: Request) -> None:
    """Raise RequestError for what the studio has no place for."""
    plain = Request()
    for name in ("partner", "target", "standing", "onto_path", "search"):
        if getattr(request, name) != getattr(plain, name):
            raise RequestError(f"the studio has no place for {name!r} of a request; make it with kinetograph render")
    if any(row.keys or row.layout != LayerRow(()).layout for row in request.layers):
        raise RequestError("the studio has no layers of keys or of other layouts; make it with kinetograph render")
    if request.path is None and not request.keys:
        raise RequestError("the request asks for nothing: give it a path, a partner or keys")


def _with_folders(project: Project, taken: Taken) -> tuple[dict[str, str], list[str]]:
    """The project's libraries with those of a request, and what the project calls that of the request and of layers."""
    own = _one(taken.request.library)
    folders = [own, *(_one(row.library or own) for row in taken.request.layers)]
    libraries, names = dict[str, str](), list[str]()
    for folder in folders:
        whole = (taken.folder / folder).resolve()
        base = taken.base.resolve()
        place = str(whole.relative_to(base)) if whole.is_relative_to(base) else str(whole)
        known = {**libraries, **project.libraries}
        there = next((name for name, each in known.items() if each == place), None)
        name = there or next(n for n in (whole.stem, *(f"{whole.stem} {i}" for i in range(2, 99))) if n not in known)
        libraries[name] = place
        names.append(name)
    return {**libraries, **{name: place for name, place in project.libraries.items() if name not in libraries}}, names


def _one(library: str | tuple[str, ...]) -> str:
    folders = (library,) if isinstance(library, str) else library
    if len(folders) != 1:
        raise RequestError(f"a section of the studio has one library, the request {len(folders)}; name one with -l")
    return folders[0]


def _points(path: str | tuple[tuple[float, float, float], ...], folder: Path) -> tuple[tuple[float, float, float], ...]:
    if not isinstance(path, str):
        return path
    from kinetograph.formats import load
    from kinetograph.methods.performance import only_track
    from kinetograph.signal import Signal

    signal = only_track(load(folder / path))
    if not isinstance(signal, Signal):
        raise RequestError(f"{path}: the studio draws paths, found a motion; make it with kinetograph render")
    points = signal.values[:, 0].tolist()
    return tuple((round(i / signal.fps, 6), x, z) for i, (x, _, z) in enumerate(points))


def _studio_key(row: OnPathRow, taken: Taken) -> KeyRow:
    if any(getattr(row, name) is not None for name in ("track", "units", "up", "fps", "along", "near")):
        raise RequestError(f"{row.name or row.pose}: the studio's keys have a time, and files that say what they mean")
    parts = tuple(StudioPart(p.role, p.within, p.position, p.orientation) for p in row.parts)
    return KeyRow(taken.pose(row.pose), row.time, row.position, row.heading, row.roles, name=row.name, parts=parts)


def _studio_layer(row: LayerRow, library: str, taken: Taken) -> StudioLayer:
    given = row.motion or row.readings
    source = given if given.startswith(_TAKE) else taken.file(given)
    return StudioLayer(row.parts, source, library, row.start, row.second, row.seconds, row.ease, row.hold)
