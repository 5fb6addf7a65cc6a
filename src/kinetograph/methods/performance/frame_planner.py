"""Choosing what a steered body plays next by a programme over frames; see `kinetograph.learn.frame_programme`."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import FloatArray, SingleArray
from kinetograph.errors import RequestError
from kinetograph.learn import FrameRules, Plan, Playing, plan_frames
from kinetograph.learn.frame_programme import BEAM
from kinetograph.methods.performance.steering_frames import APART, ROWS, UNIT, States, SteeringFrames, make_states


@dataclass(frozen=True)
class PlannerSettings:
    """How far a planner looks, and what it pays.

    Parameters
    ----------
    horizon : float
        Seconds.
    jump_weight, jump_constant : float
        A jump costs ``jump_weight`` times the mean squared distance of the joints, and ``jump_constant``.
    neighbours : int
        Frames that may be jumped to from each frame.
    width : int
        Hypotheses of each frame.
    beam : int, optional
        Hypotheses of each unit; None keeps all that may win.
    """

    horizon: float = 1.5
    jump_weight: float = 4.0
    jump_constant: float = 1.6e-3
    neighbours: int = 64
    width: int = 1
    beam: int | None = BEAM

    def __post_init__(self) -> None:
        for name in ("horizon", "jump_weight", "jump_constant", "neighbours", "width"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise RequestError(f"{name} must be positive and finite, found {value}")

    @property
    def units(self) -> int:
        """Units of the horizon."""
        return max(round(self.horizon / UNIT), 1)


@dataclass(frozen=True, eq=False)
class Playhead:
    """What is playing, and where.

    Parameters
    ----------
    recording : int
    second : float
        Time in it.
    body : ndarray, shape (4,)
        Place ``z, x``, facing and rate.
    """

    recording: int
    second: float
    body: FloatArray


@dataclass(eq=False)
class FramePlanner:
    """Plans by the frame programme.

    Parameters
    ----------
    frames : SteeringFrames
    rules : FrameRules
        How bodies move and are corrected; `Steering` moves them by the same.
    settings : PlannerSettings
    """

    frames: SteeringFrames
    rules: FrameRules = field(default_factory=FrameRules)
    settings: PlannerSettings = field(default_factory=PlannerSettings)
    plan: Plan | None = field(default=None, init=False)
    """The last plan."""

    def __post_init__(self) -> None:
        set_ = self.settings
        self.states: States = make_states(self.frames, set_.jump_weight, set_.jump_constant, set_.neighbours)
        self._sizes = np.einsum("ij,ij->i", self.states.features, self.states.features)

    @property
    def units(self) -> int:
        """How many units of wishes it looks at."""
        return self.settings.units

    def choose(self, head: Playhead, wishes: FloatArray) -> int | None:
        """The row to jump to now, or None to go on.

        Parameters
        ----------
        head : Playhead
        wishes : ndarray, shape (T, 3)
            Places ``z, x`` and facings at the ends of the next units.

        Returns
        -------
        int or None
        """
        set_ = self.settings
        playing = self.playing(head)
        self.plan = plan_frames(
            self.states.graph, playing, wishes, self.rules, width=set_.width, beam=set_.beam, old=self.plan
        )
        state = int(self.plan.states[0])
        if state < 0 and (not np.isfinite(self.plan.cost) or len(playing.steps) == 0):
            state = int(np.argmin(playing.prices))  # a recording that ends, and nothing that reaches the horizon
        return self._alike(head, int(self.states.rows[state])) if state >= 0 else None

    def _alike(self, head: Playhead, row: int) -> int:
        """The row around a state's that is most like what plays: states are coarser than rows."""
        frames = self.frames
        query = np.asarray(frames.between(frames.features, head.recording, head.second), dtype=np.float32)
        recording = frames.source[row]
        first = max(row - ROWS // 2, int(frames.starts[recording]))
        stop = min(row + ROWS // 2 + 1, int(frames.starts[recording + 1]))
        return first + int(np.argmin(np.sum((frames.features[first:stop] - query) ** 2, axis=1)))

    def playing(self, head: Playhead) -> Playing:
        """What is playing, as the programme takes it."""
        frames, recording = self.frames, head.recording
        rate = float(head.body[3])
        last = float(frames.second[frames.starts[recording + 1] - 1])
        seconds = np.array([head.second + UNIT * k for k in range(self.units + 1)])
        count = int(np.searchsorted(seconds, last - UNIT * (rate - 1.0) + 1e-9, side="right"))
        seconds = seconds[: max(count, 1)]
        place = np.array([frames.between(frames.place, recording, s) for s in seconds])
        facing = np.array([frames.between(frames.facing, recording, s) for s in seconds])
        pivot = np.array([frames.between(frames.pivots, recording, s + UNIT / 2) for s in seconds[:-1]])
        way = np.diff(place) * np.exp(-1j * facing[:-1])
        steps = np.stack([way.real, way.imag, np.diff(facing), pivot.real, pivot.imag], axis=1)
        near = np.array([self.states.near(recording, s) for s in seconds[:-1]], dtype=np.int64)
        return Playing(head.body, steps, near, self._prices(head))

    def _prices(self, head: Playhead) -> SingleArray:
        frames, states, set_ = self.frames, self.states, self.settings
        query = np.asarray(frames.between(frames.features, head.recording, head.second), dtype=np.float32)
        squares = np.maximum(self._sizes + query @ query - 2 * (states.features @ query), 0.0)
        prices = np.asarray(set_.jump_weight * squares + set_.jump_constant, dtype=np.float32)
        prices[~states.open] = np.inf
        low, stop = states.first[head.recording : head.recording + 2]
        near = np.abs(frames.second[states.rows[low:stop]] - head.second) <= APART
        prices[low:stop][near] = np.inf
        return prices
