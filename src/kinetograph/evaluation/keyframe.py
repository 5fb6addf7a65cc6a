"""How good keyframe control is: seams, feet and keys against the recordings, and in-betweening of held-out takes."""

from __future__ import annotations

import functools
import itertools
import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.evaluation.inbetweening import (
    PAST,
    Filler,
    Score,
    interpolation,
    position_scale,
    score,
    windows_of,
    zero_velocity,
)
from kinetograph.evaluation.leaving_out import Run
from kinetograph.evaluation.metrics import accelerations
from kinetograph.evaluation.plausibility import below_pieces, seam_falls
from kinetograph.keys import Key
from kinetograph.kinematics import joint_positions, on_ground, role_positions
from kinetograph.library import Library, folders_of
from kinetograph.library.fingerprints import digest, of_takes, state
from kinetograph.methods.keyframe import (
    Example,
    KeyframeControl,
    KeyframeModel,
    TimedSearch,
    adopt_named,
    collect_examples,
)
from kinetograph.motion import Motion, cut, heading_at, place
from kinetograph.pipeline import fit_keyframe
from kinetograph.post.footskate import contact_mask
from kinetograph.progress import Progress
from kinetograph.synthesis import Synthesis
from kinetograph.take import Annotation
from kinetograph.work import in_shards, require_seen


@dataclass(frozen=True)
class PairFigures:
    """Figures of one pair of keys.

    Parameters
    ----------
    first, last : str
        What the keys are called.
    solved : bool
    reason : str
        Why the pair is not solved.
    seconds : float
        Duration of the result.
    pieces : int
    jump : float
        See `seam_jump`.
    skate : float
        See `skate_ratio`.
    miss : float
        Metres, the larger of both keys' mean joint distances.
    untouched : float
        Share of the frames.
    below : float
        Metres, see `below_pieces`.
    fall : float
        The largest of ``seam_falls``; 0 without seams.
    """

    first: str
    last: str
    solved: bool
    reason: str = ""
    seconds: float = 0.0
    pieces: int = 0
    jump: float = 0.0
    skate: float = 0.0
    miss: float = 0.0
    untouched: float = 0.0
    below: float = 0.0
    fall: float = 0.0


def speed_jumps(motion: Motion) -> FloatArray:
    """How much the joints' velocities change from a frame to the next, mean over the joints, shape ``(F - 2,)`` m/s."""
    return np.asarray(accelerations(motion).mean(axis=1) / motion.fps)


def recorded_jumps(examples: Sequence[Example]) -> dict[str, float]:
    """The 99th percentile of ``speed_jumps`` of every take."""
    return {e.take: float(np.quantile(speed_jumps(e.motion), 0.99)) for e in examples if len(e.motion) > 2}


def seam_jump(result: Synthesis, recorded: Mapping[str, float]) -> float:
    """The largest of ``speed_jumps`` within two frames of a seam, over what is recorded; 0 without seams.

    Parameters
    ----------
    result : Synthesis
    recorded : mapping of str to float
        `recorded_jumps` of the library. A seam is compared with that of the two takes that has the larger jumps: the
        steps of a run are jumps compared with lying on the floor.
    """
    jumps = speed_jumps(result.motion)
    worst = 0.0
    for before, after in itertools.pairwise(result.pieces):
        frame = round(after.start * result.motion.fps)
        near = jumps[max(frame - 3, 0) : frame + 2]
        allowed = max(recorded.get(before.take, 0.0), recorded.get(after.take, 0.0), 1e-6)
        worst = max(worst, float(near.max(initial=0.0)) / allowed)
    return worst


def slide(motion: Motion, contacts: Sequence[Annotation]) -> tuple[float, int]:
    """How fast planted points move along the ground.

    Returns
    -------
    total : float
        Metres per second, summed over the steps that begin and end planted.
    count : int
        How many steps those are.
    """
    total, count = 0.0, 0
    for role in {note.label for note in contacts}:
        mask = contact_mask(tuple(contacts), role, len(motion), motion.fps)
        points = role_positions(motion, (role,))[:, 0]
        speed = np.linalg.norm(np.diff(points[:, [0, 2]], axis=0), axis=1) * motion.fps
        both = mask[1:] & mask[:-1]
        total, count = total + float(speed[both].sum()), count + int(both.sum())
    return total, count


def skate_ratio(result: Synthesis, examples: Sequence[Example]) -> float:
    """The result's mean contact speed over that of the recorded frames it is made of; at least 1 cm/s counts."""
    total, count = slide(result.motion, result.annotations)
    source_total, source_count = 0.0, 0
    by_name = {(e.take, e.track, e.mirrored): e for e in examples}
    for piece in result.pieces:
        example = by_name[piece.take, piece.track, piece.mirrored]
        a, b = slide(*_recorded(example, piece.source_start, piece.source_stop))
        source_total, source_count = source_total + a, source_count + b
    return (total / max(count, 1)) / max(source_total / max(source_count, 1), 0.01)


def _recorded(example: Example, start: float, stop: float) -> tuple[Motion, list[Annotation]]:
    """The frames of an example between two seconds, and its contacts on their clock."""
    low = round(start * example.motion.fps)
    high = min(round(stop * example.motion.fps) + 1, len(example.motion))
    offset = low / example.motion.fps
    contacts = [
        replace(n, start=max(n.start - offset, 0.0), stop=n.stop - offset) for n in example.contacts if n.stop > offset
    ]
    return cut(example.motion, low, high), contacts


def key_miss(result: Synthesis, key: Key, frame: int) -> float:
    """Mean joint distance in metres between a frame and a key that is moved to its place and heading."""
    pose = cut(key.clip, key.frame, key.frame + 1)
    mine = cut(result.motion, frame, frame + 1)
    missing = heading_at(mine, 0) - heading_at(pose, 0)
    aligned = place(pose, missing, (0.0, 0.0, 0.0))
    gap = joint_positions(aligned)[0] - joint_positions(mine)[0]
    root = on_ground(aligned.translation[0] - mine.translation[0])
    return float(np.linalg.norm(gap - root, axis=1).mean())


def judge_pair(model: KeyframeModel, first: Key, last: Key, recorded: Mapping[str, float]) -> PairFigures:
    """Solve one pair of keys and measure the result.

    Parameters
    ----------
    model : KeyframeModel
    first, last : Key
    recorded : mapping of str to float
        `recorded_jumps` of the library.
    """
    try:
        result = model.synthesize([first, last])
    except RequestError as error:
        return PairFigures(first.label, last.label, False, str(error))
    miss = max(key_miss(result, first, 0), key_miss(result, last, len(result.motion) - 1))
    return PairFigures(
        first.label,
        last.label,
        True,
        seconds=result.motion.duration,
        pieces=len(result.pieces),
        jump=seam_jump(result, recorded),
        skate=skate_ratio(result, model.examples),
        miss=miss,
        untouched=result.statistics["untouched"],
        below=below_pieces(result, model.examples),
        fall=float(seam_falls(result, model.examples).max(initial=0.0)),
    )


def inbetween_held_out(
    library: Library,
    held_out: Sequence[str],
    gaps: Sequence[int] = (5, 15, 30, 45),
    method: KeyframeControl | None = None,
    run: Run | None = None,
) -> dict[tuple[str, int], Score]:
    """Gaps of held-out takes, filled from all takes that are not held out.

    Parameters
    ----------
    library : Library
    held_out : sequence of str
        Names of takes.
    gaps : sequence of int
        Frames that are taken out.
    method : KeyframeControl, optional
        Of the timed search. In a gap that is short, recordings may be left after a third of it instead of the solver's
        ``shortest``.
    run : Run, optional
        Who fills the gaps, take by take, and what is called with the takes done and with the scores.

    Returns
    -------
    dict
        Scores by the name of the method (keyframe control and two baselines) and the gap.

    Raises
    ------
    RequestError
        For names that are not there, for a solver other than the timed search, and where no training clip is as long as
        a window.
    """
    method, run = method or KeyframeControl(), run or Run()
    held_out = tuple(held_out)
    content = digest(*map(str, folders_of(library)), of_takes(library), state(method), *held_out)
    tests = [name for name in library.names() if name in set(held_out)]
    scores: dict[tuple[str, int], Score] = {}
    for number, gap in enumerate(gaps):
        filling = _Filling(library, _for_gap(method, gap), held_out, content, gap)
        scale = position_scale([example.motion for example in filling.model().examples], gap)
        windows = [w for name in tests for w in filling.windows(name)]
        progress = partial(_along, run.progress, number * len(tests), len(gaps) * len(tests))
        filled = in_shards(partial(_filled, filling), tests, run.workers, count=len(tests), progress=progress)
        fillers: dict[str, Filler] = {
            "zero velocity": zero_velocity,
            "interpolation": interpolation,
            "keyframe": partial(_as_filled, iter([each for of_take in filled for each in of_take])),
        }
        for name, filler in fillers.items():
            scores[name, gap] = score(filler, windows, gap, scale)
            if run.note:
                run.note(f"{name} at {gap}: {scores[name, gap]}")
    return scores


def _along(progress: Progress | None, before: int, of: int, done: int, _: int) -> None:
    if progress:
        progress(before + done, of)


@dataclass(frozen=True)
class _Filling:
    """Gaps of one length, and what they are filled from."""

    library: Library = field(compare=False)
    method: KeyframeControl = field(compare=False)
    held_out: tuple[str, ...] = field(compare=False)
    digest: str
    gap: int

    def model(self) -> KeyframeModel:
        """What is fitted to the other takes: once in a process, and kept beside the library."""
        with _ONCE:
            return _model_of(self)

    def windows(self, name: str) -> list[Motion]:
        """The windows of a held-out take."""
        others = tuple(other for other in self.library.names() if other != name)
        skeleton = self.model().examples[0].motion.skeleton
        found = collect_examples(self.library, self.method.rate, exclude=others)
        return [w for e in found for w in windows_of(adopt_named(e.motion, skeleton, "a held-out take"), self.gap)]


_ONCE = threading.Lock()


@functools.lru_cache(maxsize=1)
def _model_of(filling: _Filling) -> KeyframeModel:
    return fit_keyframe(filling.method, filling.library, exclude=filling.held_out)


_Gap = tuple[FloatArray, FloatArray]
"""The root's translation and the rotations within a gap."""


def _filled(filling: _Filling, name: str) -> list[_Gap | None]:
    """The gaps of a take as they are filled; None where a gap is refused."""
    require_seen(*folders_of(filling.library))
    model, inside = filling.model(), slice(PAST, PAST + filling.gap)
    found: list[_Gap | None] = []
    for window in filling.windows(name):
        try:
            filled = _fill(model, window, filling.gap)
        except RequestError:
            found.append(None)
        else:
            found.append((filled.translation[inside], filled.rotations[inside]))
    return found


def _as_filled(gaps: Iterator[_Gap | None], window: Motion, gap: int) -> Motion:
    """A window with its gap as it was filled before."""
    made = next(gaps)
    if made is None:
        raise RequestError("the gap was refused")
    root, rotations = window.translation.copy(), window.rotations.copy()
    root[PAST : PAST + gap], rotations[PAST : PAST + gap] = made
    return replace(window, translation=root, rotations=rotations)


def _for_gap(method: KeyframeControl, gap: int) -> KeyframeControl:
    """The method, with recordings that may be left after a third of the gap where that is short."""
    if not isinstance(method.solver, TimedSearch):
        raise RequestError(f"gaps are filled by TimedSearch, which meets keys at their times, found {method.solver!r}")
    shortest = min(method.solver.shortest, (gap + 1) / 3 / method.rate)
    return replace(method, solver=replace(method.solver, shortest=shortest, force_timing=True))


def _fill(model: KeyframeModel, window: Motion, gap: int) -> Motion:
    """A window with its gap filled: the pose and speed before it, and pose, place and heading after it, are keys."""
    last = PAST + gap
    after = cut(window, last, last + 1)
    x, _, z = after.translation[0]
    at = (gap + 1) / window.fps
    keys = [
        Key(cut(window, 0, PAST), PAST - 1, label="before"),
        Key(after, 0, (at, at), (float(x), float(z)), heading_at(after, 0), label="after"),
    ]
    filled = model.synthesize(keys).motion
    root, rotations = window.translation.copy(), window.rotations.copy()
    root[PAST:last], rotations[PAST:last] = filled.translation[1 : gap + 1], filled.rotations[1 : gap + 1]
    return replace(window, translation=root, rotations=rotations)
