"""Files read as takes: what they are called, with roles, with bodies fitted to markers; and what was guessed."""

from __future__ import annotations

import hashlib
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import unquote

from kinetograph.formats import ReadOptions
from kinetograph.pipeline.libraries import read_takes
from kinetograph.signal import Signal
from kinetograph.take import Take

if TYPE_CHECKING:
    from kinetograph.markers import MarkerFit

_BLOCK = 1 << 22


@dataclass(frozen=True)
class ReadRecordings:
    """Reads files in one manner; other processes can be given one.

    Parameters
    ----------
    options : ReadOptions
    roles : dict of str to str
        Joint names by role, put in place of those that are found.
    fit_markers : bool
        Fit bodies to markers.
    """

    options: ReadOptions = field(default_factory=ReadOptions)
    roles: dict[str, str] = field(default_factory=dict)
    fit_markers: bool = False

    def takes(self, path: Path) -> tuple[list[Take], tuple[str, ...]]:
        """Every animation in a file as a take, or the one that is named, and what was guessed."""
        takes: list[Take] = []
        notes: list[str] = []
        for take, guesses in read_takes(path, self.options, self.roles):
            notes += guesses
            if self.fit_markers:
                take, _, said = with_fitted_markers(take, path, str(self.options.markers or "") or None)
                notes += said
            takes.append(take)
        return takes, tuple(dict.fromkeys(notes))

    def content(self, path: Path) -> str:
        """A digest of a file, of those that it refers to, and of how it is read. Raises OSError."""
        digest = hashlib.blake2b(repr(self).encode(), digest_size=16)
        tables = [Path(self.options.markers)] if self.options.markers else []
        for part in (path, *_companions(path), *(table for table in tables if table.is_file())):
            with part.open("rb") as file:
                while data := file.read(_BLOCK):
                    digest.update(data)
        return digest.hexdigest()


def _companions(path: Path) -> list[Path]:
    """The files that a file refers to: the skeletons in its folder, or the buffers that it names."""
    suffix = path.suffix.lower()
    if suffix == ".amc":
        return sorted(other for other in path.parent.iterdir() if other.suffix.lower() == ".asf")
    if suffix == ".gltf":
        named = re.findall(rb'"uri"\s*:\s*"([^"]{1,255})"', path.read_bytes())
        inside = [
            path.parent / unquote(name.decode(errors="replace")) for name in named if not name.startswith(b"data:")
        ]
        return [file for file in inside if file.is_file()]
    return []


def with_fitted_markers(
    take: Take, source: Path, markers: str | None = None
) -> tuple[Take, dict[str, MarkerFit], tuple[str, ...]]:
    """The take with its markers made motions, where it has markers and no motion.

    Parameters
    ----------
    take : Take
    source : Path
        Where it is from.
    markers : str, optional
        The set of the markers; found by their names unless given.

    Returns
    -------
    take : Take
    fits : dict of str to MarkerFit
        By track.
    notes : tuple of str
        How well they fit.
    """
    from kinetograph.markers import fitted_take, marker_sets, subjects
    from kinetograph.markers.people import split_name

    signals = [track for track in take.tracks.values() if isinstance(track, Signal)]
    gait = marker_sets()["plug_in_gait"]
    points = [name for signal in signals if signal.spatial for name in signal.names]
    marked = markers is not None or source.suffix.lower() == ".c3d" or any(split_name(name, gait) for name in points)
    marked = marked or any(subjects(signal) for signal in signals)
    if len(signals) < len(take.tracks) or not marked:
        return take, {}, ()
    take, fits = fitted_take(take, markers)
    notes: list[str] = []
    for name, fit in fits.items():
        whole = fit.residuals()[-1]
        notes.append(
            f"{name}: fitted to {len(fit.places)} markers, which miss by "
            f"{whole['mean_mm']:.1f} mm in the mean, {whole['p95_mm']:.1f} for 95 %, {whole['max_mm']:.1f} at most"
        )
        notes += [f"{name}: {note}" for note in fit.notes]
    return take, fits, tuple(notes)
