"""Torsos in one another: a known overlap is measured, and bodies that walk into one another come apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinetograph.errors import RequestError
from kinetograph.motion import Motion
from kinetograph.post.torsos import Torso, TorsoSettings, keep_apart, nearest_between, overlaps, torso_of
from walkers import walk


def _rods(x: float, radius: float) -> Torso:
    """Three capsules that lie in one another, upright at ``x``, over one frame."""
    low = np.tile([x, 1.0, 0.0], (1, 3, 1))
    return Torso(low, low + np.array([0.0, 0.5, 0.0]), np.full(3, radius))


def _placed(motion: Motion, x: float, z: float) -> Motion:
    return replace(motion, translation=motion.translation + np.array([x, 0.0, z]))


def test_two_upright_torsos_overlap_by_what_they_should() -> None:
    own, other = _rods(0.0, 0.15), _rods(0.2, 0.1)
    assert overlaps(own, other) == pytest.approx([0.05])
    assert overlaps(own, _rods(0.4, 0.1)) == pytest.approx([-0.15])
    assert overlaps(own.moved(np.array([[-0.05, 0.0, 0.0]])), other) == pytest.approx([0.0])


_POINT = st.tuples(*[st.floats(-1, 1)] * 3)


@given(_POINT, _POINT, _POINT, _POINT)
def test_the_shortest_way_between_segments_is_that_of_brute_force(
    first: tuple[float, ...], second: tuple[float, ...], third: tuple[float, ...], fourth: tuple[float, ...]
) -> None:
    a, b, c, d = map(np.array, (first, second, third, fourth))
    share = np.linspace(0.0, 1.0, 41)[:, None]
    mine, theirs = a + share * (b - a), c + share * (d - c)
    brute = np.linalg.norm(mine[:, None] - theirs[None], axis=-1).min()
    found = np.linalg.norm(nearest_between(a, b, c, d))
    spacing = (np.linalg.norm(b - a) + np.linalg.norm(d - c)) / 80
    assert brute - spacing - 1e-6 <= found <= brute + 1e-6


def test_a_body_in_another_is_moved_out_of_it() -> None:
    own, other = walk(3.0), _placed(walk(3.0), 0.03, 0.02)
    apart = keep_apart(own, other, TorsoSettings(deepest=0.02))
    assert overlaps(torso_of(own), torso_of(other)).min() > 0.08
    assert overlaps(torso_of(apart), torso_of(other)).max() <= 0.02 + 1e-3
    np.testing.assert_array_equal(apart.rotations, own.rotations)
    np.testing.assert_array_equal(apart.translation[:, 1], own.translation[:, 1])


def test_a_body_that_walks_through_another_goes_round_it_and_slowly() -> None:
    own = walk(6.0)
    still = replace(own, translation=np.tile(own.translation[90] + np.array([0.1, 0.0, 0.0]), (len(own), 1)))
    apart = keep_apart(own, still, TorsoSettings(deepest=0.0, calm=0.5))
    shift = apart.translation - own.translation
    before = overlaps(torso_of(own), torso_of(still))
    assert before.max() > 0.08
    assert overlaps(torso_of(apart), torso_of(still)).max() <= 0.01
    met = np.flatnonzero(before > 0)
    assert met[0] > 60
    assert np.abs(shift[: met[0] - 45]).max() < 1e-9
    assert np.linalg.norm(np.diff(shift, axis=0), axis=1).max() * own.fps < 1.1


def test_bodies_that_are_apart_stay_as_they_are() -> None:
    own = walk(2.0)
    assert keep_apart(own, _placed(own, 2.0, 0.0)) is own


def test_settings_that_make_no_sense() -> None:
    with pytest.raises(RequestError, match=r"calm above 0, found 0\.04 and 0"):
        TorsoSettings(calm=0.0)
