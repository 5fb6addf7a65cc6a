"""Copies of held-out takes: what an evaluation leaves out besides, and says so."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from kinetograph.cli.output import note

if TYPE_CHECKING:
    from kinetograph.library import Library

KeepCopies = Annotated[
    bool, typer.Option("--keep-copies", help="Keep copies of the held-out take in the library (library duplicates).")
]


def copies_left_out(library: Library, keep: bool, takes: Sequence[str] = ()) -> dict[str, tuple[str, ...]]:
    """The copies that are left out, by held-out take; said on stderr, kept or not."""
    from kinetograph.pipeline import copies_among

    known = tuple(take for take in takes if take in library.names())
    found = copies_among(library, known) if known or not takes else {}
    names = set(library.names())
    alone = {take for take, copies in found.items() if names == {take, *copies}}
    for take, copies in found.items():
        what = "left out of the library (--keep-copies keeps it)"
        what = "stays in the library" + ", which has no other take" * (take in alone) if keep or take in alone else what
        note(f"{take} is held out; its copy {', '.join(copies)} {what}")
    return {} if keep else {take: copies for take, copies in found.items() if take not in alone}
