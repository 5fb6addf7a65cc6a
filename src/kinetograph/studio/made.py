"""What a section of a project makes, ready for the page and for files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from kinetograph.character import Character
from kinetograph.motion import Motion
from kinetograph.studio.messages import Figure, Lane, MadeHeader, PieceRow, Span
from kinetograph.studio.project import Mode
from kinetograph.synthesis import Piece, Synthesis
from kinetograph.take import Annotation, Take


@dataclass(frozen=True, eq=False)
class Made:
    """What was made of a section.

    Parameters
    ----------
    syntheses : tuple of Synthesis
        What is shown and exported first is number ``chosen``; the others are alternatives.
    chosen : int
    others : mapping of str to Motion
        Bodies shown with it: ``leader``, ``truth``.
    lanes : tuple of Lane
        Besides contacts.
    figures : tuple of Figure
    path : tuple of (float, float, float)
        The path that was performed: seconds, metres x and z.
    notes : tuple of Annotation
        Contacts and handholds of the others, on tracks of their names.
    """

    syntheses: tuple[Synthesis, ...]
    chosen: int = 0
    others: Mapping[str, Motion] = field(default_factory=dict)
    lanes: tuple[Lane, ...] = ()
    figures: tuple[Figure, ...] = ()
    path: tuple[tuple[float, float, float], ...] = ()
    notes: tuple[Annotation, ...] = ()

    @property
    def synthesis(self) -> Synthesis:
        """The one that is shown."""
        return self.syntheses[self.chosen]

    @property
    def annotations(self) -> tuple[Annotation, ...]:
        """Those of all the bodies that are shown; the synthesis' are on the track ``motion``."""
        return (*self.synthesis.annotations, *self.notes)


def header(section: Mode, key: str, made: Made, floor: float) -> MadeHeader:
    """What the page is sent of it, besides the bodies."""
    synthesis = made.synthesis
    return MadeHeader(
        section=section,
        key=key,
        seconds=synthesis.motion.duration,
        fps=synthesis.motion.fps,
        floor=floor,
        characters=("motion", *made.others),
        pieces=tuple(piece_row(piece) for piece in synthesis.pieces),
        lanes=(*contact_lanes(synthesis.annotations), *made.lanes, *edited_lane(synthesis)),
        figures=(*made.figures, *synthesis_figures(synthesis)),
        warnings=grouped(synthesis.warnings),
        path=made.path,
        clock=clock_rows(synthesis),
        costs=tuple(each.cost for each in made.syntheses),
        chosen=made.chosen,
    )


def clock_rows(synthesis: Synthesis) -> tuple[tuple[float, float], ...]:
    """The seconds of a synthesis and of its control where spans begin and end in which that waits, and at both ends."""
    if not len(synthesis.clock):
        return ()
    fps, last = synthesis.motion.fps, len(synthesis.motion) - 1
    frames = [0, *(round(second * fps) for span in synthesis.filled for second in span), last]
    return tuple((frame / fps, synthesis.clock_at(frame)) for frame in frames)


def bodies(motions: Mapping[str, Motion], character: Character | None, notes: tuple[Annotation, ...] = ()) -> Take:
    """Motions as they are shown and written: on the character, stood on the floor; without one, as they are.

    Parameters
    ----------
    motions : mapping of str to Motion
        By the names of their bodies.
    character : Character, optional
        Whose skin they wear.
    notes : tuple of Annotation
        Contacts and handholds, on tracks of the bodies' names; bodies whose hands are held stay hand in hand.
    """
    if character is None:
        return Take("studio", dict(motions))
    from kinetograph.post import retarget

    scale = 1.0 if len(motions) > 1 else None  # partners stay together
    worn: dict[str, Motion] = {}
    for name, motion in motions.items():
        holds = tuple(note for note in notes if note.track == name and note.kind in ("contact", "handhold"))
        worn[name] = retarget(motion, character, scale=scale, handholds=holds).motion
    return Take("studio", dict(worn))


def clip(take: Take, character: Character | None) -> bytes:
    """A take of `bodies` as GLB."""
    from kinetograph.formats.gltf import encode

    return encode(take, character)


def grouped(lines: Sequence[str]) -> tuple[str, ...]:
    """Lines that say the same of several things, as one.

    Parameters
    ----------
    lines : sequence of str
        Those that are about something begin with its name and a colon.

    Returns
    -------
    tuple of str

    Examples
    --------
    >>> grouped(["a: too fast", "slow", "b: too fast"])
    ('2 takes (a, b): too fast', 'slow')
    """
    about: dict[str, list[str]] = {}
    for line in lines:
        name, colon, text = line.partition(": ")
        about.setdefault(text if colon else line, []).append(name if colon else "")
    return tuple(f"{_together(names)}{text}" for text, names in about.items())


def _together(names: Sequence[str]) -> str:
    if len(names) > 1:
        return f"{len(names)} takes ({', '.join(names)}): "
    return f"{names[0]}: " if names[0] else ""


def piece_row(piece: Piece) -> PieceRow:
    """A piece, for the page."""
    return PieceRow(
        take=piece.take,
        track=piece.track,
        start=piece.start,
        stop=piece.stop,
        source_start=piece.source_start,
        source_stop=piece.source_stop,
        cost=piece.cost,
        seam=piece.seam,
        mirrored=piece.mirrored,
    )


def contact_lanes(annotations: Sequence[Annotation]) -> tuple[Lane, ...]:
    """A lane for the contacts of each side's foot."""
    lanes = []
    for side in ("left", "right"):
        notes = [n for n in annotations if n.kind == "contact" and n.label.startswith(side)]
        if notes:
            spans = tuple(Span(n.start, n.stop, n.label.replace("_", " ")) for n in notes)
            lanes.append(Lane(f"{side} foot", "contacts", spans))
    return tuple(lanes)


def edited_lane(synthesis: Synthesis) -> tuple[Lane, ...]:
    """How far each frame is from its recording, where the method measures it."""
    if not len(synthesis.edited):
        return ()
    return (Lane("edited", "edited", values=tuple(np.round(100 * synthesis.edited, 3).tolist()), unit="cm"),)


def synthesis_figures(synthesis: Synthesis) -> tuple[Figure, ...]:
    """Its cost, and how much of it is recording."""
    figures = [Figure("cost", f"{synthesis.cost:.4g}")]
    untouched = synthesis.statistics.get("untouched")
    if untouched is not None:
        title = "Frames of the result that are frames of a recording, moved and rotated as a whole"
        figures.append(Figure("untouched recording", f"{100 * untouched:.0f} %", title))
    return tuple(figures)
