"""Sensor control as readings arrive; whole recordings go the same way."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.methods.sensor.estimators import Estimate
from kinetograph.methods.sensor.pieces import pieces_of, warnings_of
from kinetograph.methods.sensor.root import RootWalker
from kinetograph.motion import Motion
from kinetograph.post.footskate import clean_feet
from kinetograph.progress import Progress
from kinetograph.segmentation.footplants import detect_contacts
from kinetograph.sensing.readings import Readings, check_names
from kinetograph.sensing.uniform import LiveUniform

if TYPE_CHECKING:
    from kinetograph.methods.sensor.model import SensorModel, SensorSynthesis

AHEAD, BEHIND = 3, 4
"""Frames of the thesis' smoothing window after and before its own."""
_CAUSAL = 0.06  # seconds in which the causal filter forgets two thirds
_SILENCE = 600.0  # seconds without rows that are more likely a wrong clock than a pause


@dataclass(frozen=True, eq=False)
class LivePose:
    """time: seconds. translation ``(3,)`` metres and rotations ``(J, 4)`` of the pose; uncertainty ``(J,)`` radians."""

    time: float
    translation: FloatArray
    rotations: FloatArray
    uncertainty: FloatArray


@dataclass
class _Counts:
    frames: int = 0
    missing: int = 0
    held: int = 0
    far: int = 0


class LiveSensor:
    """A run of a model over a stream of readings: `step`, `step`, ..., `finish`."""

    def __init__(self, model: SensorModel) -> None:
        self.model = model
        method, examples = model.method, model.examples
        self._uniform = LiveUniform(len(examples.names), method.rate, method.resampling, examples.kinds)
        self._estimator = model.estimator()
        self._walker = RootWalker(examples.root, method.rate)
        self._joint = np.nonzero(examples.space.moving)[0]
        self._total = examples.poses.var(axis=0)
        self._whitening = model.overall.whitening()
        standing = examples.root_features.mean(axis=0)
        standing[:3] = 0.0
        self._last = Estimate(examples.poses.mean(axis=0), standing, self._total, 0, 0.0)
        self._owed = self._estimator.lag
        self._window: list[Estimate] = []
        self._emitted = 0
        self._done: list[tuple[LivePose, int, float]] = []
        self._counts = _Counts()
        self._heard: set[str] = set()
        self._until = 0.0

    def step(
        self, readings: Readings, now: float | None = None, progress: Progress | None = None
    ) -> tuple[LivePose, ...]:
        """Take in rows, later than all before, and give the poses that are settled by them.

        now: seconds up to which there are no more rows, where the stream has stopped but time has not; the pose is held
        and its uncertainty grows. Raises RequestError for unknown sensors, DataError where time runs backwards.
        """
        names = self.model.examples.names
        check_names(readings.names, names)
        end = max(readings.duration, now or 0.0)
        if end > self._until + _SILENCE:
            raise RequestError(
                f"readings leap from {self._until:g} s to {end:g} s; times are seconds from the start of the motion"
            )
        self._until = max(self._until, end)
        self._heard |= {readings.names[i] for i in np.unique(readings.sensors)}
        number = np.array([names.index(name) for name in readings.names])
        self._uniform.add(replace(readings, names=names, sensors=number[readings.sensors], _checked=True))
        return self._advance(*self._uniform.ready(now), progress)

    def finish(self) -> SensorSynthesis:
        """The poses still owed, and the whole as a synthesis. Raises RequestError where no rows ever came."""
        from kinetograph.methods.sensor.model import SensorSynthesis

        if not self._heard:
            raise RequestError("no readings came; nothing can be synthesised")
        self._advance(*self._uniform.rest(self._until), None)
        width = self.model.examples.readings.shape[1]
        for _ in range(self._estimator.lag):
            self._push(self._estimator.step(np.zeros(width), np.zeros(width, dtype=np.bool_)))
        while self._emitted < self._counts.frames and self._window:
            self._emit()
        model, examples = self.model, self.model.examples
        poses = [pose for pose, _, _ in self._done]
        motion = Motion(
            examples.space.skeleton,
            np.array([pose.translation for pose in poses]),
            np.array([pose.rotations for pose in poses]),
            model.method.rate,
        )
        contacts = detect_contacts(motion)
        if model.method.clean_feet:
            motion = clean_feet(motion, contacts)
        cost = float(np.mean([cost for _, _, cost in self._done]))
        return SensorSynthesis(
            motion,
            pieces_of(examples, [example for _, example, _ in self._done]),
            cost,
            costs={"readings": cost},
            annotations=contacts,
            statistics=self._statistics(),
            warnings=warnings_of(self._statistics(), examples.names, self._heard, model.method.rate),
            uncertainty=np.array([pose.uncertainty for pose in poses]),
        )

    def _statistics(self) -> dict[str, float]:
        counts, model = self._counts, self.model
        channels = max(counts.frames * len(model.examples.names), 1)
        found = {
            "frames": counts.frames,
            "missing": counts.missing / channels,
            "held": counts.held / model.method.rate,
            "far": counts.far / max(counts.frames, 1),
            "spikes": self._uniform.spikes,
            "latency": model.latency,
        }
        if model.local is not None:
            found |= {"clusters": len(model.local.clusters), "condition": model.local.condition}
        return found

    def _advance(self, values: FloatArray, valid: BoolArray, progress: Progress | None) -> tuple[LivePose, ...]:
        before = len(self._done)
        for i in range(len(values)):
            self._frame(values[i], valid[i])
            if progress is not None and i % 60 == 59:
                progress(i + 1, len(values))
        return tuple(pose for pose, _, _ in self._done[before:])

    def _frame(self, values: FloatArray, valid: BoolArray) -> None:
        self._counts.frames += 1
        self._counts.missing += int((~valid).sum())
        if not valid.any():
            self._counts.held += 1
            self._push(self._held())
            return
        scaled = values.reshape(-1) / self.model.examples.scale
        mask = np.repeat(valid, 3 * len(self.model.examples.kinds))
        self._counts.far += self._is_far(scaled, mask)
        self._push(self._estimator.step(np.where(mask, scaled, 0.0), mask))

    def _is_far(self, scaled: FloatArray, mask: BoolArray) -> bool:
        if not mask.all():
            return False
        away = self._whitening @ (scaled - self.model.overall.mean)
        return bool(away @ away > self.model.reach)

    def _held(self) -> Estimate:
        """The last estimate again, standing still and less and less sure."""
        variance = np.minimum(self._last.variance + self._total / self.model.method.rate, np.maximum(
            self._total, self._last.variance))  # fmt: skip
        root = self._last.root.copy()
        root[:3] *= 0.8
        return replace(self._last, variance=variance, root=root)

    def _push(self, estimate: Estimate) -> None:
        if self._owed > 0:
            self._owed -= 1
            return
        self._last = estimate
        smoothing = self.model.smoothing
        if smoothing == "window":
            self._window.append(estimate)
            if len(self._window) > AHEAD + min(self._emitted, BEHIND):
                self._emit()
            return
        if smoothing == "causal" and self._window:
            share = float(np.exp(-1.0 / (_CAUSAL * self.model.method.rate)))
            estimate = _mixed([self._window[0], estimate], np.array([share, 1.0 - share]), 1)
        self._window = [estimate]
        self._emit()

    def _emit(self) -> None:
        """Settle the next frame from the estimates around it."""
        if self.model.smoothing == "window":
            own = min(self._emitted, BEHIND)
            around = self._window[: BEHIND + 1 + AHEAD]
            estimate = _mixed(around, np.full(len(around), 1.0 / len(around)), min(own, len(around) - 1))
            if self._emitted >= BEHIND:
                self._window.pop(0)
        else:
            estimate = self._window[0]
        space = self.model.examples.space
        rotations = space.decode(estimate.pose[None])[0]
        translation, world = self._walker.step(rotations, estimate.root)
        spread = 2.0 * np.sqrt(np.bincount(self._joint, estimate.variance, len(rotations)))
        pose = LivePose(self._emitted / self.model.method.rate, translation, world, spread)
        self._done.append((pose, estimate.example, estimate.cost))
        self._emitted += 1


def _mixed(estimates: list[Estimate], weights: FloatArray, own: int) -> Estimate:
    return replace(
        estimates[own],
        pose=weights @ np.array([e.pose for e in estimates]),
        root=weights @ np.array([e.root for e in estimates]),
        variance=weights @ np.array([e.variance for e in estimates]),
    )
