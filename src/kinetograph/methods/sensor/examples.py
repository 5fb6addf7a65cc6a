"""From a library to synchronised examples of poses, root motion and virtual readings (Xie 2009, chapter 4)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray, IntArray, SingleArray
from kinetograph.errors import RequestError
from kinetograph.learn import spread_of
from kinetograph.left_out import by_reason, left_out_lines, together
from kinetograph.library import Library
from kinetograph.methods.bodies import Bodies
from kinetograph.methods.recordings import Gathered, Recording, adopt, gather
from kinetograph.methods.sensor.pose_space import PoseSpace, moments, one_sided, pose_space_of, without_heading
from kinetograph.methods.sensor.root import HEIGHT, FootLevels, RootModel, features_over, foot_levels, root_model_of
from kinetograph.methods.sensor.settings import require_positive
from kinetograph.motion import Motion, resample
from kinetograph.progress import Progress
from kinetograph.segmentation import detect_contacts
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
from kinetograph.skeleton import Skeleton

LEAST = {"force": 0.5, "angular": 0.1, "tilt": 0.02}
"""Spread of a channel, in its unit, below which it is noise rather than movement."""
SHORTEST = 0.5
"""Seconds; shorter takes are left out."""

Key = tuple[str, str]
"""Take and track."""
Motions = Mapping[Key, Motion]
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
    poses : ndarray of float32, shape (N, D)
        Vectors in ``space``.
    root_features : ndarray of float32, shape (N, A)
    readings : ndarray of float32, shape (N, C)
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
    people : tuple of str
        Who moves in each of ``takes``; a take of which that is not known is a person of its own.
    """

    space: PoseSpace
    root: RootModel
    poses: SingleArray
    root_features: SingleArray
    readings: SingleArray
    scale: FloatArray
    starts: IntArray
    takes: tuple[Key, ...]
    names: tuple[str, ...]
    fps: float
    kinds: tuple[str, ...] = ("force",)
    people: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.people:
            object.__setattr__(self, "people", tuple(take for take, _ in self.takes))

    def __len__(self) -> int:
        return len(self.poses)

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
) -> dict[Key, Motion]:
    """The motions of a library's takes, all on the skeleton of the first; see ``gather_long_enough``."""
    gathered = gather_long_enough(library, exclude=exclude, track=track, progress=progress)
    return dict(adopted(list(gathered.recordings)))


def gather_long_enough(
    library: Library,
    bodies: Bodies | None = None,
    *,
    exclude: Iterable[str] = (),
    track: str | None = None,
    progress: Progress | None = None,
) -> Gathered:
    """The recordings that examples are made of.

    Takes shorter than half a second are left out. Looping clips are played once: repeated frames would only count more
    in means and mixtures.

    Parameters
    ----------
    library : Library
    bodies : Bodies, optional
        Which skeleton is used where there are several, and whether takes of others are brought over or left out.
    exclude : iterable of str
        Names of takes to leave out.
    track : str, optional
        Name of the motions' track; needed where takes have several motions.
    progress : Progress, optional

    Returns
    -------
    Gathered

    Raises
    ------
    RequestError
        For a name to leave out that is not there, and for no take that is long enough.
    """
    gathered = gather(library, bodies, exclude=exclude, track=track, progress=progress)
    used = tuple(recording for recording in gathered.recordings if recording.motion.duration >= SHORTEST)
    if not used:
        raise RequestError(f"the library has no take of {SHORTEST} s or more to use; add recordings, or exclude fewer")
    brief = [recording for recording in gathered.recordings if recording.motion.duration < SHORTEST]
    short = by_reason((recording.name, f"shorter than {SHORTEST} s") for recording in brief)
    return Gathered(used, together(gathered.left, short), (*gathered.notes, *left_out_lines(short)))


def adopted(recordings: list[Recording]) -> Iterator[tuple[Key, Motion]]:
    """The motions of recordings, on the skeleton of the first; the list is emptied on the way, for its memory."""
    skeleton = recordings[0].motion.skeleton
    recordings.reverse()
    while recordings:
        recording = recordings.pop()
        yield (recording.name, recording.track), adopt(recording.motion, skeleton)


def build_examples(
    motions: Iterable[tuple[Key, Motion]],
    setup: SensorSetup,
    rng: np.random.Generator,
    recorded: Mapping[Key, Readings] = MappingProxyType({}),
    *,
    people: Mapping[Key, str] = MappingProxyType({}),
    count: int = 0,
    progress: Progress | None = None,
) -> Examples:
    """Examples of motions whose readings are recorded or, where they are not, simulated.

    Simulated sensors have their device's faults except for losses and clock offset, and pass through the same
    resampling as real ones, so that its effects are the same on both.

    Parameters
    ----------
    motions : iterable of tuple of (str, str) and Motion
        Take and track, and the motion; all of one skeleton. Each is let go before the next is asked for.
    setup : SensorSetup
    rng : numpy.random.Generator
        For the noise of simulated sensors.
    recorded : mapping, optional
        Readings by take and track.
    people : mapping, optional
        Who moves, by take and track; a take of which that is not known is a person of its own.
    count : int
        How many motions there are, for the progress.
    progress : Progress, optional
        Called with the motions done and their number.

    Returns
    -------
    Examples
    """
    made = _Made()
    for part in example_parts(motions, setup, rng, recorded):
        made.add(part)
        if progress:
            progress(len(made.takes), max(count, len(made.takes)))
    return _joined(made, setup, people)


@dataclass(frozen=True, eq=False)
class ExamplePart:
    """What one motion gives to examples, whatever the others are.

    Parameters
    ----------
    key : (str, str)
        Take and track.
    readings : ndarray of float32, shape (F, C)
        In the channels' units.
    rotations : ndarray of float32, shape (F, J, 4)
        Without the root's heading.
    features : ndarray of float32, shape (F, A)
    levels : FootLevels
    moments : ndarray
        Of the rotations, for the pose space.
    skeleton : Skeleton
    """

    key: Key
    readings: SingleArray
    rotations: SingleArray
    features: SingleArray
    levels: FootLevels
    moments: FloatArray
    skeleton: Skeleton


def example_parts(
    motions: Iterable[tuple[Key, Motion]],
    setup: SensorSetup,
    rng: np.random.Generator,
    recorded: Mapping[Key, Readings] = MappingProxyType({}),
) -> Iterator[ExamplePart]:
    """What each of some motions gives to examples; see `build_examples`."""
    for key, motion in motions:
        at_rate = resample(motion, setup.rate)
        rows = recorded.get(key) or simulate_kinds(motion, faultless(setup.layout), setup.kinds, rng)
        yield _part(key, at_rate, _sampled(rows, setup, (len(at_rate) - 1) / setup.rate))


def examples_of_parts(
    parts: Iterable[ExamplePart], setup: SensorSetup, people: Mapping[Key, str] = MappingProxyType({})
) -> Examples:
    """The examples of some motions, one or more, from what each gives: the same as are built of these motions."""
    made = _Made()
    for part in parts:
        made.add(part)
    return _joined(made, setup, people)


def people_of(recordings: Iterable[Recording]) -> dict[Key, str]:
    """Who moves in recordings, by take and track, where that is known."""
    return {(one.name, one.track): one.facts.subject for one in recordings if one.facts.subject}


def examples_of(examples: Examples, kept: BoolArray) -> Examples:
    """The examples of some takes, ``kept`` of shape ``(T,)``."""
    lengths = np.diff(examples.starts)
    rows = np.repeat(kept, lengths)
    return replace(
        examples,
        poses=examples.poses[rows],
        root_features=examples.root_features[rows],
        readings=examples.readings[rows],
        starts=np.concatenate([[0], np.cumsum(lengths[kept])]),
        takes=tuple(take for take, keep in zip(examples.takes, kept, strict=True) if keep),
        people=tuple(person for person, keep in zip(examples.people, kept, strict=True) if keep),
    )


class _Made:
    """What is made of motions, take by take: arrays of float32, and sums of float64."""

    def __init__(self) -> None:
        self.takes: list[Key] = []
        self.lengths: list[int] = []
        self.readings: list[SingleArray] = []
        self.rotations: list[SingleArray] = []
        self.features: list[SingleArray] = []
        self.levels: list[FootLevels] = []
        self.moments: FloatArray | None = None
        self.skeleton: Skeleton | None = None

    def add(self, part: ExamplePart) -> None:
        """Take what one motion gives."""
        self.takes.append(part.key)
        self.lengths.append(len(part.readings))
        self.readings.append(part.readings)
        self.rotations.append(part.rotations)
        self.features.append(part.features)
        self.levels.append(part.levels)
        self.moments = part.moments if self.moments is None else self.moments + part.moments
        self.skeleton = self.skeleton or part.skeleton


def _part(key: Key, motion: Motion, readings: FloatArray) -> ExamplePart:
    """What a motion at the examples' rate gives, with its readings ``(F, C)``."""
    rotations = without_heading(motion.rotations, motion.skeleton)
    contacts = detect_contacts(motion)
    levels = foot_levels(motion, contacts)
    return ExamplePart(
        key,
        readings.astype(np.float32),
        rotations.astype(np.float32),
        features_over(motion, levels.ground, contacts).astype(np.float32),
        levels,
        moments(rotations),
        motion.skeleton,
    )


def _joined(made: _Made, setup: SensorSetup, people: Mapping[Key, str]) -> Examples:
    assert made.skeleton is not None  # one motion or more
    assert made.moments is not None
    space = pose_space_of(made.skeleton, made.moments, made.rotations)
    root = root_model_of(made.skeleton, made.levels)
    readings, features = _end_to_end(made.readings), _end_to_end(made.features)
    scale = np.maximum(spread_of(readings).deviation, _least_spread(setup))
    readings /= scale.astype(np.float32)
    features[:, HEIGHT] += np.float32(root.level)
    return Examples(
        space,
        root,
        _end_to_end(made.rotations, lambda part: one_sided(part, space.reference)[:, space.moving]),
        features,
        readings,
        scale,
        np.concatenate([[0], np.cumsum(made.lengths)]),
        tuple(made.takes),
        setup.layout.names,
        setup.rate,
        setup.kinds,
        tuple(people.get(key) or key[0] for key in made.takes),
    )


def _end_to_end(
    parts: list[SingleArray], through: Callable[[SingleArray], SingleArray] = lambda part: part
) -> SingleArray:
    """Parts ``(F, ...)`` as one array of rows; the list is emptied on the way, for its memory."""
    total, at = sum(map(len, parts)), 0
    out = np.empty((total, through(parts[0][:1]).shape[1]), dtype=np.float32)
    parts.reverse()
    while parts:
        rows = through(parts.pop())
        out[at : at + len(rows)] = rows
        at += len(rows)
    return out


def _sampled(rows: Readings, setup: SensorSetup, duration: float) -> FloatArray:
    """Channels ``(F, C)`` of the layout's sensors."""
    own = select_sensors(rows, setup.layout.names)
    return uniform(own, setup.rate, duration, setup.resampling, setup.kinds).values


def _least_spread(setup: SensorSetup) -> FloatArray:
    return np.tile(np.repeat([LEAST[kind] for kind in setup.kinds], 3), len(setup.layout.names))
