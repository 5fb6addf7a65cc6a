"""Commands on files: info and convert."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.characters import AnotherBody, body, dressed, with_handholds
from kinetograph.cli.markers import fitted, list_residuals, residuals, wants_motion
from kinetograph.cli.options import AsJson, Force, add, options
from kinetograph.cli.output import note, notes, refuse_existing, result, table
from kinetograph.cli.reading import Everything, FitMarkers, Lenient, LenientReading, Markers, Reading, read_file
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.motion import Motion
    from kinetograph.take import Annotation, Take, Track


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    for command in (info, convert):
        add(app, command, panel="Files")


# ---- info ----


def info(
    files: Annotated[list[Path], typer.Argument(help="Motion or signal files.")],
    reading: LenientReading,
    joints: Annotated[bool, typer.Option("--joints", help="List every joint with its parent and role.")] = False,
    as_json: AsJson = False,
) -> None:
    """Show what is in files: skeleton, roles, frames, rate, duration, units and axes, and the names of animations.

    Example: kinetograph info out/walk.bvh --joints
    """
    from kinetograph.formats import read

    rows = []
    for path in files:
        loaded = read(path, reading.read_options)
        for name, track in loaded.take.tracks.items():
            rows.append(_describe(path, name, track) | ({"animations": list(loaded.animations)} if as_json else {}))
            if joints and not as_json:
                _list_joints(track)
        notes((*loaded.notes, *_missing_roles(loaded.take)), path)
        if reading.animation is not None and len(loaded.animations) > 1:
            note(f"{path}: its animations are {', '.join(map(repr, loaded.animations))}")
    table(rows, as_json)


def _missing_roles(take: Take) -> list[str]:
    """The roles that no joint of a body plays, once for all bodies that lack the same."""
    from kinetograph.motion import Motion
    from kinetograph.roles import is_body
    from kinetograph.skeleton import ROLES

    lacking: dict[str, list[str]] = {}
    for name, track in take.tracks.items():
        if isinstance(track, Motion) and is_body(track.skeleton):
            missing = ", ".join(role for role in ROLES if role not in track.skeleton.roles)
            lacking.setdefault(missing, []).append(name)
    return [f"no joint of {', '.join(names)} was found for {missing}" for missing, names in lacking.items() if missing]


def _describe(path: Path, name: str, track: Track) -> dict[str, Any]:
    from kinetograph.motion import Motion
    from kinetograph.readings import Readings
    from kinetograph.roles import is_body
    from kinetograph.sensing import kinds_of
    from kinetograph.skeleton import ROLES

    rate = track.rate / len(track.names) if isinstance(track, Readings) else track.fps
    row: dict[str, Any] = {"file": path.name, "track": name, "frames": len(track), "fps": rate}
    row["seconds"] = track.duration
    if isinstance(track, Readings):
        row["what"] = f"readings of {len(track.names)} sensors: {', '.join(kinds_of(track))}"
        row["roles"] = "-"
    elif isinstance(track, Motion):
        skeleton = track.skeleton
        above = " in " + " > ".join(node.name for node in skeleton.ancestors) if skeleton.ancestors else ""
        tall = f", {skeleton.height:.2f} m tall" if is_body(skeleton) else ""
        row["what"] = f"{len(skeleton)} joints{above}{tall}"
        row["roles"] = f"{len(skeleton.roles)} of {len(ROLES)}" if is_body(skeleton) else "no body"
    else:
        row["what"] = f"{len(track.names)} {'points' if track.spatial else 'channels'} in {track.units}"
        row["roles"] = "-"
    return row


def _list_joints(track: Track) -> None:
    from kinetograph.motion import Motion

    if not isinstance(track, Motion):
        return
    skeleton = track.skeleton
    roles = {point.joint: role for role, point in skeleton.roles.items() if not point.offset.any()}
    rows = [
        {"joint": name, "parent": skeleton.names[parent] if parent >= 0 else "-", "role": roles.get(i, "")}
        for i, (name, parent) in enumerate(zip(skeleton.names, skeleton.parents, strict=True))
    ]
    table(rows, as_json=False)


# ---- convert ----


@options()
class Changes:
    """What is changed of a motion."""

    resampled: Annotated[float | None, typer.Option("--fps", help="Resample to this rate.")] = None
    start: Annotated[float, typer.Option(help="First second to keep.")] = 0.0
    end: Annotated[float | None, typer.Option(help="Last second to keep.")] = None
    mirror: Annotated[bool, typer.Option("--mirror", help="Exchange left and right.")] = False
    fit_markers: FitMarkers = False


@options("Writing files")
class Writing:
    """How numbers are written, and how the command ends."""

    to_units: Annotated[str, typer.Option(help="Units to write where the format leaves a choice.")] = "metre"
    to_up: Annotated[str, typer.Option(help="Upward axis to write where the format leaves a choice.")] = "y"
    order: Annotated[str, typer.Option(help="Euler order to write, outermost first.")] = "zxy"
    values: Annotated[str, typer.Option(help="What a CSV of a motion holds: positions or angles.")] = "positions"
    force: Force = False
    as_json: AsJson = False


@options("Reading files")
class SourceReading(Reading):
    """How the source is read."""

    fps: Annotated[float | None, typer.Option("--file-fps", help="The source's rate, in place of its own.")] = None
    skeleton: Annotated[Path | None, typer.Option(help="File with the bones of an .amc or of AMASS poses.")] = None
    lenient: Lenient = False
    everything: Everything = False
    markers: Markers = None


def convert(
    source: Annotated[Path, typer.Argument(help="The file to read.")],
    target: Annotated[Path, typer.Argument(help="The file to write; its suffix chooses the format.")],
    changes: Changes,
    another: AnotherBody,
    writing: Writing,
    reading: SourceReading,
) -> None:
    """Convert a motion or signal to another format, rate, span, unit, axis or body, and markers to a motion.

    Example: kinetograph convert out/walk.bvh out/part.glb --fps 60 --start 2 --end 8

    Example: kinetograph convert out/walk.bvh out/person.glb --character human
    """
    from kinetograph.formats import WriteOptions, save, together
    from kinetograph.readings import Readings

    refuse_existing([target], writing.force)
    worn = body(another.character, another.onto)
    take = read_file(source, reading, root_motion=not worn.other)
    bodily = changes.fit_markers or wants_motion(target) or worn.other or writing.values == "angles"
    take, fits = fitted(take, source, reading.markers) if bodily else (take, {})
    if not writing.as_json:
        list_residuals(fits)
    if another.handholds is not None and not worn.other:
        raise RequestError("--handholds goes with --retarget or --character")
    take = _edited(with_handholds(take, another.handholds), changes)
    choices = WriteOptions(writing.order, writing.to_units, writing.to_up, worn.character, writing.values)
    with together():  # the table of joints as well
        take = dressed(take, worn, another.joint_table, another.scale)
        save(take, target, force=writing.force, options=choices)
    first = next(iter(take.tracks.values()))
    rate = first.rate if isinstance(first, Readings) else first.fps
    figures = {"wrote": str(target), "frames": len(first), "fps": rate, "seconds": first.duration}
    result(figures | (residuals(fits) if writing.as_json else {}), writing.as_json)


def _edited(take: Take, changes: Changes) -> Take:
    from dataclasses import replace

    from kinetograph.motion import Motion
    from kinetograph.readings import Readings
    from kinetograph.signal import resample_signal

    tracks: dict[str, Track] = {}
    for name, track in take.tracks.items():
        if isinstance(track, Motion):
            tracks[name] = _edited_motion(track, changes)
        elif isinstance(track, Readings):
            raise RequestError(f"track {name!r} has readings of sensors: only motions and signals are converted")
        elif changes.start or changes.end is not None or changes.mirror:
            raise RequestError(f"track {name!r} is a signal: --start, --end and --mirror are for motions")
        else:
            tracks[name] = resample_signal(track, changes.resampled) if changes.resampled else track
    span = max(track.duration for track in tracks.values())
    annotations = edited_annotations(take.annotations, changes.start, span, changes.mirror)
    return replace(take, tracks=tracks, annotations=annotations)


def _edited_motion(motion: Motion, changes: Changes) -> Motion:
    from kinetograph.mirroring import mirror
    from kinetograph.motion import cut, resample

    first = round(changes.start * motion.fps)
    last = len(motion) if changes.end is None else min(round(changes.end * motion.fps) + 1, len(motion))
    kept = cut(motion, first, last)
    kept = mirror(kept) if changes.mirror else kept
    return resample(kept, changes.resampled) if changes.resampled else kept


def edited_annotations(
    annotations: Sequence[Annotation], start: float, span: float, mirrored: bool
) -> tuple[Annotation, ...]:
    """The annotations of what is left of a take, in its time and on its sides.

    Parameters
    ----------
    annotations : sequence of Annotation
        Those of the whole take.
    start, span : float
        Where what is left begins, and how long it is, in seconds.
    mirrored : bool
        Whether left and right are exchanged.
    """
    from kinetograph.skeleton import opposite
    from kinetograph.take import Annotation

    edited = []
    for annotation in annotations:
        begin, end = max(annotation.start - start, 0.0), min(annotation.stop - start, span)
        label = ":".join(map(opposite, annotation.label.split(":"))) if mirrored else annotation.label
        if begin <= end:
            edited.append(Annotation(annotation.track, annotation.kind, label, begin, end))
    return tuple(edited)
