"""Performance control on stick figures: what was walked is known, so what comes out can be."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.evaluation.metrics import control_error, joint_error
from kinetograph.kinematics import joint_positions, on_ground
from kinetograph.methods.performance import Fixed, Ground, PerformanceControl, Rigid, legal_steps, partner_control
from kinetograph.mirroring import mirror
from kinetograph.motion import Motion, cut, place, sample, transform
from kinetograph.post import OntoPath
from kinetograph.post.assemble import PostSettings
from kinetograph.skeleton import same_shape
from kinetograph.synthesis import Synthesis
from kinetograph.take import Annotation, Take
from walkers import HIP_HEIGHT, stick_figure, walk

_FPS = 30.0
_PLAIN = PostSettings(blend="none", footskate=False)
_EXACT = PerformanceControl(stretch=0.0, post=_PLAIN)


def _wander(duration: float = 8.0) -> Motion:
    """A walk whose speed and turn change all the while, so that no two of its steps are alike."""
    times = np.arange(round(duration * _FPS) + 1) / _FPS
    return walk(duration, speed=1.0 + 0.25 * np.sin(0.9 * times), turn_rate=0.6 * np.cos(0.7 * times))


def _cut_every(motion: Motion, length: float = 0.5, name: str = "walk") -> Take:
    """A take with a cut every ``length`` seconds, which a search at 10 Hz meets exactly."""
    cuts = np.arange(int(motion.duration / length + 1e-9) + 1) * length
    return Take(name, {"body": motion}, tuple(Annotation("body", "cut", "", t, t) for t in cuts))


def _library(folder: Path, *takes: Take) -> kg.Library:
    library = kg.Library.create(folder / "library")
    for take in takes:
        library.add(take)
    return library


def _path(points: FloatArray, fps: float = _FPS) -> kg.Signal:
    return kg.Signal(points[:, None], ("path",), "m", fps)


def _straight(duration: float, speed: float) -> kg.Signal:
    return _path(np.outer(np.arange(round(duration * _FPS) + 1) / _FPS * speed, [0.0, 0.0, 1.0]))


def _arc(duration: float, turn_rate: float, speed: float = 1.0) -> kg.Signal:
    return _path(walk(duration, speed=speed, turn_rate=turn_rate).translation)


def _source_frames(result: Synthesis, library: kg.Library) -> FloatArray:
    """Joint positions of every frame, made anew from the recording, second and placement that its piece names."""
    frames = []
    for frame, (take, second) in enumerate(result.provenance()):
        piece = result.piece_at(frame)
        source = library.take(take).motion()
        source = mirror(source) if piece.mirrored else source
        at = transform(sample(source, [second], _FPS), np.array(piece.rotation), piece.shift)
        frames.append(joint_positions(at)[0])
    return np.array(frames)


# ---- what is asked for is in the library ----


def test_a_recording_is_recovered_from_its_own_path(tmp_path: Path) -> None:
    recording = _wander()
    model = _EXACT.fit(_library(tmp_path, _cut_every(recording)))
    result = model.synthesize(recording)
    assert result.cost == pytest.approx(0.0, abs=1e-6)
    assert joint_error(result.motion, recording) < 1e-3
    assert len(result.motion) == len(recording)
    assert [p.source_start for p in result.pieces] == pytest.approx(np.arange(16) / 2)
    assert result.warnings == ()
    assert result.edited.shape == (len(recording),)
    assert result.edited.max() < 1e-4


def test_the_cost_is_an_integral_over_time(tmp_path: Path) -> None:
    # two points, each 0.1 m off for 8 s; a sample on the border of two pieces is shared between them
    recording = _wander()
    model = dataclasses.replace(_EXACT, alignment=Fixed(), fine_rate=None).fit(
        _library(tmp_path, _cut_every(recording))
    )
    result = model.synthesize(place(recording, 0.0, (0.06, 0.0, 0.08)))
    assert len(result.pieces) == 16
    assert result.cost == pytest.approx(2 * 0.1**2 * 8.0, rel=1e-5)
    assert [p.cost for p in result.pieces] == pytest.approx([2 * 0.1**2 * 0.5] * 16, rel=1e-4)


def test_a_long_control_is_taken_in_chunks(tmp_path: Path) -> None:
    recording = walk(36.0, speed=1.0 + 0.25 * np.sin(0.9 * np.arange(1081) / _FPS), turn_rate=0.3)
    result = _EXACT.fit(_library(tmp_path, _cut_every(recording))).synthesize(recording)
    assert result.cost == pytest.approx(0.0, abs=1e-5)
    assert joint_error(result.motion, recording) < 2e-3


def test_elsewhere_and_turned_it_is_recovered_there(tmp_path: Path) -> None:
    recording = _wander()
    elsewhere = place(recording, 2.1, (4.0, 0.0, -7.0))
    model = _EXACT.fit(_library(tmp_path, _cut_every(recording)))
    result = model.synthesize(elsewhere)
    assert joint_error(result.motion, elsewhere) < 1e-3
    assert [p.turn for p in result.pieces] == pytest.approx([2.1] * 16, abs=1e-3)


@pytest.mark.parametrize(("start", "stop"), [(6, 228), (9, 216), (99, 117), (99, 114), (90, 105)])
def test_a_control_that_begins_and_ends_within_a_step_is_recovered(tmp_path: Path, start: int, stop: int) -> None:
    recording = _wander()
    control = cut(recording, start, stop + 1)
    result = _EXACT.fit(_library(tmp_path, _cut_every(recording))).synthesize(control)
    assert result.cost == pytest.approx(0.0, abs=1e-6)
    assert joint_error(result.motion, control) < 1e-3
    first = result.pieces[0]
    assert first.start <= 0.0
    assert float(first.source_time(0.0)) == pytest.approx(start / _FPS, abs=1e-6)


def test_blending_and_cleanup_leave_what_fits_nearly_as_it_is(tmp_path: Path) -> None:
    times = np.arange(181) / _FPS  # left steps a little longer, or the control could not tell them from right ones
    recording = walk(6.0, speed=1.0 + 0.01 * np.sin(2 * np.pi * times))
    library = _library(tmp_path, _cut_every(recording))
    result = dataclasses.replace(_EXACT, post=PostSettings()).fit(library).synthesize(recording)
    assert joint_error(result.motion, recording) < 1e-3


def test_a_recording_without_cuts_is_cut_at_its_footplants_and_says_so(tmp_path: Path) -> None:
    model = PerformanceControl(stand=False).fit(_library(tmp_path, Take("walk", {"body": walk(4.0)})))
    assert model.notes == ("1 take had no cuts and was cut at footplants (walk); library segment does so once",)
    starts = [s.start for s in model.fitted.instances.segments]
    np.testing.assert_allclose(starts, np.arange(1, 7) / 2, atol=0.05)


def test_a_step_made_slower_is_stretched(tmp_path: Path) -> None:
    # the same steps at half the pace again: every piece takes 0.7 s for its 0.5 s
    recording = _wander()
    model = dataclasses.replace(_EXACT, stretch=0.2).fit(_library(tmp_path, _cut_every(recording)))
    times = np.arange(round(8.0 * 1.4 * _FPS) + 1) / _FPS
    slower = sample(recording, times / 1.4, _FPS)
    result = model.synthesize(slower)
    assert [p.stretch for p in result.pieces] == pytest.approx([1.4] * 16)
    assert joint_error(result.motion, slower) < 2e-3


def test_durations_are_adjusted_at_the_finer_rate(tmp_path: Path) -> None:
    # 1.2667 times slower is 6.33 steps of the search and 19 of the finer one
    recording = _wander()
    library = _library(tmp_path, _cut_every(recording))
    method = dataclasses.replace(_EXACT, stretch=0.2, continuity=2.0)
    slower = sample(recording, np.arange(round(8.0 * 19 / 15 * _FPS) + 1) / _FPS * 15 / 19, _FPS)
    fine = method.fit(library).synthesize(slower)
    coarse = dataclasses.replace(method, fine_rate=None).fit(library).synthesize(slower)
    for result in (fine, coarse):
        assert [p.source_start for p in result.pieces] == pytest.approx(np.arange(16) / 2)
    assert sum(p.cost + p.seam for p in fine.pieces) < 0.6 * sum(p.cost + p.seam for p in coarse.pieces)
    assert joint_error(fine.motion, slower) < 0.8 * joint_error(coarse.motion, slower)


# ---- other paths ----


def test_a_path_is_followed_by_steps_of_several_recordings(tmp_path: Path) -> None:
    library = _library(
        tmp_path,
        *(
            _cut_every(walk(4.0, turn_rate=rate), name=name)
            for name, rate in (("left", 0.8), ("on", 0.0), ("right", -0.8))
        ),
    )
    rates = np.concatenate([np.full(90, 0.8), np.full(60, 0.0), np.full(91, -0.8)])
    target = walk(8.0, turn_rate=rates)
    result = PerformanceControl().fit(library).synthesize(_path(target.translation))
    assert control_error(result.motion, target.translation[:, None], _FPS) < 0.02
    takes = [p.take for p in result.pieces]
    assert (takes[1], takes[-2]) == ("left", "right")
    assert "on" in takes


def test_a_looping_clip_goes_on_and_on(tmp_path: Path) -> None:
    cycle = walk(1.0)
    loop = (Annotation("body", "loop", "", 0.0, 1.0),)
    cuts = tuple(Annotation("body", "cut", "", t, t) for t in (0.0, 0.5))
    library = _library(tmp_path, Take("cycle", {"body": cycle}, loop + cuts))
    result = PerformanceControl().fit(library).synthesize(_straight(7.0, 1.0))
    assert result.cost == pytest.approx(0.0, abs=1e-6)
    # the phase is free: whatever it is, this is the long walk from there on
    second = float(result.pieces[0].source_time(0.0))
    expected = walk(9.0)
    expected = cut(expected, round(second % 1.0 * _FPS), round(second % 1.0 * _FPS) + 211)
    at_origin = place(expected, 0.0, (0.0, 0.0, -float(expected.translation[0, 2])))
    assert joint_error(result.motion, at_origin) < 1e-3
    assert all(1.0 <= p.source_start < 2.0 for p in result.pieces)  # of a middle cycle


def test_a_clip_that_does_not_loop_is_not_played_twice(tmp_path: Path) -> None:
    take = _cut_every(walk(1.0))
    model = PerformanceControl(stand=False).fit(_library(tmp_path, take))
    assert model.fitted.sources[0].motion.duration == pytest.approx(1.0)
    assert len(model.fitted.instances.segments) == 2


def test_mirrored_copies_turn_the_other_way(tmp_path: Path) -> None:
    recording = walk(6.0, turn_rate=0.8)
    library = _library(tmp_path, _cut_every(recording))
    right = _arc(5.0, -0.8)
    plain = PerformanceControl().fit(library).synthesize(right)
    mirrored = PerformanceControl(mirror=True, post=_PLAIN).fit(library).synthesize(right)
    assert mirrored.cost < 0.05 * plain.cost
    assert all(p.mirrored for p in mirrored.pieces)
    assert not any(p.mirrored for p in plain.pieces)
    np.testing.assert_allclose(joint_positions(mirrored.motion), _source_frames(mirrored, library), atol=1e-5)


def test_mirrored_contacts_are_those_of_the_other_foot(tmp_path: Path) -> None:
    noted = (Annotation("body", "contact", "left_toe", 1.0, 1.6), Annotation("body", "contact", "right_foot", 2.0, 2.5))
    take = _cut_every(walk(4.0))
    model = PerformanceControl(mirror=True).fit(_library(tmp_path, Take("walk", take.tracks, take.annotations + noted)))
    own, mirrored = ([(n.label, n.start) for n in s.annotations] for s in model.fitted.sources)
    assert own == [("left_toe", 1.0), ("right_foot", 2.0)]
    assert mirrored == [("right_toe", 1.0), ("left_foot", 2.0)]


# ---- what the result says of itself ----


def test_provenance_points_to_the_recordings_own_frames(tmp_path: Path) -> None:
    takes = [_cut_every(_wander(), name="first"), _cut_every(walk(4.0, speed=0.8), name="second")]
    library = _library(tmp_path, *takes)
    result = PerformanceControl(post=_PLAIN).fit(library).synthesize(_arc(6.0, 0.5, speed=1.1))
    np.testing.assert_allclose(joint_positions(result.motion), _source_frames(result, library), atol=1e-5)
    for take, second in result.provenance():
        assert 0.0 <= second <= library.take(take).duration + 1e-6


def test_pieces_follow_one_another_and_share_out_the_cost(tmp_path: Path) -> None:
    method = PerformanceControl(fine_rate=None)
    result = method.fit(_library(tmp_path, _cut_every(_wander()))).synthesize(_arc(6.0, 0.5, speed=1.1))
    pieces = result.pieces
    assert pieces[0].start <= 0.0 < pieces[0].stop
    assert pieces[-1].stop >= 6.0
    assert [p.start for p in pieces[1:]] == pytest.approx([p.stop for p in pieces[:-1]])
    parts = sum(p.cost + p.seam for p in pieces) + result.costs["reuse"]
    assert parts == pytest.approx(result.cost, rel=1e-4)
    assert sum(result.costs.values()) == pytest.approx(parts)
    assert pieces[0].seam == 0.0
    assert result.statistics["pieces"] == len(pieces)
    for piece in pieces:
        assert abs((piece.stop - piece.start) - (piece.source_stop - piece.source_start)) <= method.stretch + 1e-6


def test_the_adjusted_durations_are_no_worse_than_the_coarse_ones(tmp_path: Path) -> None:
    library = _library(tmp_path, _cut_every(_wander()))
    fine, coarse = (
        PerformanceControl(fine_rate=rate).fit(library).synthesize(_arc(6.0, 0.5, speed=1.1)) for rate in (30.0, None)
    )
    # D by the trapezium rule at either rate differs by little
    assert sum(p.cost + p.seam for p in fine.pieces) <= 1.02 * sum(p.cost + p.seam for p in coarse.pieces)
    assert [p.source_start for p in fine.pieces] == [p.source_start for p in coarse.pieces]


def test_contacts_come_with_the_pieces(tmp_path: Path) -> None:
    result = PerformanceControl().fit(_library(tmp_path, _cut_every(walk(6.0)))).synthesize(_straight(5.0, 1.0))
    planted = [n for n in result.annotations if n.label == "left_toe" and n.start > 0 and n.stop < 4.9]
    assert len(planted) >= 3
    np.testing.assert_allclose([n.stop - n.start for n in planted], 0.6, atol=0.1)
    assert {(n.track, n.kind) for n in result.annotations} == {("motion", "contact")}


def test_a_path_that_is_too_fast_is_performed_with_a_warning(tmp_path: Path) -> None:
    method = PerformanceControl(stretch=0.0, keep_time=True)
    model = method.fit(_library(tmp_path, _cut_every(walk(4.0, speed=1.0))))
    result = model.synthesize(_straight(4.0, 2.0))
    warning, strange = result.warnings
    assert strange.startswith("the library has nothing like parts of this control: it costs ")
    assert warning.startswith("the path asks for 2.00 m/s where the library's fastest segment gives 1.00 m/s")
    assert "slow it down by 2.0" in warning
    assert len(result.motion) == 121
    assert model.synthesize(_straight(4.0, 1.0)).warnings == ()


def test_the_same_request_gives_the_same_answer(tmp_path: Path) -> None:
    library = _library(tmp_path, _cut_every(_wander()))
    path = _arc(6.0, 0.5, speed=1.1)
    one, two = (PerformanceControl().fit(library).synthesize(path) for _ in range(2))
    assert one.pieces == two.pieces
    assert one.cost == two.cost
    np.testing.assert_array_equal(one.motion.rotations, two.motion.rotations)
    np.testing.assert_array_equal(one.motion.translation, two.motion.translation)


def test_progress_is_told_and_ends_at_the_end(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    model = PerformanceControl().fit(_library(tmp_path, _cut_every(walk(4.0))))
    model.synthesize(_straight(6.0, 1.0), lambda done, total: told.append((done, total)))
    assert told[-1] == (60, 60)
    assert [done for done, _ in told] == sorted(done for done, _ in told)


# ---- configurations ----


@pytest.mark.parametrize("alignment", [Ground(), Rigid()])
def test_either_group_of_transforms_recovers_a_walk(tmp_path: Path, alignment: Ground | Rigid) -> None:
    recording = _wander()
    method = dataclasses.replace(_EXACT, alignment=alignment)
    result = method.fit(_library(tmp_path, _cut_every(recording))).synthesize(recording)
    assert joint_error(result.motion, recording) < 1e-3


def test_a_beam_scores_no_better_than_the_exact_search(tmp_path: Path) -> None:
    library = _library(tmp_path, _cut_every(_wander()))
    path = _arc(6.0, 0.5, speed=1.1)
    exact, wide, narrow = (
        PerformanceControl(beam=beam).fit(library).synthesize(path).cost for beam in (None, 1e9, 0.0)
    )
    assert wide == pytest.approx(exact, rel=1e-9)
    assert narrow >= exact


def test_segments_that_are_alike_are_represented_by_one(tmp_path: Path) -> None:
    # eight steps of one even walk are two kinds of step, left and right
    model = PerformanceControl(cluster=0.01, stand=False).fit(_library(tmp_path / "even", _cut_every(walk(4.0))))
    assert len(model.fitted.instances.segments) == 2
    assert model.notes == ("clustering kept 2 of 8 segments",)
    model = PerformanceControl(cluster=0.001, stand=False).fit(_library(tmp_path / "odd", _cut_every(_wander(4.0))))
    assert len(model.fitted.instances.segments) == 8


@pytest.mark.parametrize(("stretch", "kept"), [(0.2, 4), (0.4, 2)])
def test_segments_that_no_stretch_brings_together_are_not_alike(tmp_path: Path, stretch: float, kept: int) -> None:
    quick = walk(3.0)
    slow = sample(quick, np.arange(145) / 30 / 1.6, _FPS)
    library = _library(tmp_path, _cut_every(quick, name="quick"), _cut_every(slow, 0.8, name="slow"))
    model = PerformanceControl(cluster=0.01, stretch=stretch, stand=False).fit(library)
    assert len(model.fitted.instances.segments) == kept


@pytest.mark.parametrize(
    ("duration", "stretch", "steps"),
    [
        (0.5, 0.2, [3, 4, 5, 6, 7]),
        (0.5, 0.0, [5]),
        (0.53, 0.0, [5]),  # the nearest whole number always
        (0.6, 2.0, [3, 4, 5, 6, 7, 8, 9, 10, 11, 12]),  # half to twice
        (0.25, 0.2, [2, 3, 4]),
        (0.08, 0.1, [2]),  # two steps at least
    ],
)
def test_legal_stretches(duration: float, stretch: float, steps: list[int]) -> None:
    assert legal_steps(duration, 10.0, stretch) == steps


def test_takes_can_be_left_out(tmp_path: Path) -> None:
    library = _library(tmp_path, _cut_every(walk(4.0), name="a"), _cut_every(walk(4.0), name="b"))
    assert {s.take for s in PerformanceControl().fit(library, exclude=("a",)).fitted.sources} == {"b"}
    with pytest.raises(RequestError, match="the library has no take to use; add recordings, or exclude fewer"):
        PerformanceControl().fit(library, exclude=("a", "b"))
    with pytest.raises(RequestError, match="no take 'c' to leave out; there are a, b"):
        PerformanceControl().fit(library, exclude=("c",))


def test_a_walker_of_another_build_walks_on_the_first_ones_legs(tmp_path: Path) -> None:
    tall, small = stick_figure(1.2), walk(4.0)
    other = Motion(tall, 1.2 * small.translation, small.rotations, _FPS)
    library = _library(tmp_path, _cut_every(small, name="a"), _cut_every(other, name="b"))
    model = PerformanceControl().fit(library)
    own, adopted = (source.motion for source in model.fitted.sources)
    assert same_shape(own.skeleton, adopted.skeleton)
    np.testing.assert_allclose(adopted.translation, own.translation, atol=1e-6)
    np.testing.assert_allclose(
        model.fitted.sources[1].control_points, model.fitted.sources[0].control_points, atol=1e-6
    )


def test_segments_that_are_all_too_long_are_an_error(tmp_path: Path) -> None:
    library = _library(tmp_path, _cut_every(walk(4.0), length=2.0))
    with pytest.raises(RequestError, match=r"the library's cuts give no segment of at most 1.0 s"):
        PerformanceControl(longest=1.0).fit(library)


def test_a_control_that_is_too_short_is_an_error(tmp_path: Path) -> None:
    model = PerformanceControl().fit(_library(tmp_path, _cut_every(walk(4.0))))
    with pytest.raises(RequestError, match="the control is too short: expected 2 samples at 10 Hz or more"):
        model.synthesize(cut(walk(1.0), 0, 2))
    message = r"it lasts 0\.20 s, the library's shortest segment, squeezed, 0\.30 s; record more of it"
    with pytest.raises(RequestError, match=message):
        model.synthesize(cut(walk(1.0), 0, 9))
    assert len(model.synthesize(cut(walk(1.0), 0, 10)).motion) == 10


@pytest.mark.parametrize(
    ("option", "value"),
    [("stretch", -0.1), ("continuity", -1.0), ("continuity", np.nan), ("rate", 0.0), ("rate", np.inf), ("longest", 0)],
)
def test_options_are_numbers_in_range(option: str, value: float) -> None:
    with pytest.raises(RequestError, match=f"{option} must be (a positive number|0 or more), found"):
        PerformanceControl(**{option: value})  # type: ignore[arg-type]


def test_a_target_is_named() -> None:
    with pytest.raises(RequestError, match="targets must name at least one role, found none"):
        PerformanceControl(targets={})


def test_the_walkers_hips_are_at_their_height() -> None:
    np.testing.assert_allclose(walk(1.0).translation[:, 1], HIP_HEIGHT)
    assert rot.angle_between(walk(1.0).rotations[0, 0], rot.IDENTITY) == 0.0


def test_clusters_are_represented_by_their_medoid_or_drawn(tmp_path: Path) -> None:
    library = _library(tmp_path, _cut_every(walk(12.0)))
    method = PerformanceControl(cluster=1.0)
    steady = [method.fit(library).fitted.instances.segments for _ in range(2)]
    assert steady[0] == steady[1]
    drawn = {method.fit(library, rng=np.random.default_rng(seed)).fitted.instances.segments for seed in range(12)}
    assert len(drawn) > 1
    assert {len(segments) for segments in drawn} == {len(steady[0])}
    assert len(steady[0]) < len(PerformanceControl().fit(library).fitted.instances.segments)


def test_hips_are_brought_onto_the_path_in_time(tmp_path: Path) -> None:
    path = _arc(6.0, 0.5, speed=0.9)
    library = _library(tmp_path, _cut_every(_wander(16.0)))
    model = PerformanceControl(post=dataclasses.replace(PostSettings(), onto_path=OntoPath(0.0))).fit(library)
    off = on_ground(model.synthesize(path).motion.translation - path.values[:, 0])
    assert np.abs(off).max() < 1e-9
    free = PerformanceControl().fit(library).synthesize(path).motion
    assert np.abs(on_ground(free.translation - path.values[:, 0])).max() > 0.01


def test_hips_are_brought_onto_those_of_a_walker(tmp_path: Path) -> None:
    walker = walk(6.0, turn_rate=0.4)
    library = _library(tmp_path, _cut_every(_wander(16.0)))
    model = PerformanceControl(post=dataclasses.replace(PostSettings(), onto_path=OntoPath(0.0))).fit(library)
    off = on_ground(model.synthesize(walker).motion.translation - walker.translation)
    assert np.abs(off).max() < 1e-9


def test_partners_have_no_path_for_the_hips() -> None:
    with pytest.raises(RequestError, match="--onto-path"):
        dataclasses.replace(partner_control(), post=PostSettings(onto_path=OntoPath()))
