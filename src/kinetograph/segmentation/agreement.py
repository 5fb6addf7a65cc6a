"""How well detected cuts and labels agree with those that a person made."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.take import Annotation


@dataclass(frozen=True)
class CutAgreement:
    """Detected cuts compared with expected cuts.

    Parameters
    ----------
    detected, expected : int
        Numbers of detected and of expected cuts.
    matched : int
        Number of pairs of one of each, at most ``tolerance`` apart.
    offset : float
        Mean distance of the pairs in seconds; not a number where there are none.
    tolerance : float
        Seconds.
    """

    detected: int
    expected: int
    matched: int
    offset: float
    tolerance: float

    @property
    def precision(self) -> float:
        """Share of the detected cuts that were expected."""
        return self.matched / self.detected if self.detected else 0.0

    @property
    def recall(self) -> float:
        """Share of the expected cuts that were detected."""
        return self.matched / self.expected if self.expected else 0.0

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall."""
        return 2 * self.matched / max(self.detected + self.expected, 1)


def compare_cuts(detected: Sequence[float], expected: Sequence[float], tolerance: float = 0.1) -> CutAgreement:
    """Detected cuts compared with those that a person made.

    Cuts are paired one to one, as many as can be within the tolerance and as closely as they can be. Cuts detected
    before the first or after the last expected one are left out, since the person has not cut those parts.

    Parameters
    ----------
    detected, expected : sequence of float
        Seconds.
    tolerance : float
        Seconds between the two cuts of a pair.

    Returns
    -------
    CutAgreement

    Raises
    ------
    RequestError
        If there is no expected cut, or the tolerance is not above 0.

    Examples
    --------
    >>> compare_cuts([0.02, 0.5, 1.04, 7.0], [0.0, 1.0, 2.0]).matched
    2
    """
    if len(expected) == 0 or not tolerance > 0:
        raise RequestError(f"expected a cut or more and a tolerance above 0, found {len(expected)} and {tolerance}")
    truth = np.sort(np.asarray(expected, dtype=np.float64))
    times = np.sort(np.asarray(detected, dtype=np.float64))
    times = times[(times >= truth[0] - tolerance) & (times <= truth[-1] + tolerance)]
    apart = np.abs(times[:, None] - truth)
    near = apart <= tolerance + 1e-9
    too_far = 2 * tolerance * (len(times) + len(truth))  # dearer than all pairs together: the number counts first
    from scipy.optimize import linear_sum_assignment  # on first use: only comparisons need it

    rows, columns = linear_sum_assignment(np.where(near, apart, too_far))
    pairs = apart[rows, columns][near[rows, columns]]
    offset = float(pairs.mean()) if len(pairs) else float("nan")
    return CutAgreement(len(times), len(truth), len(pairs), offset, tolerance)


def compare_labels(detected: Iterable[Annotation], expected: Iterable[Annotation]) -> float:
    """Detected labels compared with those that a person gave.

    Parameters
    ----------
    detected, expected : iterable of Annotation
        Of one kind, on one track.

    Returns
    -------
    float
        Share of the time labelled by the person over which exactly the same labels were detected; not a number where
        there is no such time.
    """
    detected, expected = tuple(detected), tuple(expected)
    times = sorted({t for note in (*detected, *expected) for t in (note.start, note.stop)})
    labelled = agreed = 0.0
    for start, stop in itertools.pairwise(times):
        middle = 0.5 * (start + stop)
        truth = _labels_at(expected, middle)
        labelled += (stop - start) * bool(truth)
        agreed += (stop - start) * bool(truth and truth == _labels_at(detected, middle))
    return agreed / labelled if labelled else float("nan")


def _labels_at(notes: tuple[Annotation, ...], time: float) -> set[str]:
    return {note.label for note in notes if note.start <= time < note.stop}


def even_cuts(duration: float, length: float, phase: float = 0.5) -> FloatArray:
    """Cuts at equal distances, a baseline that does not look at the motion.

    Parameters
    ----------
    duration : float
        Seconds.
    length : float
        Seconds between cuts.
    phase : float
        Time of the first cut as a share of the length.

    Returns
    -------
    ndarray, shape (N,)
        Seconds.
    """
    return np.arange(phase * length, duration, length)
