"""Alignment in closed form against numerical searches, other libraries and its own residual."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import naive
from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.learn.alignment import Affine, Alignment, Continued, Fixed, Ground, Rigid, Similarity
from kinetograph.learn.placement import Placement

_GROUPS = (Ground(), Similarity(), Rigid(), Fixed())
"""Affine maps are not what bodies are placed by: their residual is tested apart."""
_SEEDS = st.integers(0, 2**32 - 1)


def _random(seed: int, windows: int = 3, examples: int = 4, samples: int = 6, points: int = 2) -> list[FloatArray]:
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(windows, samples, points, 3)) + 5.0
    a = rng.normal(size=(examples, samples, points, 3)) - [2.0, 0.0, 1.0]
    return [x, a, rng.uniform(0.1, 1.0, (samples, points))]


def _moved(points: FloatArray, rotation: FloatArray, shift: FloatArray) -> FloatArray:
    return rot.rotate(rotation, points) + shift


def _placed(placement: Placement, window: int, index: int, example: FloatArray) -> FloatArray:
    scale = placement.scale(window, index)
    return _moved(example * [scale, 1.0, scale], *placement.transform(window, index))


def test_a_path_turned_by_a_right_angle() -> None:
    along_x = np.zeros((1, 3, 1, 3))
    along_x[0, :, 0, 0] = [10.0, 11.0, 12.0]
    along_z = np.zeros((1, 3, 1, 3))
    along_z[0, :, 0, 2] = [0.0, 1.0, 2.0]
    costs, placement = Ground().align(along_x, along_z, np.ones((3, 1)))
    rotation, shift = placement.transform(0, 0)
    assert costs[0, 0] == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(rotation, rot.about("y", np.pi / 2), atol=1e-12)
    np.testing.assert_allclose(shift, [10.0, 0.0, 0.0], atol=1e-12)


def test_what_no_turn_can_mend_is_the_cost() -> None:
    # two points 2 m apart against two 4 m apart: each is a metre off, and its weight is a half and a quarter
    near, far = np.zeros((2, 1, 2, 1, 3))
    near[0, :, 0, 0], far[0, :, 0, 2] = [-1.0, 1.0], [-2.0, 2.0]
    for group in (Ground(), Rigid()):
        assert group.align(near, far, np.full((2, 1), 0.5))[0][0, 0] == pytest.approx(1.0)
    assert Fixed().align(near, far, np.array([[0.5], [0.25]]))[0][0, 0] == pytest.approx(0.75 * (1 + 4))


@pytest.mark.parametrize("group", _GROUPS)
@given(seed=_SEEDS)
@settings(max_examples=20)
def test_costs_are_the_residual_of_the_transform(group: Alignment, seed: int) -> None:
    x, a, w = _random(seed)
    costs, placement = group.align(x, a, w)
    for b, n in np.ndindex(costs.shape):
        assert costs[b, n] == pytest.approx(naive.residual(x[b], _placed(placement, b, n, a[n]), w), rel=1e-9)


@pytest.mark.parametrize(
    ("group", "slow"), [(Ground(), naive.align_on_ground), (Rigid(), naive.align_rigidly), (Fixed(), naive.residual)]
)
@given(seed=_SEEDS)
@settings(max_examples=12)
def test_costs_agree_with_the_naive_twin(
    group: Alignment, slow: Callable[[FloatArray, FloatArray, FloatArray], float], seed: int
) -> None:
    x, a, w = _random(seed, windows=2, examples=2)
    costs, _ = group.align(x, a, w)
    expected = [[slow(window, example, w) for example in a] for window in x]
    np.testing.assert_allclose(costs, expected, rtol=1e-7)


@pytest.mark.parametrize("group", [Ground(), Rigid()])
@given(seed=_SEEDS, size=st.sampled_from([1e-4, 1e-2, 1.0]))
@settings(max_examples=25)
def test_no_transform_nearby_does_better(group: Alignment, seed: int, size: float) -> None:
    x, a, w = _random(seed, windows=1, examples=1)
    costs, placement = group.align(x, a, w)
    rotation, shift = placement.transform(0, 0)
    rng = np.random.default_rng(seed)
    for _ in range(10):
        angles, move = size * rng.normal(size=(2, 3))
        if group == Ground():
            angles, move = angles * [0, 1, 0], move * [1, 0, 1]
        other = _moved(a[0], rot.multiply(rot.exp(angles), rotation), shift + move)
        assert naive.residual(x[0], other, w) >= costs[0, 0] * (1 - 1e-12)


@pytest.mark.parametrize("group", [Ground(), Rigid()])
@given(seed=_SEEDS)
@settings(max_examples=25)
def test_a_known_transform_is_recovered(group: Alignment, seed: int) -> None:
    rng = np.random.default_rng(seed)
    _, a, w = _random(seed, examples=1)
    angles = rng.uniform(-3.1, 3.1) * (np.array([0.0, 1, 0]) if group == Ground() else rng.normal(size=3))
    shift = rng.normal(size=3) * ([1, 0, 1] if group == Ground() else [1, 1, 1])
    costs, placement = group.align(_moved(a, rot.exp(angles), shift), a, w)
    rotation, found = placement.transform(0, 0)
    assert costs[0, 0] == pytest.approx(0.0, abs=1e-9)
    assert rot.angle_between(rotation, rot.exp(angles)) < 1e-6
    np.testing.assert_allclose(found, shift, atol=1e-6)


@pytest.mark.parametrize("group", [Ground(), Rigid()])
@given(seed=_SEEDS)
@settings(max_examples=15)
def test_costs_do_not_depend_on_where_either_stands(group: Alignment, seed: int) -> None:
    rng = np.random.default_rng(seed)
    x, a, w = _random(seed)
    turn, shift = rot.about("y", rng.uniform(-3, 3)), rng.normal(size=3) * [1, 0, 1]
    moved, _ = group.align(_moved(x, turn, shift), _moved(a, rot.conjugate(turn), -shift), w)
    np.testing.assert_allclose(moved, group.align(x, a, w)[0], rtol=1e-8)


# ---- scales ----


@pytest.mark.parametrize("scales", [(0.5, 2.0), (0.9, 1.1), (1.0, 1.0)])
@given(seed=_SEEDS)
@settings(max_examples=4)
def test_similarity_agrees_with_the_naive_twin(scales: tuple[float, float], seed: int) -> None:
    x, a, w = _random(seed, windows=2, examples=2, samples=4)
    x[1] *= 3.0
    costs, placement = Similarity(*scales).align(x, a, w)
    for b, n in np.ndindex(costs.shape):
        assert costs[b, n] == pytest.approx(naive.align_with_scale(x[b], a[n], w, scales), rel=1e-6)
        assert scales[0] <= placement.scale(b, n) * (1 + 1e-12)
        assert placement.scale(b, n) <= scales[1] * (1 + 1e-12)


@given(seed=_SEEDS, scale=st.floats(0.5, 2.0))
@settings(max_examples=25)
def test_a_known_scale_is_recovered(seed: int, scale: float) -> None:
    rng = np.random.default_rng(seed)
    _, a, w = _random(seed, examples=1)
    turn, shift = rot.about("y", rng.uniform(-3.1, 3.1)), rng.normal(size=3) * [1, 0, 1]
    costs, placement = Similarity().align(_moved(a * [scale, 1, scale], turn, shift), a, w)
    rotation, found = placement.transform(0, 0)
    assert costs[0, 0] == pytest.approx(0.0, abs=1e-9)
    assert placement.scale(0, 0) == pytest.approx(scale)
    assert rot.angle_between(rotation, turn) < 1e-6
    np.testing.assert_allclose(found, shift, atol=1e-6)


def test_nothing_shrinks_to_a_point_to_fit_one_that_stands_still() -> None:
    walk, still = np.zeros((2, 1, 5, 1, 3))
    walk[0, :, 0, 2] = np.arange(5.0)
    costs, placement = Similarity(0.5, 2.0).align(still, walk, np.ones((5, 1)))
    assert placement.scale(0, 0) == 0.5
    assert costs[0, 0] == pytest.approx(0.25 * (4 + 1 + 0 + 1 + 4))
    # and a point has no scale
    costs, placement = Similarity(0.5, 2.0).align(walk, still, np.ones((5, 1)))
    assert placement.scale(0, 0) == 1.0
    assert costs[0, 0] == pytest.approx(4 + 1 + 0 + 1 + 4)


# ---- affine maps ----


@pytest.mark.parametrize("scales", [(0.5, 2.0), (0.8, 1.25), (0.97, 1.03)])
@pytest.mark.parametrize("seed", [1, 2])
def test_affine_agrees_with_the_naive_twin(scales: tuple[float, float], seed: int) -> None:
    x, a, w = _random(seed, windows=2, examples=1, samples=4)
    x[1] *= 3.0
    group = Affine(*scales)
    costs, _ = group.align(x, a, w)
    linear, shift = group.maps(x, a, w)
    for b, n in np.ndindex(costs.shape):
        values = np.linalg.svd(linear[b, n], compute_uv=False)
        assert scales[0] * (1 - 1e-9) <= values[1]
        assert values[0] <= scales[1] * (1 + 1e-9)
        assert np.linalg.det(linear[b, n]) > 0
        moved = a[n].copy()
        moved[..., [0, 2]] = a[n][..., [0, 2]] @ linear[b, n].T + shift[b, n]
        assert costs[b, n] == pytest.approx(naive.residual(x[b], moved, w), rel=1e-9)
        assert costs[b, n] <= naive.align_affinely(x[b], a[n], w, scales) * (1 + 1e-3)


@given(seed=_SEEDS)
@settings(max_examples=25)
def test_a_known_affine_map_is_recovered(seed: int) -> None:
    rng = np.random.default_rng(seed)
    _, a, w = _random(seed, examples=1)
    left, right = (np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]]) for t in rng.uniform(-3.1, 3.1, 2))
    values = rng.uniform(0.55, 1.9, 2)
    known, moved = left @ np.diag(values) @ right, a.copy()
    moved[..., [0, 2]] = a[..., [0, 2]] @ known.T + [1.0, -2.0]
    linear, _ = Affine().maps(moved, a, w)
    np.testing.assert_allclose(linear[0, 0], known, atol=0.02)
    costs, placement = Affine().align(moved, a, w)
    assert costs[0, 0] < 1e-4 * Ground().align(moved, a, w)[0][0, 0] + 1e-9
    assert placement.scale(0, 0) == pytest.approx(values.mean(), abs=0.02)  # of the nearest similarity
    u, _, vt = np.linalg.svd(known)
    nearest = u @ vt
    heading = rot.heading(placement.transform(0, 0)[0])
    assert np.cos(heading - np.arctan2(nearest[0, 1], nearest[0, 0])) > 0.999


def test_a_mirror_image_is_not_reached_by_reflecting() -> None:
    x, a, w = _random(5, windows=1, examples=1)
    x[0] = a[0] * [-1, 1, 1]
    linear, _ = Affine().maps(x, a, w)
    assert np.linalg.det(linear[0, 0]) >= 0.25
    assert Affine().align(x, a, w)[0][0, 0] > 0.1


def test_a_straight_line_is_mapped_by_a_similarity() -> None:
    line, aslant = np.zeros((2, 1, 5, 1, 3))
    line[0, :, 0, 2] = np.arange(5.0)
    aslant[0, :, 0, 0] = aslant[0, :, 0, 2] = np.arange(5.0)
    linear, _ = Affine().maps(aslant, line, np.ones((5, 1)))
    np.testing.assert_allclose(linear[0, 0], [[1, 1], [-1, 1]], atol=1e-6)
    still = np.zeros((1, 5, 1, 3))
    assert Affine().align(line, still, np.ones((5, 1)))[1].scale(0, 0) == 1.0


@given(seed=_SEEDS)
@settings(max_examples=10)
def test_a_larger_group_fits_no_worse(seed: int) -> None:
    x, a, w = _random(seed)
    affine, similar = Affine(0.7, 1.4).align(x, a, w)[0], Similarity(0.7, 1.4).align(x, a, w)[0]
    assert np.all(affine <= similar * (1 + 1e-6))


def test_without_room_for_scale_it_is_the_ground_group() -> None:
    x, a, w = _random(11)
    for group in (Similarity(1.0, 1.0), Affine(1.0, 1.0)):
        np.testing.assert_allclose(group.align(x, a, w)[0], Ground().align(x, a, w)[0], rtol=1e-7)


def test_none_is_another_name_for_fixed() -> None:
    x, a, w = _random(12)
    np.testing.assert_array_equal(Continued().align(x, a, w)[0], Fixed().align(x, a, w)[0])


def test_a_reflection_is_never_taken_for_a_rotation() -> None:
    rng = np.random.default_rng(1)
    x = rng.normal(size=(5, 8, 2, 3))
    costs, placement = Rigid().align(x, x * [-1.0, 1.0, 1.0], np.ones((8, 2)))
    for b in range(5):
        assert costs[b, b] > 0.1
        points = _placed(placement, b, b, x[b] * [-1.0, 1.0, 1.0])
        assert costs[b, b] == pytest.approx(naive.residual(x[b], points, np.ones((8, 2))))
        frame = _moved(np.eye(3), *placement.transform(b, b)) - _moved(np.zeros(3), *placement.transform(b, b))
        assert np.linalg.det(frame) == pytest.approx(1.0)


@pytest.mark.parametrize("group", [Ground(), Rigid()])
def test_points_without_extent_are_moved_and_not_turned(group: Alignment) -> None:
    still = np.full((1, 4, 2, 3), 3.0)
    costs, placement = group.align(still, still - [2.0, 0.0, 1.0], np.ones((4, 2)))
    rotation, shift = placement.transform(0, 0)
    assert costs[0, 0] == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(np.abs(rotation[0]), 1.0)
    np.testing.assert_allclose(shift, [2.0, 0.0, 1.0])


@pytest.mark.parametrize("group", [Ground(), Rigid()])
def test_a_walk_against_standing_still_costs_its_whole_spread(group: Alignment) -> None:
    walk, still = np.zeros((2, 1, 5, 1, 3))
    walk[0, :, 0, 2] = np.arange(5.0)
    costs, placement = group.align(walk, still, np.ones((5, 1)))
    assert costs[0, 0] == pytest.approx(4 + 1 + 0 + 1 + 4)
    np.testing.assert_allclose(_placed(placement, 0, 0, still[0]), walk[0].mean(axis=0)[None].repeat(5, 0))


def test_standing_still_keeps_its_facing() -> None:
    # two points apart give a direction even where nothing moves
    pair = np.zeros((1, 4, 2, 3))
    pair[..., 0] = [0.15, -0.15]
    turned = rot.rotate(rot.about("y", 1.0), pair)
    costs, placement = Ground().align(turned, pair, np.ones((4, 2)))
    assert costs[0, 0] == pytest.approx(0.0, abs=1e-12)
    assert rot.angle_between(placement.transform(0, 0)[0], rot.about("y", 1.0)) < 1e-9


def test_heights_cost_on_the_ground_and_do_not_move() -> None:
    x, a, w = _random(2, windows=1, examples=1)
    lifted, placement = Ground().align(x + np.array([0.0, 0.5, 0.0]), a, w)
    base, _ = Ground().align(x, a, w)
    gap = x[0, ..., 1] - a[0, ..., 1]
    assert lifted[0, 0] - base[0, 0] == pytest.approx(float(np.sum(w * (gap + 0.5) ** 2) - np.sum(w * gap**2)))
    assert placement.transform(0, 0)[1][1] == 0.0


@pytest.mark.parametrize("group", _GROUPS)
def test_ends_lie_as_far_apart_as_the_placed_points(group: Alignment) -> None:
    # whatever the layout and the mixture, the squared distance of two rows is that of the placed points, weighted
    x, a, w = _random(3, windows=2, examples=5)
    points = np.random.default_rng(4).normal(size=(5, 3, 3))
    scale = np.array([1.0, 0.5, 2.0])
    basis = np.linalg.qr(np.random.default_rng(8).normal(size=(3, 3)))[0] * scale
    _, placement = group.align(x, a, w)
    rows = [placement.ends(b, basis @ points, basis.sum(axis=1), 12) for b in (0, 1)]
    placed = [np.stack([_placed(placement, b, n, points[n]) for n in range(5)]) for b in (0, 1)]
    assert rows[0].shape == (5, 12)
    assert rows[0].dtype == np.float32
    for i, j in np.ndindex(5, 5):
        expected = np.sum(scale**2 * np.sum((placed[0][i] - placed[1][j]) ** 2, axis=-1))
        assert np.sum((rows[0][i] - rows[1][j]) ** 2) == pytest.approx(expected, rel=1e-4, abs=1e-6)


def test_ground_ends_hold_ground_coordinates_first() -> None:
    x, a, w = _random(5, windows=1, examples=1)
    points = np.random.default_rng(6).normal(size=(1, 2, 3))
    _, placement = Ground().align(x, a, w)
    (p, q) = _placed(placement, 0, 0, points[0])
    expected = [p[0], p[2], q[0], q[2], p[1], q[1], 0, 0]
    np.testing.assert_allclose(placement.ends(0, points, np.ones(2), 8)[0], expected, rtol=1e-5)


@pytest.mark.parametrize("group", _GROUPS)
def test_joined_placements_are_those_of_all_examples(group: Alignment) -> None:
    x, a, w = _random(7, examples=5)
    parts = [group.align(x, part, w)[1] for part in (a[:2], a[2:3], a[3:])]
    joined, whole = parts[0].join(parts[1:]), group.align(x, a, w)[1]
    for b, n in np.ndindex(3, 5):
        for got, expected in zip(joined.transform(b, n), whole.transform(b, n), strict=True):
            np.testing.assert_allclose(got, expected, atol=1e-12)


@pytest.mark.parametrize("group", _GROUPS)
def test_prepared_examples_are_aligned_like_others(group: Alignment) -> None:
    x, a, w = _random(9, examples=4)
    costs, whole = group.align(x, a, w)
    prepared = group.prepare(a, w)
    for b in range(len(x)):
        found, placement = prepared.align(x[b])
        np.testing.assert_allclose(found[0], costs[b], atol=1e-9)
        for n in range(4):
            for got, expected in zip(placement.transform(0, n), whole.transform(b, n), strict=True):
                np.testing.assert_allclose(got, expected, atol=1e-9)
            assert placement.scale(0, n) == pytest.approx(whole.scale(b, n))


def test_scales_that_make_no_sense() -> None:
    for least, greatest in ((0.0, 2.0), (1.5, 2.0), (0.5, 0.9), (0.5, np.inf)):
        with pytest.raises(RequestError, match=r"scales run from one in \(0, 1\] to one of 1 or more"):
            Similarity(least, greatest)
        with pytest.raises(RequestError, match=r"scales run from one in \(0, 1\] to one of 1 or more"):
            Affine(least, greatest)
