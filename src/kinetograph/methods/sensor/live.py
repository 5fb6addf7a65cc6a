"""Sensor control as readings arrive; the same code serves whole recordings."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.methods.sensor.estimators import Estimate, Estimator
from kinetograph.methods.sensor.feet import finished_feet
from kinetograph.methods.sensor.fitted import SensorFit
from kinetograph.methods.sensor.pieces import pieces_of
from kinetograph.methods.sensor.result import SensorSynthesis, warnings_of
from kinetograph.methods.sensor.root import RootIntegrator
from kinetograph.methods.sensor.smoothing import Smoother
from kinetograph.motion import Motion
from kinetograph.progress import Progress
from kinetograph.rows import KeptRows
from kinetograph.segmentation import detect_contacts
from kinetograph.sensing import LiveUniform, Readings, Resampling, check_units, may_leap, renumbered
from kinetograph.synthesis import LivePose

_SILENCE = 600.0  # seconds without rows that are more likely a wrong clock than a pause
_PAUSE = 3600.0  # seconds that may be waited through at once
_CHECKED = 200  # rows whose units are looked at
_LEAPING = 4000  # the same where whoever wears the sensors may be leaping
_ASLEEP = 10.0  # seconds without rows after which a held pose no longer changes
_EVERY = 60  # frames between two calls of a progress callback


class FrameEstimates:
    """Estimates from frames of readings at the model's rate, and counts of what was missing.

    Parameters
    ----------
    fit : SensorFit
    estimator : Estimator
    """

    def __init__(self, fit: SensorFit, estimator: Estimator) -> None:
        self.frames = self.missing = self.held = self.far = 0
        self._expected, self._known = 0.0, 0
        self._fit, self._estimator = fit, estimator
        self._total = fit.averages.variance
        self._whitening = fit.overall.whitening()
        standing = fit.averages.root.copy()
        standing[:3] = 0.0
        self._last = Estimate(fit.averages.pose, standing, self._total, 0, 0.0)
        self._owed = estimator.lag
        self._unheard: deque[bool] = deque()

    def add(self, values: FloatArray, valid: BoolArray) -> list[Estimate]:
        """The estimate that one more frame settles, if any.

        Parameters
        ----------
        values : ndarray, shape (S, 3 K)
            Channels in their units.
        valid : ndarray of bool, shape (S,)

        Returns
        -------
        list of Estimate
        """
        self.frames += 1
        self.missing += int((~valid).sum())
        examples = self._fit.examples
        scaled = values.reshape(-1) / examples.scale
        mask = np.repeat(valid, 3 * len(examples.kinds))
        self.held += not mask.any()
        self.far += self._is_far(scaled, mask)
        return self._stepped(np.where(mask, scaled, 0.0), mask)

    def skip(self, valid: BoolArray) -> None:
        """Count one more frame without readings, whose estimate is that of the frame before."""
        self.frames += 1
        self.missing += len(valid)
        self.held += 1

    def rest(self) -> list[Estimate]:
        """The estimates that are left when no more frames will come."""
        width = self._fit.examples.readings.shape[1]
        none = np.zeros(width, dtype=np.bool_)
        late: list[Estimate] = []
        for _ in range(self._estimator.lag):
            late += self._stepped(np.zeros(width), none)
        return late

    def statistics(self) -> dict[str, float]:
        """Frames, the share of missing readings, seconds held, and the share of frames far from all in the library.

        Where it is known, also the error in degrees that one can expect, and the one of the library's people, left out.
        """
        examples, ridge = self._fit.examples, self._fit.ridge
        statistics: dict[str, float] = {
            "frames": self.frames,
            "missing": self.missing / max(self.frames * len(examples.names), 1),
            "held": self.held / examples.fps,
            "far": self.far / max(self.frames, 1),
        }
        if self._known and ridge is not None:
            statistics |= {"expected": self._expected / self._known, "usual": ridge.expected.usual}
        return statistics

    def _stepped(self, scaled: FloatArray, mask: BoolArray) -> list[Estimate]:
        """The estimate that a frame settles, unless it is of a time before the first one."""
        self._unheard.append(not mask.any())
        silent = self._unheard[-1] and self._estimator.lag == 0
        estimate = None if silent else self._estimator.step(scaled, mask)
        if self._owed > 0:
            self._owed -= 1
            return []
        unheard = self._unheard.popleft()
        self._last = self._held() if unheard or estimate is None else estimate
        if not unheard and np.isfinite(self._last.degrees):
            self._expected, self._known = self._expected + self._last.degrees, self._known + 1
        return [self._last]

    def _is_far(self, scaled: FloatArray, mask: BoolArray) -> bool:
        if not mask.all():
            return False
        away = self._whitening @ (scaled - self._fit.overall.mean)
        return bool(away @ away > self._fit.reach)

    def _held(self) -> Estimate:
        """The last estimate again, slowing down and with growing variance."""
        last, rate = self._last, self._fit.examples.fps
        variance = np.minimum(last.variance + self._total / rate, np.maximum(self._total, last.variance))
        root = last.root.copy()
        root[:3] *= 0.8
        return replace(last, variance=variance, root=root)


class LiveSensor:
    """A run of a model over a stream of readings: ``step``, ``step``, ..., ``finish``.

    Parameters
    ----------
    fit : SensorFit
    estimator : Estimator
    smoother : Smoother
    resampling : Resampling
    latency : float
        Seconds between a reading and the pose that it completes, for the statistics.
    clean : bool
        Whether the whole result's planted feet are held still.
    keep : bool
        Whether poses are kept for `finish`, on disk but for the latest; without it a run may last for days.
    """

    def __init__(
        self,
        fit: SensorFit,
        estimator: Estimator,
        smoother: Smoother,
        resampling: Resampling,
        latency: float,
        clean: bool = True,
        keep: bool = True,
    ) -> None:
        examples = fit.examples
        self._fit, self._smoother, self._latency, self._clean, self._keep = fit, smoother, latency, clean, keep
        self._uniform = LiveUniform(len(examples.names), examples.fps, resampling, examples.kinds)
        self._estimates = FrameEstimates(fit, estimator)
        self._root = RootIntegrator(examples.root, examples.fps)
        self._joint = examples.space.joint_of_component
        joints = len(examples.space.skeleton)
        self._kept = KeptRows((3 + 5 * joints + 2,))
        self._settled = self._silent = 0
        self._last: LivePose | None = None
        self._note = (0, 0.0)
        self._heard: set[str] = set()
        self._until = 0.0
        self._first: list[Readings] = []
        self._trusted = False

    def step(
        self, readings: Readings, now: float | None = None, progress: Progress | None = None
    ) -> tuple[LivePose, ...]:
        """Take rows, later than all before, and give the poses that are settled by them.

        Parameters
        ----------
        readings : Readings
        now : float, optional
            Seconds up to which there are no more rows, where the stream has stopped but time has not; the pose is held
            and its uncertainty grows.
        progress : Progress, optional
            Called with the frames done and their number.

        Returns
        -------
        tuple of LivePose

        Raises
        ------
        RequestError
            For unknown sensors, where the first rows cannot be specific force in m/s^2, and for times that leap ahead.
            Rows far out of range are left out and counted as spikes.
        DataError
            Where time runs backwards; none of the rows is taken.
        """
        rows = renumbered(readings, self._fit.examples.names)
        self._check_units(readings)
        end = _not_leaping(self._until, max(readings.duration, now or 0.0), _SILENCE)
        self._uniform.add(rows)
        self._until = max(self._until, end)
        self._heard |= {readings.names[i] for i in np.unique(readings.sensors)}
        return self._advance(*self._uniform.ready(now), progress)

    def _check_units(self, readings: Readings) -> None:
        """Raise RequestError where the first `_CHECKED` rows cannot be in m/s^2 and rad/s."""
        if self._trusted:
            return
        if _too_few(self._first):
            self._first.append(readings)
        if not _too_few(self._first):
            check_units(_together(self._first))
            self._trusted, self._first = True, []

    def wait(self, now: float) -> tuple[LivePose, ...]:
        """The poses that are settled by there being no rows up to ``now`` seconds: the last is held after a while."""
        self._until = max(self._until, _not_leaping(self._until, now, _PAUSE))
        return self._advance(*self._uniform.ready(now), None)

    def finish(self) -> SensorSynthesis:
        """The poses that are left, and the whole as a synthesis.

        Raises
        ------
        RequestError
            Where no rows ever came, or poses are not kept.
        """
        if not self._heard:
            raise RequestError("no readings came; nothing can be synthesised")
        if not self._keep:
            raise RequestError("poses were not kept, so that there is no whole; use rest for those that are left")
        self.rest()
        return self._whole()

    def rest(self) -> tuple[LivePose, ...]:
        """The poses that are left when no more rows will come."""
        poses = list(self._advance(*self._uniform.rest(self._until), None))
        for estimate in self._estimates.rest():
            poses += self._settle(self._smoother.add(estimate))
        return (*poses, *self._settle(self._smoother.rest()))

    def _advance(self, values: FloatArray, valid: BoolArray, progress: Progress | None) -> tuple[LivePose, ...]:
        poses: list[LivePose] = []
        heard: BoolArray = np.any(valid, axis=1)
        for i in range(len(values)):
            self._silent = 0 if heard[i] else self._silent + 1
            if self._last is not None and self._silent > _ASLEEP * self._fit.examples.fps:
                self._estimates.skip(valid[i])
                poses.append(self._given(self._last, self._note))
                continue
            for estimate in self._estimates.add(values[i], valid[i]):
                poses += self._settle(self._smoother.add(estimate))
            if progress is not None and i % _EVERY == _EVERY - 1:
                progress(i + 1, len(values))
        return tuple(poses)

    def _settle(self, estimates: Iterable[Estimate]) -> list[LivePose]:
        """Poses of smoothed estimates."""
        examples = self._fit.examples
        poses: list[LivePose] = []
        for estimate in estimates:
            rotations = examples.space.decode(estimate.pose[None])[0]
            translation, world = self._root.step(rotations, estimate.root)
            spread = 2.0 * np.sqrt(np.bincount(self._joint, estimate.variance, len(rotations)))
            poses.append(self._given(LivePose(0.0, translation, world, spread), (estimate.example, estimate.cost)))
        return poses

    def _given(self, pose: LivePose, note: tuple[int, float]) -> LivePose:
        """A pose as the next one that is settled, with its example and cost."""
        self._last = replace(pose, time=self._settled / self._fit.examples.fps)
        self._note = note
        self._settled += 1
        if self._keep:
            assert pose.uncertainty is not None
            self._kept.add(np.concatenate([pose.translation, pose.rotations.ravel(), pose.uncertainty, note]))
        return self._last

    def _whole(self) -> SensorSynthesis:
        examples = self._fit.examples
        joints, rows = len(examples.space.skeleton), self._kept.all()
        rotations = rows[:, 3 : 3 + 4 * joints].reshape(len(rows), joints, 4)
        motion = Motion(examples.space.skeleton, rows[:, :3].copy(), rotations.copy(), examples.fps)
        if self._clean:
            motion, contacts = finished_feet(motion, examples.root)
        else:
            contacts = detect_contacts(motion)
        cost = float(np.mean(rows[:, -1]))
        statistics = self._statistics()
        return SensorSynthesis(
            motion,
            pieces_of(examples, rows[:, -2].astype(int).tolist()),
            cost,
            costs={"readings": cost},
            annotations=contacts,
            statistics=statistics,
            warnings=warnings_of(statistics, examples.names, self._heard),
            uncertainty=rows[:, 3 + 4 * joints : 3 + 5 * joints].copy(),
        )

    def _statistics(self) -> dict[str, float]:
        local = self._fit.local
        statistics = self._estimates.statistics() | {"spikes": self._uniform.spikes, "latency": self._latency}
        if local is not None:
            statistics |= {"clusters": len(local.clusters), "condition": local.condition}
        return statistics


def _not_leaping(since: float, until: float, silence: float) -> float:
    """A time, unless it leaps ahead."""
    if not until <= since + silence:
        raise RequestError(
            f"readings leap from {since:g} s to {until:g} s; times are seconds from the start of the motion"
        )
    return until


def _too_few(first: list[Readings]) -> bool:
    """Whether more rows are to come before their units are looked at."""
    known = sum(map(len, first))
    return known < _CHECKED or (known < _LEAPING and may_leap(_together(first)))


def _together(parts: list[Readings]) -> Readings:
    """The forces and angular velocities of readings as those of one sensor, for their units."""
    force = np.concatenate([part.force for part in parts])
    rates = [part.angular for part in parts if part.angular is not None]
    count = len(force)
    angular = np.concatenate(rates) if rates and sum(map(len, rates)) == count else None
    return Readings(("all",), np.arange(count, dtype=np.float64), np.zeros(count, dtype=np.int64), force, angular)
