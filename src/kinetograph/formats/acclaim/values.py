"""The values of an ``.amc`` file: a frame's number alone on a line, then one line per bone."""

from __future__ import annotations

from array import array
from dataclasses import dataclass
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
        Take the frames before the first fault.

    Returns
    -------
    Values

    Raises
    ------
    FormatError
        With the line.
    """
    table = _Table(path, asf)
    frames, notes = table.read(), []
    if table.fault is not None:
        if not lenient or frames < 2:
            raise table.fault
        frames -= 1
        notes.append(f"{table.fault}: took {frames} frames before it")
    if frames == 0 or not table.rows:
        raise FormatError(path, "expected frames: a number alone on a line, then one line per bone; found none")
    given = sum(len(values) // max(table.widths[name], 1) for name, values in table.rows.items())
    if frames * (len(asf.bones) + 1) > 1_000_000 + _CROWDED * given:
        raise FormatError(path, "expected values for most bones, found few; is the file damaged?")
    columns = {
        name: np.array(values[: frames * table.widths[name]]).reshape(frames, table.widths[name])
        for name, values in table.rows.items()
        if name in table.first  # not those that only the frame at fault has
    }
    # some programs write three angles for every bone, whatever its degrees of freedom are
    odd = [n for n, values in columns.items() if values.shape[1] != len(_freedoms(asf, n))]
    if odd:
        notes.append(f"{len(odd)} bones have three angles where the skeleton names fewer: taken as rx ry rz")
    return Values(columns, frames, tuple(notes))


class _Table:
    """Rows of values by bone, as far as they have been read, and the first fault."""

    def __init__(self, path: Path, asf: Asf) -> None:
        self.path, self.asf = path, asf
        self.rows: dict[str, array[float]] = {}  # a list would take ten times the file
        self.widths: dict[str, int] = {}
        self.frame = 0
        self.seen: set[str] = set()
        self.first: set[str] = set()
        self.fault: FormatError | None = None

    def read(self) -> int:
        """Read up to the end or the first fault; the number of frames, one with the fault included."""
        for number, words in text_lines(self.path):
            if words[0][0] in "#:":
                continue
            if len(words) == 1 and words[0].isdigit():
                self.fault = self.close(number, "")
                if self.fault is None:
                    self.frame, self.seen = self.frame + 1, set()
            else:
                self.fault = self.add(number, words)
            if self.fault is not None:
                return self.frame
        self.fault = self.close(None, "; is the file cut short?")
        return self.frame

    def close(self, line: int | None, advice: str) -> FormatError | None:
        """The fault of the frame that ends here: every frame has the bones of the first one."""
        if self.frame == 1:
            self.first = self.seen
        if self.seen == self.first:
            return None
        return FormatError(self.path, f"frame {self.frame} has other bones than the first one{advice}", line=line)

    def add(self, number: int, words: list[str]) -> FormatError | None:
        """Add a line; its fault where it has one."""
        name = words[0]
        if self.frame == 0:
            return self.error(number, f"expected a frame's number, found {name[:40]!r}")
        if name != ROOT and name not in self.asf.bones:
            return self.error(number, f"expected a bone of the skeleton, found {name[:40]!r}; is it another's?")
        if name in self.seen:
            return self.error(number, f"bone {name!r} occurs twice in frame {self.frame}")
        try:
            values = [float(word) for word in words[1:]]
        except ValueError:
            return self.error(number, f"expected numbers after {name!r}, found {' '.join(words[1:])[:40]!r}")
        if not all(abs(value) < _LARGEST for value in values):
            return self.error(number, f"expected finite numbers after {name!r}")
        expected = self.widths.setdefault(name, len(values))
        if len(values) != expected or not _fits(self.asf, name, expected):
            wanted = len(_freedoms(self.asf, name))
            return self.error(number, f"expected {wanted} numbers after {name!r}, found {len(values)}")
        self.seen.add(name)
        self.rows.setdefault(name, array("d")).extend(values)
        return None

    def error(self, line: int, message: str) -> FormatError:
        return FormatError(self.path, message, line=line)


def _freedoms(asf: Asf, name: str) -> tuple[str, ...]:
    return asf.order if name == ROOT else asf.bones[name].freedoms


def _fits(asf: Asf, name: str, count: int) -> bool:
    return count == len(_freedoms(asf, name)) or (count == 3 and name != ROOT)
