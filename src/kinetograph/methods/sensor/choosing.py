"""What is best for takes that the library does not have: learnt inside the library, on people and takes left out.

Which is better, regression, recorded movement or the mean pose, depends on the library and on how near to it a frame
is: regression goes between its people, a library of one walk has nothing to go between, and where the library has
nearly the same movement there is nothing better than that. Parts of the library are therefore estimated from the
others, and the shares of the estimates are learnt that have the least error. People are left out where there are
several, who are far from the others, and takes of everybody, which are near to other takes of the same person.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from kinetograph.arrays import FloatArray
from kinetograph.learn import Gate, Prior, fit_gate, learn_strengths
from kinetograph.methods.sensor.estimators import Estimate
from kinetograph.methods.sensor.examples import Examples, examples_of
from kinetograph.methods.sensor.expected import ExpectedErrors, expected_errors
from kinetograph.methods.sensor.fitted import Averages
from kinetograph.methods.sensor.guided import GuidedPaths, Regressed, Regression, gate_features
from kinetograph.methods.sensor.nearest import NearestExamples
from kinetograph.methods.sensor.ridge import Blend
from kinetograph.progress import Progress

USUAL = np.array([0.25, 0.6, 0.1, 0.05])
"""Shares of paths, regression, nearest examples and mean pose towards which those learnt from few people are drawn."""
OF_FEW = np.array([0.45, 0.1, 0.45, 0.0])
"""Those of a few takes of one person, where nothing is learnt: there is little to regress on."""
HABIT = 0.02
"""How strongly, over the square of the number of people: six are enough to learn from."""
FOLDS = 4
"""Parts into which people, takes or parts of takes are put, at most; each is estimated from the others."""
FRAMES, SHORTEST = 1000, 40
"""Frames that are estimated in all with people left out, and with takes, and of a take at least."""
LOOKED_AT = 60_000
"""Frames of the library that this looks at; of more, takes are picked evenly."""
SMOOTHED = 8
"""Frames over which estimates are averaged before they are compared, as results are."""
ENOUGH = 9
"""Takes below which nothing is learnt about the mean pose: a few cases say little about another wearer."""
CLEARLY = 0.995
"""Share of the error with guidance that one without must be below."""


@dataclass(frozen=True, eq=False)
class Trial:
    """Fresh estimators of some of the examples.

    Parameters
    ----------
    regression : Regression
    guided, alone : GuidedPaths
        That the regression guides, and not.
    nearest : NearestExamples
    """

    regression: Regression
    guided: GuidedPaths
    alone: GuidedPaths
    nearest: NearestExamples


Fresh = Callable[[], Trial]


@dataclass(frozen=True, eq=False)
class _Case:
    """What is made of a take that was left out: errors of estimates, and what their shares depend on.

    Parameters
    ----------
    person : str
        Who was left out, empty where a take was.
    guided, alone : ndarray, shape (F, 4, D)
        Errors of paths, with guidance and without, of regression, of nearest examples and of the mean pose.
    features : ndarray, shape (F, 2)
    distances : ndarray, shape (F,)
        Of windows, in widths of the regression's kernel.
    truth : ndarray, shape (F, D)
        Pose vectors.
    """

    person: str
    guided: FloatArray
    alone: FloatArray
    features: FloatArray
    distances: FloatArray
    truth: FloatArray


def choose_blend(
    examples: Examples,
    averages: Averages,
    paths: Callable[[Examples], Fresh],
    cautious: bool = True,
    progress: Progress | None = None,
) -> Blend:
    """The blend of estimates that has the least error on parts of the library that are left out.

    Parameters
    ----------
    examples : Examples
    averages : Averages
        Of the examples: the mean pose is that of all, as a part's would be poorer.
    paths : callable
        Gets examples, and gives what makes fresh estimators of them.
    cautious : bool
        Whether there may be something of the mean pose in it.
    progress : Progress, optional
        Called with the takes estimated and their number.

    Returns
    -------
    Blend
    """
    people = len(set(examples.people))
    if len(examples.takes) < ENOUGH and people in (1, len(examples.takes)):
        if progress:
            progress(1, 1)
        return Blend(Gate.constant(OF_FEW, 2), guided=False)
    some = _fewer(examples)
    cases = list(_all_cases(some, averages.pose, paths, progress))
    cautious = cautious and len(examples.takes) >= ENOUGH
    guided, alone = (_learnt(cases, way, cautious) for way in ("guided", "alone"))
    is_guided = alone[1] >= CLEARLY * guided[1]
    blend = Blend((guided if is_guided else alone)[0], is_guided)
    if not cautious:
        return blend
    doubts = _doubts(some, cases)
    return replace(blend, strengths=_strengths(some, cases, blend, doubts), doubts=doubts)


def _learnt(cases: Sequence[_Case], way: str, cautious: bool) -> tuple[Gate, float]:
    """The gate of the least error, and the error, in the mean over cases, as a share of that of even shares."""
    used = 4 if cautious else 3
    products, weights = [], []
    for case in cases:
        errors = getattr(case, way)[:, :used]
        products.append(np.einsum("fkd,fld->fkl", errors, errors))
        even = float((errors.mean(axis=1) ** 2).sum(axis=1).mean())
        weights.append(np.full(len(errors), 1.0 / (max(even, 1e-12) * len(errors) * len(cases))))
    features, every = np.concatenate([case.features for case in cases]), np.concatenate(weights)
    people = len({case.person for case in cases if case.person})
    prior = Prior(USUAL[:used] / USUAL[:used].sum(), HABIT / people**2 if people else 0.0)
    gate, error = fit_gate(features, np.concatenate(products), every / every.sum(), prior)
    return (gate if cautious else gate.widened()), error * float(every.sum())


def _doubts(examples: Examples, cases: Sequence[_Case]) -> ExpectedErrors:
    """The errors of regression by distance, of people and takes alike."""
    distances = np.concatenate([case.distances for case in cases])
    truth = np.concatenate([case.truth for case in cases])
    regressed = truth + np.concatenate([case.guided[:, 1] for case in cases])
    return expected_errors(examples.space, distances, truth, regressed)


def _strengths(examples: Examples, cases: Sequence[_Case], blend: Blend, expected: ExpectedErrors) -> FloatArray:
    """Each joint's strength of shrinkage towards the mean pose, by the error of a person or of all takes."""
    away, wanted, doubts, numbers = [], [], [], []
    known = {person: i for i, person in enumerate(dict.fromkeys(case.person for case in cases))}
    for case in cases:
        errors = case.guided if blend.guided else case.alone
        own = np.einsum("fk,fkd->fd", blend.gate.shares(case.features), errors)
        away.append(own - errors[:, -1])
        wanted.append(-errors[:, -1])
        doubts.append(np.interp(case.distances, expected.distances, expected.shares) ** 2)
        numbers.append(np.full(len(own), known[case.person]))
    joints = examples.space.joint_of_component
    together = [np.concatenate(parts) for parts in (away, wanted, doubts)]
    found = learn_strengths(together[0], together[1], together[2], joints, np.concatenate(numbers))
    return np.pad(found, (0, len(examples.space.moving) - len(found)))


def _fewer(examples: Examples) -> Examples:
    """As many of the takes, evenly picked, as have few enough frames in all."""
    most = max(len(examples.takes) * LOOKED_AT // max(len(examples), 1), 2)
    if most >= len(examples.takes):
        return examples
    kept = np.zeros(len(examples.takes), dtype=np.bool_)
    kept[np.linspace(0, len(kept) - 1, most).astype(np.int64)] = True
    return examples_of(examples, kept)


def _all_cases(
    examples: Examples, mean: FloatArray, paths: Callable[[Examples], Fresh], progress: Progress | None
) -> Iterator[_Case]:
    """Cases of people who are left out, where there are several, and of takes."""
    takes = len(examples.takes)
    people = np.unique(examples.people, return_inverse=True)[1].ravel()
    count = int(people.max()) + 1
    ways = [(people * min(FOLDS, count) // count, examples.people)] if count > 1 else []
    if takes > 1 and count < takes:
        # takes of one person, who are neighbours in the library, are put into different parts
        ways.append((np.arange(takes) % min(FOLDS, takes), ("",) * takes))
    used = np.unique(np.linspace(0, takes - 1, min(takes, FRAMES // SHORTEST)).astype(np.int64))
    done = 0
    for folds, names in ways:
        for fold in np.unique(folds):
            mine = used[folds[used] == fold]
            fresh = paths(examples_of(examples, folds != fold)) if len(mine) else None
            for take in mine:
                assert fresh is not None
                yield _case(examples, mean, _middle(examples, int(take), len(used)), names[take], fresh())
                done += 1
                if progress:
                    progress(done, len(used) * len(ways))


def _middle(examples: Examples, take: int, count: int) -> slice:
    """The middle of one take, of ``count`` that are estimated."""
    frames = max(FRAMES // count, SHORTEST)
    start, stop = int(examples.starts[take]), int(examples.starts[take + 1])
    spare = max(stop - start - frames, 0) // 2
    return slice(start + spare, min(start + spare + frames, stop))


def _case(examples: Examples, mean: FloatArray, rows: slice, person: str, trial: Trial) -> _Case:
    """What is made of some rows of one take."""
    truth = examples.poses[rows].astype(np.float64)
    settled = _regressed(trial.regression, examples.readings[rows].astype(np.float64))
    near = [trial.nearest.of(one.readings, one.valid) for one in settled]
    others = np.stack(
        [
            _smoothed([one.estimate for one in settled]),
            _smoothed([one.estimate for one in near]),
            np.repeat(mean[None], len(truth), axis=0),
        ],
        axis=1,
    )
    guided, alone = (
        np.concatenate([_smoothed(_followed(paths, settled))[:, None], others], axis=1) - truth[:, None]
        for paths in (trial.guided, trial.alone)
    )
    near_by, distances = np.array([one.distance for one in near]), np.array([one.distance for one in settled])
    return _Case(person, guided, alone, gate_features(near_by, distances), distances, truth)


def _regressed(regression: Regression, readings: FloatArray) -> list[Regressed]:
    """What a regression makes of readings ``(F, C)``."""
    width = readings.shape[1]
    every, none = np.ones(width, dtype=np.bool_), np.zeros(width, dtype=np.bool_)
    made = [regression.step(row, every) for row in readings]
    made += [regression.step(np.zeros(width), none) for _ in range(regression.lag)]
    return made[regression.lag :]


def _followed(paths: GuidedPaths, settled: list[Regressed]) -> list[Estimate]:
    """What paths make of what was regressed."""
    made = [paths.step(one)[0] for one in (*settled, *settled[-1:] * paths.lag)]
    return made[paths.lag :]


def _smoothed(estimates: Sequence[Estimate]) -> FloatArray:
    """Pose vectors ``(F, D)``, smoothed as results are."""
    poses = np.array([estimate.pose for estimate in estimates])
    return np.asarray(uniform_filter1d(poses, SMOOTHED, axis=0, mode="nearest"))
