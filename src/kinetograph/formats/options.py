"""What every reader and writer of the package takes and returns."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from kinetograph.character import Character
from kinetograph.formats.bodies import Keep
from kinetograph.take import Take


@dataclass(frozen=True)
class ReadOptions:
    """What a person knows about a file. ``None``: as the file says, or a guess where it does not say.

    Parameters
    ----------
    units : {"metre", "centimetre", "millimetre", "inch", "foot", "cmu"}, optional
        What the file's lengths are in.
    up : {"x", "y", "z"}, optional
        The file's upward axis.
    fps : float, optional
        Frames per second, in place of the file's own rate.
    lenient : bool
        Take what can be read of a damaged file.
    skeleton : str or Path, optional
        A file with the bones that the file's rotations belong to, for formats that keep them apart (the ``.asf`` of an
        ``.amc``, a body for AMASS poses).
    animation : str, optional
        Which of several animations in a file: one of `Loaded.animations`, or a number from 1; the first unless given.
    rest : int, optional
        A frame in which the body stands upright, for files whose rest pose does not.
    everything : bool
        Every tree of joints as the file has it; else only bodies, each from its own root, at the hips, on.
    root_motion : bool
        Keep a joint above the hips that moves, as in games, as the root of its body.
    markers : str or Path, optional
        The set that the points in a file are of: one of the package's by name or, for markers, a ``.toml`` file with
        one's own; found from the file unless given.
    """

    units: str | None = None
    up: str | None = None
    fps: float | None = None
    lenient: bool = False
    skeleton: str | Path | None = None
    animation: str | None = None
    rest: int | None = None
    everything: bool = False
    root_motion: bool = False
    markers: str | Path | None = None

    @property
    def keep(self) -> Keep:
        """What is kept besides the bodies."""
        return Keep(self.everything, self.root_motion)


@dataclass(frozen=True)
class WriteOptions:
    """How numbers are written where a format leaves a choice.

    Parameters
    ----------
    order : str
        Order of Euler angles, outermost first; ``"zxy"`` is BVH's ``Zrotation Xrotation Yrotation``.
    units : {"metre", "centimetre", "millimetre", "inch", "foot", "cmu"}
        What lengths are written in.
    up : {"x", "y", "z"}
        The upward axis.
    character : Character, optional
        Whose skin the motions wear, where the format has skins; a body of capsules without one.
    table : {"positions", "angles"}
        What a CSV of a motion holds: positions of its joints, or their angles.
    """

    order: str = "zxy"
    units: str = "metre"
    up: str = "y"
    character: Character | None = None
    table: str = "positions"


@dataclass(frozen=True, eq=False)
class Loaded:
    """What a reader returns.

    Parameters
    ----------
    take : Take
        In metres, Y up.
    notes : tuple of str
        What was guessed or repaired, one line each.
    animations : tuple of str
        The names of all animations in the file, of which ``take`` is one; empty for formats that hold only one.
    """

    take: Take
    notes: tuple[str, ...] = field(default=())
    animations: tuple[str, ...] = field(default=())
