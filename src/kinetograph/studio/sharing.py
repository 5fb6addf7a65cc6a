"""Motions in a page of their own: one HTML file with the player and the motions in it, which asks nothing of a network.

A notebook shows the same page within a cell, with long motions at a lower rate.
"""

from __future__ import annotations

import base64
import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec

from kinetograph.character import Character
from kinetograph.display import summary
from kinetograph.errors import KinetographError, RequestError
from kinetograph.motion import Motion, cut, resample
from kinetograph.segmentation import detect_contacts
from kinetograph.studio.floor import floor_of
from kinetograph.studio.made import clip as encoded
from kinetograph.studio.made import contact_lanes, edited_lane, grouped, piece_row, synthesis_figures
from kinetograph.studio.messages import Figure, Lane, PieceRow, Span
from kinetograph.studio.page import page_folder
from kinetograph.synthesis import Synthesis
from kinetograph.take import Annotation, Take

Shown = Motion | Take | Synthesis
"""What the player shows."""

CELL_BYTES = 1_450_000
"""Most bytes of what a cell of a notebook is given: notebooks keep them in their file."""

_SLOWEST = 12.0  # frames per second of a motion in a notebook, before it is cut short
_MARGIN = 0.97  # of a cell's bytes that are aimed at
_HEIGHT = 440  # pixels of a cell
_LANES = {"handhold": "handholds", "contact": "contacts"}
_PAGE = """<!doctype html>
<!-- Drawn with three.js:
{licence}-->
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="Kinetograph">
<meta http-equiv="Content-Security-Policy" content="default-src 'unsafe-inline' 'unsafe-eval' data: blob:">
<title>{title}</title>
<link rel="icon" href="data:,">
<style>{style}</style>
</head>
<body class="player" data-state="idle">
<script type="application/json" id="clips">{clips}</script>
<script type="module">{script}</script>
</body>
</html>
"""


class SharedClip(msgspec.Struct, frozen=True, omit_defaults=True):
    """A clip of the player.

    Parameters
    ----------
    name : str
    glb : str
        Its characters and their motion, in base64.
    floor : float
        Height of the ground, metres.
    pieces, lanes, figures, warnings : tuple
        As in `kinetograph.studio.messages.MadeHeader`.
    """

    name: str
    glb: str
    floor: float
    pieces: tuple[PieceRow, ...] = ()
    lanes: tuple[Lane, ...] = ()
    figures: tuple[Figure, ...] = ()
    warnings: tuple[str, ...] = ()


class SharedPage(msgspec.Struct, frozen=True):
    """What the player is given: a title, and one clip or several to choose from."""

    title: str
    clips: tuple[SharedClip, ...]


@dataclass(frozen=True, eq=False)
class _Scene:
    """Motions to show, and what is known about them."""

    take: Take
    floor: float
    character: Character | None = None
    synthesis: Synthesis | None = None
    warnings: tuple[str, ...] = ()


def player_page(
    shown: Shown | Mapping[str, Shown],
    title: str = "Kinetograph",
    character: Character | None = None,
    *,
    contacts: bool = True,
) -> str:
    """One HTML file with the player and motions in it.

    Parameters
    ----------
    shown : Motion, Take or Synthesis, or mapping of str to these
        Several are chosen by their names. The motions of a take are shown together.
    title : str
    character : Character, optional
        Whose skin the motions wear; without one, capsules.
    contacts : bool
        Whether contacts of feet are detected where none are annotated.

    Returns
    -------
    str

    Raises
    ------
    RequestError
        The page is not built, there is no motion, or its skeleton is not the character's.
    """
    folder = page_folder()
    named = shown if isinstance(shown, Mapping) else {title: shown}
    clips = tuple(_shared(name, _scene(each, character, contacts)) for name, each in named.items())
    return _filled(folder, SharedPage(title, clips))


def notebook_html(shown: Shown) -> str:
    """What a notebook shows for a motion: the player, or a line of text where the page is not built.

    Parameters
    ----------
    shown : Motion, Take or Synthesis

    Returns
    -------
    str
    """
    try:
        folder = page_folder()
        page = _small_page(folder, _scene(shown))
    except KinetographError as error:
        return f"<pre>{html.escape(summary(shown))}\n{html.escape(str(error))}</pre>"
    style = f"width:100%;height:{_HEIGHT}px;border:1px solid #8885;border-radius:6px"
    name = html.escape(summary(shown))
    return f'<iframe sandbox="allow-scripts" title="{name}" style="{style}" srcdoc="{html.escape(page)}"></iframe>'


def _small_page(folder: Path, scene: _Scene) -> str:
    """The page with as much of a motion as a cell may hold."""
    page, share = _cell(folder, scene), 1.0
    fixed = len(html.escape(_filled(folder, SharedPage("", ()))))
    while len(html.escape(page)) > CELL_BYTES:
        share *= _MARGIN * (CELL_BYTES - fixed) / (len(html.escape(page)) - fixed)
        page = _cell(folder, _thinned(scene, share))
    return page


def _cell(folder: Path, scene: _Scene) -> str:
    return _filled(folder, SharedPage("", (_shared("motion", scene),)))


def _thinned(scene: _Scene, share: float) -> _Scene:
    """A scene with a share of its frames: at a lower rate, and cut short where that is not enough."""
    motions = _motions(scene.take)
    fastest = max(motion.fps for motion in motions.values())
    rate = max(fastest * share, min(_SLOWEST, fastest))
    seconds = scene.take.duration * min(share * fastest / rate, 1.0)
    if seconds * rate < 2:
        raise RequestError("its bodies are too large for a notebook; show it in a page: kinetograph view -o page.html")
    tracks: dict[str, Motion] = {}
    for name, motion in motions.items():
        slower = resample(motion, min(rate, motion.fps))
        tracks[name] = cut(slower, 0, min(len(slower), int(seconds * slower.fps) + 1))
    note = f"shown at {rate:.3g} frames per second"
    if seconds < scene.take.duration:
        note += f", the first {seconds:.0f} of {scene.take.duration:.0f} s"
    return replace(scene, take=Take(scene.take.name, tracks, scene.take.annotations), warnings=(*scene.warnings, note))


def _filled(folder: Path, page: SharedPage) -> str:
    # within an element of HTML, only its end would be taken for one
    data = msgspec.json.encode(page).decode().replace("<", "\\u003c")
    script = (folder / "player.js").read_text(encoding="utf-8").replace("</script", "<\\/script")
    style = (folder / "style.css").read_text(encoding="utf-8")
    licence = (folder / "three.LICENSE.txt").read_text(encoding="utf-8")
    return _PAGE.format(licence=licence, title=html.escape(page.title), style=style, clips=data, script=script)


def _scene(shown: Shown, character: Character | None = None, contacts: bool = True) -> _Scene:
    """What is shown as a take of motions with its contacts, and the floor under them."""
    made = shown if isinstance(shown, Synthesis) else None
    if isinstance(shown, Take):
        take = shown
    elif isinstance(shown, Motion):
        take = Take("motion", {"motion": shown})
    else:
        take = Take("synthesis", {"motion": shown.motion}, shown.annotations)
    take = _annotated(take, contacts)
    floor = min(floor_of(motion, character) for motion in _motions(take).values())
    return _Scene(take, floor, character, made, grouped(made.warnings) if made else ())


def _motions(take: Take) -> dict[str, Motion]:
    return {name: track for name, track in take.tracks.items() if isinstance(track, Motion)}


def _annotated(take: Take, contacts: bool) -> Take:
    """The motions of a take and what is annotated on them; their contacts are detected where none are."""
    motions = _motions(take)
    if not motions:
        raise RequestError(f"take {take.name!r} has no motion to show, only the signals {', '.join(take.tracks)}")
    found: tuple[Annotation, ...] = ()
    if contacts and not any(note.kind == "contact" for note in take.annotations):
        found = tuple(note for name, motion in motions.items() for note in detect_contacts(motion, track=name))
    kept = tuple(note for note in take.annotations if note.track in motions)
    return Take(take.name, dict(motions), (*kept, *found))


def _shared(name: str, scene: _Scene) -> SharedClip:
    take, made = scene.take, scene.synthesis
    clip = SharedClip(
        name,
        base64.b64encode(encoded(take, scene.character)).decode(),
        scene.floor,
        lanes=_lanes(take),
        figures=_figures(_motions(take)),
        warnings=scene.warnings,
    )
    if made is None:
        return clip
    share = take.duration / made.motion.duration if made.motion.duration else 1.0
    return msgspec.structs.replace(
        clip,
        pieces=tuple(piece_row(piece) for piece in made.pieces if piece.start < take.duration or not piece.start),
        lanes=(*clip.lanes, *(_first_values(lane, share) for lane in edited_lane(made))),
        figures=(*clip.figures, *synthesis_figures(made)),
    )


def _figures(motions: Mapping[str, Motion]) -> tuple[Figure, ...]:
    first = next(iter(motions.values()))
    return Figure("joints", str(len(first.skeleton))), Figure("frames per second", f"{first.fps:.4g}")


def _first_values(lane: Lane, share: float) -> Lane:
    """A lane with the first share of its values."""
    return msgspec.structs.replace(lane, values=lane.values[: max(round(share * len(lane.values)), 1)])


def _lanes(take: Take) -> tuple[Lane, ...]:
    """The lanes of each track: its contacts, then its other annotations by their kind."""
    lanes: list[Lane] = []
    for track in take.tracks:
        of = f"{track}: " if len(take.tracks) > 1 else ""
        own = [
            _held(note, take.duration)
            for note in take.annotations
            if note.track == track and note.start < take.duration
        ]
        lanes += [msgspec.structs.replace(lane, name=f"{of}{lane.name}") for lane in contact_lanes(own)]
        for kind in sorted({note.kind for note in own} - {"contact", "cut"}):
            lanes.append(Lane(f"{of}{kind}", _LANES.get(kind, "moves"), _spans(own, kind)))
    return tuple(lanes)


def _held(note: Annotation, seconds: float) -> Annotation:
    return replace(note, stop=min(note.stop, seconds))


def _spans(notes: Sequence[Annotation], kind: str) -> tuple[Span, ...]:
    return tuple(Span(note.start, note.stop, note.label or kind) for note in notes if note.kind == kind)
