"""How well cuts and labels that were found agree with those that a person made."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.take import Annotation


@dataclass(frozen=True)
class CutAgreement:
    """Cuts found against cuts expected. matched: pairs of one each, at most ``tolerance`` seconds apart.

    offset: mean distance in seconds of the pairs, not a number where there are none.
    """

    found: int
    expected: int
    matched: int
    offset: float
    tolerance: float

    @property
    def precision(self) -> float:
        """Share of the cuts found that were expected."""
        return self.matched / self.found if self.found else 0.0

    @property
    def recall(self) -> float:
        """Share of the cuts expected that were found."""
        return self.matched / self.expected if self.expected else 0.0

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall."""
        return 2 * self.matched / max(self.found + self.expected, 1)


def compare_cuts(found: Sequence[float], expected: Sequence[float], tolerance: float = 0.1) -> CutAgreement:
    """As many one-to-one pairs at most ``tolerance`` seconds apart as there can be, as close together as they can be.

    What was found before the first or after the last expected cut is left out: of those parts a person has said
    nothing. Raises RequestError without a cut to expect.

    >>> compare_cuts([0.02, 0.5, 1.04, 7.0], [0.0, 1.0, 2.0]).matched
    2
    """
    if len(expected) == 0 or not tolerance > 0:
        raise RequestError(f"expected a cut or more and a tolerance above 0, found {len(expected)} and {tolerance}")
    truth = np.sort(np.asarray(expected, dtype=np.float64))
    times = np.sort(np.asarray(found, dtype=np.float64))
    times = times[(times >= truth[0] - tolerance) & (times <= truth[-1] + tolerance)]
    apart = np.abs(times[:, None] - truth)
    near = apart <= tolerance + 1e-9
    too_far = 2 * tolerance * (len(times) + len(truth))  # dearer than all pairs together: the number counts first
    rows, columns = linear_sum_assignment(np.where(near, apart, too_far))
    pairs = apart[rows, columns][near[rows, columns]]
    offset = float(pairs.mean()) if len(pairs) else float("nan")
    return CutAgreement(len(times), len(truth), len(pairs), offset, tolerance)


def compare_labels(found: Iterable[Annotation], expected: Iterable[Annotation]) -> float:
    """Share of the time labelled by a person over which exactly the same labels were found; not a number without any.

    Annotations of one kind, of one track.
    """
    found, expected = tuple(found), tuple(expected)
    times = sorted({t for note in (*found, *expected) for t in (note.start, note.stop)})
    labelled = agreed = 0.0
    for start, stop in itertools.pairwise(times):
        middle = 0.5 * (start + stop)
        truth = _labels_at(expected, middle)
        labelled += (stop - start) * bool(truth)
        agreed += (stop - start) * bool(truth and truth == _labels_at(found, middle))
    return agreed / labelled if labelled else float("nan")


def _labels_at(notes: tuple[Annotation, ...], time: float) -> set[str]:
    return {note.label for note in notes if note.start <= time < note.stop}


def even_cuts(duration: float, length: float, phase: float = 0.5) -> FloatArray:
    """Cuts ``length`` seconds apart, the first ``phase`` of a length from the start: what knows nothing of a motion."""
    return np.arange(phase * length, duration, length)
