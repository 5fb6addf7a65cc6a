"""Live control: one control frame at a time, a piece decided as soon as it must be (Hsu 2004, chapter 7).

The search is the one that answers a whole control; what is added is *commitment*. Without a lag a piece is committed
when every hypothesis that may still win has it, which changes nothing. With one, the motion is needed ``lag`` seconds
after its control, and what is needed is decided: which segment goes on by then, and since when. That binds the search.
How far the segment is stretched is open until it ends, since little of that has been seen.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.learn import SegmentalPath
from kinetograph.methods.performance.control import Control, points_of
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.live_search import Link, LiveSearch
from kinetograph.methods.performance.pieces import pieces_of
from kinetograph.methods.performance.realization import realize
from kinetograph.motion import Motion, concatenate
from kinetograph.sampling import interpolate
from kinetograph.synthesis import Piece, Synthesis


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
        for agreement.
    """

    fitted: Fitted
    fps: float
    lag: float | None = None
    _frames: list[Motion] = field(default_factory=list)
    _points: list[FloatArray] = field(default_factory=list)
    _search: LiveSearch = field(init=False)

    def __post_init__(self) -> None:
        steps = None if self.lag is None else max(int(self.lag * self.fitted.settings.rate + 1e-6), 1)
        self._search = LiveSearch(self.fitted, steps)

    def step(self, frame: Motion | FloatArray) -> tuple[Piece, ...]:
        """Take one frame of control and give the pieces newly committed.

        A piece is committed before its end is reached: it is placed by what has been seen of the control, and its end
        is the likeliest.

        Parameters
        ----------
        frame : Motion or ndarray, shape (P, 3)
            A motion of one frame, or control points.

        Returns
        -------
        tuple of Piece

        Raises
        ------
        RequestError
            For control points of another shape, or that are not finite.
        """
        before = len(self._search.committed)
        if isinstance(frame, Motion):
            self._frames.append(frame)
            self._take_frame()
        else:
            self._take(np.asarray(frame, dtype=np.float64))
        return self._pieces(self._search.committed[before:])

    def finish(self) -> Synthesis:
        """Close the control: the whole motion, made as that of a control which was known from the start."""
        settings = self.fitted.settings
        if len(self._points) < len(self._frames):
            self._take(points_of(settings, concatenate(self._frames[-3:]))[-1])
        partner = concatenate(self._frames) if len(self._frames) == len(self._points) > 0 else None
        return realize(self.fitted, Control(np.stack(self._points), self.fps, partner), self.path())

    def path(self) -> SegmentalPath:
        """The best sequence for the control so far that goes on from what is committed."""
        return self._search.path()

    def _take_frame(self) -> None:
        """Control points of the latest frame or, where velocities are wanted, of the one before it."""
        settings = self.fitted.settings
        window = self._frames[-1:] if settings.control_points.frame_by_frame else self._frames[-3:]
        points = points_of(settings, concatenate(window))
        if settings.control_points.frame_by_frame:
            self._take(points[0])
        elif len(self._frames) > 1:
            self._take(points[-2])

    def _take(self, points: FloatArray) -> None:
        """One more frame of control points; as many steps of the search as it completes."""
        expected = self.fitted.sources[0].control_points.shape[1:]
        if points.shape != expected or not np.isfinite(points).all():
            raise RequestError(f"expected a frame of finite control points {expected}, found shape {points.shape}")
        self._points.append(points)
        rate, steps = self.fitted.settings.rate, self._search.samples
        while len(steps) / rate * self.fps <= len(self._points) - 1 + 1e-6:
            self._search.step(self._at(len(steps) / rate * self.fps))

    def _at(self, position: float) -> FloatArray:
        """Control points ``(P, 3)`` at a fractional frame."""
        low = min(int(position + 1e-9), len(self._points) - 1)
        near = np.stack(self._points[low : low + 2])
        return np.asarray(interpolate(near, [position - low])[0])

    def _pieces(self, links: list[Link]) -> tuple[Piece, ...]:
        samples = self._search.samples
        x = np.stack(samples) if samples else np.zeros((0, 0, 3))
        pieces: list[Piece] = []
        for state, start, stop in links:
            borders = np.array([start, stop], dtype=float)
            pieces += pieces_of(self.fitted, x, self.fitted.settings.rate, [self.fitted.segment_of(state)], borders)
        return tuple(pieces)
