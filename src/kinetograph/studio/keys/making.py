"""Keys: the poses of a project, and the motions that go through them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import msgspec
import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import KinetographError, RequestError, TooSoonError, UnmetError
from kinetograph.keys import Key
from kinetograph.kinematics import on_ground
from kinetograph.library import Library
from kinetograph.methods.keyframe import FittedTimedSearch, KeyframeControl, KeyframeModel, TimedSearch
from kinetograph.methods.relative_pose import BODY
from kinetograph.motion import cut, heading_at, place
from kinetograph.pipeline import inbetween_with
from kinetograph.post import JointRange, ends_of, limbs_of, parts_of, put_ends, seen_ranges
from kinetograph.progress import Progress
from kinetograph.skeleton import same_shape
from kinetograph.studio.keys.rows import file_of, key_labels, key_of, said_of
from kinetograph.studio.made import Made, bodies, clip
from kinetograph.studio.messages import (
    Alternative,
    ClipHeader,
    EndPlaces,
    Figure,
    KeyEnds,
    KeyPose,
    KeysMet,
    KeyTrouble,
    Lane,
    Message,
    Met,
    MetRow,
    Span,
    Trouble,
    blob,
)
from kinetograph.studio.project import KeyRow, Keys, Project
from kinetograph.studio.room import Room
from kinetograph.studio.sections import Answer
from kinetograph.synthesis import Synthesis

MOST = 4
"""Alternatives."""
FORCE = "; or force it (--force-timing)"
"""How refusals end of what can be made all the same."""
DEEPEST = 32
"""How many spans may be locked one after another."""
_REMEMBERED = 32  # results
_SHAPE = 0.02  # metres by which bones may differ for joints to be those of the library


@dataclass(frozen=True, eq=False)
class Solved:
    """Motions through the rows of some keys.

    Parameters
    ----------
    syntheses : tuple of Synthesis
        The best first.
    times : tuple of tuple of float
        Seconds at which each row is met, of every synthesis.
    """

    syntheses: tuple[Synthesis, ...]
    times: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, eq=False)
class _Learned:
    """A model with what was solved by it, so that choosing an alternative searches for nothing."""

    model: KeyframeModel
    ranges: tuple[JointRange, ...]
    solved: dict[bytes, Solved] = field(default_factory=dict)
    refused: dict[bytes, KinetographError] = field(default_factory=dict)

    def refuse(self, name: bytes, error: KinetographError) -> None:
        while len(self.refused) >= _REMEMBERED:
            self.refused.pop(next(iter(self.refused)))
        self.refused[name] = error

    def keep(self, name: bytes, solved: Solved) -> Solved:
        while len(self.solved) >= _REMEMBERED:
            self.solved.pop(next(iter(self.solved)))
        self.solved[name] = solved
        return solved


def make(project: Project, room: Room, progress: Progress) -> Made | None:
    """The motions through a project's keys.

    Parameters
    ----------
    project : Project
    room : Room
    progress : Progress
        May raise to stop.

    Returns
    -------
    Made or None
        None for fewer than two keys.

    Raises
    ------
    RequestError
        For keys that cannot be met.
    """
    keys = project.keys
    if len(keys.rows) < 2 and keys.lock is None:
        if keys.rows:  # while someone looks for the second key, the recordings are learned
            _learned(keys, room.library(project.libraries, keys.library), room, progress)
        return None
    solved = solve(keys, project, room, progress)
    chosen = min(keys.chosen, len(solved.syntheses) - 1)
    lane = _lane(keys, solved.times[chosen])
    figures = (Figure("alternatives", str(len(solved.syntheses))),) if keys.alternatives > 1 else ()
    return Made(solved.syntheses, chosen, lanes=(lane,), figures=figures)


def solve(keys: Keys, project: Project, room: Room, progress: Progress, depth: int = 0) -> Solved:
    """Motions through keys, or those found before.

    Parameters
    ----------
    keys : Keys
    project : Project
        Has the libraries.
    room : Room
    progress : Progress
        May raise to stop.
    depth : int
        How many locks lead here.

    Raises
    ------
    RequestError
        For keys that cannot be met.
    """
    if depth > DEEPEST:
        raise RequestError(f"at most {DEEPEST} spans can be locked one after another; unlock one")
    if not (0 <= keys.chosen < MOST and 1 <= keys.alternatives <= MOST):
        raise RequestError(f"expected 1 to {MOST} alternatives, one of them chosen, found {keys.alternatives}")
    library = room.library(project.libraries, keys.library)
    learned = _learned(keys, library, room, progress)
    name = _name(keys, room)
    if (known := learned.solved.get(name)) is not None:
        return known
    if (refused := learned.refused.get(name)) is not None:
        raise refused
    progress(0, 1)
    try:
        if keys.lock is None:
            solved = _through(keys, learned, library, room)
        else:
            earlier = solve(keys.lock.of, project, room, progress, depth + 1)
            progress(0, 1)
            solved = _around(keys, earlier, learned, library, room)
    except UnmetError as error:  # the page asks for it once more
        learned.refuse(name, error)
        raise
    progress(1, 1)
    return learned.keep(name, solved)


def _learned(keys: Keys, library: Library, room: Room, progress: Progress) -> _Learned:
    base = room.fitted(library, ("keys", keys.mirror), lambda: _learn(Keys(mirror=keys.mirror), library, progress))
    name = ("keys", keys.mirror, keys.moves, keys.without, keys.filler, keys.force)
    return room.fitted(library, name, lambda: _learn_names(keys, base))


def _learn(keys: Keys, library: Library, progress: Progress) -> _Learned:
    model = control_of(keys).fit(library, rng=np.random.default_rng(0), progress=progress)
    motions = [example.motion for example in model.examples]
    joints = [joint for limb in limbs_of(motions[0].skeleton) for joint in limb]
    return _Learned(model, seen_ranges(motions, joints))


def _learn_names(keys: Keys, base: _Learned) -> _Learned:
    """The same recordings, by way of other moves: that needs no other index of them."""
    method = control_of(keys)
    model = base.model
    if isinstance(method.solver, TimedSearch) and isinstance(model.fitted, FittedTimedSearch):
        model = KeyframeModel(method, model.examples, method.solver.refit(model.examples, model.fitted))
    return _Learned(model, base.ranges)


def control_of(keys: Keys) -> KeyframeControl:
    """The configuration by which keys are gone through: that of ``inbetween``, with ``--force-timing`` if asked."""
    search = TimedSearch(moves=keys.moves, without=keys.without, force_timing=keys.force)
    search = replace(search, begin_unasked=0.0, unasked=0.0) if keys.filler else search
    return KeyframeControl(solver=search, mirror=keys.mirror)


def _name(keys: Keys, room: Room) -> bytes:
    """All that a result depends on, besides the library."""
    files = {name for row in keys.rows if (name := file_of(row)) is not None}
    states = {name: room.file(name).stat().st_mtime_ns for name in sorted(files)}
    return msgspec.json.encode([msgspec.structs.replace(keys, chosen=0), states])


def _keys_of(keys: Keys, library: Library, room: Room) -> tuple[Key, ...]:
    labels = key_labels(keys.rows)
    return tuple(key_of(row, label, library, room) for row, label in zip(keys.rows, labels, strict=True))


def _through(keys: Keys, learned: _Learned, library: Library, room: Room) -> Solved:
    wanted = _keys_of(keys, library, room)
    found = inbetween_with(learned.model, wanted, keys.alternatives)
    times = tuple(synthesis.met for synthesis in found)
    return _finished(keys, wanted, Solved(found, times), learned)


def _around(keys: Keys, earlier: Solved, learned: _Learned, library: Library, room: Room) -> Solved:
    """Motions of which a span is that of an earlier result."""
    assert keys.lock is not None
    of = keys.lock.of
    number = min(of.chosen, len(earlier.syntheses) - 1)
    held, met = earlier.syntheses[number], _met_before(keys.rows, of.rows, earlier.times[number])
    low, high = (round(second * held.motion.fps) / held.motion.fps for second in keys.lock.span)
    inside = [time is not None and low <= time <= high for time in met]
    wanted = _windows(_keys_of(keys, library, room), met, (low, high), 1.0 / held.motion.fps)
    free = [key for key, within in zip(wanted, inside, strict=True) if not within]
    found = learned.model.alternatives_around(held, keys.lock.span, free, keys.alternatives)
    shift = 0.0 if free and (free[0].time is None or free[0].time[1] < low) else -low
    span, known = (low + shift, high + shift), [t + shift if t is not None else 0.0 for t in met]
    times = tuple(_times(synthesis, known, inside, span) for synthesis in found)
    return _finished(keys, wanted, Solved(found, times), learned, span)


def _met_before(rows: tuple[KeyRow, ...], of: tuple[KeyRow, ...], times: tuple[float, ...]) -> list[float | None]:
    """When the rows that an earlier result has as well are met there; None for others."""
    known = {msgspec.json.encode(row): time for row, time in zip(of, times, strict=True)}
    return [known.get(msgspec.json.encode(row)) for row in rows]


def _windows(
    keys: tuple[Key, ...], met: list[float | None], span: tuple[float, float], frame: float
) -> tuple[Key, ...]:
    """Keys around a span that is held: those whose time is free have all the time on their side of it."""
    windows = ((0.0, span[0] - frame), (span[1] + frame, span[1] + TimedSearch.longest * len(keys)))
    timed, after = [], False
    for number, (key, time) in enumerate(zip(keys, met, strict=True)):
        before = time if time is not None else None if key.time is None else key.time[1]
        after = after if before is None else before >= span[0]
        free = key.time is None and number > 0
        timed.append(replace(key, time=windows[after]) if free else key)
    return tuple(timed)


def _times(
    synthesis: Synthesis, known: list[float], inside: list[bool], span: tuple[float, float]
) -> tuple[float, ...]:
    """When each row is met: those in the span that is held as before, the others in their order."""
    rest = (time for time in synthesis.met if not span[0] - 1e-6 <= time <= span[1] + 1e-6)
    return tuple(time if within else next(rest) for time, within in zip(known, inside, strict=True))


def _finished(
    keys: Keys, wanted: tuple[Key, ...], solved: Solved, learned: _Learned, span: tuple[float, float] | None = None
) -> Solved:
    """With hands and feet of keys of a few parts where they were put, and with what a person should know of them."""
    skeleton = learned.model.examples[0].motion.skeleton
    said = [
        line
        for row, key in zip(keys.rows, wanted, strict=True)
        for line in said_of(row, key, learned.ranges if same_shape(key.clip.skeleton, skeleton, _SHAPE) else ())
    ]
    syntheses = []
    for synthesis, times in zip(solved.syntheses, solved.times, strict=True):
        motion = synthesis.motion
        for row, time in zip(keys.rows, times, strict=True):
            if row.moved and row.roles is not None and (decay := _decay(time, span)) > 0:
                motion = put_ends(motion, round(time * motion.fps), row.moved, decay)
        syntheses.append(replace(synthesis, motion=motion, warnings=(*synthesis.warnings, *said)))
    return replace(solved, syntheses=tuple(syntheses))


def _decay(time: float, span: tuple[float, float] | None) -> float:
    """Seconds over which the change of a hand fades: not into a span that is held."""
    room = TimedSearch.decay if span is None else max(span[0] - time, time - span[1], 0.0)
    return min(TimedSearch.decay, room)


def _lane(keys: Keys, times: tuple[float, ...]) -> Lane:
    """The keys at the times at which they are met."""
    labels = key_labels(keys.rows)
    titles = [_title(row, time) for row, time in zip(keys.rows, times, strict=True)]
    spans = zip(times, labels, titles, strict=True)
    return Lane("keys", "keys", tuple(Span(time, time, label, title) for time, label, title in spans))


def _title(row: KeyRow, time: float) -> str:
    asked = "free" if row.time is None else "asked for"
    return f"{row.pose}, met at {time:.2f} s ({asked})"


# ---- questions of the page ----


def _pose(room: Room, project: Project, question: KeyPose) -> bytes:
    """The pose of a row alone, its root above the origin, facing as at rest."""
    key = _key(room, project, question.row)
    pose = cut(key.clip, key.frame, key.frame + 1)
    pose = place(pose, -heading_at(pose, 0), (0.0, 0.0, 0.0))
    pose = place(pose, 0.0, -on_ground(pose.translation[0]))
    return blob(ClipHeader(question.id, key.label), clip(bodies({"key": pose}, None), None))


def _ends(room: Room, project: Project, question: KeyEnds) -> EndPlaces:
    """Where a row's hands and feet are, and where its pose stands in its recording."""
    key = _key(room, project, question.row)
    ends = {role: _three(point) for role, point in ends_of(key.clip, key.frame).items()}
    x, _, z = _three(key.clip.translation[key.frame])
    heading = math.degrees(heading_at(key.clip, key.frame))
    roles = tuple(role for role in BODY if role in key.clip.skeleton.roles)
    said = tuple(line.removeprefix(f"{key.label}: ") for line in said_of(question.row, key, ()))
    places, rotations = (each[0].tolist() for each in parts_of(cut(key.clip, key.frame, key.frame + 1), roles))
    positions = {role: (p[0], p[1], p[2]) for role, p in zip(roles, places, strict=True)}
    orientations = {role: (q[0], q[1], q[2], q[3]) for role, q in zip(roles, rotations, strict=True)}
    return EndPlaces(question.id, ends, roles, (x, z), heading, said, positions, orientations)


def _key(room: Room, project: Project, row: KeyRow) -> Key:
    return key_of(row, row.name or "the key", room.library(project.libraries, project.keys.library), room)


def _three(point: FloatArray) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in point)
    return x, y, z


def _met(room: Room, project: Project, question: KeysMet) -> Met:
    """When and where the keys are met in the motion that is shown."""
    keys = project.keys
    learned = _learned(keys, room.library(project.libraries, keys.library), room, _ignored)
    solved = learned.solved.get(_name(keys, room))
    if solved is None:
        raise RequestError("the keys have changed since they were solved")
    number = min(keys.chosen, len(solved.syntheses) - 1)
    motion, rows = solved.syntheses[number].motion, []
    for time in solved.times[number]:
        frame = min(round(time * motion.fps), len(motion) - 1)
        x, _, z = _three(motion.translation[frame])
        rows.append(MetRow(time, (x, z), math.degrees(heading_at(motion, frame))))
    return Met(question.id, tuple(rows))


def _alternative(room: Room, project: Project, question: Alternative) -> bytes:
    """One of the motions that were made last."""
    made = room.latest.get("keys")
    if made is None or not 0 <= question.number < len(made.syntheses):
        raise RequestError(f"there is no alternative {question.number + 1}")
    character = room.character(project.character)
    synthesis = made.syntheses[question.number]
    take = bodies({"motion": synthesis.motion}, character, tuple(synthesis.annotations))
    return blob(ClipHeader(question.id, f"alternative {question.number + 1}"), clip(take, character))


def _trouble(room: Room, project: Project, question: KeyTrouble) -> Trouble:
    """Which key cannot be met, and how much later it can be, if it is too soon."""
    labels = key_labels(project.keys.rows)
    try:
        solve(project.keys, project, room, _ignored)
    except UnmetError as error:
        row = labels.index(error.label) if error.label in labels else None
        seconds = error.seconds if isinstance(error, TooSoonError) else None
        said = str(error)
        return Trouble(question.id, said.removesuffix(FORCE), row, seconds, said.endswith(FORCE))
    except KinetographError as error:
        rows = [row for row, label in enumerate(labels) if str(error).startswith(f"{label}:")]
        return Trouble(question.id, str(error), rows[0] if rows else None)
    return Trouble(question.id)


def _ignored(done: int, total: int) -> None:
    pass


ANSWERS: Mapping[type[Message], Answer] = {
    KeyPose: _pose,
    KeyEnds: _ends,
    KeysMet: _met,
    Alternative: _alternative,
    KeyTrouble: _trouble,
}
"""What the panel of keys asks."""
