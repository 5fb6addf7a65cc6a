"""Commands on files: info, convert, view."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli._characters import Holds, Onto, Scale, Table, Wear, body, dressed, held
from kinetograph.cli._markers import Fit, fitted, list_residuals, residuals, wants_motion
from kinetograph.cli._shell import (
    AsJson,
    Force,
    Fps,
    Lenient,
    Units,
    Up,
    note,
    parse_roles,
    progress_bar,
    refuse_existing,
    result,
    table,
)
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.take import Annotation, Take, Track

GROUP = "Files"


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    for command in (info, convert, view):
        app.command(rich_help_panel=GROUP)(command)


def info(
    files: Annotated[list[Path], typer.Argument(help="Motion or signal files.")],
    units: Units = None,
    up: Up = None,
    fps: Fps = None,
    lenient: Lenient = False,
    joints: Annotated[bool, typer.Option("--joints", help="List every joint with its parent and role.")] = False,
    as_json: AsJson = False,
) -> None:
    """Tell what is in files: skeleton, roles, frames, rate, duration, units and axes.

    Example: kinetograph info walk.bvh --joints
    """
    from kinetograph.formats import ReadOptions, read

    rows = []
    for path in files:
        loaded = read(path, ReadOptions(units, up, fps, lenient))
        for name, track in loaded.take.tracks.items():
            rows.append(_describe(path, name, track))
            if joints and not as_json:
                _list_joints(track)
        for text in loaded.notes:
            note(f"{path}: {text}")
    table(rows, as_json)


def _describe(path: Path, name: str, track: Track) -> dict[str, Any]:
    from kinetograph.motion import Motion
    from kinetograph.skeleton import ROLES

    row: dict[str, Any] = {"file": path.name, "track": name, "frames": len(track), "fps": track.fps}
    row["seconds"] = track.duration
    if isinstance(track, Motion):
        missing = [role for role in ROLES if role not in track.skeleton.roles]
        row["what"] = f"{len(track.skeleton)} joints, {track.skeleton.height:.2f} m tall"
        row["roles"] = f"{len(ROLES) - len(missing)} of {len(ROLES)}" + (f", without {missing}" if missing else "")
    else:
        row["what"] = f"{len(track.names)} {'points' if track.spatial else 'channels'} in {track.units}"
        row["roles"] = "-"
    return row


def _list_joints(track: Track) -> None:
    from kinetograph.motion import Motion

    if not isinstance(track, Motion):
        return
    skeleton = track.skeleton
    roles = {mark.joint: role for role, mark in skeleton.roles.items() if not mark.offset.any()}
    rows = [
        {"joint": name, "parent": skeleton.names[parent] if parent >= 0 else "-", "role": roles.get(i, "")}
        for i, (name, parent) in enumerate(zip(skeleton.names, skeleton.parents, strict=True))
    ]
    table(rows, as_json=False)


def convert(
    source: Annotated[Path, typer.Argument(help="The file to read.")],
    target: Annotated[Path, typer.Argument(help="The file to write; its suffix chooses the format.")],
    units: Units = None,
    up: Up = None,
    fps: Annotated[float | None, typer.Option(help="Resample to this rate.")] = None,
    file_fps: Annotated[float | None, typer.Option(help="The source's rate, in place of its own.")] = None,
    start: Annotated[float, typer.Option(help="First second to keep.")] = 0.0,
    end: Annotated[float | None, typer.Option(help="Last second to keep.")] = None,
    to_units: Annotated[str, typer.Option(help="Units to write where the format leaves a choice.")] = "metre",
    to_up: Annotated[str, typer.Option(help="Upward axis to write where the format leaves a choice.")] = "y",
    order: Annotated[str, typer.Option(help="Euler order to write, outermost first.")] = "zxy",
    values: Annotated[str, typer.Option(help="What a CSV of a motion holds: positions or angles.")] = "positions",
    mirrored: Annotated[bool, typer.Option("--mirror", help="Exchange left and right.")] = False,
    skeleton: Annotated[Path | None, typer.Option(help="The bones of an .amc or of AMASS poses.")] = None,
    onto: Onto = None,
    character: Wear = None,
    joint_table: Table = None,
    scale: Scale = None,
    handholds: Holds = None,
    fit_markers: Fit = False,
    lenient: Lenient = False,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Convert a motion or signal to another format, rate, span, unit, axis or body; markers too, to a body's motion.

    Example: kinetograph convert walk.bvh walk.glb --fps 60 --start 2 --end 8 --character human
    """
    from kinetograph.formats import ReadOptions, WriteOptions, read, save

    refuse_existing([target], force)
    loaded = read(source, ReadOptions(units, up, file_fps, lenient, skeleton))
    for text in loaded.notes:
        note(f"{source}: {text}")
    worn = body(character, onto)
    bodily = fit_markers or wants_motion(target) or worn.skeleton is not None or values == "angles"
    take, fits = fitted(loaded.take, source) if bodily else (loaded.take, {})
    if not as_json:
        list_residuals(fits)
    if handholds is not None and worn.skeleton is None:
        raise RequestError("--handholds goes with --retarget or --character")
    take = _edited(held(take, handholds), fps, start, end, mirrored)
    take = dressed(take, worn.skeleton, joint_table, scale)
    save(take, target, force=force, options=WriteOptions(order, to_units, to_up, worn.character, values))
    first = next(iter(take.tracks.values()))
    figures = {"wrote": str(target), "frames": len(first), "fps": first.fps, "seconds": first.duration}
    result(figures | (residuals(fits) if as_json else {}), as_json)


def _edited(take: Take, fps: float | None, start: float, end: float | None, mirrored: bool) -> Take:
    from kinetograph.mirroring import mirror
    from kinetograph.motion import Motion, cut, resample
    from kinetograph.signal import resample_signal
    from kinetograph.take import Take

    tracks: dict[str, Track] = {}
    for name, track in take.tracks.items():
        if isinstance(track, Motion):
            first = round(start * track.fps)
            last = len(track) if end is None else min(round(end * track.fps) + 1, len(track))
            motion = cut(track, first, last)
            motion = mirror(motion) if mirrored else motion
            tracks[name] = resample(motion, fps) if fps else motion
        elif start or end is not None or mirrored:
            raise RequestError(f"track {name!r} is a signal: --start, --end and --mirror are for motions")
        else:
            tracks[name] = resample_signal(track, fps) if fps else track
    span = max(track.duration for track in tracks.values())
    return Take(take.name, tracks, _moved(take.annotations, start, span, mirrored))


def _moved(marks: Sequence[Annotation], start: float, span: float, mirrored: bool) -> tuple[Annotation, ...]:
    """Annotations of what is left of a take, in its time and on its sides."""
    from kinetograph.skeleton import opposite
    from kinetograph.take import Annotation

    out = []
    for mark in marks:
        begin, end = max(mark.start - start, 0.0), min(mark.stop - start, span)
        label = ":".join(map(opposite, mark.label.split(":"))) if mirrored else mark.label
        if begin <= end:
            out.append(Annotation(mark.track, mark.kind, label, begin, end))
    return tuple(out)


def view(
    file: Annotated[Path, typer.Argument(help="A motion file.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="The picture to write, .png, or the film, .gif.")],
    path: Annotated[Path | None, typer.Option(help="A path CSV to draw beneath the root's.")] = None,
    frames: Annotated[int, typer.Option(help="How many poses.")] = 24,
    character: Wear = None,
    seconds: Annotated[float, typer.Option(help="Length of a film, .gif.")] = 8.0,
    strobe: Annotated[bool, typer.Option("--strobe", help="One strip of the figure along its way instead.")] = False,
    contacts: Annotated[bool, typer.Option(help="Detect and mark the contacts of the feet.")] = True,
    role: Annotated[list[str] | None, typer.Option(help="Override a role: role=joint. Repeatable.")] = None,
    units: Units = None,
    up: Up = None,
    fps: Fps = None,
    lenient: Lenient = False,
    force: Force = False,
) -> None:
    """Draw a contact sheet: poses, the way from above, the feet over time; or a person, or a film of one.

    Example: kinetograph view walk.bvh -o walk.gif --character human
    """
    from kinetograph import drawing
    from kinetograph.formats import ReadOptions, load
    from kinetograph.motion import Motion
    from kinetograph.pipeline import read_take
    from kinetograph.segmentation import detect_contacts
    from kinetograph.take import Take

    refuse_existing([output], force)
    take, notes = read_take(file, ReadOptions(units, up, fps, lenient), parse_roles(role))
    for text in notes:
        note(f"{file}: {text}")
    take, _ = fitted(take, file)
    if character is not None or output.suffix.lower() == ".gif":
        _view_character(take, output, character, frames, seconds)
        return
    marks = take.annotations
    if contacts and not any(n.kind == "contact" for n in marks):
        found = [detect_contacts(t, track=n) for n, t in take.tracks.items() if isinstance(t, Motion)]
        marks = (*marks, *(mark for group in found for mark in group))
    take = Take(take.name, take.tracks, marks)
    wanted = load(path).signal() if path else None
    if strobe:
        drawing.strobe(take, output, path_signal=wanted, title=file.name)
    else:
        drawing.contact_sheet(take, output, path_signal=wanted, title=file.name, frames=frames)
    result({"wrote": str(output)}, as_json=False)


def _view_character(take: Take, output: Path, character: str | None, frames: int, seconds: float) -> None:
    from kinetograph.drawing import character_film, character_sheet
    from kinetograph.formats.atomic import atomic_path

    worn = body(character, None)
    take = dressed(take, worn.skeleton, None, None)
    with progress_bar("drawing") as progress, atomic_path(output) as draft:
        if output.suffix.lower() == ".gif":
            character_film(take, draft, worn.character, seconds=seconds, progress=progress)
        else:
            character_sheet(take, draft, worn.character, frames=frames, progress=progress)
    result({"wrote": str(output)}, as_json=False)
