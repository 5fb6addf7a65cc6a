"""Optimal alignment of examples with windows of a control, in closed form (Hsu 2004, section 4.1).

D is the weighted squared distance that is left after the best transform M of a group has been applied to the example
(4.1, 4.2). Four groups: *ground* (a turn about the vertical and a shift on the ground), *similarity* (also a scale, of
what lies on the ground: heights stay), *rigid* (any rotation and shift) and *fixed* or *none* (for controls that are
not spatial). Each scores all windows against all examples with one matrix product.

A scale of 0 would fit any example to a control that stands still, for nothing: scales are bounded. Within the bounds
the optimum has a closed form too: D is quadratic in the scale, whatever the turn.

Shapes: windows ``(B, S, P, 3)`` and examples ``(N, S, P, 3)`` in metres, S samples of P points; weights ``(S, P)``,
which carry the time step, so that D is in m^2 s. Costs come out as ``(B, N)``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import ComplexArray, FloatArray, SingleArray
from kinetograph.errors import RequestError
from kinetograph.learn import _kernels

GROUPS = ("ground", "similarity", "rigid", "fixed", "none")
SCALES = (0.5, 2.0)
"""Least and greatest scale of the similarity group where none are given."""


class Placement(Protocol):
    """The transforms M, one for each of ``(B, N)`` pairs of a window and an example."""

    def ends(self, window: int, mixed: FloatArray, sums: FloatArray, width: int) -> SingleArray:
        """Mixtures of points ``(N, P, 3)`` placed for one window and laid out flat: ``(N, width)``.

        A basis ``(P, P)`` mixes the points: ``mixed`` is its product with them, and ``sums`` ``(P,)``, the sums of its
        rows, say how much of a shift each mixture takes.
        """

    def transform(self, window: int, example: int) -> tuple[FloatArray, FloatArray]:
        """Rotation, a quaternion ``(4,)``, and shift ``(3,)`` of one pair."""

    def scale(self, window: int, example: int) -> float:
        """By what one pair's example is scaled on the ground, before it is turned and shifted."""

    def join(self, others: list[Placement]) -> Placement:
        """This placement and others of the same windows, side by side along the examples."""


@dataclass(frozen=True, eq=False)
class GroundPlacement:
    """Turns and shifts ``(B, N)`` in the complex ground plane z + i x: a point p goes to turn p + shift.

    The absolute value of a turn is a scale.
    """

    turn: ComplexArray
    shift: ComplexArray

    def ends(self, window: int, mixed: FloatArray, sums: FloatArray, width: int) -> SingleArray:
        """See `Placement`."""
        turn, shift = self.turn[window], self.shift[window]
        out = np.empty((len(mixed), width), dtype=np.float32)
        _kernels.place_on_ground(mixed, turn.real, turn.imag, shift.real, shift.imag, sums, out)
        return out

    def transform(self, window: int, example: int) -> tuple[FloatArray, FloatArray]:
        """See `Placement`."""
        turn, shift = self.turn[window, example], self.shift[window, example]
        return rot.about("y", float(np.angle(turn))), np.array([shift.imag, 0.0, shift.real])

    def scale(self, window: int, example: int) -> float:
        """See `Placement`."""
        return float(np.abs(self.turn[window, example]))

    def join(self, others: list[Placement]) -> Placement:
        """See `Placement`."""
        parts = [self, *(o for o in others if isinstance(o, GroundPlacement))]
        return GroundPlacement(
            np.concatenate([p.turn for p in parts], axis=1), np.concatenate([p.shift for p in parts], axis=1)
        )


@dataclass(frozen=True, eq=False)
class RigidPlacement:
    """Rotation matrices ``(B, N, 3, 3)`` and shifts ``(B, N, 3)``; the fixed group has identities and zeros."""

    rotation: FloatArray
    shift: FloatArray

    def ends(self, window: int, mixed: FloatArray, sums: FloatArray, width: int) -> SingleArray:
        """See `Placement`."""
        placed = mixed @ np.swapaxes(self.rotation[window], -1, -2) + sums[:, None] * self.shift[window][:, None]
        out = np.zeros((len(mixed), width), dtype=np.float32)
        out[:, : 3 * mixed.shape[1]] = placed.reshape(len(mixed), -1)
        return out

    def transform(self, window: int, example: int) -> tuple[FloatArray, FloatArray]:
        """See `Placement`."""
        return rot.from_matrix(self.rotation[window, example]), self.shift[window, example]

    def scale(self, window: int, example: int) -> float:
        """See `Placement`."""
        return 1.0

    def join(self, others: list[Placement]) -> Placement:
        """See `Placement`."""
        parts = [self, *(o for o in others if isinstance(o, RigidPlacement))]
        return RigidPlacement(
            np.concatenate([p.rotation for p in parts], axis=1), np.concatenate([p.shift for p in parts], axis=1)
        )


def align(
    group: str,
    windows: FloatArray,
    examples: FloatArray,
    weights: FloatArray,
    scales: tuple[float, float] = SCALES,
) -> tuple[FloatArray, Placement]:
    """D and the optimal transforms of every example for every window; costs ``(B, N)`` in m^2 s.

    group: one of `GROUPS`. scales: least and greatest scale, for ``"similarity"``. Raises RequestError for any other.

    >>> path = np.zeros((1, 3, 1, 3)); path[0, :, 0, 0] = [0, 1, 2]
    >>> turned = np.zeros((1, 3, 1, 3)); turned[0, :, 0, 2] = [5, 6, 7]
    >>> costs, placement = align("ground", path, turned, np.ones((3, 1)))
    >>> bool(costs[0, 0] < 1e-12)
    True
    """
    if group == "ground":
        return _align_ground(windows, examples, weights, None)
    if group == "similarity":
        return _align_ground(windows, examples, weights, scales)
    if group == "rigid":
        return _align_rigid(windows, examples, weights)
    if group in ("fixed", "none"):
        return _align_fixed(windows, examples, weights)
    raise unknown_group(group)


def unknown_group(group: str) -> RequestError:
    """The error that names the groups there are."""
    return RequestError(f"alignment must be {', '.join(GROUPS[:-1])} or {GROUPS[-1]}, found {group!r}")


def _align_ground(
    windows: FloatArray, examples: FloatArray, weights: FloatArray, scales: tuple[float, float] | None
) -> tuple[FloatArray, Placement]:
    w = weights.ravel()
    total = w.sum()
    x = (windows[..., 2] + 1j * windows[..., 0]).reshape(len(windows), -1)
    a = (examples[..., 2] + 1j * examples[..., 0]).reshape(len(examples), -1)
    x_mean, a_mean = x @ w / total, a @ w / total
    x, a = x - x_mean[:, None], a - a_mean[:, None]
    product = x @ (a.conj() * w).T
    spreads = _power(x) @ w, _power(a) @ w
    costs, turn, shift = _kernels.fit_on_ground(product, *spreads, x_mean, a_mean)
    if scales is not None:
        costs, scale = _fit_scale(np.abs(product), *spreads, scales)
        turn = scale * turn
        shift = x_mean[:, None] - turn * a_mean
    return costs + _heights(windows, examples, w), GroundPlacement(turn, shift)


def _fit_scale(
    size: FloatArray, window_spread: FloatArray, example_spread: FloatArray, scales: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Costs and scales ``(B, N)``, of turned examples whose product with the windows is ``size``, within the bounds."""
    best = np.where(example_spread > 1e-12, size / np.maximum(example_spread, 1e-12), 1.0)
    scale = np.clip(best, *scales)
    costs = window_spread[:, None] + scale * (scale * example_spread - 2.0 * size)
    return np.maximum(costs, 0.0), scale


def _power(z: ComplexArray) -> FloatArray:
    return z.real**2 + z.imag**2


def _heights(windows: FloatArray, examples: FloatArray, w: FloatArray) -> FloatArray:
    """The vertical part of D, which no transform of the ground group changes."""
    x, a = windows[..., 1].reshape(len(windows), -1), examples[..., 1].reshape(len(examples), -1)
    if not x.any() and not a.any():
        return np.zeros((1, 1))
    return np.maximum((x**2 @ w)[:, None] + a**2 @ w - 2 * x @ (a * w).T, 0.0)


def _align_fixed(windows: FloatArray, examples: FloatArray, weights: FloatArray) -> tuple[FloatArray, Placement]:
    w = np.broadcast_to(weights[..., None], windows.shape[1:]).ravel()
    x, a = windows.reshape(len(windows), -1), examples.reshape(len(examples), -1)
    costs = np.maximum((x**2 @ w)[:, None] + a**2 @ w - 2 * x @ (a * w).T, 0.0)
    shape = costs.shape
    return costs, RigidPlacement(np.broadcast_to(np.eye(3), (*shape, 3, 3)), np.zeros((*shape, 3)))


def _align_rigid(windows: FloatArray, examples: FloatArray, weights: FloatArray) -> tuple[FloatArray, Placement]:
    """Kabsch: the rotation is read off the singular vectors of the cross-covariance."""
    w = weights.ravel()
    total = w.sum()
    x, a = windows.reshape(len(windows), -1, 3), examples.reshape(len(examples), -1, 3)
    x_mean, a_mean = np.einsum("bsi,s->bi", x, w) / total, np.einsum("nsi,s->ni", a, w) / total
    x, a = x - x_mean[:, None], a - a_mean[:, None]
    batch, count = len(x), len(a)
    left = np.swapaxes(x, 1, 2).reshape(batch * 3, -1)
    right = np.swapaxes(a * w[:, None], 0, 1).reshape(len(w), count * 3)
    covariance = (left @ right).reshape(batch, 3, count, 3).swapaxes(1, 2)
    u, s, vt = np.linalg.svd(covariance)
    sign = np.sign(np.linalg.det(u) * np.linalg.det(vt))
    s[..., 2] *= sign
    u[..., 2] *= sign[..., None]
    rotation = u @ vt
    spread = np.einsum("bsi,s->b", x**2, w)[:, None] + np.einsum("nsi,s->n", a**2, w)
    costs = np.maximum(spread - 2 * s.sum(axis=-1), 0.0)
    return costs, RigidPlacement(rotation, x_mean[:, None] - np.einsum("bnij,nj->bni", rotation, a_mean))
