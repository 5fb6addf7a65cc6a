"""Standing still: which poses are held, where, for how long, and what is said about it."""

from __future__ import annotations

import numpy as np
import pytest

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.kinematics import on_ground, role_positions
from kinetograph.methods.performance import PerformanceControl, PerformanceModel
from kinetograph.methods.performance.standing import standing
from kinetograph.motion import Motion
from kinetograph.post.contacts import contacts_of
from kinetograph.signal import Signal
from kinetograph.synthesis import Synthesis
from kinetograph.take import Take
from walkers import walk

_FPS = 30.0


def _stop_and_go(pause: float, turn: float = 0.0, jitter: float = 0.0) -> Signal:
    """Three seconds at 1 m/s along z, a pause, and three seconds in another direction."""
    steps = np.arange(round(3 * _FPS) + 1)[:, None] / _FPS
    there = steps * [0.0, 0.0, 1.0]
    back = there[-1] + steps[1:] * [np.sin(turn), 0.0, np.cos(turn)]
    places = np.concatenate([there, np.repeat(there[-1:], round(pause * _FPS), axis=0), back])
    places = places + on_ground(jitter * np.random.default_rng(0).normal(size=places.shape))
    return Signal(places[:, None], ("path",), "m", _FPS)


def _pausing() -> Motion:
    """A walk that slows down, stands for a second, and goes on, twice."""
    times = np.arange(round(16 * _FPS) + 1) / _FPS
    return walk(16.0, speed=np.clip(1.6 * np.sin(0.25 * np.pi * times) ** 2, 0.0, 1.0))


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> PerformanceModel:
    library = kg.Library.create(tmp_path_factory.mktemp("standing") / "library")
    library.add(Take("pauses", {"body": _pausing()}))
    return PerformanceControl().fit(library)


def _held_frames(result: Synthesis, inside: float = 0.5) -> FloatArray:
    times = np.arange(len(result.motion)) / result.motion.fps
    masks = [(times >= p.start + inside) & (times <= p.stop - inside) for p in result.pieces if p.held]
    return np.flatnonzero(np.any(masks, axis=0)) if masks else np.zeros(0, dtype=np.int64)


@pytest.mark.parametrize(("pause", "jitter"), [(10.0, 0.0), (10.0, 0.004), (60.0, 0.002)])
def test_stands_still_between_two_walks(model: PerformanceModel, pause: float, jitter: float) -> None:
    path = _stop_and_go(pause, jitter=jitter)
    result = model.synthesize(path)
    held = [piece for piece in result.pieces if piece.held]
    assert len(held) == 1
    assert held[0].stop - held[0].start > pause - 2.5
    frames = _held_frames(result)
    toes = role_positions(result.motion, ("left_toe", "right_toe"))[frames]
    assert np.ptp(toes, axis=0).max() < 0.002
    root = on_ground(result.motion.translation[frames])
    assert np.linalg.norm(root - on_ground(path.values[frames, 0]), axis=-1).max() < 0.1
    assert any(f"poses are held for {held[0].stop - held[0].start:.1f} s, breathing" in w for w in result.warnings)


def test_every_frame_held_is_a_frame_of_the_recording(model: PerformanceModel) -> None:
    result = model.synthesize(_stop_and_go(12.0))
    frames = _held_frames(result)
    (piece,) = (piece for piece in result.pieces if piece.held)
    assert {result.provenance()[f] for f in frames} == {("pauses", piece.source_start)}
    recorded = model.fitted.sources[0].motion
    frame = round(piece.source_start * recorded.fps)
    np.testing.assert_allclose(result.motion.translation[frames, 1], recorded.translation[frame, 1], atol=1e-3)
    assert result.edited[frames].max() < 1e-3  # a figure without a chest does not breathe


def test_both_feet_are_down_as_long_as_a_pose_is_held(model: PerformanceModel) -> None:
    result = model.synthesize(_stop_and_go(8.0))
    (piece,) = (piece for piece in result.pieces if piece.held)
    for side in ("left", "right"):
        notes = [note for note in contacts_of(result.annotations) if note.label.startswith(side)]
        assert any(note.start <= piece.start + 1e-6 and note.stop >= piece.stop - 1e-6 for note in notes)


def test_somebody_who_only_stands(model: PerformanceModel) -> None:
    result = model.synthesize(Signal(np.zeros((300, 1, 3)), ("path",), "m", _FPS))
    assert all(piece.held for piece in result.pieces)
    assert np.abs(rot.heading(result.motion.rotations[:, 0])).max() < np.deg2rad(15.0)  # along z, as the hips were
    toes = role_positions(result.motion, ("left_toe", "right_toe"))
    assert np.ptp(toes, axis=0).max() < 0.002


def test_turns_before_it_goes_on(model: PerformanceModel) -> None:
    result = model.synthesize(_stop_and_go(8.0, turn=np.pi / 2))
    heading = np.rad2deg(np.unwrap(rot.heading(result.motion.rotations[:, 0])))
    assert np.ptp(heading[_held_frames(result)]) < 0.5
    assert heading[-1] == pytest.approx(90.0, abs=25.0)


def test_short_pauses_are_those_of_the_recordings(model: PerformanceModel) -> None:
    assert not any(piece.held for piece in model.synthesize(_stop_and_go(1.5)).pieces)


def test_stands_where_neither_point_moves_for_long() -> None:
    rate = 10.0
    x = np.zeros((100, 2, 3))
    x[:, 0, 0], x[:, 1, 0] = 0.15, -0.15
    x[:30, :, 2] = -0.1 * np.arange(30, 0, -1)[:, None]  # comes at 1 m/s
    stands = standing(x, rate)
    assert not stands[:30].any()
    assert stands[37:].all()
    x[60:, 0, 2], x[60:, 1, 2] = 0.02 * np.arange(40), -0.02 * np.arange(40)  # then turns on the spot
    stands = standing(x, rate)
    assert stands[37:53].all()
    assert not stands[62:].any()
    assert not standing(x[45:75], rate).any()  # 1.5 s only


def test_a_control_that_arrives_stands_too(model: PerformanceModel) -> None:
    path = _stop_and_go(10.0)
    live = model.start(_FPS)
    points = model.method.control_points.points(path)
    for frame in points:
        live.step(frame)
    result = live.finish()
    held = sum(piece.stop - piece.start for piece in result.pieces if piece.held)
    assert held > 5.0
