"""The values of an ``.amc`` file: a frame's number alone on a line, then one line per bone."""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats.acclaim.skeleton import ROOT, Asf, text_lines

_LARGEST = 1e12
_CROWDED = 20  # joints per value read at most


@dataclass(frozen=True, eq=False)
class Values:
    """The values of a file.

    Parameters
    ----------
    columns : dict of str to ndarray, shape (F, n)
        By bone, as written.
    frames : int
        Number of frames.
    notes : tuple of str
        What was left out or reinterpreted.
    """

    columns: dict[str, FloatArray]
    frames: int
    notes: tuple[str, ...] = ()


def parse_values(path: Path, asf: Asf, lenient: bool) -> Values:
    """Read the values of every frame, the last one too.

    Parameters
    ----------
    path : Path
        An ``.amc`` file.
    asf : Asf
        Its skeleton.
    lenient : bool
        Take the frames that are whole, each that is damaged as the one before it; those at the ends are left out.

    Returns
    -------
    Values

    Raises
    ------
    FormatError
        With the line.

    Notes
    -----
    Leniently, a frame is whole if each of its lines can be read and it has the bones that most frames have.
    """
    table = _Table(path, asf, lenient)
    table.read()
    frames, notes = table.best(), []
    if frames is None or not frames.rows:
        if table.first_fault is not None:
            raise table.first_fault
        raise FormatError(path, "expected frames: a number alone on a line, then one line per bone; found none")
    at = np.array(frames.at)
    given = sum(len(values) // max(width, 1) for width, values in zip(frames.widths, frames.rows.values(), strict=True))
    if (at[-1] - at[0] + 1) * (len(asf.bones) + 1) > 1_000_000 + _CROWDED * given:
        raise FormatError(path, "expected values for most bones, found few; is the file damaged?")
    missing = int(at[-1] - at[0] + 1 - len(at))
    if table.first_fault is not None or len(at) < table.frames:
        if missing > len(at):
            raise FormatError(path, f"{missing} frames are damaged and {len(at)} whole; {table.why(frames)}")
        left = table.frames - len(at) - missing
        notes.append(f"{table.why(frames)}: took the {len(at)} whole frames, {missing} repeat the frame before")
        if left > 0:
            notes[-1] += f", {left} at an end are left out"
    source = np.searchsorted(at, np.arange(at[0], at[-1] + 1), side="right") - 1
    columns = {
        name: np.array(values).reshape(len(at), width)[source]
        for width, (name, values) in zip(frames.widths, frames.rows.items(), strict=True)
    }
    # some programs write three angles for every bone, whatever its degrees of freedom are
    odd = [n for n, values in columns.items() if values.shape[1] != len(_freedoms(asf, n))]
    if odd:
        notes.append(f"{len(odd)} bones have three angles where the skeleton names fewer: taken as rx ry rz")
    return Values(columns, len(source), tuple(notes))


@dataclass(eq=False)
class _Frames:
    """Frames with the same bones: their indices in the file, and the values of each bone."""

    widths: tuple[int, ...]
    at: list[int] = field(default_factory=list)
    rows: dict[str, array[float]] = field(default_factory=dict)  # lists would take ten times the file

    def add(self, index: int, frame: dict[str, list[float]]) -> None:
        self.at.append(index)
        for name, values in frame.items():
            self.rows.setdefault(name, array("d")).extend(values)


class _Table:
    """Frames as far as they have been read, by the bones that they have, and what is wrong with others."""

    def __init__(self, path: Path, asf: Asf, lenient: bool) -> None:
        self.path, self.asf, self.lenient = path, asf, lenient
        self.groups: dict[tuple[tuple[str, int], ...], _Frames] = {}
        self.frames = 0
        self.first_fault: FormatError | None = None
        self.frame: dict[str, list[float]] | None = None
        self.damaged = False

    def read(self) -> None:
        """Read to the end; strictly, to the first fault, which is raised."""
        for number, words in text_lines(self.path):
            if words[0][0] in "#:":
                continue
            if len(words) == 1 and words[0].isdigit():
                self.close(number, "")
                self.frame, self.damaged, self.frames = {}, False, self.frames + 1
            else:
                self.add(number, words)
        self.close(None, "; is the file cut short?")

    def best(self) -> _Frames | None:
        """The frames with the bones that most have, or with more bones where as many have them."""
        return max(self.groups.values(), key=lambda group: (len(group.at), len(group.rows)), default=None)

    def why(self, frames: _Frames) -> str:
        """The first fault, in words."""
        if self.first_fault is not None:
            return str(self.first_fault).replace(f"{self.path}:", "line ", 1)
        return f"{self.frames - len(frames.at)} frames have other bones than most"

    def close(self, line: int | None, advice: str) -> None:
        """Keep the frame that ends here: every frame has the bones of the first one."""
        if self.frame is None or self.damaged:
            return
        key = tuple((name, len(values)) for name, values in sorted(self.frame.items()))
        if not self.lenient and self.groups and key not in self.groups:
            self.fault(line, f"frame {self.frames} has other bones than the first one{advice}")
        frame = dict(sorted(self.frame.items()))
        group = self.groups.setdefault(key, _Frames(tuple(width for _, width in key)))
        group.add(self.frames, frame)

    def add(self, number: int, words: list[str]) -> None:
        """Add a line to the frame."""
        name = words[0]
        if self.frame is None:
            return self.fault(number, f"expected a frame's number, found {name[:40]!r}")
        if name != ROOT and name not in self.asf.bones:
            return self.fault(number, f"expected a bone of the skeleton, found {name[:40]!r}; is it another's?")
        if name in self.frame:
            return self.fault(number, f"bone {name!r} occurs twice in frame {self.frames}")
        try:
            values = [float(word) for word in words[1:]]
        except ValueError:
            return self.fault(number, f"expected numbers after {name!r}, found {' '.join(words[1:])[:40]!r}")
        if not all(abs(value) < _LARGEST for value in values):
            return self.fault(number, f"expected finite numbers after {name!r}")
        wanted = len(_freedoms(self.asf, name))
        if len(values) != wanted and (len(values) != 3 or name == ROOT):
            return self.fault(number, f"expected {wanted} numbers after {name!r}, found {len(values)}")
        self.frame[name] = values
        return None

    def fault(self, line: int | None, message: str) -> None:
        """What is wrong with the frame: an error, or a frame that is left out."""
        error = FormatError(self.path, message, line=line)
        if not self.lenient:
            raise error
        self.damaged = True
        self.first_fault = self.first_fault or error


def _freedoms(asf: Asf, name: str) -> tuple[str, ...]:
    return asf.order if name == ROOT else asf.bones[name].freedoms
