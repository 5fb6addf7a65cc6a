"""Hips that are off their path, and on it afterwards, with feet that stand all the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.kinematics import on_ground, role_positions
from kinetograph.motion import Motion
from kinetograph.post import OntoPath, clean_feet, hips_of, onto_path
from kinetograph.segmentation import detect_contacts
from walkers import stick_figure, walk

_FPS = 60.0


def _swaying(drift: float = 0.06, sway: float = 0.02) -> tuple[Motion, FloatArray]:
    """A walk that is carried off a straight line by a slow wave, and sways about it twice a second; and the line."""
    motion = walk(6.0, fps=_FPS)
    times = np.arange(len(motion)) / _FPS
    off = drift * np.sin(2 * np.pi * times / 6.0) + sway * np.sin(2 * np.pi * 2.0 * times)
    return replace(motion, translation=motion.translation + np.outer(off, [1.0, 0.0, 0.5])), motion.translation


def test_hips_are_on_the_path_at_every_frame_where_they_may_not_sway() -> None:
    motion, path = _swaying()
    moved = onto_path(motion, path, OntoPath(0.0))
    np.testing.assert_allclose(on_ground(hips_of(moved)), on_ground(path), atol=1e-12)
    np.testing.assert_array_equal(moved.translation[:, 1], motion.translation[:, 1])
    np.testing.assert_array_equal(moved.rotations, motion.rotations)


def test_a_drift_is_taken_away_and_a_quick_sway_stays() -> None:
    motion, path = _swaying()
    moved = onto_path(motion, path, OntoPath(0.3))
    off = on_ground(moved.translation - path)[30:-30, 0]
    times = np.arange(len(motion))[30:-30] / _FPS
    sway, drift = (2 * abs(np.mean(off * np.exp(-2j * np.pi * frequency * times))) for frequency in (2.0, 1.0 / 6.0))
    assert sway == pytest.approx(0.02, rel=0.1)
    assert drift < 0.1 * 0.06


def test_heights_of_the_path_do_not_count() -> None:
    motion, path = _swaying()
    raised = path + np.array([0.0, 1.0, 0.0])
    np.testing.assert_array_equal(onto_path(motion, raised).translation, onto_path(motion, path).translation)


def test_feet_stand_once_they_are_cleaned() -> None:
    straight = walk(6.0, fps=_FPS)
    contacts = detect_contacts(straight)
    motion, path = _swaying(drift=0.0, sway=0.0)
    bent = path + np.outer(0.03 * np.sin(2 * np.pi * np.arange(len(path)) / _FPS / 2.0), [1.0, 0.0, 0.0])
    moved = onto_path(motion, bent, OntoPath(0.0))
    stood = clean_feet(moved, contacts)
    np.testing.assert_allclose(on_ground(hips_of(stood)), on_ground(bent), atol=1e-9)
    slid, still = (_slides(each, contacts) for each in (moved, stood))
    assert np.median(still) < 0.1 * np.median(slid)


def _slides(motion: Motion, contacts: tuple) -> FloatArray:  # type: ignore[type-arg]
    toes = role_positions(motion, ("left_toe",))[:, 0]
    spans = [(round(n.start * _FPS) + 8, round(n.stop * _FPS) - 8) for n in contacts if n.label == "left_toe"]
    speeds = [np.linalg.norm(np.diff(on_ground(toes[a:b]), axis=0), axis=1) for a, b in spans if b > a + 2]
    return np.concatenate(speeds) * _FPS


def test_without_a_joint_for_the_hips_their_middle_counts() -> None:
    motion = walk(1.0)
    roles = {role: mark for role, mark in stick_figure().roles.items() if role != "hips"}
    unnamed = replace(motion, skeleton=replace(motion.skeleton, roles=roles))
    np.testing.assert_allclose(on_ground(hips_of(unnamed)), on_ground(motion.translation), atol=1e-12)


@pytest.mark.parametrize("sway", [-0.1, float("nan"), float("inf")])
def test_a_width_that_is_none_is_refused(sway: float) -> None:
    with pytest.raises(RequestError, match="0 s or more"):
        OntoPath(sway)
