"""Live control: one control frame at a time, a piece decided as soon as it must be (Hsu 2004, chapter 7).

The search is the one that answers a whole control; what is added is *commitment*. Without a lag a piece is committed
when every hypothesis that may still win has it, which changes nothing. With one, the motion is needed ``lag`` seconds
after its control, and what is needed is decided: which segment goes on by then, and since when. That binds the search.
How far the segment is stretched is open until it ends, since little of that has been seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.learn import SegmentalPath
from kinetograph.methods.performance.control import Control, points_of
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.forecast import Continuations
from kinetograph.methods.performance.live_frames import LatestFrames
from kinetograph.methods.performance.live_motion import LiveMotion, Partner
from kinetograph.methods.performance.live_search import Link, LiveSearch
from kinetograph.methods.performance.pieces import pieces_of
from kinetograph.methods.performance.realization import realize
from kinetograph.methods.performance.scoring import at_rate
from kinetograph.motion import Motion
from kinetograph.rows import KeptRows, LatestRows
from kinetograph.sampling import interpolate
from kinetograph.synthesis import LivePose, Piece, Synthesis

KNOWN = 1.5
"""Seconds of what is known to come that a decision looks at."""
FARTHEST = 1e5
"""Metres from the origin within which a control stays: the search's numbers are exact to millimetres up to there."""


@dataclass(eq=False)
class Live:
    """A control under way. Made by `PerformanceModel.start`; `step` it frame by frame and `finish` it once.

    Parameters
    ----------
    fitted : Fitted
    fps : float
        Rate of the control's frames.
    lag : float, optional
        Seconds after which motion is decided, in whole steps of the search, rounded down, but one at least; None waits
        for the end, and the whole is then that of a control which was known from the start.
    keep : bool
        Whether the control is kept for `finish`, on disk but for its latest part; without it a run may last for days,
        and `rest` gives its last frames.
    forecast : bool, optional
        Whether decisions look ahead, at what controls like this one did next in the recordings. Unless given, they do
        where the lag is shorter than segments are in the median: longer ones would be begun before they are seen.
    """

    fitted: Fitted
    fps: float
    lag: float | None = None
    keep: bool = True
    forecast: bool | None = None
    _frames: LatestFrames = field(init=False)
    _arrived: _Arrived = field(init=False)
    _search: LiveSearch = field(init=False)
    _partner: Partner | None = None

    def __post_init__(self) -> None:
        steps = None if self.lag is None else max(int(self.lag * self.fitted.settings.rate + 1e-6), 1)
        forecast = (
            Continuations.of(self.fitted)
            if steps is not None and _looks_ahead(self.fitted, steps, self.forecast)
            else None
        )
        self._arrived = _Arrived(self.fps, self.keep)
        self._frames = LatestFrames(self.keep)
        self._search = LiveSearch(self.fitted, steps, keep=self.keep, forecast=forecast)

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """The pieces that are committed, the last of them with its likeliest end.

        A piece is placed by what has been seen of the control.
        """
        rate = self.fitted.settings.rate
        if self.keep and self._arrived.count:
            return _pieces(self.fitted, self._search.committed, at_rate(self._arrived.all(), self.fps, rate), 0)
        samples = self._search.samples
        return _pieces(self.fitted, self._search.committed, samples.since(samples.first), samples.first)

    def step(self, frame: Motion | FloatArray, ahead: FloatArray | None = None) -> tuple[LivePose, ...]:
        """Take one frame of control and give the frames of motion that it settles.

        Without a lag nothing is settled before `finish`.

        Parameters
        ----------
        frame : Motion or ndarray, shape (P, 3)
            A motion of one frame, or control points.
        ahead : ndarray, shape (H, P, 3), optional
            The control points after this frame, as far as they are known: the rest of a drawn path.

        Returns
        -------
        tuple of LivePose

        Raises
        ------
        RequestError
            For control points of another shape, or that are not within `FARTHEST`, for a motion of several frames, and
            for a frame of another skeleton than the first. Nothing is taken then: the next frame may come.
        """
        if isinstance(frame, Motion):
            return self._take_frame(frame)
        return self._take(np.asarray(frame, dtype=np.float64), ahead)

    def rest(self) -> tuple[LivePose, ...]:
        """The frames that are left when no more control will come; nothing without a lag."""
        if self.lag is None or self._search.latest is None:
            return ()
        rate, end = self.fitted.settings.rate, (self._arrived.count - 1) / self.fps
        poses: list[LivePose] = []
        for link in self._search.rest():
            self._motion.decide(link, *self._latest_samples())
            poses += self._motion.until(min(link[2] / rate - 0.5 / self._motion.fps, end))
        return (*poses, *self._motion.until(end))

    def finish(self) -> Synthesis:
        """Close the control: the whole motion, made as that of a control which was known from the start.

        Raises
        ------
        RequestError
            For a control that is too short, and where nothing was kept.
        """
        if not self.keep:
            raise RequestError("frames were not kept, so that there is no whole; use rest for those that are left")
        settings = self.fitted.settings
        if self._arrived.count < self._frames.count:
            self._take(points_of(settings, self._frames.latest(3))[-1])
        partner = self._frames.all() if self._frames.count == self._arrived.count > 0 else None
        return realize(self.fitted, Control(self._arrived.all(), self.fps, partner), self.path())

    def path(self) -> SegmentalPath:
        """The best sequence for the control so far that goes on from what is committed."""
        return self._search.path()

    @cached_property
    def _motion(self) -> LiveMotion:
        return LiveMotion(self.fitted, self._partner)

    def _take_frame(self, frame: Motion) -> tuple[LivePose, ...]:
        """Control points of the latest frame or, where velocities are wanted, of the one before it."""
        settings = self.fitted.settings
        alone = settings.control_points.frame_by_frame
        points = points_of(settings, self._frames.with_next(frame, 1 if alone else 3))
        points = points[:1] if alone else points[-2:-1]
        for each in points:
            _check(self.fitted, each)
        self._frames.add(frame)
        if self._partner is None and settings.post.handholds:
            self._partner = Partner(self.fps)
        if self._partner is not None:
            self._partner.add(frame)
        return self._take(points[0]) if len(points) else ()

    def _take(self, points: FloatArray, ahead: FloatArray | None = None) -> tuple[LivePose, ...]:
        """One more frame of control points; as many steps of the search as it completes."""
        _check(self.fitted, points)
        self._arrived.add(points)
        rate, steps = self.fitted.settings.rate, self._search.samples
        poses: list[LivePose] = []
        while len(steps) / rate * self.fps <= self._arrived.count - 1 + 1e-6:
            position = len(steps) / rate * self.fps
            known = None if ahead is None else self._arrived.after(ahead, position, rate)
            self._search.step(self._arrived.at(position), known)
            poses += self._settled()
        return tuple(poses)

    def _settled(self) -> list[LivePose]:
        """The frames that the latest step of the search settles."""
        search = self._search
        if search.lag is None or search.latest is None:
            return []
        self._motion.decide(search.latest, *self._latest_samples())
        return self._motion.until((len(search.samples) - 1 - search.lag) / self.fitted.settings.rate)

    def _latest_samples(self) -> tuple[FloatArray, int]:
        """Control points that placing a piece may need, and the step of the first."""
        samples = self._search.samples
        first = max(len(samples) - self.fitted.instances.longest - (self._search.lag or 0) - 1, samples.first)
        return samples.since(first), first


@dataclass(eq=False)
class _Arrived:
    """Control points as they arrive, at ``fps``: the latest second and, if they are kept, all of them."""

    fps: float
    keep: bool
    kept: KeptRows | None = None

    def __post_init__(self) -> None:
        self.latest = LatestRows(max(round(self.fps), 3))

    @property
    def count(self) -> int:
        """How many frames there were."""
        return len(self.latest)

    def add(self, points: FloatArray) -> None:
        """Take the next frame's."""
        if self.keep:
            self.kept = self.kept or KeptRows(points.shape)
            self.kept.add(points)
        self.latest.add(points)

    def all(self) -> FloatArray:
        """All that were kept, ``(F, P, 3)``."""
        return np.zeros((0, 0, 3)) if self.kept is None else self.kept.all()

    def at(self, position: float) -> FloatArray:
        """Control points ``(P, 3)`` at a fractional frame."""
        low = min(int(position + 1e-9), self.count - 1)
        near = self.latest.since(low)[:2]
        return np.asarray(interpolate(near, [position - low])[0])

    def after(self, ahead: FloatArray, position: float, rate: float) -> FloatArray:
        """What is known to come after a fractional frame, at ``rate`` and up to `KNOWN` seconds: ``(H, P, 3)``."""
        line = np.concatenate([self.latest.last(1), np.asarray(ahead, dtype=np.float64)])
        per_step = self.fps / rate
        begin = position - (self.count - 1) + per_step
        count = min(int((len(line) - 1 - begin) / per_step + 1e-6) + 1, round(KNOWN * rate))
        return interpolate(line, begin + per_step * np.arange(max(count, 0)))


def _check(fitted: Fitted, points: FloatArray) -> None:
    """Raise RequestError for control points that cannot be followed."""
    expected = fitted.sources[0].control_points.shape[1:]
    if points.shape != expected or not np.isfinite(points).all():
        raise RequestError(f"expected a frame of finite control points {expected}, found shape {points.shape}")
    far = float(np.abs(points).max(initial=0.0))
    if far > FARTHEST:
        raise RequestError(
            f"expected control points within {FARTHEST / 1000:.0f} km of the origin, found {far:g} m; leave such "
            "frames out, and look at their units"
        )


def _looks_ahead(fitted: Fitted, lag: int, wanted: bool | None) -> bool:
    """Whether decisions look ahead, unless it is given: where segments are longer than a lag, in steps."""
    return lag < float(np.median(fitted.search.durations[~fitted.instances.held])) if wanted is None else wanted


def _pieces(fitted: Fitted, committed: Sequence[Link], x: FloatArray, first: int) -> tuple[Piece, ...]:
    """The pieces that are committed, placed by control points at the search's rate, of which the first has a number."""
    rate = fitted.settings.rate
    pieces: list[Piece] = []
    for state, start, stop in committed:
        borders = np.array([start - first, stop - first], dtype=float)
        made = pieces_of(fitted, x, rate, [fitted.segment_of(state)], borders)
        pieces += [replace(piece, start=start / rate, stop=stop / rate) for piece in made]
    return tuple(pieces)
