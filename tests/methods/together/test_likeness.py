"""What is like an example: the same windows as the search by example finds, as spans of recordings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.methods.performance import PerformanceControl, RecordedSpan, Rule
from kinetograph.methods.performance.rules import matching
from kinetograph.motion import Motion, cut
from kinetograph.pipeline import find_alike, index_of, spans_like
from kinetograph.take import Annotation, Take
from walkers import walk


def lifted(motion: Motion, start: float, stop: float) -> Motion:
    """A walk whose left arm is raised from second to second."""
    times = np.arange(len(motion)) / motion.fps
    rotations = motion.rotations.copy()
    joint = motion.skeleton.names.index("left_shoulder")
    rotations[:, joint] = rot.about("z", np.where((times >= start) & (times <= stop), 2.0, 0.0))
    return replace(motion, rotations=rotations)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> kg.Library:
    made = kg.Library.create(tmp_path_factory.mktemp("likeness") / "library")
    motions = {"plain": walk(8.0), "early": lifted(walk(8.0), 1.0, 3.0), "late": lifted(walk(8.0), 4.0, 7.0)}
    for name, motion in motions.items():
        made.add(Take(name, {"body": motion}, tuple(Annotation("body", "cut", "", t, t) for t in np.arange(17) / 2)))
    return made


def test_spans_are_where_the_arm_is_raised(library: kg.Library) -> None:
    """Poses repeat with every cycle of a second, and what is moved in 0.2 s counts at the borders."""
    found = spans_like("take:early@1.3-2.5", library)
    spans = {each.take: (each.start, each.stop) for each in found}
    assert set(spans) == {"early", "late"}
    assert spans["early"] == pytest.approx((1.0, 3.0), abs=0.55)
    assert spans["late"] == pytest.approx((4.0, 7.0), abs=0.55)
    assert not any(each.mirrored for each in found)


def test_spans_are_the_windows_that_are_found_one_by_one(library: kg.Library) -> None:
    example = cut(library.take("early").motion(), 39, 76)
    alike = find_alike(index_of(library), example, count=999, each=999)
    for within in (0.05, 0.2, 0.4):
        spans = spans_like("take:early@1.3-2.5", library, within)
        near = [each for each in alike if each.distance <= within]
        assert near
        for one in near:
            assert any(
                each.take == one.take and each.start <= one.start + 1e-9 and one.stop <= each.stop + 1e-9
                for each in spans
            )


def test_pieces_count_that_show_a_span_for_half_of_their_duration(library: kg.Library) -> None:
    fitted = PerformanceControl(mirror=True, stand=False).fit(library).fitted
    rule = Rule(
        0.0, 1.0, like="x", spans=(RecordedSpan("early", "body", 1.2, 2.1), RecordedSpan("late", "body", 3, 4, True))
    )
    chosen = matching(fitted, rule)
    for state, (index, _) in zip(chosen, fitted.instances.states.tolist(), strict=True):
        segment = fitted.instances.segments[index]
        source = fitted.sources[segment.source]
        first, last = {("early", False): (1.2, 2.1), ("late", True): (3.0, 4.0)}.get(
            (source.take, source.mirrored), (0.0, 0.0)
        )
        shared = max(min(segment.stop, last) - max(segment.start, first), 0.0)
        assert state == (shared >= 0.5 * (segment.stop - segment.start) and shared > 0)
    assert 0 < chosen.sum() < len(chosen)


def test_a_clip_that_loops_shows_a_span_in_every_cycle(tmp_path: Path) -> None:
    made = kg.Library.create(tmp_path / "loops")
    notes = (
        Annotation("body", "loop", "", 0.0, 2.0),
        *(Annotation("body", "cut", "", t, t) for t in (0.0, 0.5, 1.0, 1.5)),
    )
    made.add(Take("loop", {"body": cut(walk(8.0), 0, 61)}, notes))
    made.add(Take("other", {"body": walk(8.0)}, tuple(Annotation("body", "cut", "", t, t) for t in np.arange(17) / 2)))
    fitted = PerformanceControl(stand=False, span=1).fit(made).fitted
    chosen = matching(fitted, Rule(0.0, 1.0, like="x", spans=(RecordedSpan("loop", "body", 0.5, 1.0),)))
    segments = {fitted.instances.segments[i] for i in fitted.instances.states[chosen, 0].tolist()}
    assert {(fitted.sources[each.source].take, round(each.start % 2.0, 3)) for each in segments} == {("loop", 0.5)}
    assert all(each.start >= 2.0 for each in segments)  # cut from its second cycle


def test_the_mirror_image_of_an_example_is_found_in_mirrored_recordings(library: kg.Library, tmp_path: Path) -> None:
    plain = spans_like("take:early@1.3-2.5", library)
    both = spans_like("take:early@1.3-2.5", library, mirrored=True)
    assert [each for each in both if not each.mirrored] == list(plain)
    assert not any(each.mirrored for each in both)  # nobody raises the right arm
    other = [each for each in spans_like("take:plain@1.3-2.5", library, mirrored=True) if each.mirrored]
    assert {each.take for each in other} == {"plain", "early", "late"}  # walking is alike on both sides


def test_an_example_of_another_length_is_refused(library: kg.Library) -> None:
    with pytest.raises(RequestError, match=r"expected a part of the 8\.00 s"):
        spans_like("take:early@7-9", library)
