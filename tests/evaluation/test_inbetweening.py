"""The in-betweening protocol: baselines, metrics with known answers, and keyframe control compared with them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.errors import RequestError
from kinetograph.evaluation import Run
from kinetograph.evaluation.inbetweening import (
    PAST,
    interpolation,
    npss,
    position_scale,
    score,
    windows_of,
    zero_velocity,
)
from kinetograph.evaluation.keyframe import inbetween_held_out, seam_jump, skate_ratio, speed_jumps
from kinetograph.keys import key_at
from kinetograph.methods.keyframe import ClusterChain
from kinetograph.take import Take
from kinetograph.work import Workers
from walkers import walk


def test_windows_stand_over_the_origin_and_face_along_z():
    windows = windows_of(walk(6.0, turn_rate=0.5), 15)
    assert len(windows) == 4
    for window in windows:
        assert len(window) == PAST + 15 + 1
        assert window.translation[PAST - 1, [0, 2]] == pytest.approx([0, 0], abs=1e-9)
        assert window.rotations[PAST - 1, 0, 2] == pytest.approx(0, abs=1e-9)


def test_baselines_know_the_ends_and_the_truth_scores_nothing():
    window = windows_of(walk(4.0), 15)[0]
    still, even = zero_velocity(window, 15), interpolation(window, 15)
    assert (still.rotations[PAST : PAST + 15] == window.rotations[PAST - 1]).all()
    middle = 0.5 * (window.translation[PAST - 1] + window.translation[PAST + 15])
    assert even.translation[PAST + 7] == pytest.approx(middle)
    scale = position_scale([walk(4.0)], 15)
    truth = score(lambda w, gap: w, [window], 15, scale)
    assert (truth.npss, truth.l2q, truth.l2p) == (0, 0, 0)
    assert score(interpolation, [window], 15, scale).l2p < score(zero_velocity, [window], 15, scale).l2p


def test_l2p_is_a_distance_in_standard_deviations():
    window = windows_of(walk(4.0), 5)[0]
    joints = len(window.skeleton)
    scale = (np.zeros((joints, 3)), np.full((joints, 3), 2.0))

    def shifted(w: kg.Motion, gap: int) -> kg.Motion:
        return kg.Motion(w.skeleton, w.translation + np.array([0, 1, 0]), w.rotations, w.fps)

    assert score(shifted, [window], 5, scale).l2p == pytest.approx(np.sqrt(joints) / 2)


def test_npss_grows_with_the_difference_in_frequency():
    t = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    slow, near, far = (np.cos(k * t)[None, :, None] for k in (2, 3, 9))
    assert npss(slow, slow) == 0
    assert 0 < npss(slow, near) < npss(slow, far)


def test_a_recording_has_no_seams_and_its_own_jumps():
    motion = walk(4.0)
    assert speed_jumps(motion).shape == (len(motion) - 2,)


def test_seams_and_feet_of_a_result_are_measured(tmp_path: Path):
    library = kg.Library.create(tmp_path / "walks")
    for name, speed in (("slow", 0.8), ("quick", 1.2)):
        library.add(Take(name, {"motion": walk(5.0, speed=speed)}))
    model = kg.KeyframeControl().fit(library)
    first, last = (library.take(name).motion() for name in ("slow", "quick"))
    result = model.synthesize([key_at(first, 0.5), key_at(last, 1.0, time=(7.0, 7.0))])
    assert len(result.pieces) > 1
    recorded = {"slow": 1.0, "quick": 2.0}
    assert seam_jump(result, recorded) == pytest.approx(2 * seam_jump(result, {"slow": 2.0, "quick": 4.0}))
    assert 0 <= skate_ratio(result, model.examples) < 3


def test_held_out_gaps_are_filled_better_than_by_interpolation(tmp_path: Path):
    library = kg.Library.create(tmp_path / "walks")
    for number, speed in enumerate((0.8, 0.95, 1.1, 1.25)):
        library.add(Take(f"walk{number}", {"motion": walk(8.0, speed=speed)}))
    lines: list[str] = []
    scores = inbetween_held_out(library, ("walk2",), gaps=(30,), run=Run(note=lines.append))
    shared = inbetween_held_out(library, ("walk2",), gaps=(30,), run=Run(workers=Workers(2)))
    assert shared == scores
    assert scores["keyframe", 30].npss < scores["interpolation", 30].npss < scores["zero velocity", 30].npss
    assert scores["keyframe", 30].windows == len(windows_of(library.take("walk2").motion(), 30))
    assert len(lines) == 3
    with pytest.raises(RequestError, match="no take 'walk9' to leave out"):
        inbetween_held_out(library, ("walk2", "walk9"), gaps=(30,))
    with pytest.raises(RequestError, match="gaps are filled by TimedSearch"):
        inbetween_held_out(library, ("walk2",), gaps=(30,), method=kg.KeyframeControl(solver=ClusterChain()))
