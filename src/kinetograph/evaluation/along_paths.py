"""Requests on paths: walks that are not in the library are followed through poses that are in it.

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
from kinetograph.errors import KinetographError, RequestError
from kinetograph.evaluation.metrics import accelerations, control_distances
from kinetograph.evaluation.played import Played
from kinetograph.keys import key_at
from kinetograph.kinematics import role_positions
from kinetograph.library import Library
from kinetograph.methods.keyframe.quality import slides_of
from kinetograph.methods.performance import PerformanceModel, Rule, Segment, Source, called, recorded_speeds
from kinetograph.methods.together import Asked, AskedKey, Keyframes, performed, pose_errors
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
HASTE = 3.0
"""m/s^2 by which a path changes its pace."""


@dataclass(frozen=True)
class Shown:
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
    moments : tuple of Shown
    keys : tuple of AskedKey
    name : str
        Of the walk, and from when on.
    """

    path: Signal
    moments: tuple[Shown, ...]
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
    keys, played : int
        How many keys, and how many of them in spans that were filled.
    filled : float
        Seconds of these spans.
    waited : float
        Seconds that the path waited meanwhile.
    beyond : float
        As ``acceleration``, but where the recording that plays has more itself, as a multiple of that.
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
    keys: int = 0
    played: int = 0
    filled: float = 0.0
    waited: float = 0.0
    beyond: float = np.nan

    @property
    def good(self) -> bool:
        """Whether keys are met to a millimetre and nothing is worse than asked for."""
        near = self.off <= 2 * self.off_plain
        return bool(self.miss_mm <= 1.0 and near and self.acceleration <= 1.0 and self.skate <= 1.0)


def moments_in(library: Library) -> list[Shown]:
    """For each take and kind the second that shows it most, where it does.

    Parameters
    ----------
    library : Library
        Takes of one motion; others are passed over.
    """
    found: list[Shown] = []
    for name in library.names():
        try:
            motion = library.take(name).motion()
            found += [Shown(kind, name, second) for kind, second in _shown(motion)]
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


def path_requests(
    library: Library, walks: Library, count: int, rng: np.random.Generator, *, placed: bool = False
) -> list[PathRequest]:
    """Random requests: stretches of walks, with keys of the library.

    Parameters
    ----------
    library : Library
        Where the poses are.
    walks : Library
        Whose hips are the paths.
    count : int
    rng : numpy.random.Generator
    placed : bool
        Keys ask for the places where the path is then, and not for times.

    Raises
    ------
    RequestError
        Where no walk is long enough, or the library shows nothing that is asked for.
    """
    moments, names = moments_in(library), _long_enough(walks)
    by_kind = {kind: [m for m in moments if m.kind == kind] for kind in KINDS}
    kinds = [kind for kind in KINDS if by_kind[kind]]
    if not kinds:
        raise RequestError(
            "no take of the library waves, picks up or turns round, so that there are no keys to ask for"
        )
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
        path = hips_path(motion, start, length)
        keys = tuple(_by_place(key, path) for key in keys) if placed else keys
        made.append(PathRequest(path, picked, keys, f"{name}@{start:.1f}"))
    return made


def _long_enough(walks: Library) -> list[str]:
    """The takes that are as long as a path is at least. Raises RequestError without one."""
    names = [name for name in walks.names() if walks.take(name).motion().duration >= SECONDS[0]]
    if not names:
        raise RequestError(f"no take of the library of walks lasts {SECONDS[0]:g} s, as paths do")
    return names


def _times(length: float, count: int, rng: np.random.Generator) -> FloatArray | None:
    """Seconds of keys, some way apart; None where there is no room."""
    room = length - (count + 1) * APART
    if room < 0:
        return None
    return np.asarray(np.sort(rng.uniform(0.0, room, count)) + APART * np.arange(1, count + 1)).round(2)


def _key(library: Library, moment: Shown, second: float, number: int) -> AskedKey:
    clip = library.take(moment.take).motion()
    label = f"key {number} ({moment.kind}, {moment.take})"
    return AskedKey(key_at(clip, moment.second, time=(second, second), label=label))


def _by_place(asked: AskedKey, path: Signal) -> AskedKey:
    """A key at the place where a path is at its time."""
    assert asked.key.time is not None
    ground = path.values[:, 0, [0, 2]]
    gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ground, axis=0), axis=1))])
    metres = float(np.interp(asked.key.time[0] * path.fps, np.arange(len(gone)), gone))
    return AskedKey(replace(asked.key, time=None), along=round(metres, 3), weight=asked.weight)


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
    model: PerformanceModel,
    requests: Sequence[PathRequest],
    progress: Progress | None = None,
    keyframes: Keyframes | None = None,
    fill: bool | None = None,
) -> list[PathRequestRow]:
    """What becomes of requests.

    Parameters
    ----------
    model : PerformanceModel
    requests : sequence of PathRequest
    progress : Progress, optional
        Called with the requests done and their number.
    keyframes : callable, optional
        See `kinetograph.methods.together.performed`; it is called once before the first request.
    fill : bool, optional
        See `kinetograph.methods.together.Asked`.
    """
    if keyframes is not None:
        fitted = keyframes()
        keyframes = lambda: fitted  # noqa: E731
    examples = () if keyframes is None else keyframes().examples
    played = Played([*examples, *model.fitted.sources])
    usual, rows = usual_of(model.fitted.sources), list[PathRequestRow]()
    for number, request in enumerate(requests, start=1):
        row, made = _row(model, request, usual, (keyframes, fill))
        beyond = np.nan if made is None else float(np.quantile(played.accelerations(made, usual.acceleration), RARE))
        rows.append(replace(row, beyond=beyond))
        if progress:
            progress(number, len(requests))
    return rows


def _row(
    model: PerformanceModel, request: PathRequest, usual: Usual, filling: tuple[Keyframes | None, bool | None]
) -> tuple[PathRequestRow, Synthesis | None]:
    kinds = ", ".join(moment.kind for moment in request.moments)
    row = PathRequestRow(request.name, kinds, request.path.duration)
    plain = model.synthesize(request.path)
    began = time.process_time()
    try:
        made = performed(model, request.path, Asked(request.keys, fill=filling[1]), keyframes=filling[0])
    except KinetographError as error:
        return replace(row, refused=str(error)), None
    spent = time.process_time() - began
    control = model.read(request.path)
    off, off_plain = (
        float(control_distances(each.motion, control.points, control.fps, each.clock)[_away(each, met)].mean())
        for each, met in ((made, made.met), (plain, _clock_of(made, made.met)))
    )
    pace, pace_plain, skate, skate_plain = (
        figure(each) / limit
        for figure, limit in ((_acceleration, usual.acceleration), (_skate, usual.skate))
        for each in (made, plain)
    )
    missed = 1000 * max(pose_errors(model, made, request.keys))
    row = replace(
        row, miss_mm=missed, off=off, off_plain=off_plain, acceleration=pace, acceleration_plain=pace_plain,
        skate=skate, skate_plain=skate_plain, processor=spent,
        keys=len(made.met), played=sum(start < second < stop for second in made.met for start, stop in made.filled),
        filled=made.statistics.get("filled_seconds", 0.0), waited=made.statistics.get("waited_seconds", 0.0),
    )  # fmt: skip
    return row, made


def _away(made: Synthesis, met: Sequence[float]) -> BoolArray:
    """The frames that are further from every key than `NEAR`."""
    times = np.arange(len(made.motion)) / made.motion.fps
    return np.asarray(np.all([np.abs(times - second) > NEAR for second in met], axis=0))


def _clock_of(made: Synthesis, seconds: Sequence[float]) -> list[float]:
    """The seconds of the control that those of a result are."""
    return [made.clock_at(round(second * made.motion.fps)) for second in seconds]


def _acceleration(made: Synthesis) -> float:
    return float(np.quantile(accelerations(made.motion), RARE))


def _skate(made: Synthesis) -> float:
    return float(np.quantile(slides_of(made.motion, contacts_of(made.annotations)), RARE))


@dataclass(frozen=True)
class SpanFigures:
    """A path in whose middle third a move was asked for.

    Parameters
    ----------
    seconds : float
        Of the path.
    share : float
        Of the span, in takes or labels that are called so.
    off, off_plain : float
        Metres of the hips from the path in the mean, with and without the move.
    """

    seconds: float
    share: float
    off: float
    off_plain: float


def evaluate_moves(
    model: PerformanceModel, paths: Sequence[Signal], move: str, progress: Progress | None = None
) -> list[SpanFigures]:
    """How much of a span is made of the move that is asked for there.

    Parameters
    ----------
    model : PerformanceModel
    paths : sequence of Signal
    move : str
        Asked for in the middle third of every path, which is followed at its usual speed.
    progress : Progress, optional
        Called with the paths done and their number.
    """
    rows: list[SpanFigures] = []
    chosen = called(model.fitted, move)
    named = {each for each, mine in zip(model.fitted.instances.segments, chosen, strict=True) if mine}
    pace = float(
        np.median(recorded_speeds(model.fitted)[chosen[[not s.held for s in model.fitted.instances.segments]]])
    )
    for number, walked in enumerate(paths, start=1):
        path, span = at_pace(walked, pace)
        control = model.read(path)
        made = performed(model, path, Asked(rules=(Rule(*span, called=move),)))
        plain = model.synthesize(path)
        off, off_plain = (
            float(control_distances(each.motion, control.points, control.fps).mean()) for each in (made, plain)
        )
        rows.append(SpanFigures(path.duration, _share(model, made, span, named), off, off_plain))
        if progress:
            progress(number, len(paths))
    return rows


def at_pace(path: Signal, pace: float) -> tuple[Signal, tuple[float, float]]:
    """A path whose middle third is followed at another speed, and the span in which it is.

    Parameters
    ----------
    path : Signal
    pace : float
        Metres per second.
    """
    points = path.values[:, 0]
    gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    usual = gone[-1] / path.duration
    distance, time, rows, times = 0.0, 0.0, list[float](), list[float]()
    speed = usual
    while distance < gone[-1]:
        rows.append(distance)
        times.append(time)
        wanted = pace if gone[-1] / 3 <= distance < 2 * gone[-1] / 3 else usual
        speed += float(np.clip(wanted - speed, -HASTE / path.fps, HASTE / path.fps))
        distance, time = distance + speed / path.fps, time + 1 / path.fps
    made = np.stack([np.interp(rows, gone, points[:, axis]) for axis in range(3)], axis=1)
    inside = [t for t, at in zip(times, rows, strict=True) if gone[-1] / 3 <= at < 2 * gone[-1] / 3]
    return Signal(made[:, None], ("path",), "m", path.fps), (inside[0], inside[-1])


def _share(model: PerformanceModel, made: Synthesis, span: tuple[float, float], named: set[Segment]) -> float:
    """The share of a span that pieces of some segments fill."""
    places = {(source.take, source.mirrored): place for place, source in enumerate(model.fitted.sources)}
    total = 0.0
    for piece in made.pieces:
        segment = Segment(places[piece.take, piece.mirrored], piece.source_start, piece.source_stop)
        if segment in named:
            total += max(min(piece.stop, span[1]) - max(piece.start, span[0]), 0.0)
    return total / (span[1] - span[0])
