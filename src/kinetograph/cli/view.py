"""The command view: pictures, films and pages of a motion."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kinetograph.cli.characters import CharacterName, body, dressed
from kinetograph.cli.markers import fitted
from kinetograph.cli.options import Force, add, options
from kinetograph.cli.output import notes, progress_bar, refuse_existing, result
from kinetograph.cli.reading import LenientReading, Role, parse_roles
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.take import Take

FILMS = (".gif", ".mp4")
PAGES = (".html", ".htm")


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    add(app, view, panel="Files")


@options()
class Picture:
    """What is drawn."""

    output: Annotated[
        Path, typer.Option("-o", "--output", help="Picture to write, .png, film, .gif or .mp4, or page, .html.")
    ]
    character: CharacterName = None
    frames: Annotated[int, typer.Option(help="How many poses.")] = 24
    seconds: Annotated[float, typer.Option(help="Length of a film.")] = 8.0
    force: Force = False


@options("Contact sheets")
class Sheet:
    """What a contact sheet shows."""

    strobe: Annotated[bool, typer.Option("--strobe", help="One strip of the figure along its path instead.")] = False
    path: Annotated[Path | None, typer.Option(help="A path CSV to draw below the root's path.")] = None
    contacts: Annotated[bool, typer.Option(help="Detect and mark the contacts of the feet.")] = True


@options("Reading files")
class SkeletonReading(LenientReading):
    """How the file is read."""

    role: Role = None


def view(
    file: Annotated[Path, typer.Argument(help="A motion file.")],
    picture: Picture,
    sheet: Sheet,
    reading: SkeletonReading,
) -> None:
    """Draw a contact sheet: poses, the path from above, the feet over time; or a person, or a film of one; or a page.

    A page, .html, plays the motion in any browser, without a network: to look around in, scrub, and send to others.

    Example: kinetograph view out/walk.bvh -o out/sheet.png

    Example: kinetograph view out/walk.bvh -o out/walk.html

    Example: kinetograph view out/walk.bvh -o out/person.gif --character human --seconds 1
    """
    from kinetograph.pipeline import read_take

    refuse_existing([picture.output], picture.force)
    _refuse_unknown(picture.output)
    take, guesses = read_take(file, reading.read_options, parse_roles(reading.role))
    notes(guesses, file)
    take, _ = fitted(take, file, reading.markers)
    if picture.output.suffix.lower() in PAGES:
        _write_page(take, picture, sheet, file.name)
    elif picture.character is not None or picture.output.suffix.lower() in FILMS:
        _draw_character(take, picture)
    else:
        _draw_figures(take, picture, sheet, file.name)
    result({"wrote": str(picture.output)}, as_json=False)


def _refuse_unknown(output: Path) -> None:
    """Raise RequestError, before any work is done, for a suffix that is none of those."""
    if output.suffix.lower() not in (".png", *FILMS, *PAGES):
        raise RequestError(
            f"{output}: expected .png for a picture, .gif or .mp4 for a film or .html for a page, "
            f"found {output.suffix or 'no suffix'!r}"
        )


def _draw_figures(take: Take, picture: Picture, sheet: Sheet, title: str) -> None:
    from kinetograph.drawing import pictures
    from kinetograph.formats import load

    take = _with_contacts(take) if sheet.contacts else take
    path = load(sheet.path).signal() if sheet.path else None
    if sheet.strobe:
        pictures.strobe(take, picture.output, path_signal=path, title=title)
    else:
        pictures.contact_sheet(take, picture.output, path_signal=path, title=title, frames=picture.frames)


def _write_page(take: Take, picture: Picture, sheet: Sheet, title: str) -> None:
    from kinetograph.formats.atomic import atomic_path
    from kinetograph.studio import player_page

    worn = body(picture.character)
    page = player_page(dressed(take, worn), title, worn.character, contacts=sheet.contacts)
    with atomic_path(picture.output) as draft:
        draft.write_text(page, encoding="utf-8")


def _with_contacts(take: Take) -> Take:
    """The take with its contacts, detected where none are annotated."""
    from dataclasses import replace

    from kinetograph.motion import Motion
    from kinetograph.segmentation import detect_contacts

    if any(annotation.kind == "contact" for annotation in take.annotations):
        return take
    motions = {name: track for name, track in take.tracks.items() if isinstance(track, Motion)}
    contacts = [contact for name, motion in motions.items() for contact in detect_contacts(motion, track=name)]
    return replace(take, annotations=(*take.annotations, *contacts))


def _draw_character(take: Take, picture: Picture) -> None:
    from kinetograph.drawing import character_film, character_sheet
    from kinetograph.formats.atomic import atomic_path

    worn = body(picture.character)
    take = dressed(take, worn)
    with progress_bar("drawing") as progress, atomic_path(picture.output) as draft:
        if picture.output.suffix.lower() in FILMS:
            character_film(take, draft, worn.character, seconds=picture.seconds, progress=progress)
        else:
            character_sheet(take, draft, worn.character, frames=picture.frames, progress=progress)
