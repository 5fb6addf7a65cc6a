"""Causal joining, the causal foot lock and the player: against arrays, closed forms and walks that slide."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import joint_positions, role_positions
from kinetograph.motion import Motion, place, resample, sample
from kinetograph.post import FootLock, Inertialisation, LockSettings, Player, Pose, Repertoire, moving
from kinetograph.post import _leg_kernels as legs
from kinetograph.post.footskate import within_reach
from kinetograph.post.inverse_kinematics import reach
from kinetograph.sampling import spline, spline_weights
from kinetograph.segmentation import detect_contacts
from walkers import stick_figure, walk

FPS = 60.0


def _motion(poses: list[Pose]) -> Motion:
    skeleton = stick_figure()
    return Motion(skeleton, np.stack([p.translation for p in poses]), np.stack([p.rotations for p in poses]), FPS)


def _repertoire(*motions: Motion) -> Repertoire:
    return Repertoire.of(motions, [detect_contacts(m) for m in motions])


def _row(motion: Motion, frame: int) -> FloatArray:
    return np.concatenate([motion.translation[frame], motion.rotations[frame].ravel()])


# ---- joining ----


def test_an_offset_decays_as_a_damped_spring_and_steps_add_up() -> None:
    rng = np.random.default_rng(0)
    still = np.zeros(3), np.zeros((2, 3))
    old = moving(Pose(rng.normal(size=3), rot.exp(rng.normal(size=(2, 3)))), rng.normal(size=3), np.zeros((2, 3)))
    new = moving(Pose(np.zeros(3), rot.identity(2)), *still)
    one, many = Inertialisation(2, 0.15), Inertialisation(2, 0.15)
    for joining in (one, many):
        joining.jump(old, new)
    y = 2 * np.log(2) / 0.15
    start = np.concatenate([one.offset[:3], old.rates[:3]])
    exact = solve_ivp(
        lambda _, s: np.concatenate([s[3:], -2 * y * s[3:] - y**2 * s[:3]]), (0, 0.31), start, rtol=1e-10, atol=1e-12
    )
    one.step(0.31)
    for dt in (0.2, 0.01, 0.1):
        many.step(dt)
    assert np.allclose(one.offset[:3], exact.y[:3, -1], atol=1e-8)
    assert np.allclose(one.offset, many.offset, atol=1e-12)


def test_what_is_shown_goes_on_through_a_jump_with_its_velocity() -> None:
    a, b = walk(4.0, speed=1.2), walk(4.0, speed=0.6, turn_rate=0.5)
    player = Player(_repertoire(a, b), lock=None)
    player.jump(0, 1.0, rot.identity(), np.zeros(3))
    dt = 1e-4
    before = [player.step(dt) for _ in range(3)]
    player.jump(1, 2.3, rot.about("y", 2.5), np.array([0.4, 0.0, 1.0]))
    poses = before + [player.step(dt) for _ in range(3)]
    rotations, places = np.stack([p.rotations for p in poses]), np.stack([p.translation for p in poses])
    turns = rot.log(rot.multiply(rotations[1:], rot.conjugate(rotations[:-1]))) / dt
    assert np.abs(np.diff(np.diff(places, axis=0) / dt, axis=0)).max() < 0.1
    assert np.abs(np.diff(turns, axis=0)).max() < 0.3  # the two walks' legs differ by some radians per second
    for _ in range(round(2.0 / dt / 100)):
        player.step(100 * dt)
    assert np.allclose(player.step(dt).translation, player.played().pose.translation, atol=1e-4)


def test_the_player_samples_as_motions_are_sampled_and_places_them() -> None:
    motion = walk(3.0, speed=1.1, turn_rate=0.4)
    player = Player(_repertoire(motion), lock=None)
    angle, shift = 0.7, np.array([1.0, 0.0, -2.0])
    player.jump(0, 0.5, rot.about("y", angle), shift)
    made = _motion([player.step(1 / FPS, 1.1) for _ in range(80)])
    expected = place(sample(motion, 0.5 + 1.1 * np.arange(1, 81) / FPS, FPS), angle, shift)
    assert np.allclose(joint_positions(made), joint_positions(expected), atol=1e-9)


@pytest.mark.parametrize("frames", [1, 2, 3, 50])
def test_spline_weights_give_the_spline(frames: int) -> None:
    values = np.random.default_rng(1).normal(size=(frames, 2))
    rows = spline_weights(values)
    at = np.linspace(0, frames - 1, 7)
    first = np.minimum(at.astype(int), max(frames - 2, 0))
    u = (at - first)[:, None]
    basis = ((1 - u) ** 3, 4 - 6 * u**2 + 3 * u**3, 1 + 3 * u + 3 * u**2 - 3 * u**3, u**3)
    got = sum(b * rows[np.minimum(first + k, len(rows) - 1)] for k, b in enumerate(basis)) / 6
    if frames == 2:
        assert np.allclose(got[[0, -1]], values)
    else:
        assert np.allclose(got, spline(values, at), atol=1e-9)


def test_the_player_refuses_what_cannot_be_played() -> None:
    player = Player(_repertoire(walk(1.0)))
    with pytest.raises(RequestError, match="jump to a recording first"):
        player.step(0.01)
    with pytest.raises(RequestError, match="recording 3 is not among 0 to 0"):
        player.jump(3, 0.0, rot.identity(), np.zeros(3))
    player.jump(0, 0.0, rot.identity(), np.zeros(3))
    for dt, rate in ((0.0, 1.0), (np.nan, 1.0), (0.01, -1.0)):
        with pytest.raises(RequestError, match="positive and finite"):
            player.step(dt, rate)


# ---- the lock ----


def test_one_leg_bends_as_arrays_of_legs_do() -> None:
    rng = np.random.default_rng(2)
    hip, hinge = rng.normal(size=(200, 3)), rng.normal(size=(200, 3)) * 0.1 + [0.2, 0, 0]
    knee = hip + [0, -0.45, 0] + 0.05 * rng.normal(size=(200, 3))
    ankle = knee + [0, -0.44, 0] + 0.05 * rng.normal(size=(200, 3))
    offset = 0.1 * rng.normal(size=(200, 3))
    upper, lower = reach(hip, knee, ankle, ankle + offset, hinge, steady=True)
    furthest = 0.99 * np.linalg.norm(knee - hip, axis=1) + np.linalg.norm(ankle - knee, axis=1)
    gentle = within_reach(hip, furthest, ankle, offset)
    for i in range(200):
        by_upper, by_lower = legs.bend_limb(hip[i], knee[i], ankle[i], ankle[i] + offset[i], hinge[i])
        assert np.allclose(rot.angle_between(by_upper, upper[i]), 0, atol=1e-6)
        assert np.allclose(rot.angle_between(by_lower, lower[i]), 0, atol=1e-6)
        assert np.allclose(legs.gentle_share(hip[i], furthest[i], ankle[i], offset[i]) * offset[i], gentle[i])


def _locked(motion: Motion, settings: LockSettings, masks: FloatArray) -> Motion:
    lock = FootLock(motion.skeleton, settings)
    rows = [lock.step(_row(motion, i), masks[i], 1 / motion.fps) for i in range(len(motion))]
    return _motion([Pose(row[:3], row[3:].reshape(-1, 4)) for row in rows])


def _sliding() -> tuple[Motion, FloatArray]:
    """A walk whose root glides on by 0.15 m/s more than its feet step, and its planted ankles and toes."""
    motion = resample(walk(6.0, speed=1.0), FPS)
    drift = np.outer(np.arange(len(motion)) / FPS * 0.15, [0.0, 0.0, 1.0])
    phase = np.arange(len(motion)) / FPS % 1.0
    left, right = (phase > 0.02) & (phase < 0.57), (phase > 0.52) | (phase < 0.07)
    masks = np.stack([left, left, right, right], axis=1)
    return Motion(motion.skeleton, motion.translation + drift, motion.rotations, FPS), masks


def _speeds(motion: Motion, masks: FloatArray) -> FloatArray:
    feet = role_positions(motion, ("left_foot", "right_foot"))
    speed = np.linalg.norm(np.diff(feet, axis=0)[..., [0, 2]], axis=-1) * FPS
    return np.asarray(speed[masks[1:, [0, 2]] & masks[:-1, [0, 2]]])


def test_a_known_slide_is_cancelled_from_first_contact() -> None:
    motion, masks = _sliding()
    settings = LockSettings(grip=1e-6)
    assert np.abs(_speeds(motion, masks) - 0.15).max() < 0.06  # it slides by what was put in
    held = _locked(motion, settings, masks)
    assert np.quantile(_speeds(held, masks), 0.9) < 0.02  # what is left, where a leg gets straight
    feet, before = (role_positions(m, ("left_foot", "right_foot")) for m in (held, motion))
    moved = np.diff(feet - before, axis=0)[~(masks[1:, [0, 2]] & masks[:-1, [0, 2]])]
    assert np.linalg.norm(moved, axis=1).max() * FPS < 1.5  # let go without a jump
    assert np.abs(feet[..., 1] - before[..., 1]).max() < 0.01  # heights are kept


def test_the_correction_changes_no_faster_than_allowed_and_goes_no_further() -> None:
    motion, masks = _sliding()
    fast = Motion(motion.skeleton, motion.translation + 30 * np.outer(np.arange(len(motion)) / FPS, [0, 0, 0.1]),
                  motion.rotations, FPS)  # fmt: skip
    lock = FootLock(fast.skeleton, LockSettings(fastest=0.5, furthest=0.1))
    corrections = []
    for i in range(len(fast)):
        lock.step(_row(fast, i), masks[i], 1 / FPS)
        corrections.append(lock.corrections)
    steps = np.linalg.norm(np.diff(corrections, axis=0), axis=-1) * FPS
    assert np.linalg.norm(corrections, axis=-1).max() < 0.1 + 1e-9
    held = masks[1:, [0, 2]] & masks[:-1, [0, 2]]
    assert steps[held].max() < 0.5 + 1e-6


def test_a_walk_that_does_not_slide_is_left_as_it_is() -> None:
    motion = resample(walk(4.0, fps=120.0, speed=1.0), FPS)
    masks = np.zeros((len(motion), 4), dtype=np.bool_)
    held = _locked(motion, LockSettings(), masks)
    assert np.allclose(joint_positions(held), joint_positions(motion), atol=1e-9)


def test_a_body_without_legs_is_left_alone() -> None:
    from kinetograph.skeleton import Skeleton

    stick = Skeleton(("root",), np.array([-1]), np.zeros((1, 3)))
    row = np.array([0.0, 1, 0, 1, 0, 0, 0])
    assert FootLock(stick).roles == ()
    assert np.array_equal(FootLock(stick).step(row, np.zeros(0, dtype=np.bool_), 0.01), row)
