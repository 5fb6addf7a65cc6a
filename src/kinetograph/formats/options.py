"""What every reader and writer of the package takes and gives."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from kinetograph.character import Character
from kinetograph.take import Take


@dataclass(frozen=True)
class ReadOptions:
    """What a person knows about a file. ``None``: as the file says, or a guess where it does not say.

    units: a name from `conventions.UNITS`. up: ``"x"``, ``"y"`` or ``"z"``. fps: frames a second, in place of the
    file's own rate. lenient: take what can be read of a damaged file. skeleton: a file with the bones that the file's
    rotations turn, for formats that keep them apart (``.asf`` of an ``.amc``, a body for AMASS poses).
    """

    units: str | None = None
    up: str | None = None
    fps: float | None = None
    lenient: bool = False
    skeleton: str | Path | None = None


@dataclass(frozen=True)
class WriteOptions:
    """How numbers are written where a format leaves a choice.

    order: of the Euler angles, outermost first, ``"zxy"`` being BVH's ``Zrotation Xrotation Yrotation``. units: a
    name from `conventions.UNITS`. up: ``"x"``, ``"y"`` or ``"z"``. character: whose skin the motions wear, where the
    format has skins; a body of capsules without one. table: what a CSV of a motion holds, ``"positions"`` of its
    joints or their ``"angles"``.
    """

    order: str = "zxy"
    units: str = "metre"
    up: str = "y"
    character: Character | None = None
    table: str = "positions"


@dataclass(frozen=True, eq=False)
class Loaded:
    """A take in metres, Y up, and notes: what was guessed or repaired on the way, one line each."""

    take: Take
    notes: tuple[str, ...] = field(default=())
