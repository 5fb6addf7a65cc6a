"""What a steered body plays: a recording, placed, at a rate, and corrected towards the path that is wished."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import BoolArray
from kinetograph.errors import RequestError
from kinetograph.learn import FrameRules
from kinetograph.methods.performance.frame_planner import Playhead
from kinetograph.methods.performance.steering_frames import UNIT, SteeringFrames
from kinetograph.methods.performance.wishes import HALF_LIFE, WishedPath, nearest_angle
from kinetograph.post.foot_lock import LockSettings
from kinetograph.post.inertialisation import Pose
from kinetograph.post.playing import Player


@dataclass(frozen=True)
class SteeringSettings:
    """How a steered body moves, whoever chooses what it plays.

    Parameters
    ----------
    half_life : float
        Seconds in which half of a change of the stick is wished for.
    joining : float
        Seconds in which the gap at a jump halves.
    easing : float
        Seconds in which half of a change of the corrections is followed.
    rules : FrameRules
        Corrections and rates; a chooser plans with the same.
    lock : LockSettings, optional
        How planted feet are held; None leaves them.
    """

    half_life: float = HALF_LIFE
    joining: float = 0.1
    easing: float = 0.045
    rules: FrameRules = field(default_factory=FrameRules)
    lock: LockSettings | None = field(default_factory=LockSettings)

    def __post_init__(self) -> None:
        for name in ("half_life", "joining", "easing"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise RequestError(f"{name} must be positive and finite, found {value}")


@dataclass(eq=False)
class SteeredBody:
    """A recording that is played and placed; `jump` before the first pose.

    Parameters
    ----------
    frames : SteeringFrames
    settings : SteeringSettings
    """

    frames: SteeringFrames
    settings: SteeringSettings
    rate: float = field(default=1.0, init=False)
    """Seconds of the recording in one second."""

    def __post_init__(self) -> None:
        self._player = Player(self.frames.repertoire, self.settings.joining, self.settings.lock)
        self._angle, self._shift, self._wanted_rate = 0.0, 0j, 1.0
        self._pull, self._turning = 0j, 0.0

    @property
    def playhead(self) -> Playhead:
        """What is playing, and where."""
        place, facing = self.stands()
        body = np.array([place.real, place.imag, facing, self.rate])
        return Playhead(self._player.recording, self._player.second, body)

    @property
    def planted(self) -> BoolArray:
        """Which of `kinetograph.post.planted_roles` are in contact in the recording now."""
        return self.frames.repertoire.planted_at(self._player.recording, self._player.second)

    def stands(self, later: float = 0.0) -> tuple[complex, float]:
        """Place and facing, ``later`` seconds of the recording from now, as it is placed now."""
        frames, recording, second = self.frames, self._player.recording, self._player.second + later
        place = complex(np.exp(1j * self._angle)) * complex(frames.between(frames.place, recording, second))
        return place + self._shift, self._angle + float(frames.between(frames.facing, recording, second))

    def jump(self, row: int, place: complex, facing: float) -> None:
        """Play another row from now on, with its place and facing where they are given."""
        frames = self.frames
        self._angle = nearest_angle(facing - float(frames.facing[row]))
        self._shift = place - complex(np.exp(1j * self._angle)) * complex(frames.place[row])
        shift = np.array([self._shift.imag, 0.0, self._shift.real])
        self._player.jump(int(frames.source[row]), float(frames.second[row]), rot.about("y", self._angle), shift)

    def keep_up_with(self, place: complex) -> None:
        """Have the rate approach the one at which the recording gets as far in a unit as a place is."""
        here = self.stands()[0]
        self._wanted_rate = abs(place - here) / max(abs(self.stands(UNIT)[0] - here), 1e-4)

    def play(self, dt: float, path: WishedPath) -> Pose:
        """The pose ``dt`` seconds later, corrected towards a wished path."""
        rules, before = self.settings.rules, self.stands()[0]
        change = rules.rate_change * dt / UNIT
        rate = min(max(self._wanted_rate, self.rate - change), self.rate + change)
        self.rate = min(max(rate, rules.slowest), rules.fastest)
        place, facing = self.stands(dt * self.rate)
        self._correct(place, facing, path, abs(place - before), dt)
        shift = np.array([self._shift.imag, 0.0, self._shift.real])
        self._player.place(rot.about("y", self._angle), shift)
        return self._player.step(dt, self.rate)

    def _correct(self, place: complex, facing: float, path: WishedPath, way: float, dt: float) -> None:
        """Move the recording towards the path: about the planted foot, and then along the ground."""
        rules, frames = self.settings.rules, self.frames
        share = (1.0 - (1.0 - rules.share) ** (dt / UNIT)) / dt
        follow = 1.0 - 0.5 ** (dt / self.settings.easing)
        fastest = rules.turn / UNIT
        wanted = min(max(share * nearest_angle(path.facing - facing), -fastest), fastest)
        self._turning += follow * (wanted - self._turning)
        pivot = complex(frames.between(frames.pivots, self._player.recording, self._player.second))
        fixed = place + pivot * complex(np.exp(1j * facing))
        turned = complex(np.exp(1j * self._turning * dt))
        gap = path.place - (fixed + turned * (place - fixed))
        pull = gap * min(share, rules.of_way * way / dt / max(abs(gap), 1e-12))
        self._pull += follow * (pull - self._pull)
        self._angle = nearest_angle(self._angle + self._turning * dt)
        self._shift = fixed + turned * (self._shift - fixed) + self._pull * dt
