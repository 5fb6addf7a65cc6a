"""What no key asks for costs, and moves are asked for or ruled out by name; nobody falls faster than freely."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.evaluation import below_pieces, seam_falls
from kinetograph.keys import key_at
from kinetograph.learn import Goal, last_frames, make_graph
from kinetograph.methods.everyday import AROUND, everyday_frames
from kinetograph.methods.keyframe import Example, TimedSearch
from kinetograph.methods.keyframe.falls import ALLOWANCE, FREE, falls_freely
from kinetograph.methods.keyframe.filler import FEW, LIKE, UNLIKE, boxes_of, familiar, shorten, unasked
from kinetograph.methods.keyframe.named import named_frames
from kinetograph.methods.naming import is_called
from kinetograph.motion import Motion
from kinetograph.post.blend import quintic_decay
from kinetograph.post.falling import GRAVITY, accelerated, centre_height
from kinetograph.take import Annotation, Take
from walkers import walk

WALKING = ("0walk_forward", "walk", "turn_left0", "turn_left1", "turn_right0", "turn_right1")


@pytest.fixture(scope="module")
def clips(tmp_path_factory: pytest.TempPathFactory, clips_folder: Path) -> kg.Library:
    library = kg.Library.create(tmp_path_factory.mktemp("filler") / "clips")
    for file in sorted(clips_folder.glob("*.txt")):
        take = kg.load(file)
        library.add(Take(file.stem.removeprefix("humanoid3d_"), take.tracks, take.annotations))
    return library


def key(clips: kg.Library, name: str, second: float, time: float | None = None) -> kg.Key:
    return key_at(clips.take(name).motion(), second, time=None if time is None else (time, time), label=name)


def example(motion: Motion, name: str = "one", labels: tuple[Annotation, ...] = (), period: float = 0.0) -> Example:
    return Example(name, "motion", False, motion, (), period, labels)


def test_a_kick_and_a_run_are_joined_by_walking(clips: kg.Library):
    # the one run of the clips is entered with a slide that no clip has
    model = kg.KeyframeControl(solver=TimedSearch(force_timing=True)).fit(clips)
    four = (("walk", 0.3, None), ("kick", 0.6, 2.0), ("run", 0.4, 5.0), ("walk", 0.6, 8.0))
    for timed in (True, False):
        keys = [key(clips, name, at, time if timed else None) for name, at, time in four]
        made = model.synthesize(keys)
        assert {piece.take for piece in made.pieces} <= {*WALKING, "kick", "run"}
        assert below_pieces(made, model.examples) < 0.02
        assert seam_falls(made, model.examples).max() <= 1.05
    assert "planted feet slide" in made.warnings[-1]
    lying = model.synthesize([key(clips, "getup_facedown", 0.0), key(clips, "run", 0.4)])
    assert {piece.take for piece in lying.pieces} <= {*WALKING, "getup_facedown", "run"}
    any_filler = kg.KeyframeControl(solver=TimedSearch(begin_unasked=0.0, unasked=0.0)).fit(clips)
    free = any_filler.synthesize([key(clips, "getup_facedown", 0.0), key(clips, "run", 0.4)])
    assert not {piece.take for piece in free.pieces} <= {*WALKING, "getup_facedown", "run"}


def test_no_hand_goes_into_the_floor_on_the_way_down(clips: kg.Library):
    keys = [key(clips, "cartwheel", 0.5), key(clips, "crawl", 0.5)]
    model = kg.KeyframeControl().fit(clips)
    made = model.synthesize(keys)
    assert below_pieces(made, model.examples) < 0.02
    assert (
        seam_falls(made, model.examples).max() <= 1.15
    )  # 1.10: what is refused is judged by heights, poses are blended
    sinking = kg.KeyframeControl(post=kg.post.PostSettings(floor=False)).fit(clips)
    assert below_pieces(sinking.synthesize(keys), model.examples) > 0.1


def test_moves_are_asked_for_and_ruled_out(clips: kg.Library):
    keys = [key(clips, "getup_facedown", 0.0), key(clips, "run", 0.4)]
    jumping = kg.KeyframeControl(solver=TimedSearch(moves=("jump",))).fit(clips).synthesize(keys)
    assert "jump" in {piece.take for piece in jumping.pieces}
    straight = kg.KeyframeControl(solver=TimedSearch(without=("turn*",))).fit(clips).synthesize(keys)
    assert not any(piece.take.startswith("turn") for piece in straight.pieces)
    with pytest.raises(RequestError, match="nothing is called 'tango'; there are 0walk_forward, backflip, "):
        kg.KeyframeControl(solver=TimedSearch(without=("tango",))).fit(clips)
    with pytest.raises(RequestError, match=r"without \* nothing is left to use"):
        kg.KeyframeControl(solver=TimedSearch(without=("*",))).fit(clips)


@pytest.mark.parametrize(
    ("known", "name", "called"),
    [
        ("humanoid3d_jump", "jump", True),
        ("humanoid3d_dance_a", "Dance_A", True),
        ("humanoid3d_dance_a", "dance a", True),
        ("Turn left", "turn*", True),
        ("jumper", "jump", False),
        ("dance_b_a", "dance_a", False),
    ],
)
def test_names_are_words_or_patterns(known: str, name: str, called: bool):
    assert is_called(known, name) is called


def test_labels_pick_out_their_spans_in_every_cycle():
    notes = (Annotation("motion", "move", "half turn", 0.5, 0.9),)
    motion = walk(3.0)
    once = named_frames([example(motion, labels=notes)], ["turn"])
    assert np.flatnonzero(once).tolist() == list(range(15, 28))
    cycles = named_frames([example(motion, labels=notes, period=1.0), example(motion, "two")], ["half turn"])
    assert np.flatnonzero(cycles).tolist() == [f + 30 * c for c in range(3) for f in range(15, 28)]
    assert named_frames([example(motion), example(motion, "two")], ["two"]).sum() == len(motion)


def test_what_is_everyday_is_so_for_a_while_before_and_after():
    motion = walk(3.0)
    rotations = motion.rotations.copy()
    rotations[45, 0] = rot.multiply(rot.about("x", np.pi / 2), rotations[45, 0])
    walking, _ = everyday_frames(replace(motion, rotations=rotations))
    half = round(AROUND * motion.fps)
    assert np.flatnonzero(~walking).tolist() == list(range(45 - half, 45 + half + 1))


def test_walking_is_everyday_and_lying_is_not():
    motion = walk(3.0)
    walking, running = everyday_frames(motion)
    assert walking.all()
    flat = rot.multiply(rot.about("x", np.pi / 2), motion.rotations[:, 0])
    lying = replace(motion, rotations=np.concatenate([flat[:, None], motion.rotations[:, 1:]], axis=1))
    assert not any(mask.any() for mask in everyday_frames(lying))
    assert not everyday_frames(replace(motion, translation=motion.translation * [0.2, 1.0, 0.2]))[1].any()
    assert running.all() or not running.any()


def test_frames_are_unasked_as_far_as_they_are_unlike_what_is_known():
    # on a line: walking at 0, the keys' own recording at 1, and another from 0 to 0.5
    line = np.concatenate([np.zeros(5), np.full(5, 1.0), np.linspace(0.0, 0.5, 11)])
    features = np.stack([line, np.zeros_like(line)], axis=1).astype(np.float32)
    last = last_frames([5, 5, 11])
    known = np.arange(21) < 5
    goals = [Goal(np.array([7]), np.zeros(1)), Goal(np.array([9]), np.zeros(1))]
    level = unasked(familiar(features, last, known, np.zeros(21, dtype=bool), 30.0), goals)
    assert (level[:10] == 0).all()
    assert level[10:] == pytest.approx(np.clip((line[10:] - 0.1) / 0.1, 0.0, 1.0), abs=1e-3)
    elsewhere = [Goal(np.array([0]), np.zeros(1)), Goal(np.array([4]), np.zeros(1))]
    assert unasked(familiar(features, last, known, np.zeros(21, dtype=bool), 30.0), elsewhere)[5:10].min() == 1.0
    running = familiar(features, last, known, np.arange(21) >= 10, 30.0)
    assert unasked(running, [Goal(np.array([20]), np.zeros(1)), goals[1]])[10:].max() == 0.0


@given(st.integers(0, 2**32 - 1), st.sampled_from([1, 7, 300, 5000]))
def test_gaps_are_those_of_all_pairs_where_these_tell(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    rows, others = (np.cumsum(0.04 * rng.normal(size=(n, 5)), axis=0).astype(np.float32) for n in (200, count))
    before = rng.choice([0.0, 0.05, 0.15, 0.3, np.inf], 200)
    gaps = before.copy()
    shorten(gaps, rows, boxes_of(rows, FEW), others)
    nearest = np.linalg.norm(rows[:, None].astype(float) - others, axis=2).min(axis=1)
    expected = np.clip(np.minimum(before, nearest), LIKE, UNLIKE)
    assert np.clip(gaps, LIKE, UNLIKE) == pytest.approx(expected, abs=1e-6)
    assert (gaps <= before).all()
    apart = before.copy()
    shorten(apart, rows + np.float32(90), boxes_of(rows + np.float32(90), FEW), others)
    assert np.array_equal(apart, before)


def test_of_very_many_frames_those_between_are_interpolated():
    # recordings of a hundred frames; each goes to 0.3 m from what is known and comes back
    count = 1500
    away = np.tile(0.3 * np.sin(np.linspace(0, np.pi, 100)) ** 2, count)
    features = np.stack([away, np.repeat(np.arange(count) % 2, 100)], axis=1).astype(np.float32)
    known = (away < 0.02) & (features[:, 1] == 0)
    gaps = familiar(features, last_frames([100] * count), known, np.zeros(len(away), dtype=bool), 30.0).gaps
    near = (features[:, 1] == 0) & (away < 0.17)
    assert (gaps[known] == 0).all()
    assert gaps[near & ~known] == pytest.approx(away[near & ~known] - away[known].max(), abs=0.02)
    assert gaps[(features[:, 1] == 1) | (away > 0.25)].min() >= 0.2


def test_transitions_from_standing_to_the_ground_are_no_faster_than_free_fall():
    motion = walk(3.0)
    low = replace(motion, translation=motion.translation * [1.0, -0.3, 1.0])
    near = replace(motion, translation=motion.translation * [1.0, 0.9, 1.0])
    examples = [example(one, name) for one, name in ((motion, "high"), (low, "low"), (near, "near"))]
    count = len(motion)
    source, target = np.array([40, 40, count + 40]), np.array([count + 40, 2 * count + 40, 40])
    graph = make_graph(last_frames([count] * 3), source, target, np.zeros(3), 3)
    # 1.2 m down in a blend of 0.8 s is a fall, 0.09 m is not; what is thrown up so high does not stop so soon
    assert falls_freely(examples, graph).tolist() == [False, True, False]


def test_falls_at_seams_are_those_of_blended_heights():
    rng, motion = np.random.default_rng(0), walk(3.0)
    count = len(motion)
    rises = [1.5 * np.cumsum(rng.normal(0.0, 0.02, count)) for _ in range(3)]
    motions = [replace(motion, translation=motion.translation + rise[:, None] * [0.0, 1.0, 0.0]) for rise in rises]
    source, target = rng.integers(0, count - 1, 400) + count * rng.integers(0, 3, 400), rng.integers(0, 3 * count, 400)
    graph = make_graph(last_frames([count] * 3), source, target, np.zeros(400), 1)
    found = falls_freely([example(one, str(i)) for i, one in enumerate(motions)], graph)
    heights = np.stack([centre_height(one) for one in motions])
    source = np.repeat(np.arange(len(graph)), np.diff(graph.starts))
    for a, b, slow in zip(source + 1, graph.target, found, strict=True):
        (one, left), (other, entered) = divmod(a, count), divmod(b, count)
        assert slow == (blended_fall(heights[one], heights[other], left, entered, 30.0) >= -1e-9)
    assert 0 < found.sum() < len(found)


def blended_fall(one: np.ndarray, other: np.ndarray, left: int, entered: int, fps: float) -> float:
    """How much slower heights fall, blended from one recording to another, than is allowed at the least."""
    away, step = np.arange(-16, 17), 4  # 0.4 s of the blend and 0.135 s
    place, change = quintic_decay(np.minimum(np.abs(away) / (0.4 * fps), 1.0))
    gap, rate = other[entered] - one[left], np.gradient(other)[entered] * fps - np.gradient(one)[left] * fps
    before, after = (
        np.array([values[at + k] if 0 <= at + k < len(values) else np.nan for k in away])
        for values, at in ((one, left), (other, entered))
    )
    blended = np.where(away < 0, before + gap / 2 * place, after - gap / 2 * place) - rate / 2 * 0.4 * change
    parts = [(accelerated(one, fps), left + away[:17]), (accelerated(other, fps), entered + away[16:])]
    recorded = [values[at[(at >= 0) & (at < len(values))]] for values, at in parts]
    fastest = np.fmin.reduce(np.concatenate([*recorded, [0.0]]))
    least = np.fmin.reduce((blended[2 * step :] - 2 * blended[step:-step] + blended[: -2 * step]) * (fps / step) ** 2)
    return 0.0 if np.isnan(least) else float(least - min(-FREE * GRAVITY, ALLOWANCE * fastest))
