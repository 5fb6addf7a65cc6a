"""What the page is sent of what was made, besides the bodies."""

from __future__ import annotations

import msgspec

from kinetograph.studio.project import Mode


class PieceRow(msgspec.Struct, frozen=True, omit_defaults=True):
    """A piece of the motion shown; see `kinetograph.Piece`."""

    take: str
    track: str
    start: float
    stop: float
    source_start: float
    source_stop: float
    cost: float
    seam: float
    mirrored: bool = False
    layer: str = ""


class Span(msgspec.Struct, frozen=True, omit_defaults=True):
    """A span of a lane of the timeline."""

    start: float
    stop: float
    label: str = ""
    title: str = ""


class Lane(msgspec.Struct, frozen=True, omit_defaults=True):
    """A lane of the timeline: spans, or the values of a signal at even times.

    Parameters
    ----------
    name : str
    role : str
        ``contacts``, ``moves``, ``handholds``, ``error``, ``edited``, ``readings``, ``uncertainty``.
    spans : tuple of Span
    values : tuple of float
        From the first second to the last.
    unit : str
        Of the values.
    """

    name: str
    role: str
    spans: tuple[Span, ...] = ()
    values: tuple[float, ...] = ()
    unit: str = ""


class Figure(msgspec.Struct, frozen=True, omit_defaults=True):
    """A figure about what was made, as a person reads it: ``"path error"``, ``"3.2 cm"``."""

    name: str
    value: str
    title: str = ""


class MadeHeader(msgspec.Struct, frozen=True, tag_field="kind", tag="made", omit_defaults=True):
    """The header of a blob whose payload is the GLB of what was made.

    Parameters
    ----------
    section : str
    key : str
        Names what was made: the same for the same section of a project.
    seconds, fps : float
    floor : float
        Metres: where the ground is.
    characters : tuple of str
        The names of the bodies in the GLB; the first is what was made, others are ``leader``, ``truth``.
    pieces, lanes, figures, warnings : tuple
    path : tuple of (float, float, float)
        The path that was performed: seconds, metres x and z.
    clock : tuple of (float, float)
        Where the path waits: seconds of what was made, and of the path then; linear between. Empty where it does not.
    costs : tuple of float
        Of each alternative.
    chosen : int
        Which of them is shown, from 0.
    """

    section: Mode
    key: str
    seconds: float
    fps: float
    floor: float = 0.0
    characters: tuple[str, ...] = ("motion",)
    pieces: tuple[PieceRow, ...] = ()
    lanes: tuple[Lane, ...] = ()
    figures: tuple[Figure, ...] = ()
    warnings: tuple[str, ...] = ()
    path: tuple[tuple[float, float, float], ...] = ()
    clock: tuple[tuple[float, float], ...] = ()
    costs: tuple[float, ...] = ()
    chosen: int = 0
