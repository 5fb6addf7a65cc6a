"""Contact sheets of what a method made, with its control."""

from __future__ import annotations

from pathlib import Path

from kinetograph.drawing.pictures import contact_sheet
from kinetograph.motion import Motion
from kinetograph.post import contacts_of
from kinetograph.signal import Signal
from kinetograph.synthesis import Synthesis


def draw_synthesis(synthesis: Synthesis, picture: str | Path, control: Signal | Motion | None, title: str) -> None:
    """Draw a contact sheet of a synthesis and its control, with its contacts and seams.

    Parameters
    ----------
    synthesis : Synthesis
    picture : str or Path
        A ``.png`` file.
    control : Signal, Motion or None
        What is shown besides.
    title : str
    """
    contact_sheet(
        [synthesis.motion, control] if isinstance(control, Motion) else synthesis.motion,
        picture,
        contacts=contacts_of(synthesis.annotations),
        path_signal=control if isinstance(control, Signal) else None,
        title=title,
        seams=[piece.start for piece in synthesis.pieces[1:]],
    )
