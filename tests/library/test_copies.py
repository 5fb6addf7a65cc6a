"""Copies of takes: variations whose truth is known, among motion that is no copy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.evaluation import HeldOut
from kinetograph.evaluation.leaving_out import left_out_for
from kinetograph.evaluation.sensor import folds
from kinetograph.formats.readings import read_layout
from kinetograph.library import Library, Selection
from kinetograph.methods.sensor import SensorControl
from kinetograph.mirroring import mirror
from kinetograph.motion import Motion, cut, place, resample, sample
from kinetograph.pipeline import Copy, copies_among, copies_of, find_alike, find_copies, index_of
from kinetograph.take import Take
from kinetograph.work import Workers
from walkers import stick_figure, walk


def dance(seed: int, duration: float = 9.0) -> Motion:
    """Somebody who moves all joints at random, and turns while walking."""
    rng = np.random.default_rng(seed)
    times = np.arange(round(30 * duration) + 1) / 30
    base = walk(duration, turn_rate=1.5 * np.sin(rng.uniform(0.5, 1.5) * times + seed), period=rng.uniform(0.8, 1.3))
    waves = rng.uniform(0.4, 2.5, (3, 1, 15, 1)) * times[None, :, None, None] + rng.uniform(0, 7, (3, 1, 15, 3))
    angles = (rng.normal(0, 0.25, (3, 1, 15, 3)) * np.sin(waves)).sum(axis=0)
    angles[:, 0] = 0
    return replace(base, rotations=rot.multiply(base.rotations, rot.exp(angles)))


def fitted_again(motion: Motion) -> Motion:
    """Another fit: every joint held a few degrees otherwise, in a body that is larger, elsewhere, looking elsewhere."""
    held = rot.exp(np.random.default_rng(9).normal(0, 0.03, (15, 3)))
    held[0] = rot.IDENTITY
    rotations = rot.multiply(motion.rotations, held)
    return place(Motion(stick_figure(1.07), 1.07 * motion.translation, rotations, motion.fps), 2.0, np.array([3, 0, 5]))


VARIATIONS: dict[str, tuple[Callable[[Motion], Motion], float, float]] = {
    "again": (fitted_again, 0.0, 9.0),
    "mirrored": (lambda motion: fitted_again(mirror(motion)), 0.0, 9.0),
    "cut out": (lambda motion: cut(motion, 77, 201), 77 / 30, 123 / 30),
    "rate": (lambda motion: resample(motion, 120.0), 0.0, 9.0),
    "slower": (lambda motion: sample(motion, np.arange(0, 9, 0.96 / 30), 30.0), 0.0, 9.0),
}


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Library:
    made = Library.create(tmp_path_factory.mktemp("copies") / "library")
    for number in range(6):
        made.add(Take(f"dance_{number}", {"motion": dance(number)}))
    for number, (name, (vary, _, _)) in enumerate(VARIATIONS.items()):
        made.add(Take(name, {"motion": vary(dance(number))}))
    for number in range(3):
        made.add(Take(f"walk_{number}", {"motion": walk(8.0, period=0.9 + 0.2 * number)}))
    return made


@pytest.fixture(scope="module")
def found(library: Library) -> tuple[Copy, ...]:
    return find_copies(library)


def test_every_copy_is_found_and_nothing_else(found: tuple[Copy, ...]) -> None:
    pairs = {(copy.take, copy.other) for copy in found}
    assert pairs == {(f"dance_{number}", name) for number, name in enumerate(VARIATIONS)}


@pytest.mark.parametrize("name", VARIATIONS)
def test_a_copy_says_where_it_lies(name: str, found: tuple[Copy, ...]) -> None:
    _, start, seconds = VARIATIONS[name]
    copy = next(copy for copy in found if copy.other == name)
    assert copy.mirrored == (name == "mirrored")
    assert copy.seconds == pytest.approx(seconds, abs=0.5)
    assert copy.start - copy.other_start == pytest.approx(start, abs=0.1)
    assert copy.speed == pytest.approx(1 / 0.96 if name == "slower" else 1.0, abs=0.01)
    assert copy.holds == ("dance_2" if name == "cut out" else "both")
    assert copy.distance < 0.1


def test_results_do_not_depend_on_who_works(library: Library, found: tuple[Copy, ...]) -> None:
    assert find_copies(library, workers=Workers(2)) == found


def test_the_copies_of_one_take(library: Library) -> None:
    assert copies_of(library, "dance_1") == ("mirrored",)
    assert copies_of(library, "cut out") == ("dance_2",)
    assert copies_of(library, "walk_0") == ()
    assert copies_of(library.only(Selection(without=("mirrored",))), "dance_1") == ()
    with pytest.raises(RequestError, match="no take 'nobody' to compare"):
        copies_of(library, "nobody")


def test_who_stands_still_is_no_copy(tmp_path: Path) -> None:
    library = Library.create(tmp_path / "still")
    for name in ("a", "b"):
        library.add(Take(name, {"motion": cut(walk(6.0, speed=0.0), 0, 1)}))
        standing = walk(6.0)
        held = np.repeat(standing.rotations[:1], len(standing), axis=0)
        library.add(Take(f"{name} stands", {"motion": Motion(standing.skeleton, np.zeros((181, 3)), held, 30.0)}))
    assert find_copies(library) == ()


def test_an_index_that_is_kept_finds_the_same(library: Library) -> None:
    example = cut(dance(3), 60, 120)
    first = find_alike(index_of(library), example, count=12, each=3)
    assert find_alike(index_of(library), example, count=12, each=3) == first
    assert first[0].take in ("dance_3", "rate")
    assert first[0].start == pytest.approx(2.0, abs=0.06)
    for one in first:
        others = [two for two in first if two.take == one.take and two is not one]
        assert all(two.start >= one.stop or two.stop <= one.start for two in others)
        assert len(others) < 3


def test_copies_are_left_out_of_the_library_of_a_held_out_take(library: Library) -> None:
    copies = copies_among(library, ["dance_1", "walk_0", "rate"])
    assert copies == {"dance_1": ("mirrored",), "rate": ("dance_3",)}
    some = library.only(Selection(("dance_1", "mirrored", "walk_0")))
    method = SensorControl(layout=read_layout("ideal"), rate=10.0)
    fold = folds(some, method, HeldOut(("dance_1",), copies=copies))[0]()
    kept = folds(some, method, HeldOut(("dance_1",)))[0]()
    assert {take for take, _ in fold.examples.takes} == {"walk_0"}
    assert {take for take, _ in kept.examples.takes} == {"walk_0", "mirrored"}


def test_takes_are_left_out_for_all_or_by_take() -> None:
    assert left_out_for(("a",), "b") == ()  # never used, for no take
    assert left_out_for({"b": ("c",)}, "b") == ("c",)
    assert left_out_for({"b": ("c",)}, "a") == ()
