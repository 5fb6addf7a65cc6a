"""Requests on paths: walks of people who are not in the library are followed through poses that are in it.

A request is a stretch of somebody's walk, as a path, and one to three keys: moments of the library's takes in which a
hand is far above the head (*wave*), a hand is near the ground and the body upright (*pick*), or the body turns round
(*turn*). Where a key is on the path is drawn at random; its place and heading are those of the path.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import KinetographError
from kinetograph.evaluation.metrics import accelerations, control_distances
from kinetograph.keys import key_at
from kinetograph.kinematics import role_positions
from kinetograph.library import Library
from kinetograph.methods.keyframe.quality import slides_of
from kinetograph.methods.performance import PerformanceModel, Source
from kinetograph.methods.together import Asked, AskedKey, performed, pose_errors
from kinetograph.motion import Motion, headings
from kinetograph.post.contacts import contacts_of
from kinetograph.progress import Progress
from kinetograph.signal import Signal
from kinetograph.synthesis import Synthesis

KINDS = ("wave", "pick", "turn")
ABOVE, BELOW, UPRIGHT, ROUND, FEET = 0.25, 0.45, 0.45, 120.0, 0.15
"""Metres of a waving hand above the head, of a picking hand and of upright hips above the lowest ankle; degrees in a
second, twice as many being a jump or a spin; metres of standing ankles above the lowest."""
SECONDS = (12.0, 20.0)
"""How long a path is, from and to."""
APART = 2.5
"""Seconds between two keys, and between a key and the path's ends."""
NEAR = 1.0
"""Seconds before and after a key in which the path may be left."""
RARE = 0.999


@dataclass(frozen=True)
class Moment:
    """A second of a take that shows something.

    Parameters
    ----------
    kind : str
        One of `KINDS`.
    take : str
    second : float
    """

    kind: str
    take: str
    second: float


@dataclass(frozen=True, eq=False)
class PathRequest:
    """A path and its keys.

    Parameters
    ----------
    path : Signal
    moments : tuple of Moment
    keys : tuple of AskedKey
    name : str
        Of the walk, and from when on.
    """

    path: Signal
    moments: tuple[Moment, ...]
    keys: tuple[AskedKey, ...]
    name: str


@dataclass(frozen=True)
class PathRequestRow:
    """What became of a request on a path.

    Parameters
    ----------
    name : str
    kinds : str
        Of its keys.
    seconds : float
        Of the path.
    refused : str
        Why, where it was.
    miss_mm : float
        The furthest joint of a key from its place as seen from the root, millimetres.
    off, off_plain : float
        Metres of the hips from the path, the mean outside 1 s of a key, with and without keys.
    acceleration, acceleration_plain : float
        The 99.9th percentile of the joints', with and without keys, as a multiple of the recordings'.
    skate, skate_plain : float
        The 99.9th percentile of the speed of planted feet over half a second, likewise.
    processor : float
        Seconds of processor time that the request took once the library was fitted.
    """

    name: str
    kinds: str
    seconds: float
    refused: str = ""
    miss_mm: float = np.nan
    off: float = np.nan
    off_plain: float = np.nan
    acceleration: float = np.nan
    acceleration_plain: float = np.nan
    skate: float = np.nan
    skate_plain: float = np.nan
    processor: float = np.nan

    @property
    def good(self) -> bool:
        """Whether keys are met to a millimetre and nothing is worse than asked for."""
        near = self.off <= 2 * self.off_plain
        return bool(self.miss_mm <= 1.0 and near and self.acceleration <= 1.0 and self.skate <= 1.0)


def moments_in(library: Library) -> list[Moment]:
    """For each take and kind the second that shows it most, where it does.

    Parameters
    ----------
    library : Library
        Takes of one motion; others are passed over.
    """
    found: list[Moment] = []
    for name in library.names():
        try:
            motion = library.take(name).motion()
            found += [Moment(kind, name, second) for kind, second in _shown(motion)]
        except KinetographError:
            continue
    return found


def _shown(motion: Motion) -> Iterator[tuple[str, float]]:
    points = role_positions(motion, ("left_hand", "right_hand", "head", "hips", "left_foot", "right_foot"))
    heights = points[..., 1] - points[:, 4:, 1].min()
    above = heights[:, :2].max(axis=1) - heights[:, 2]
    low = np.where(heights[:, 3] > UPRIGHT, heights[:, :2].min(axis=1), np.inf)
    second = round(motion.fps)
    standing = (heights[:, 4:].max(axis=1) < FEET) & (heights[:, 2] > heights[:, 3])
    above = np.where(standing & (heights[:, 3] > 0.8 * np.median(heights[:, 3])), above, -np.inf)
    if above.max() > ABOVE:
        yield "wave", float(np.argmax(above)) / motion.fps
    low[~standing] = np.inf
    if low.min() < BELOW:
        yield "pick", float(np.argmin(low)) / motion.fps
    if len(motion) > second:
        angles = np.unwrap(headings(motion))
        turned = np.degrees(np.abs(angles[second:] - angles[:-second]))
        turned[~standing[second // 2 :][: len(turned)] | (turned > 2 * ROUND)] = 0.0
        if turned.max() > ROUND:
            yield "turn", float(np.argmax(turned)) / motion.fps + 0.5


def path_requests(library: Library, walks: Library, count: int, rng: np.random.Generator) -> list[PathRequest]:
    """Random requests: stretches of walks, with keys of the library.

    Parameters
    ----------
    library : Library
        Where the poses are.
    walks : Library
        Whose hips are the paths.
    count : int
    rng : numpy.random.Generator
    """
    moments, names = moments_in(library), walks.names()
    by_kind = {kind: [m for m in moments if m.kind == kind] for kind in KINDS}
    kinds = [kind for kind in KINDS if by_kind[kind]]
    made: list[PathRequest] = []
    while len(made) < count:
        name = names[int(rng.integers(len(names)))]
        motion = walks.take(name).motion()
        length = min(float(rng.uniform(*SECONDS)), motion.duration)
        start = float(rng.uniform(0.0, motion.duration - length))
        chosen = [by_kind[kind] for kind in rng.choice(kinds, int(rng.integers(1, 4)))]
        picked = tuple(each[int(rng.integers(len(each)))] for each in chosen)
        times = _times(length, len(picked), rng)
        if times is None:
            continue
        keys = tuple(_key(library, moment, at, i) for i, (moment, at) in enumerate(zip(picked, times, strict=True), 1))
        made.append(PathRequest(hips_path(motion, start, length), picked, keys, f"{name}@{start:.1f}"))
    return made


def _times(length: float, count: int, rng: np.random.Generator) -> FloatArray | None:
    """Seconds of keys, some way apart; None where there is no room."""
    room = length - (count + 1) * APART
    if room < 0:
        return None
    return np.asarray(np.sort(rng.uniform(0.0, room, count)) + APART * np.arange(1, count + 1)).round(2)


def _key(library: Library, moment: Moment, second: float, number: int) -> AskedKey:
    clip = library.take(moment.take).motion()
    label = f"key {number} ({moment.kind}, {moment.take})"
    return AskedKey(key_at(clip, moment.second, time=(second, second), label=label))


def hips_path(motion: Motion, start: float, length: float) -> Signal:
    """The middle of the hips on the ground, for a stretch of a motion, as a path.

    Parameters
    ----------
    motion : Motion
    start, length : float
        Seconds.
    """
    first, last = round(start * motion.fps), round((start + length) * motion.fps)
    middle = role_positions(motion, ("left_hip", "right_hip")).mean(axis=1)[first : last + 1] * [1.0, 0.0, 1.0]
    return Signal(middle[:, None], ("path",), "m", motion.fps)


@dataclass(frozen=True)
class Usual:
    """What is rare in recordings.

    Parameters
    ----------
    acceleration, skate : float
        The 99.9th percentiles of the joints' accelerations, m/s^2, and of the speed of planted feet, m/s.
    """

    acceleration: float
    skate: float


def usual_of(sources: Sequence[Source]) -> Usual:
    """What is rare in some recordings: of all frames together."""
    whole = [source for source in sources if not source.mirrored and len(source.motion) > 2]
    speeds = [slides_of(source.motion, contacts_of(source.annotations)) for source in whole]
    pace = [accelerations(source.motion).ravel() for source in whole]
    return Usual(*(float(np.quantile(np.concatenate(each), RARE)) for each in (pace, speeds)))


def evaluate_requests(
    model: PerformanceModel, requests: Sequence[PathRequest], progress: Progress | None = None
) -> list[PathRequestRow]:
    """What becomes of requests.

    Parameters
    ----------
    model : PerformanceModel
    requests : sequence of PathRequest
    progress : Progress, optional
        Called with the requests done and their number.
    """
    usual, rows = usual_of(model.fitted.sources), list[PathRequestRow]()
    for number, request in enumerate(requests, start=1):
        rows.append(_row(model, request, usual))
        if progress:
            progress(number, len(requests))
    return rows


def _row(model: PerformanceModel, request: PathRequest, usual: Usual) -> PathRequestRow:
    kinds = ", ".join(moment.kind for moment in request.moments)
    row = PathRequestRow(request.name, kinds, request.path.duration)
    plain = model.synthesize(request.path)
    began = time.process_time()
    try:
        made = performed(model, request.path, Asked(request.keys))
    except KinetographError as error:
        return replace(row, refused=str(error))
    spent = time.process_time() - began
    control = model.read(request.path)
    away = _away(made, made.met)
    off, off_plain = (
        float(control_distances(each.motion, control.points, control.fps)[away].mean()) for each in (made, plain)
    )
    pace, pace_plain, skate, skate_plain = (
        figure(each) / limit
        for figure, limit in ((_acceleration, usual.acceleration), (_skate, usual.skate))
        for each in (made, plain)
    )
    missed = 1000 * max(pose_errors(model, made, request.keys))
    return replace(
        row, miss_mm=missed, off=off, off_plain=off_plain, acceleration=pace, acceleration_plain=pace_plain,
        skate=skate, skate_plain=skate_plain, processor=spent,
    )  # fmt: skip


def _away(made: Synthesis, met: Sequence[float]) -> BoolArray:
    """The frames that are further from every key than `NEAR`."""
    times = np.arange(len(made.motion)) / made.motion.fps
    return np.asarray(np.all([np.abs(times - second) > NEAR for second in met], axis=0))


def _acceleration(made: Synthesis) -> float:
    return float(np.quantile(accelerations(made.motion), RARE))


def _skate(made: Synthesis) -> float:
    return float(np.quantile(slides_of(made.motion, contacts_of(made.annotations)), RARE))
