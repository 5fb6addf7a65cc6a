"""Optimal alignment of examples with windows of a control, in closed form (Hsu 2004, section 4.1).

D is the weighted squared distance that is left after the best transform M of a group has been applied to the example
(4.1, 4.2). Each group is a class: `Ground` (a rotation about the vertical and a shift on the ground), `Similarity`
(also a scale of what lies on the ground: heights stay), `Affine` (any linear map of the ground without reflection, and
a shift), `Rigid` (any rotation and shift), `Fixed` (no transform) and `Continued` (no transform; each piece goes on
from where the one before ends). Each scores all windows against all examples with one matrix product, or two.

A scale of 0 would fit any example to a control that stands still, for nothing: scales are bounded. Within the bounds
the optimum of a similarity has a closed form too: D is quadratic in the scale, whatever the rotation.

Shapes: windows ``(B, S, P, 3)`` and examples ``(N, S, P, 3)`` in metres, S samples of P points; weights ``(S, P)``,
which carry the time step, so that D is in m^2 s. Costs come out as ``(B, N)``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from kinetograph.arrays import ComplexArray, FloatArray
from kinetograph.errors import RequestError
from kinetograph.learn import _affine_kernels, _kernels
from kinetograph.learn.ground_examples import GroundExamples
from kinetograph.learn.placement import GroundPlacement, Placement, RigidPlacement
from kinetograph.learn.products import products, products_on_plane, shifts, weighted_sums


class PreparedExamples(Protocol):
    """Examples that are aligned with one window after another."""

    def align(self, window: FloatArray) -> tuple[FloatArray, Placement]:
        """D ``(1, N)`` and the optimal transforms for a window ``(S, P, 3)``."""


class Alignment(Protocol):
    """A group of transforms."""

    @property
    def moves(self) -> bool:
        """Whether examples are moved in space; if not, what is compared need not lie in space."""

    @property
    def continues(self) -> bool:
        """Whether each piece goes on from where the one before ends, wherever its example was recorded."""

    def align(self, windows: FloatArray, examples: FloatArray, weights: FloatArray) -> tuple[FloatArray, Placement]:
        """D and the optimal transforms of every example for every window.

        Parameters
        ----------
        windows : ndarray, shape (B, S, P, 3)
            Samples of the control, metres.
        examples : ndarray, shape (N, S, P, 3)
        weights : ndarray, shape (S, P)
            Weights of the samples, seconds.

        Returns
        -------
        costs : ndarray, shape (B, N)
            D in m^2 s.
        placement : Placement
        """

    def prepare(self, examples: FloatArray, weights: FloatArray) -> PreparedExamples:
        """Examples ``(N, S, P, 3)`` with weights ``(S, P)``, made ready for one window after another."""


@dataclass(frozen=True, eq=False)
class _AsTheyAre:
    """Examples with nothing worked out beforehand."""

    group: Alignment
    examples: FloatArray
    weights: FloatArray

    def align(self, window: FloatArray) -> tuple[FloatArray, Placement]:
        """See `PreparedExamples`."""
        return self.group.align(window[None], self.examples, self.weights)


@dataclass(frozen=True)
class Ground:
    """A rotation about the vertical and a shift on the ground: the group for walks and dances (section 4.1).

    Examples
    --------
    >>> path = np.zeros((1, 3, 1, 3)); path[0, :, 0, 0] = [0, 1, 2]
    >>> turned = np.zeros((1, 3, 1, 3)); turned[0, :, 0, 2] = [5, 6, 7]
    >>> costs, placement = Ground().align(path, turned, np.ones((3, 1)))
    >>> bool(costs[0, 0] < 1e-12)
    True
    """

    moves = True
    continues = False

    def align(self, windows: FloatArray, examples: FloatArray, weights: FloatArray) -> tuple[FloatArray, Placement]:
        """See `Alignment.align`."""
        plane = _Plane.of(windows, examples, weights)
        costs, rotation, shift = _kernels.fit_on_ground(plane.product, *plane.spreads, *plane.means)
        return costs + _heights(windows, examples, weights.ravel()), GroundPlacement(rotation, shift)

    def prepare(self, examples: FloatArray, weights: FloatArray) -> PreparedExamples:
        """See `Alignment.prepare`."""
        return GroundExamples.of(examples, weights)


@dataclass(frozen=True)
class Similarity:
    """A rotation about the vertical, a scale and a shift on the ground; heights stay.

    Parameters
    ----------
    least, greatest : float
        Bounds of the scale: 0 < least <= 1 <= greatest.
    """

    least: float = 0.5
    greatest: float = 2.0

    moves = True
    continues = False

    def __post_init__(self) -> None:
        _require_scales(self.least, self.greatest)

    def align(self, windows: FloatArray, examples: FloatArray, weights: FloatArray) -> tuple[FloatArray, Placement]:
        """See `Alignment.align`."""
        plane = _Plane.of(windows, examples, weights)
        _, rotation, _ = _kernels.fit_on_ground(plane.product, *plane.spreads, *plane.means)
        costs, scale = self._fit_scale(np.abs(plane.product), *plane.spreads)
        rotation = scale * rotation
        shift = shifts(plane.means[0], rotation, plane.means[1])
        return costs + _heights(windows, examples, weights.ravel()), GroundPlacement(rotation, shift)

    def prepare(self, examples: FloatArray, weights: FloatArray) -> PreparedExamples:
        """See `Alignment.prepare`."""
        return _AsTheyAre(self, examples, weights)

    def _fit_scale(
        self, size: FloatArray, window_spread: FloatArray, example_spread: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Costs and scales ``(B, N)`` of rotated examples whose product with the windows is ``size``."""
        best = np.where(example_spread > 1e-12, size / np.maximum(example_spread, 1e-12), 1.0)
        scale = np.clip(best, self.least, self.greatest)
        costs = window_spread[:, None] + scale * (scale * example_spread - 2.0 * size)
        return np.maximum(costs, 0.0), scale


@dataclass(frozen=True)
class Affine:
    """Any linear map of the ground without reflection, and a shift on it; heights stay (chapter 7).

    The thesis calls these arbitrary homogeneous transformations in two dimensions. D is that of the affine map, which a
    thousandth of the example's spread draws to the best similarity: a straight line says nothing about the axis across
    it. A body
    cannot be sheared: what is placed, the points compared across seams as well as the character, is placed by the
    similarity nearest to the map about the middle of the example, which has its own rotation and scale; a character
    keeps its size, and its path over the ground is scaled.

    Parameters
    ----------
    least, greatest : float
        Bounds of the two singular values, the scales along the axes that the map keeps square: 0 < least <= 1 <=
        greatest.
    """

    least: float = 0.5
    greatest: float = 2.0

    moves = True
    continues = False

    def __post_init__(self) -> None:
        _require_scales(self.least, self.greatest)

    def align(self, windows: FloatArray, examples: FloatArray, weights: FloatArray) -> tuple[FloatArray, Placement]:
        """See `Alignment.align`."""
        costs, direct, _, means = self._fit(windows, examples, weights)
        shift = shifts(means[0], direct, means[1])
        return costs + _heights(windows, examples, weights.ravel()), GroundPlacement(direct, shift)

    def maps(self, windows: FloatArray, examples: FloatArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The maps themselves: a point (x, z) of an example goes to ``linear @ (x, z) + shift``.

        Parameters
        ----------
        windows : ndarray, shape (B, S, P, 3)
        examples : ndarray, shape (N, S, P, 3)
        weights : ndarray, shape (S, P)

        Returns
        -------
        linear : ndarray, shape (B, N, 2, 2)
        shift : ndarray, shape (B, N, 2)
            Metres.
        """
        _, p, q, (window_means, example_means) = self._fit(windows, examples, weights)
        shift = window_means[:, None] - p * example_means - q * example_means.conj()
        # z + i x is p (z + i x) + q (z - i x)
        rows = ((p.real - q.real, p.imag + q.imag), (q.imag - p.imag, p.real + q.real))
        linear = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
        return linear, np.stack([shift.imag, shift.real], axis=-1)

    def prepare(self, examples: FloatArray, weights: FloatArray) -> PreparedExamples:
        """See `Alignment.prepare`."""
        return _AsTheyAre(self, examples, weights)

    def _fit(
        self, windows: FloatArray, examples: FloatArray, weights: FloatArray
    ) -> tuple[FloatArray, ComplexArray, ComplexArray, tuple[ComplexArray, ComplexArray]]:
        """Costs on the ground, p and q of ``p z + q conj(z)``, all ``(B, N)``, and the means of both."""
        w = weights.ravel()
        x, a, means = _centred(windows, examples, w)
        both = products(x, a.conj() * w), products(x, a * w)
        spreads = weighted_sums(_power(x), w), weighted_sums(_power(a), w)
        fit = _affine_kernels.fit_affine(both, weighted_sums(a**2, w), spreads, (self.least, self.greatest))
        return *fit, means


@dataclass(frozen=True)
class Rigid:
    """Any rotation and shift, by Kabsch's method."""

    moves = True
    continues = False

    def align(self, windows: FloatArray, examples: FloatArray, weights: FloatArray) -> tuple[FloatArray, Placement]:
        """See `Alignment.align`. The rotation is read off the singular vectors of the cross-covariance."""
        w = weights.ravel()
        total = w.sum()
        x, a = windows.reshape(len(windows), -1, 3), examples.reshape(len(examples), -1, 3)
        x_mean, a_mean = (np.stack([weighted_sums(p[..., i], w) for i in range(3)], axis=1) / total for p in (x, a))
        x, a = x - x_mean[:, None], a - a_mean[:, None]
        u, s, vt = np.linalg.svd(_covariances(x, a, w))
        sign = np.sign(np.linalg.det(u) * np.linalg.det(vt))
        s[..., 2] *= sign
        u[..., 2] *= sign[..., None]
        rotation = u @ vt
        spread = weighted_sums((x**2).sum(axis=-1), w)[:, None] + weighted_sums((a**2).sum(axis=-1), w)
        costs = np.maximum(spread - 2 * s.sum(axis=-1), 0.0)
        return costs, RigidPlacement(rotation, x_mean[:, None] - (rotation @ a_mean[..., None])[..., 0])

    def prepare(self, examples: FloatArray, weights: FloatArray) -> PreparedExamples:
        """See `Alignment.prepare`."""
        return _AsTheyAre(self, examples, weights)


@dataclass(frozen=True)
class Fixed:
    """No transform: what is compared stays as it was recorded."""

    moves = False
    continues = False

    def align(self, windows: FloatArray, examples: FloatArray, weights: FloatArray) -> tuple[FloatArray, Placement]:
        """See `Alignment.align`."""
        w = np.broadcast_to(weights[..., None], windows.shape[1:]).ravel()
        x, a = windows.reshape(len(windows), -1), examples.reshape(len(examples), -1)
        costs = _left(x, a, w)
        shape = costs.shape
        return costs, RigidPlacement(np.broadcast_to(np.eye(3), (*shape, 3, 3)), np.zeros((*shape, 3)))

    def prepare(self, examples: FloatArray, weights: FloatArray) -> PreparedExamples:
        """See `Alignment.prepare`."""
        return _AsTheyAre(self, examples, weights)


@dataclass(frozen=True)
class Continued(Fixed):
    """No transform in D; each piece is placed where the one before ends."""

    continues = True


@dataclass(frozen=True, eq=False)
class _Plane:
    """Windows and examples in the complex ground plane z + i x, centred: products, spreads and means."""

    product: ComplexArray
    spreads: tuple[FloatArray, FloatArray]
    means: tuple[ComplexArray, ComplexArray]

    @classmethod
    def of(cls, windows: FloatArray, examples: FloatArray, weights: FloatArray) -> _Plane:
        w = weights.ravel()
        x, x_mean = _without_mean(windows, w)
        product, spread, mean = products_on_plane(x, examples.reshape(len(examples), -1, 3), w)
        return cls(product, (weighted_sums(_power(x), w), spread), (x_mean, mean))


def _centred(
    windows: FloatArray, examples: FloatArray, w: FloatArray
) -> tuple[ComplexArray, ComplexArray, tuple[ComplexArray, ComplexArray]]:
    """Windows and examples in the complex ground plane z + i x without their weighted means, and these."""
    (x, x_mean), (a, a_mean) = (_without_mean(points, w) for points in (windows, examples))
    return x, a, (x_mean, a_mean)


def _without_mean(points: FloatArray, w: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Points in the complex ground plane z + i x without their weighted mean, and that."""
    flat = (points[..., 2] + 1j * points[..., 0]).reshape(len(points), -1)
    mean = weighted_sums(flat, w) / w.sum()
    return flat - mean[:, None], mean


def _require_scales(least: float, greatest: float) -> None:
    if not 0 < least <= 1 <= greatest < np.inf:
        raise RequestError(f"scales run from one in (0, 1] to one of 1 or more, found {least} and {greatest}")


def _power(z: ComplexArray) -> FloatArray:
    return z.real**2 + z.imag**2


def _heights(windows: FloatArray, examples: FloatArray, w: FloatArray) -> FloatArray:
    """The vertical part of D, which no transform on the ground changes."""
    x, a = windows[..., 1].reshape(len(windows), -1), examples[..., 1].reshape(len(examples), -1)
    if not x.any() and not a.any():
        return np.zeros((1, 1))
    return _left(x, a, w)


def _left(x: FloatArray, a: FloatArray, w: FloatArray) -> FloatArray:
    """Weighted squared distances ``(B, N)`` of rows ``(B, K)`` and ``(N, K)``."""
    squares = weighted_sums(x**2, w)[:, None] + weighted_sums(a**2, w)
    return np.asarray(np.maximum(squares - 2 * products(x, a * w), 0.0))


def _covariances(x: FloatArray, a: FloatArray, w: FloatArray) -> FloatArray:
    """Weighted cross-covariances ``(B, N, 3, 3)`` of centred windows ``(B, S, 3)`` and examples ``(N, S, 3)``."""
    batch, count = len(x), len(a)
    left = np.swapaxes(x, 1, 2).reshape(batch * 3, -1)
    right = np.swapaxes(a * w[:, None], 1, 2).reshape(count * 3, -1)
    return np.asarray(products(left, right).reshape(batch, 3, count, 3).swapaxes(1, 2))
