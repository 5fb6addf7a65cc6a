"""Animation curves of FBX: their keys, and their values between keys and beyond the ends.

Between two keys a curve is constant, linear, or a cubic Bezier curve in time and value. Its slopes are the file's own,
or follow from the neighbouring keys: automatic ones from the mean of the slopes on both sides, and those of tension,
continuity and bias as Kochanek and Bartels define them.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.errors import FormatError
from kinetograph.formats.fbx.nodes import Node
from kinetograph.formats.timing import bracket_times

Bools = npt.NDArray[np.bool_]

LARGEST = 1e12
"""Numbers beyond this are damage."""

CONSTANT, LINEAR, CUBIC = 1 << 1, 1 << 2, 1 << 3
"""Bits of a key's flags: how the curve runs to the next key."""

CONSTANT_NEXT = 1 << 8
"""Constant at the value of the next key."""

AUTO, TCB, USER = 1 << 8, 1 << 9, 1 << 10
"""Where the slopes of a cubic key come from."""

CLAMP, TIME_INDEPENDENT, PROGRESSIVE = 1 << 12, 1 << 13, 1 << 14
"""How automatic slopes are found."""

WEIGHTED_RIGHT, WEIGHTED_LEFT = 1 << 24, 1 << 25
"""Whether the tangents of the interval after a key have weights of their own."""

EXACT_WEIGHTS = "Weights"
"""The node of a curve that has weights which are not rounded, of files that give them so."""

_THIRD = 1.0 / 3.0
_WEIGHT = 1e-4  # unit of the weights in a file
_SLACK = 1e-8  # seconds by which a time may miss a key
_MOST_SECONDS = 1e6


@dataclass(frozen=True)
class Extrapolation:
    """How a curve goes on beyond an end.

    Parameters
    ----------
    kind : str
        ``"C"`` constant, ``"K"`` with its slope, ``"R"`` repeated, ``"A"`` repeated and added up, ``"M"`` mirrored.
    times : int
        How often it is repeated; below zero, always.
    """

    kind: str = "C"
    times: int = -1


@dataclass(frozen=True, eq=False)
class Intervals:
    """How a curve runs between its keys.

    Parameters
    ----------
    kinds : ndarray of int, shape (K - 1,)
        Flags.
    slopes, weights : ndarray, shape (K - 1, 2)
        Leaving the first key and arriving at the second: values per second, and shares of the interval.
    """

    kinds: IntArray
    slopes: FloatArray
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve of K keys.

    Parameters
    ----------
    times, values : ndarray, shape (K,)
        Seconds, increasing, and what the property is.
    intervals : Intervals, optional
        Linear without them.
    before, after : Extrapolation
    """

    times: FloatArray
    values: FloatArray
    intervals: Intervals | None = None
    before: Extrapolation = Extrapolation()
    after: Extrapolation = Extrapolation()

    def at(self, times: FloatArray) -> FloatArray:
        """Values at some times, both of shape ``(F,)``."""
        if len(self.times) == 1:
            return np.full(len(times), self.values[0])
        shifted, added = _extrapolated(self, times)
        if self.intervals is None:
            inside = np.asarray(np.interp(shifted, self.times, self.values))
        else:
            inside = self._inside(self.intervals, shifted)
        return inside if added is None else inside + added

    def end_slopes(self) -> tuple[float, float]:
        """Slopes at the first and the last key."""
        if self.intervals is not None:
            return float(self.intervals.slopes[0, 0]), float(self.intervals.slopes[-1, 1])
        times, values = self.times[[0, 1, -2, -1]], self.values[[0, 1, -2, -1]]
        first, _, last = np.diff(values) / np.maximum(np.diff(times), 1e-300)
        return float(first), float(last)

    def _inside(self, intervals: Intervals, times: FloatArray) -> FloatArray:
        lower, upper, _ = bracket_times(times + _SLACK, self.times)
        share = np.clip((times - self.times[lower]) / (self.times[upper] - self.times[lower]), 0.0, 1.0)
        start, stop, kind = self.values[lower], self.values[upper], intervals.kinds[lower]
        out = start + share * (stop - start)
        still = (kind & CONSTANT) != 0
        past = (share == 1) | ((kind & CONSTANT_NEXT != 0) & (times > self.times[lower] + _SLACK))
        out = np.where(still, np.where(past, stop, start), out)
        cubic = np.flatnonzero(~still & (kind & CUBIC != 0))
        out[cubic] = _bezier(self, intervals, lower[cubic], share[cubic])
        return np.asarray(out)


def _bezier(curve: Curve, intervals: Intervals, lower: IntArray, share: FloatArray) -> FloatArray:
    first, second = intervals.weights[lower].T
    leave, arrive = intervals.slopes[lower].T
    span = curve.times[lower + 1] - curve.times[lower]
    place = share.copy()
    weighted = np.flatnonzero((np.abs(first - _THIRD) > 1e-6) | (np.abs(second - _THIRD) > 1e-6))
    if len(weighted):
        place[weighted] = _parameter(share[weighted], first[weighted], 1 - second[weighted])
    begin, end = curve.values[lower], curve.values[lower + 1]
    ends = begin, begin + first * span * leave, end - second * span * arrive, end
    return _bernstein(place, *ends)


def _bernstein(u: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    v = 1 - u
    return np.asarray(v * v * v * a + 3 * u * v * (v * b + u * c) + u * u * u * d)


def _parameter(share: FloatArray, first: FloatArray, second: FloatArray) -> FloatArray:
    """Where a Bezier curve in time, which never goes back, is at a share of its interval: by halving."""
    low, high = np.zeros(len(share)), np.ones(len(share))
    for _ in range(48):
        middle = 0.5 * (low + high)
        early = _bernstein(middle, np.zeros(len(share)), first, second, np.ones(len(share))) < share
        low, high = np.where(early, middle, low), np.where(early, high, middle)
    return 0.5 * (low + high)


def _extrapolated(curve: Curve, times: FloatArray) -> tuple[FloatArray, FloatArray | None]:
    """Times between the curve's ends in place of those beyond them, and what is added to the values there."""
    first, last = curve.times[0], curve.times[-1]
    beyond = ((curve.before, times < first - _SLACK), (curve.after, times > last + _SLACK))
    if all(how.kind == "C" or not outside.any() for how, outside in beyond):
        return times, None
    times, added = times.copy(), np.zeros(len(times))
    for side, (how, outside) in enumerate(beyond):
        away = times[outside] - last if side else first - times[outside]
        if how.kind == "K":
            added[outside] = away * (curve.end_slopes()[1] if side else -curve.end_slopes()[0])
        elif how.kind in "RAM" and how.times != 0:
            rounds, rest = np.divmod(away, last - first)
            over = (rounds >= how.times) & (how.times > 0)
            rounds, rest = np.where(over, how.times - 1, rounds), np.where(over, last - first, rest)
            if how.kind == "M":
                rest = np.where(rounds % 2 == 0, last - first - rest, rest)
            times[outside] = first + rest if side else last - rest
            if how.kind == "A":
                added[outside] = (rounds + 1) * (curve.values[-1] - curve.values[0]) * (1 if side else -1)
    return times, added


# ---- reading ----


def parse_curve(path: Path, node: Node, ticks: int) -> Curve | None:
    """An AnimationCurve, whose times are in ``ticks`` a second; ``None`` without keys. Raises FormatError."""
    keys, numbers = node.numbers("KeyTime"), node.numbers("KeyValueFloat")
    if keys is None or numbers is None or len(keys) != len(numbers):
        raise FormatError(path, "expected an animation curve to have as many times as values")
    if len(keys) == 0:
        return None
    count, times, values = len(keys), keys.astype(np.float64) / ticks, numbers.astype(np.float64)
    if not np.abs(times).max() <= _MOST_SECONDS or np.any(np.diff(times) < 0):
        raise FormatError(path, "expected the times of an animation curve to increase")
    if not np.abs(values).max() < LARGEST:
        raise FormatError(path, "expected finite numbers in an animation curve")
    kinds, data, weights = _attributes(node, count)
    kept = np.flatnonzero(np.append(np.diff(times) > 0, True))  # of keys at one time the last
    if len(kept) < len(times):
        times, values = times[kept], values[kept]
    intervals = None
    if len(times) > 1 and np.any(kinds & (CONSTANT | CUBIC)):
        kinds = np.broadcast_to(kinds, count)[kept]
        data, weights = np.broadcast_to(data, (count, 3))[kept], np.broadcast_to(weights, (count, 2))[kept]
        intervals = Intervals(kinds[:-1], _slopes(times, values, kinds, data, weights), weights[:-1])
    before, after = (_extrapolation(node.child(name)) for name in ("Pre-Extrapolation", "Post-Extrapolation"))
    return Curve(times, values, intervals, before, after)


def _attributes(node: Node, count: int) -> tuple[IntArray, FloatArray, FloatArray]:
    """Flags, the first three numbers, and weights of the keys, of shapes ``(K,)``, ``(K, 3)`` and ``(K, 2)``.

    A single row counts for all keys; where they are damaged, they say linear.
    """
    flags, data, repeats = (node.numbers(f"KeyAttr{name}") for name in ("Flags", "DataFloat", "RefCount"))
    rows = 0 if flags is None else len(flags)
    whole = flags is not None and repeats is not None and flags.dtype.kind == repeats.dtype.kind == "i"
    if (
        flags is None
        or data is None
        or repeats is None
        or not whole
        or not 4 <= 4 * rows == len(data) == 4 * len(repeats)
    ):
        return np.full(1, LINEAR), np.zeros((1, 3)), np.full((1, 2), _THIRD)
    if data.dtype.kind in "iu":  # files in text have the bits of these numbers
        data = data.astype(np.int64).astype(np.uint32).view(np.float32)
    with np.errstate(over="ignore", invalid="ignore"):
        table = data.astype(np.float32).reshape(-1, 4)
    packed = np.ascontiguousarray(table[:, 2]).view(np.uint32)
    kinds = flags.astype(np.int64)
    shares = np.column_stack([packed & 0xFFFF, packed >> 16]) * _WEIGHT
    own = np.column_stack([kinds & WEIGHTED_RIGHT, kinds & WEIGHTED_LEFT]) != 0
    own &= (kinds & CUBIC != 0)[:, None] & ((kinds & TCB == 0)[:, None] | np.array([True, False]))
    exact = node.numbers(EXACT_WEIGHTS)
    if exact is not None and len(exact) == 2 * rows:
        shares = exact.reshape(-1, 2)
    weights = np.where(own, np.clip(shares, 1e-4, 1.0), _THIRD)
    finite = np.clip(np.nan_to_num(table[:, :3].astype(np.float64)), -LARGEST, LARGEST)
    if rows == 1:
        return kinds, finite, weights
    stops = np.cumsum(np.clip(repeats.astype(np.int64), 0, count))
    row = np.minimum(np.searchsorted(stops, np.arange(count), side="right"), rows - 1)
    return kinds[row], finite[row], weights[row]


def _slopes(
    times: FloatArray, values: FloatArray, kinds: IntArray, data: FloatArray, weights: FloatArray
) -> FloatArray:
    """Slopes leaving and arriving, shape ``(K - 1, 2)``, of every interval."""
    chords = np.diff(values) / np.diff(times)
    straight = kinds & (CONSTANT | CUBIC) == 0
    right = np.where(kinds & CUBIC != 0, data[:, 0], 0.0)
    left = np.zeros(len(times))
    left[1:] = np.where(kinds[:-1] & CUBIC != 0, np.where(kinds[:-1] & TCB != 0, 0.0, data[:-1, 1]), 0.0)
    right[:-1] = np.where(straight[:-1], chords, right[:-1])
    left[1:] = np.where(straight[:-1], chords, left[1:])
    cubic = kinds & CUBIC != 0
    chosen = np.flatnonzero(cubic & (kinds & TCB != 0))
    if len(chosen):
        left[chosen], right[chosen] = _kochanek_bartels(chords, chosen, data[chosen])
    chosen = np.flatnonzero(cubic & (kinds & (TCB | USER) == 0))
    if len(chosen) and len(chords):
        left[chosen], right[chosen] = _automatic(times, values, kinds, weights, chosen, (left[chosen], right[chosen]))
    return np.column_stack([right[:-1], left[1:]])


def _sides(chords: FloatArray, chosen: IntArray) -> tuple[FloatArray, FloatArray, Bools, Bools]:
    """The chords before and after some keys, zero beyond the ends, and whether there are any."""
    padded = np.concatenate([[0.0], chords, [0.0]])
    return padded[chosen], padded[chosen + 1], chosen > 0, chosen < len(chords)


def _kochanek_bartels(chords: FloatArray, chosen: IntArray, data: FloatArray) -> tuple[FloatArray, FloatArray]:
    before, after, has_before, has_after = _sides(chords, chosen)
    tension, continuity, bias = data.T
    factor = np.where(has_before & has_after, 0.5, 1.0) * (1 - tension)
    one, other = factor * (1 + bias), factor * (1 - bias)
    left = one * (1 - continuity) * before + other * (1 + continuity) * after
    right = one * (1 + continuity) * before + other * (1 - continuity) * after
    return left, right


def _automatic(
    times: FloatArray,
    values: FloatArray,
    kinds: IntArray,
    weights: FloatArray,
    chosen: IntArray,
    biases: tuple[FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """Slopes on both sides of keys whose tangents are automatic, from their neighbours and biases in percent."""
    flags = kinds[chosen]
    before, after, has_before, has_after = _sides(np.diff(values) / np.diff(times), chosen)
    inner = has_before & has_after
    last, following = np.maximum(chosen - 1, 0), np.minimum(chosen + 1, len(times) - 1)
    spans = times[chosen] - times[last], times[following] - times[chosen]
    free = flags & TIME_INDEPENDENT == 0
    share = spans[0] / (spans[0] + spans[1])
    mean = (values[following] - values[last]) / (times[following] - times[last])
    blend = np.where(free, 0.5 * mean + 0.5 * (before * (1 - share) + after * share), mean)
    ends = np.where(has_before, before, after)
    left_bias, right_bias = biases
    together = inner & (np.abs(left_bias + right_bias) <= 1e-4)
    left_bias = np.where(together, right_bias, -left_bias)
    right_bias = np.where(inner | ~has_before, right_bias, left_bias)
    left_bias = np.where(has_before, left_bias, right_bias)
    out = []
    for bias in (left_bias, right_bias):
        biased = _biased(blend, before, after, bias)
        slope = np.where(inner, np.where(free, biased, blend), ends + np.where(free, _beyond(bias) * _sign(bias), 0.0))
        out.append(_clamped(slope, flags, values, (last, chosen, following), spans, weights))
    return out[0], out[1]


def _sign(numbers: FloatArray) -> FloatArray:
    return np.where(numbers > 0, 1.0, -1.0)


def _beyond(bias: FloatArray) -> FloatArray:
    """What a bias beyond 500 percent adds to a slope."""
    return np.asarray(40.0 * np.maximum(np.abs(bias) / 100.0 - 5.0, 0.0) ** 2)


def _biased(slope: FloatArray, before: FloatArray, after: FloatArray, bias: FloatArray) -> FloatArray:
    """A slope moved towards the chord after a key by a positive bias, before it by a negative one."""
    target = np.where(bias > 0, after, before)
    difference = target - slope
    moved = slope + np.abs(bias) / 100.0 * difference
    way = np.where(np.abs(difference) > 1e-5, difference, bias)
    return np.asarray(np.where(np.abs(bias) > 0.01, moved + _beyond(bias) * _sign(way), slope))


def _clamped(
    slope: FloatArray,
    flags: IntArray,
    values: FloatArray,
    near: tuple[IntArray, IntArray, IntArray],
    spans: tuple[FloatArray, FloatArray],
    weights: FloatArray,
) -> FloatArray:
    """Slopes without overshoot: zero next to an equal key, or no steeper than the tangents reach the next keys."""
    last, here, following = near
    inner = (spans[0] > 0) & (spans[1] > 0)
    steps = values[here] - values[last], values[following] - values[here]
    small = [np.where(span > 0, np.abs(step), np.inf) for step, span in zip(steps, spans, strict=True)]
    flat = (flags & CLAMP != 0) & (np.minimum(*small) <= 1e-9)
    sign = np.where(slope >= 0, 1.0, -1.0)
    reach = weights[last, 1] * spans[0], weights[here, 0] * spans[1]
    steep = [np.where(r > 0, sign * step / np.where(r > 0, r, 1.0), 0.0) for r, step in zip(reach, steps, strict=True)]
    limited = sign * np.minimum(np.abs(slope), np.maximum(np.minimum(*steep), 0.0))
    slope = np.where(flags & PROGRESSIVE != 0, np.where(inner, limited, 0.0), slope)
    return np.asarray(np.where(flat, 0.0, slope))


def _extrapolation(node: Node | None) -> Extrapolation:
    kind, times = (node.child(name) if node else None for name in ("Type", "Repetition"))
    letter = kind.values[0] if kind and kind.values else "C"
    letter = chr(letter) if isinstance(letter, int) and 32 < letter < 127 else letter
    number = times.values[0] if times and times.values else -1
    good = isinstance(letter, str) and letter in ("C", "K", "R", "A", "M")
    return Extrapolation(letter if good else "C", number if isinstance(number, int) and abs(number) < 2**31 else -1)
