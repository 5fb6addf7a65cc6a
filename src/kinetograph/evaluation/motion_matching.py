"""Motion matching as people use it, for comparison: the frame whose features are nearest is played next.

Features are those of Holden's open implementation (orangeduck/Motion-Matching): where the feet are and how they move,
how the hips move, and where the body will be and face in a third, two thirds and one second, all seen from where it
stands and faces now. Each kind is divided by its standard deviation and weighted. Frames near the one that plays are
left out, and a jump is made where another is nearer than the one that plays.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.learn import FrameRules
from kinetograph.methods.performance.frame_planner import Playhead
from kinetograph.methods.performance.steered_body import SteeringSettings
from kinetograph.methods.performance.steering_frames import ROWS, UNIT, SteeringFrames

AHEAD = (1 / 3, 2 / 3, 1.0)
"""Seconds: 20, 40 and 60 frames at 60 Hz."""
SURROUNDING = 1 / 3
"""Seconds around the frame that plays which are not searched, and at the end of a recording which are not played."""


@dataclass(frozen=True)
class MatchingWeights:
    """Weights of the features; the defaults are the usual ones.

    Parameters
    ----------
    foot_place, foot_velocity, hip_velocity, path_place, path_facing : float
    """

    foot_place: float = 0.75
    foot_velocity: float = 1.0
    hip_velocity: float = 1.0
    path_place: float = 1.0
    path_facing: float = 1.5

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value >= 0):
                raise RequestError(f"{name} must be finite and 0 or more, found {value}")


@dataclass(eq=False)
class MotionMatching:
    """Chooses what a steered body plays by motion matching; a `kinetograph.methods.performance.Steering` plays it.

    Parameters
    ----------
    frames : SteeringFrames
    weights : MatchingWeights
    """

    frames: SteeringFrames
    weights: MatchingWeights = field(default_factory=MatchingWeights)

    def __post_init__(self) -> None:
        frames = self.frames
        rows, ends = np.arange(len(frames.second)), frames.starts[1:][frames.source]
        self._playable: BoolArray = (ends - rows) / (ROWS / UNIT) > SURROUNDING
        places, facings = _paths(frames, rows, ends)
        body = _body_features(frames)
        parts = [*body, _flat(places), _flat(np.exp(1j * facings))]
        weights = np.array(list(vars(self.weights).values()))
        scales = [w / max(float(part.std(axis=0).mean()), 1e-9) for w, part in zip(weights, parts, strict=True)]
        self._scales = np.repeat(scales, [part.shape[1] for part in parts])
        self._features = np.concatenate(parts, axis=1) * self._scales
        self._body = sum(part.shape[1] for part in body)

    @property
    def units(self) -> int:
        """How many units of wishes it looks at."""
        return round(AHEAD[-1] / UNIT)

    def choose(self, head: Playhead, wishes: FloatArray) -> int | None:
        """The row that is nearest, or None where that is the one that plays.

        Parameters
        ----------
        head : Playhead
        wishes : ndarray, shape (T, 3)
            Places ``z, x`` and facings at the ends of the next units.

        Returns
        -------
        int or None
        """
        row = self.frames.row(head.recording, head.second)
        query = self._features[row].copy()
        query[self._body :] = self._wished(head.body, wishes) * self._scales[self._body :]
        distances = np.sum((self._features - query) ** 2, axis=1)
        now = distances[row] if self._playable[row] else np.inf
        around = round(SURROUNDING * ROWS / UNIT)
        low, stop = self.frames.starts[head.recording : head.recording + 2]
        distances[~self._playable] = np.inf
        distances[max(row - around, low) : min(row + around + 1, stop)] = np.inf
        best = int(distances.argmin())
        return best if distances[best] < now else None

    def _wished(self, body: FloatArray, wishes: FloatArray) -> FloatArray:
        clock = UNIT * np.arange(1, len(wishes) + 1)
        z, x, facing = (np.interp(AHEAD, clock, wishes[:, i]) for i in range(3))
        back = np.exp(-1j * body[2])
        places = (z + 1j * x - complex(body[0], body[1])) * back
        return np.concatenate([_flat(places[None])[0], _flat((np.exp(1j * facing) * back)[None])[0]])


def _body_features(frames: SteeringFrames) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Places and velocities of the ankles, ``(M, 6)`` each, and the velocity of the root, ``(M, 3)``."""
    skeleton = frames.repertoire.skeleton
    joints = len(skeleton)
    whole = frames.features[:, : 6 * joints].astype(np.float64) * np.sqrt(joints)
    places, moved = whole.reshape(len(whole), 2, joints, 3).transpose(1, 0, 2, 3)
    feet = [skeleton.landmark(role).joint for role in ("left_foot", "right_foot")]
    velocities = moved / UNIT
    return places[:, feet].reshape(-1, 6), velocities[:, feet].reshape(-1, 6), velocities[:, 0]


def _paths(frames: SteeringFrames, rows: IntArray, ends: IntArray) -> tuple[ComplexArray, FloatArray]:
    """Where bodies will be and face, from where they are and face, ``(M, 3)`` each; held at a recording's end."""
    later = [np.minimum(rows + round(s * ROWS / UNIT), ends - 1) for s in AHEAD]
    back = np.exp(-1j * frames.facing)
    places = np.stack([(frames.place[r] - frames.place) * back for r in later], axis=1)
    return places, np.stack([frames.facing[r] - frames.facing for r in later], axis=1)


def _flat(values: ComplexArray) -> FloatArray:
    """Real and imaginary parts, ``(M, 2 K)``, of ``(M, K)``."""
    return np.stack([values.real, values.imag], axis=-1).reshape(len(values), -1)


USUAL_STEERING = SteeringSettings(rules=FrameRules(of_way=0.5, slowest=1.0, fastest=1.0, rate_change=0.0))
"""How a body moves in the open implementation: half of its way is corrected at most, and nothing is played faster."""
TUNED = MatchingWeights(foot_place=0.28, foot_velocity=1.64, hip_velocity=0.99, path_place=1.02, path_facing=0.91)
"""Weights chosen by random search on the walks and sticks of ``benchmarks/steering.py``."""
TUNED_STEERING = SteeringSettings(
    joining=0.15, easing=0.043, rules=FrameRules(of_way=0.6, slowest=1.0, fastest=1.2, rate_change=0.1)
)
"""How a body moves, chosen in the same search."""
