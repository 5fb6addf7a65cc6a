"""Configuration of local models: the reduction of poses, and the choice of a cluster for readings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.learn import Classes, Gaussian, Lle, Pca, classes_of, fit_lle, fit_pca


@dataclass(frozen=True)
class PcaReduction:
    """Principal components of pose vectors (section 5.1).

    Parameters
    ----------
    keep : float or int
        Share of the variance to keep, below 1, or number of coordinates.
    """

    keep: float | int = 0.99

    def __post_init__(self) -> None:
        require_positive(self, "keep")

    def fit(self, poses: FloatArray) -> Pca:
        """The reduction of pose vectors ``(N, D)``."""
        return fit_pca(poses, self.keep)


@dataclass(frozen=True)
class LleReduction:
    """Locally linear embedding of pose vectors (section 5.1.4).

    Parameters
    ----------
    keep : float or int
        Share of the variance, below 1: there are as many coordinates as principal components that keep it; or the
        number of coordinates.
    most : int
        Number of coordinates at most.
    neighbours : tuple of int
        Numbers of neighbours to try.
    regularisation : tuple of float
        Regularisations to try.
    """

    keep: float | int = 0.99
    most: int = 12
    neighbours: tuple[int, ...] = (8, 12, 20)
    regularisation: tuple[float, ...] = (1e-4, 1e-3, 1e-2)

    def __post_init__(self) -> None:
        require_positive(self, "keep", "most")
        if not self.neighbours or not self.regularisation:
            raise RequestError("an embedding needs numbers of neighbours and regularisations to try, found none")

    def fit(self, poses: FloatArray) -> Lle:
        """The reduction of pose vectors ``(N, D)``."""
        dimensions = min(fit_pca(poses, self.keep).dimensions, self.most)
        return fit_lle(poses, dimensions, self.neighbours, self.regularisation)


@dataclass(frozen=True)
class ByDensity:
    """Choose the cluster whose Gaussian of readings, times its share of the frames, is the densest."""

    def classes(self, clusters: Sequence[Gaussian], shares: FloatArray) -> Classes:
        """The classes among which readings are sorted; ``shares`` has shape ``(K,)``."""
        return classes_of(clusters, shares)


@dataclass(frozen=True)
class ByMean:
    """Choose the cluster whose mean of readings is the nearest, as in the thesis."""

    def classes(self, clusters: Sequence[Gaussian], shares: FloatArray) -> Classes:
        """The classes among which readings are sorted; ``shares``, shape ``(K,)``, do not count."""
        spheres = [Gaussian(cluster.mean, np.eye(len(cluster.mean))) for cluster in clusters]
        return classes_of(spheres, np.full(len(clusters), 1.0 / len(clusters)))


@dataclass(frozen=True)
class LocalModelSettings:
    """How local models are learnt (chapter 5).

    Parameters
    ----------
    reduction : PcaReduction or LleReduction
    choice : ByDensity or ByMean
        How the cluster for readings is chosen.
    runs : int
        Runs of the mixture's estimation; the best is kept.
    clusters : int
        Components to begin with; fewer are kept.
    frames : int
        Frames that the mixture is estimated from, evenly spaced.
    centres : int
        Centres of a cluster's radial basis functions at most.
    ridge : float
        Regularisation of their solve.

    Raises
    ------
    RequestError
        For numbers below 1, and for a reduction or a choice that is not one of these.
    """

    reduction: PcaReduction | LleReduction = field(default_factory=PcaReduction)
    choice: ByDensity | ByMean = field(default_factory=ByDensity)
    runs: int = 2
    clusters: int = 50
    frames: int = 3000
    centres: int = 150
    ridge: float = 1e-3

    def __post_init__(self) -> None:
        require_one_of(self, "reduction", PcaReduction, LleReduction)
        require_one_of(self, "choice", ByDensity, ByMean)
        for name in ("runs", "clusters", "frames", "centres"):
            if getattr(self, name) < 1:
                raise RequestError(f"{name} must be 1 or more, found {getattr(self, name)}")


def require_positive(settings: object, *names: str) -> None:
    """Raise RequestError where a field is not a positive finite number."""
    for name in names:
        value = getattr(settings, name)
        if not (np.isfinite(value) and value > 0):
            raise RequestError(f"{name} must be a positive number, found {value}")


def require_one_of(settings: object, name: str, *kinds: type) -> None:
    """Raise RequestError where a field is not of one of some classes."""
    value = getattr(settings, name)
    if not isinstance(value, kinds):
        allowed = ", ".join(f"{kind.__name__}()" for kind in kinds)
        raise RequestError(f"{name} must be one of {allowed}, found {value!r}")
