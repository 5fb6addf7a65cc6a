"""What is best for takes that the library does not have: chosen inside the library, on people or takes left out.

Which is better, regression or recorded movement, depends on the library: regression goes between its people, and a
library of one walk has nothing to go between. Parts of the library are therefore estimated from the others, by paths
with and without guidance and by regression, and the blend of least error is taken. People are left out where there are
several, else takes, else parts of takes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray, IntArray
from kinetograph.learn import learn_strengths, shrinkage
from kinetograph.methods.sensor.estimators import Estimate
from kinetograph.methods.sensor.examples import Examples, examples_of
from kinetograph.methods.sensor.fitted import Averages
from kinetograph.methods.sensor.guided import GuidedPaths, Regression, between, uncertainty_of
from kinetograph.methods.sensor.ridge import Blend
from kinetograph.progress import Progress

SHARES = (0.75, 0.5, 0.25)
"""Shares of the regression that are tried where it guides; the first is taken where nothing can be left out."""
FOLDS = 4
"""Parts into which people, takes or parts of takes are put, at most; each is estimated from the others."""
FEW = 3
"""Takes of one person below which parts of them are left out."""
PARTS = 5
"""Parts of all takes together then, at least."""
FRAMES, SHORTEST = 1500, 60
"""Frames that are estimated in all, evenly shared among takes, and of a take at least."""
LOOKED_AT = 60_000
"""Frames of the library that this looks at; of more, takes are picked evenly."""
SMOOTHED = 8
"""Frames over which estimates are averaged before they are compared, as results are."""
CLEARLY = 0.995
"""Share of the error of what was tried before that an error must be below."""
WORTH = 0.96
"""Share of the error without shrinkage that the error with it must be below: libraries without somebody are poorer."""
ENOUGH = 9
"""Takes below which no shrinkage is learnt: a few cases say little about another wearer."""

Fresh = Callable[[], tuple[Regression, GuidedPaths, GuidedPaths]]
"""Makes a regression, and paths that it guides and that it does not."""


_Made = tuple[FloatArray, FloatArray]  # poses and variances, (F, D) each


@dataclass(frozen=True, eq=False)
class _Case:
    """A take that was left out: its poses, and what paths without and with guidance and regression make of it."""

    truth: FloatArray
    alone: _Made
    guided: _Made
    regressed: _Made

    def blended(self, examples: Examples, share: float, guided: bool) -> _Made:
        """Poses and variances ``(F, D)`` of a blend."""
        (first, spread), (second, more) = self.guided if guided else self.alone, self.regressed
        apart = (first - second) ** 2
        poses = between(examples.space, first, second, share)
        return poses, (1 - share) * spread + share * more + share * (1 - share) * apart


def choose_blend(
    examples: Examples,
    averages: Averages,
    paths: Callable[[Examples], Fresh],
    cautious: bool = True,
    progress: Progress | None = None,
) -> Blend:
    """The blend of paths and regression that has the least error on parts of the library that are left out.

    Parameters
    ----------
    examples : Examples
    averages : Averages
        Of the examples.
    paths : callable
        Gets examples, and gives what makes fresh paths through them.
    cautious : bool
        Whether shrinkage towards the mean pose is learnt, too.
    progress : Progress, optional
        Called with the takes estimated and their number.

    Returns
    -------
    Blend
    """
    none = np.zeros(len(examples.space.moving))
    some = _parted(_fewer(examples))
    groups = np.unique(some.people if len(set(some.people)) > 1 else some.takes, axis=0, return_inverse=True)[1].ravel()
    if groups.max() == 0:
        return Blend(SHARES[0], True, none)
    count = int(groups.max()) + 1
    folds = np.arange(count) * min(FOLDS, count) // count
    cases = _cases(some, folds[groups], paths, progress)
    share, guided = _best(some, cases)
    if not cautious or len(examples.takes) < ENOUGH:
        return Blend(share, guided, none)
    return Blend(share, guided, _strengths(some, averages, cases, share, guided))


def _fewer(examples: Examples) -> Examples:
    """As many of the takes, evenly picked, as have few enough frames in all."""
    most = max(len(examples.takes) * LOOKED_AT // max(len(examples), 1), 2)
    if most >= len(examples.takes):
        return examples
    kept = np.zeros(len(examples.takes), dtype=np.bool_)
    kept[np.linspace(0, len(kept) - 1, most).astype(np.int64)] = True
    return examples_of(examples, kept)


def _parted(examples: Examples) -> Examples:
    """Takes cut into parts where there are too few to leave some out."""
    takes = len(examples.takes)
    if takes >= FEW or len(set(examples.people)) > 1:
        return examples
    each = -(-PARTS // takes)
    edges = [
        np.linspace(a, b, each + 1)[:-1].astype(np.int64)
        for a, b in zip(examples.starts[:-1], examples.starts[1:], strict=True)
    ]
    starts = np.append(np.concatenate(edges), examples.starts[-1])
    names = tuple((f"{take}[{i}]", track) for take, track in examples.takes for i in range(each))
    captured = np.repeat(examples.captured, each)
    return replace(examples, starts=starts, takes=names, people=("one",) * len(names), captured=captured)


def _cases(
    examples: Examples, folds: IntArray, paths: Callable[[Examples], Fresh], progress: Progress | None
) -> list[_Case]:
    takes = len(folds)
    used = np.unique(np.linspace(0, takes - 1, min(takes, FRAMES // SHORTEST)).astype(np.int64))
    frames = max(FRAMES // len(used), SHORTEST)
    cases: list[_Case] = []
    for fold in np.unique(folds):
        rest = examples_of(examples, folds != fold)
        fresh = paths(rest)
        for take in used[folds[used] == fold]:
            start, stop = int(examples.starts[take]), int(examples.starts[take + 1])
            spare = max(stop - start - frames, 0) // 2
            rows = slice(start + spare, min(start + spare + frames, stop))
            readings = examples.readings[rows].astype(np.float64)
            cases.append(_Case(examples.poses[rows].astype(np.float64), *_run(fresh(), readings)))
            if progress:
                progress(len(cases), len(used))
    return cases


def _run(fresh: tuple[Regression, GuidedPaths, GuidedPaths], readings: FloatArray) -> tuple[_Made, _Made, _Made]:
    """What paths without and with guidance and regression make of readings ``(F, C)``."""
    regression, guided, alone = fresh
    width = readings.shape[1]
    every, none = np.ones(width, dtype=np.bool_), np.zeros(width, dtype=np.bool_)
    made = [regression.step(row, every) for row in readings]
    made += [regression.step(np.zeros(width), none) for _ in range(regression.lag)]
    settled = made[regression.lag :]
    followed = [[paths.step(one)[0] for one in (*settled, *settled[-1:] * paths.lag)] for paths in (alone, guided)]
    without, by_path = (estimates[len(estimates) - len(settled) :] for estimates in followed)
    return _smoothed(without), _smoothed(by_path), _smoothed([one.estimate for one in settled])


def _smoothed(estimates: Sequence[Estimate]) -> _Made:
    poses = np.array([estimate.pose for estimate in estimates])
    variances = np.array([estimate.variance for estimate in estimates])
    return uniform_filter1d(poses, SMOOTHED, axis=0, mode="nearest"), variances


def _best(examples: Examples, cases: Sequence[_Case]) -> tuple[float, bool]:
    """The share and whether there is guidance, of least mean logarithm of the error of a case."""
    space = examples.space
    real = [space.decode(case.truth)[:, space.joints] for case in cases]
    least, best = np.inf, (SHARES[0], True)
    for share, guided in (*((share, True) for share in SHARES), (0.0, False)):
        made = [space.decode(case.blended(examples, share, guided)[0])[:, space.joints] for case in cases]
        errors = [float(rot.angle_between(a, b).mean()) for a, b in zip(made, real, strict=True)]
        score = float(np.log(np.array(errors) + 1e-6).mean())
        if score < least + np.log(CLEARLY):
            least, best = score, (share, guided)
    return best


def _strengths(
    examples: Examples, averages: Averages, cases: Sequence[_Case], share: float, guided: bool
) -> FloatArray:
    """Each joint's strength of shrinkage; none unless it makes the error clearly less, case by case."""
    made = [case.blended(examples, share, guided) for case in cases]
    unsure = np.array([uncertainty_of(row, averages.variance) for _, variances in made for row in variances])
    away = np.concatenate([poses - averages.pose for poses, _ in made])
    wanted = np.concatenate([case.truth - averages.pose for case in cases])
    numbers = np.repeat(np.arange(len(cases)), [len(case.truth) for case in cases])
    joints = examples.space.joint_of_component
    found = learn_strengths(away, wanted, unsure, joints, numbers)
    shrunk = away * (1.0 - shrinkage(found[joints], unsure[:, None]))
    errors = [
        np.bincount(numbers, np.linalg.norm(own - wanted, axis=1)) / np.bincount(numbers) for own in (shrunk, away)
    ]
    if np.log(errors[0] / errors[1]).mean() > np.log(WORTH):
        found = np.zeros_like(found)
    return np.pad(found, (0, len(examples.space.moving) - len(found)))
