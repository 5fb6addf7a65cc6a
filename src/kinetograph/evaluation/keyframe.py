"""How good keyframe control is: seams, feet and keys against the recordings, and in-betweening of held-out clips."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

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
from kinetograph.evaluation.metrics import accelerations
from kinetograph.keys import Key
from kinetograph.kinematics import joint_positions, on_ground, role_positions
from kinetograph.library import Library
from kinetograph.methods.keyframe.examples import Example, adopt, collect_examples
from kinetograph.methods.keyframe.model import KeyframeControl, KeyframeModel
from kinetograph.motion import Motion, cut, headings, place
from kinetograph.post.footskate import contact_mask
from kinetograph.synthesis import Synthesis
from kinetograph.take import Annotation

Report = Callable[[str], None]


@dataclass(frozen=True)
class PairFigures:
    """One pair of keys. solved, or why not; jump: see `seam_jump`; skate: see `skate_ratio`; miss: metres, the larger
    of both keys' mean joint distances; untouched: share of the frames.
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


def speed_jumps(motion: Motion) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """How much the joints' velocities change from a frame to the next, the mean over joints, ``(F - 2,)`` m/s."""
    return np.asarray(accelerations(motion).mean(axis=1) / motion.fps)


def recorded_jumps(examples: Sequence[Example]) -> dict[str, float]:
    """The 99th percentile of `speed_jumps` of every take."""
    return {e.take: float(np.quantile(speed_jumps(e.motion), 0.99)) for e in examples if len(e.motion) > 2}


def seam_jump(result: Synthesis, recorded: Mapping[str, float]) -> float:
    """The largest of `speed_jumps` within two frames of a seam, over what is recorded, 0 without seams.

    recorded: `recorded_jumps`; a seam is held against the livelier of the two takes that meet there, for a run's own
    steps are jumps to one who lies on the floor.
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
    """Metres a second that planted points move along the ground, summed over the steps that both ends of are planted,
    and how many those are.
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
        low = round(piece.source_start * example.motion.fps)
        high = min(round(piece.source_stop * example.motion.fps) + 1, len(example.motion))
        offset = low / example.motion.fps
        moved = [
            replace(n, start=max(n.start - offset, 0.0), stop=n.stop - offset)
            for n in example.contacts
            if n.stop > offset
        ]
        a, b = slide(cut(example.motion, low, high), moved)
        source_total, source_count = source_total + a, source_count + b
    return (total / max(count, 1)) / max(source_total / max(source_count, 1), 0.01)


def key_miss(result: Synthesis, key: Key, frame: int) -> float:
    """Mean joint distance in metres between a frame and a key that is moved to its place and heading."""
    pose = cut(key.clip, key.frame, key.frame + 1)
    mine = cut(result.motion, frame, frame + 1)
    turned = place(pose, float(headings(mine)[0] - headings(pose)[0]), (0.0, 0.0, 0.0))
    gap = joint_positions(turned)[0] - joint_positions(mine)[0]
    root = on_ground(turned.translation[0] - mine.translation[0])
    return float(np.linalg.norm(gap - root, axis=1).mean())


def judge_pair(model: KeyframeModel, first: Key, last: Key, recorded: Mapping[str, float]) -> PairFigures:
    """Solve one pair of keys and measure the result. recorded: `recorded_jumps` of the library."""
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
    )


def _fill(model: KeyframeModel, window: Motion, gap: int) -> Motion:
    """A window with its gap filled: the pose and speed before it, and pose, place and heading after it, are keys."""
    last = PAST + gap
    after = cut(window, last, last + 1)
    x, _, z = after.translation[0]
    at = (gap + 1) / window.fps
    keys = [
        Key(cut(window, 0, PAST), PAST - 1, label="before"),
        Key(after, 0, (at, at), (float(x), float(z)), float(headings(after)[0]), label="after"),
    ]
    filled = model.synthesize(keys).motion
    root, turns = window.translation.copy(), window.rotations.copy()
    root[PAST:last], turns[PAST:last] = filled.translation[1 : gap + 1], filled.rotations[1 : gap + 1]
    return replace(window, translation=root, rotations=turns)


def inbetween_held_out(
    library: Library,
    held_out: Sequence[str],
    gaps: Sequence[int] = (5, 15, 30, 45),
    method: KeyframeControl | None = None,
    report: Report | None = None,
) -> dict[tuple[str, int], Score]:
    """Scores by method and gap: every held-out take's gaps filled from all takes that are not held out.

    In a gap that is short, recordings may be left after a third of it instead of ``method.search.shortest``.
    """
    method = method or KeyframeControl()
    kept = tuple(name for name in library.names() if name not in held_out)
    tests = [example.motion for example in collect_examples(library, method.rate, exclude=kept)]
    found: dict[tuple[str, int], Score] = {}
    for gap in gaps:
        shortest = min(method.search.shortest, (gap + 1) / 3 / method.rate)
        model = replace(method, search=replace(method.search, shortest=shortest)).fit(library, exclude=tuple(held_out))
        trained = [example.motion for example in model.examples]
        scale = position_scale(trained, gap)
        windows = [w for test in tests for w in windows_of(adopt(test, trained[0].skeleton, "a held-out take"), gap)]
        fillers: dict[str, Filler] = {
            "zero velocity": zero_velocity,
            "interpolation": interpolation,
            "keyframe": partial(_fill, model),
        }
        for name, filler in fillers.items():
            found[name, gap] = score(filler, windows, gap, scale)
            if report:
                report(f"{name} at {gap}: {found[name, gap]}")
    return found
