"""Where aligned examples are placed: the transforms M of Hsu 2004, section 4.1."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import ComplexArray, FloatArray, SingleArray
from kinetograph.learn import _kernels


class Placement(Protocol):
    """The transforms M, one for each of ``(B, N)`` pairs of a window and an example."""

    def ends(self, window: int, mixed: FloatArray, sums: FloatArray, width: int) -> SingleArray:
        """Mixtures of points, placed for one window and laid out flat.

        A basis ``(P, P)`` mixes the points of an example.

        Parameters
        ----------
        window : int
            Index of the window.
        mixed : ndarray, shape (N, P, 3)
            Product of the basis with every example's points.
        sums : ndarray, shape (P,)
            Sums of the basis' rows: how much of a shift each mixture takes.
        width : int
            Length of a row, 3 P or more; the rest is 0.

        Returns
        -------
        ndarray of float32, shape (N, width)
        """

    def transform(self, window: int, example: int) -> tuple[FloatArray, FloatArray]:
        """Rotation, a quaternion ``(4,)``, and shift ``(3,)`` of one pair."""

    def scale(self, window: int, example: int) -> float:
        """By what one pair's example is scaled on the ground, before it is rotated and shifted."""

    def join(self, others: list[Placement]) -> Placement:
        """This placement and others of the same windows, next to each other along the examples."""


@dataclass(frozen=True, eq=False)
class GroundPlacement:
    """Rotations about the vertical, scales and shifts on the ground.

    Parameters
    ----------
    rotation : ndarray of complex, shape (B, N)
        In the ground plane z + i x a point p goes to ``rotation * p + shift``; the absolute value is a scale.
    shift : ndarray of complex, shape (B, N)
    """

    rotation: ComplexArray
    shift: ComplexArray

    def ends(self, window: int, mixed: FloatArray, sums: FloatArray, width: int) -> SingleArray:
        """See `Placement.ends`."""
        rotation, shift = self.rotation[window], self.shift[window]
        out = np.empty((len(mixed), width), dtype=np.float32)
        _kernels.place_on_ground(mixed, rotation.real, rotation.imag, shift.real, shift.imag, sums, out)
        return out

    def transform(self, window: int, example: int) -> tuple[FloatArray, FloatArray]:
        """See `Placement.transform`."""
        rotation, shift = self.rotation[window, example], self.shift[window, example]
        return rot.about("y", float(np.angle(rotation))), np.array([shift.imag, 0.0, shift.real])

    def scale(self, window: int, example: int) -> float:
        """See `Placement.scale`."""
        return float(np.abs(self.rotation[window, example]))

    def join(self, others: list[Placement]) -> Placement:
        """See `Placement.join`."""
        parts = [self, *(o for o in others if isinstance(o, GroundPlacement))]
        return GroundPlacement(
            np.concatenate([p.rotation for p in parts], axis=1), np.concatenate([p.shift for p in parts], axis=1)
        )


@dataclass(frozen=True, eq=False)
class RigidPlacement:
    """Rotations and shifts in space; those of examples that are not moved are identities and zeros.

    Parameters
    ----------
    rotation : ndarray, shape (B, N, 3, 3)
    shift : ndarray, shape (B, N, 3)
    """

    rotation: FloatArray
    shift: FloatArray

    def ends(self, window: int, mixed: FloatArray, sums: FloatArray, width: int) -> SingleArray:
        """See `Placement.ends`."""
        placed = mixed @ np.swapaxes(self.rotation[window], -1, -2) + sums[:, None] * self.shift[window][:, None]
        out = np.zeros((len(mixed), width), dtype=np.float32)
        out[:, : 3 * mixed.shape[1]] = placed.reshape(len(mixed), -1)
        return out

    def transform(self, window: int, example: int) -> tuple[FloatArray, FloatArray]:
        """See `Placement.transform`."""
        return rot.from_matrix(self.rotation[window, example]), self.shift[window, example]

    def scale(self, window: int, example: int) -> float:
        """See `Placement.scale`."""
        return 1.0

    def join(self, others: list[Placement]) -> Placement:
        """See `Placement.join`."""
        parts = [self, *(o for o in others if isinstance(o, RigidPlacement))]
        return RigidPlacement(
            np.concatenate([p.rotation for p in parts], axis=1), np.concatenate([p.shift for p in parts], axis=1)
        )
