"""The scores of one file against another: known rotations, other rates, lengths and rest poses."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from kinetograph import rotations as rot
from kinetograph.cli import app
from kinetograph.errors import RequestError
from kinetograph.evaluation import score_against
from kinetograph.formats import save
from kinetograph.motion import Motion, cut, resample
from kinetograph.skeleton import Skeleton
from walkers import walk


def with_rest(motion: Motion, turn: np.ndarray, scale: float = 1.0) -> Motion:
    """The same poses on bones of other directions at rest, and of other lengths."""
    old = motion.skeleton
    roles = {role: replace(mark, offset=rot.rotate(turn, mark.offset)) for role, mark in old.roles.items()}
    skeleton = Skeleton(old.names, old.parents, scale * rot.rotate(turn, old.offsets), roles=roles)
    local = rot.multiply(rot.multiply(turn, motion.rotations), rot.conjugate(turn))
    local[:, 0] = rot.multiply(motion.rotations[:, 0], rot.conjugate(turn))
    return Motion(skeleton, scale * motion.translation, local, motion.fps)


def test_a_known_rotation_is_its_angle_at_another_rate_and_length():
    truth = walk(3.0, fps=60.0)
    bent = truth.rotations.copy()
    joint = truth.skeleton.index(truth.skeleton.names[3])
    bent[:, joint] = rot.multiply(bent[:, joint], rot.about("z", np.radians(10.0)))
    result = cut(resample(replace(truth, rotations=bent), 30.0), 0, 45)
    found = score_against(result, truth)
    assert found.rate == 30.0
    assert found.row.frames == 45
    assert not found.by_roles
    assert found.row.angle == pytest.approx(10.0 / len(truth.skeleton), rel=0.01)
    assert found.row.jitter == pytest.approx(1.0, abs=0.2)
    assert score_against(truth, truth).row.recorded_cm_s == score_against(truth, truth).row.slide_cm_s


def test_other_rest_poses_and_sizes_are_compared_by_roles():
    truth = walk(2.0)
    other = with_rest(truth, rot.about("x", 1.0), scale=1.25)
    found = score_against(other, truth)
    assert found.by_roles
    assert found.row.angle == pytest.approx(0.0, abs=1e-4)
    assert found.row.position_cm == pytest.approx(0.0, abs=1e-6)
    assert np.isnan(found.row.rms)
    turned = rot.multiply(rot.about("y", 1.0), other.rotations[:, :1])
    elsewhere = replace(other, rotations=np.concatenate([turned, other.rotations[:, 1:]], axis=1))
    assert score_against(elsewhere, truth).row.angle == pytest.approx(0.0, abs=1e-4)  # headings do not count


def test_a_bent_knee_counts_by_roles_as_the_bones_below_it():
    truth = walk(2.0)
    bent = truth.rotations.copy()
    knee = truth.skeleton.landmark("left_knee").joint
    bent[:, knee] = rot.multiply(bent[:, knee], rot.about("x", np.radians(20.0)))
    found = score_against(with_rest(replace(truth, rotations=bent), rot.about("x", 1.0)), truth)
    assert 20.0 / 10 < found.row.angle < 2.5 * 20.0 / 10


def test_what_has_too_little_in_common_is_refused():
    truth = walk(1.0)
    with pytest.raises(RequestError, match="expected three common frames or more at 60 Hz, found 2"):
        score_against(cut(resample(truth, 60.0), 0, 2), resample(truth, 60.0))
    names = tuple(f"j{i}" for i in range(len(truth.skeleton)))
    bare = Skeleton(names, truth.skeleton.parents, truth.skeleton.offsets, roles={})
    with pytest.raises(RequestError, match="have only these roles in common: none"):
        score_against(Motion(bare, truth.translation, truth.rotations, truth.fps), truth)


def test_two_files_are_scored_without_a_library(tmp_path: Path):
    for name, motion in (("a", walk(1.0)), ("b", resample(walk(1.5), 25.0))):
        save(motion, tmp_path / f"{name}.bvh")
    command = ["evaluate", "sensor", "--against", str(tmp_path / "a.bvh"), str(tmp_path / "b.bvh")]
    run = CliRunner().invoke(app, command)
    assert run.exit_code == 0, run.output
    assert "rate" in run.output
    alone = CliRunner().invoke(app, ["evaluate", "sensor"])
    assert alone.exit_code != 0
