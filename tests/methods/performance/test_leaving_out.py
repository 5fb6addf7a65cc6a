"""What is left of a fit without some takes is what a fit of the others gives, bit by bit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinetograph.errors import RequestError
from kinetograph.library import Facts, Library, describe_takes
from kinetograph.methods.performance import PerformanceControl, PerformanceModel, fit_without
from kinetograph.methods.performance.leaving_out import without
from kinetograph.motion import Motion
from kinetograph.take import Annotation, Take
from walkers import stick_figure, walk

METHODS = (PerformanceControl(), PerformanceControl(mirror=True, span=2, stretch=0.3), PerformanceControl(stand=False))


def _same(one: Any, other: Any, place: str) -> None:
    """Fail where two values differ in a bit, and say where."""
    assert type(one) is type(other), place
    if isinstance(one, np.ndarray):
        assert (one.dtype, one.shape, one.tobytes()) == (other.dtype, other.shape, other.tobytes()), place
    elif is_dataclass(one):
        for field in fields(one):
            if field.name != "builds":  # the numbers of skeletons may differ
                _same(getattr(one, field.name), getattr(other, field.name), f"{place}.{field.name}")
    elif isinstance(one, Mapping):
        assert list(one) == list(other), place
        for name in one:
            _same(one[name], other[name], f"{place}[{name}]")
    elif isinstance(one, tuple | list):
        assert len(one) == len(other), place
        for i, (a, b) in enumerate(zip(one, other, strict=True)):
            _same(a, b, f"{place}[{i}]")
    else:
        assert one == other, place


def _pausing(seconds: float) -> Motion:
    times = np.arange(round(seconds * 30) + 1) / 30
    return walk(seconds, speed=np.clip(1.6 * np.sin(0.25 * np.pi * times) ** 2, 0.0, 1.0))


def _still(seconds: float) -> Motion:
    motion = walk(seconds)
    return Motion(
        motion.skeleton, motion.translation[:1].repeat(len(motion), 0), motion.rotations * 0 + [1, 0, 0, 0], 30
    )


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Library:
    """Walks of two persons with and without cuts and pauses, two takes of nobody stepping, one of another build."""
    made = Library.create(tmp_path_factory.mktemp("leaving") / "library")
    cuts = tuple(Annotation("body", "cut", "", t, t) for t in np.arange(1, 10) / 2)
    made.add(Take("a/one", {"body": walk(5.0)}, cuts))
    made.add(Take("a/two", {"body": _pausing(9.0)}))
    made.add(Take("a/idle", {"body": _still(4.0)}))
    made.add(Take("b/one", {"body": walk(5.0, turn_rate=0.4)}, cuts))
    made.add(Take("b/two", {"body": _pausing(12.0)}))
    made.add(Take("b/idle", {"body": _still(3.0)}))
    tall = walk(5.0, turn_rate=-0.3)
    tall = Motion(stick_figure(1.1), 1.1 * tall.translation, tall.rotations, tall.fps)
    made.add(Take("c/tall", {"body": tall}, cuts))
    describe_takes(made, {"b/two": Facts(tags=frozenset({"dance"}))})
    return made


@pytest.mark.parametrize("method", METHODS)
def test_the_rest_of_a_fit_is_a_fit_of_the_rest(library: Library, method: PerformanceControl) -> None:
    whole = method.fit(library).fitted
    for away in (*((name,) for name in library.names()), ("a/two", "b/one"), ("a/two", "b/two", "a/idle"), ()):
        left = without(whole, away)
        assert left is not None, away
        again = method.fit(library, exclude=away).fitted
        _same(left, again, "fit")
        for derived in ("limits", "basis", "state_ends", "origins", "prices", "speeds", "fastest", "reuse"):
            _same(getattr(left, derived), getattr(again, derived), derived)


def test_a_take_may_be_left_out_of_what_is_left(library: Library) -> None:
    whole = PerformanceControl().fit(library).fitted
    once = without(whole, ("a/two",))
    assert once is not None
    _same(without(once, ("b/idle",)), without(whole, ("a/two", "b/idle")), "fit")


def test_what_is_left_makes_the_same_motion(library: Library) -> None:
    method = PerformanceControl()
    whole = method.fit(library)
    made, again = (
        model.synthesize(walk(4.0, turn_rate=0.2))
        for model in (fit_without(whole, library, ["b/one"]), method.fit(library, exclude=["b/one"]))
    )
    assert made.pieces == again.pieces
    assert np.array_equal(made.motion.translation, again.motion.translation)
    assert np.array_equal(made.motion.rotations, again.motion.rotations)


def _counted(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    from kinetograph.methods.performance import leaving_out

    fits: list[int] = []
    fit = leaving_out.fit

    def counting(*args: Any, **options: Any) -> Any:
        fits.append(1)
        return fit(*args, **options)

    monkeypatch.setattr(leaving_out, "fit", counting)
    return fits


def test_only_what_cannot_be_told_is_fitted_again(
    library: Library, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fits = _counted(monkeypatch)
    clustered = PerformanceControl(cluster=0.05)
    whole = PerformanceControl().fit(library)
    fit_without(whole, library, ["a/one"])
    assert not fits
    again = fit_without(clustered.fit(library), library, ["a/one"])
    assert len(fits) == 1
    _same(again.fitted, clustered.fit(library, exclude=["a/one"]).fitted, "clustered")
    builds = Library.create(tmp_path / "library")
    for name in ("c/tall", "b/one", "a/one"):  # whose first take has a build of its own
        builds.add(library.take(name))
    first = PerformanceControl().fit(builds)
    _same(
        fit_without(first, builds, ["c/tall"]).fitted,
        PerformanceControl().fit(builds, exclude=["c/tall"]).fitted,
        "another build",
    )
    assert len(fits) == 2
    assert without(first.fitted, ["b/one"]) is not None


def test_a_take_that_is_not_there_and_a_last_one(library: Library) -> None:
    whole: PerformanceModel = PerformanceControl().fit(library)
    with pytest.raises(RequestError, match="no take 'd' to leave out"):
        fit_without(whole, library, ["d"])
    with pytest.raises(RequestError, match="no take to use"):
        fit_without(whole, library, library.names())
    with pytest.raises(RequestError, match="idle"):
        fit_without(whole, library, [name for name in library.names() if "idle" not in name])
