"""From a library to synchronised examples of poses, root motion and virtual readings (Xie 2009, chapter 4)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray
from kinetograph.errors import RequestError
from kinetograph.left_out import by_reason, left_out_lines, together
from kinetograph.library import Library
from kinetograph.methods.bodies import Bodies
from kinetograph.methods.recordings import Gathered, adopt, gather
from kinetograph.methods.sensor.pose_space import PoseSpace, fit_pose_space
from kinetograph.methods.sensor.root import RootModel, fit_root_model, root_features
from kinetograph.methods.sensor.settings import require_positive
from kinetograph.motion import Motion, resample
from kinetograph.progress import Progress
from kinetograph.sensing import (
    KINDS,
    Layout,
    Readings,
    Resampling,
    faultless,
    preset,
    select_sensors,
    simulate_kinds,
    uniform,
)

LEAST = {"force": 0.5, "angular": 0.1, "tilt": 0.02}
"""Spread of a channel, in its unit, below which it is noise rather than movement."""
SHORTEST = 0.5
"""Seconds; shorter takes are left out."""

Motions = Mapping[tuple[str, str], Motion]
"""Motions of one skeleton by take and track."""


@dataclass(frozen=True, eq=False)
class SensorSetup:
    """The sensors of examples and of readings alike, and their sampling.

    Parameters
    ----------
    layout : Layout
    kinds : tuple of str
        Kinds of channels, of `kinetograph.sensing.KINDS`: force, and then angular, tilt or both.
    rate : float
        Frames per second.
    resampling : Resampling

    Raises
    ------
    RequestError
        For other kinds, or a rate that is not positive.
    """

    layout: Layout = field(default_factory=lambda: preset("wii"))
    kinds: tuple[str, ...] = ("force",)
    rate: float = 60.0
    resampling: Resampling = field(default_factory=Resampling)

    def __post_init__(self) -> None:
        require_positive(self, "rate")
        if "force" not in self.kinds or tuple(k for k in KINDS if k in self.kinds) != tuple(self.kinds):
            raise RequestError(f"kinds must be force and then angular, tilt or both, found {', '.join(self.kinds)}")


@dataclass(frozen=True, eq=False)
class Examples:
    """N frames of recordings, one after another.

    Parameters
    ----------
    space : PoseSpace
    root : RootModel
    poses : ndarray, shape (N, D)
        Vectors in ``space``.
    root_features : ndarray, shape (N, A)
    readings : ndarray, shape (N, C)
        Divided by ``scale``.
    scale : ndarray, shape (C,)
        In the channels' units.
    starts : ndarray of int, shape (T + 1,)
        Where each of ``takes`` begins, and the end.
    takes : tuple of (str, str)
        Take and track.
    names : tuple of str
        The sensors.
    fps : float
    kinds : tuple of str
        Kinds of channels.
    """

    space: PoseSpace
    root: RootModel
    poses: FloatArray
    root_features: FloatArray
    readings: FloatArray
    scale: FloatArray
    starts: IntArray
    takes: tuple[tuple[str, str], ...]
    names: tuple[str, ...]
    fps: float
    kinds: tuple[str, ...] = ("force",)

    @property
    def first(self) -> BoolArray:
        """Which frames begin a take, shape ``(N,)``."""
        mask = np.zeros(len(self.poses), dtype=np.bool_)
        mask[self.starts[:-1]] = True
        return mask


def example_motions(
    library: Library,
    *,
    exclude: Iterable[str] = (),
    track: str | None = None,
    progress: Progress | None = None,
) -> dict[tuple[str, str], Motion]:
    """The motions of a library's takes, all on the skeleton of the first; see `gather_motions`."""
    return gather_motions(library, exclude=exclude, track=track, progress=progress)[0]


def gather_motions(
    library: Library,
    bodies: Bodies | None = None,
    *,
    exclude: Iterable[str] = (),
    track: str | None = None,
    progress: Progress | None = None,
) -> tuple[dict[tuple[str, str], Motion], Gathered]:
    """The motions of a library's takes, all on the skeleton of the first.

    Takes shorter than half a second are left out. Looping clips are played once: repeated frames would only count more
    in means and mixtures.

    Parameters
    ----------
    library : Library
    bodies : Bodies, optional
        Which skeleton is used where there are several.
    exclude : iterable of str
        Names of takes to leave out.
    track : str, optional
        Name of the motions' track; needed where takes have several motions.
    progress : Progress, optional

    Returns
    -------
    motions : dict
        Motions by take and track.
    gathered : Gathered
        What is left out.

    Raises
    ------
    RequestError
        For a name to leave out that is not there, and for no take that is long enough.
    """
    gathered = gather(library, bodies, exclude=exclude, track=track, progress=progress)
    long_enough = [recording for recording in gathered.recordings if recording.motion.duration >= SHORTEST]
    if not long_enough:
        raise RequestError(f"the library has no take of {SHORTEST} s or more to use; add recordings, or exclude fewer")
    short = by_reason((r.name, f"shorter than {SHORTEST} s") for r in gathered.recordings if r not in long_enough)
    skeleton = long_enough[0].motion.skeleton
    motions = {(r.name, r.track): adopt(r.motion, skeleton) for r in long_enough}
    return motions, Gathered(
        tuple(long_enough), together(gathered.left, short), (*gathered.notes, *left_out_lines(short))
    )


def build_examples(
    motions: Motions,
    setup: SensorSetup,
    rng: np.random.Generator,
    recorded: Mapping[tuple[str, str], Readings] = MappingProxyType({}),
    progress: Progress | None = None,
) -> Examples:
    """Examples of motions whose readings are recorded or, where they are not, simulated.

    Simulated sensors have their device's faults except for losses and clock offset, and pass through the same
    resampling as real ones, so that its effects are the same on both.

    Parameters
    ----------
    motions : mapping
        Motions of one skeleton by take and track.
    setup : SensorSetup
    rng : numpy.random.Generator
        For the noise of simulated sensors.
    recorded : mapping, optional
        Readings by take and track.
    progress : Progress, optional
        Called with the takes done and their number.

    Returns
    -------
    Examples
    """
    at_rate = {key: resample(motion, setup.rate) for key, motion in motions.items()}
    readings = []
    for done, (key, motion) in enumerate(at_rate.items(), start=1):
        rows = recorded.get(key) or simulate_kinds(motions[key], faultless(setup.layout), setup.kinds, rng)
        readings.append(_sampled(rows, setup, (len(motion) - 1) / setup.rate))
        if progress:
            progress(done, len(at_rate))
    together = np.concatenate(readings)
    scale = np.maximum(together.std(axis=0), _least_spread(setup))
    space = fit_pose_space(list(at_rate.values()))
    root = fit_root_model(list(at_rate.values()))
    return Examples(
        space,
        root,
        np.concatenate([space.encode(motion) for motion in at_rate.values()]),
        np.concatenate([root_features(motion, root) for motion in at_rate.values()]),
        together / scale,
        scale,
        np.concatenate([[0], np.cumsum([len(motion) for motion in at_rate.values()])]),
        tuple(motions),
        setup.layout.names,
        setup.rate,
        setup.kinds,
    )


def _sampled(rows: Readings, setup: SensorSetup, duration: float) -> FloatArray:
    """Channels ``(F, C)`` of the layout's sensors."""
    own = select_sensors(rows, setup.layout.names)
    return uniform(own, setup.rate, duration, setup.resampling, setup.kinds).values


def _least_spread(setup: SensorSetup) -> FloatArray:
    return np.tile(np.repeat([LEAST[kind] for kind in setup.kinds], 3), len(setup.layout.names))
