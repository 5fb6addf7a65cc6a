"""The frames that are nearest to a key are those of a comparison with all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinetograph.keys import Key
from kinetograph.methods.keyframe import Example
from kinetograph.methods.keyframe.features import PoseFeatures, nearest_frames, pose_features
from kinetograph.methods.relative_pose import REACH, relative_joints
from kinetograph.motion import Motion, cut
from walkers import walk


@pytest.fixture(scope="module")
def motions() -> tuple[Motion, ...]:
    return tuple(walk(seconds, speed=speed) for seconds, speed in ((4.0, 0.9), (5.0, 0.7), (3.0, 1.1)))


@pytest.fixture(scope="module")
def features(motions: tuple[Motion, ...]) -> PoseFeatures:
    return pose_features(tuple(Example(f"take {n}", "motion", False, one, ()) for n, one in enumerate(motions)))


def naive(motions: tuple[Motion, ...], key: Key, roles: tuple[str, ...], moving: bool) -> np.ndarray:
    """Metres between a key and every frame, one role after the other."""
    pose, velocity = relative_joints(key.clip, roles)
    found = []
    for motion in motions:
        poses, velocities = relative_joints(motion, roles)
        squares = ((poses - pose[key.frame]) ** 2).sum(axis=(1, 2))
        if moving:
            squares += (REACH * (velocities - velocity[key.frame]) ** 2 * REACH).sum(axis=(1, 2))
        found.append(np.sqrt(squares / len(roles)))
    return np.concatenate(found)


@pytest.mark.parametrize("moving", [True, False])
@pytest.mark.parametrize("some_roles", [False, True])
@pytest.mark.parametrize(("most", "slack"), [(12, 0.1), (12, 0.01), (1, 0.1), (10_000, 0.05)])
def test_they_are_those_of_a_comparison_with_all(
    motions: tuple[Motion, ...], features: PoseFeatures, moving: bool, some_roles: bool, most: int, slack: float
) -> None:
    rng = np.random.default_rng(1)
    barred = rng.random(sum(map(len, motions))) < 0.2
    for frame in (0, 17, 60):
        clip = motions[1] if moving else cut(motions[1], frame, frame + 1)
        roles = features.roles[::2] if some_roles else features.roles
        key = Key(clip, frame if moving else 0, roles=roles if some_roles else ())
        distances = np.where(barred, np.inf, naive(motions, key, roles, moving))
        expected = np.sort(np.argsort(distances, kind="stable")[:most])
        expected = expected[distances[expected] <= distances.min() + slack]
        frames, found = nearest_frames(features, key, motions[0].skeleton, barred, most=most, slack=slack)
        assert found == pytest.approx(np.sort(distances)[np.argsort(np.argsort(found))], abs=1e-5)
        assert np.abs(found - distances[frames]).max() < 1e-5
        assert abs(len(frames) - len(expected)) <= 1  # rounding at the very edge
        assert not barred[frames].any()


def test_few_rows_are_compared_in_full(motions: tuple[Motion, ...], features: PoseFeatures, monkeypatch) -> None:
    """Frames that cannot be near, by the few dimensions, are not looked at."""
    spoilt = features.pose.copy()
    far = np.arange(len(spoilt)) >= len(motions[0])
    spoilt[far] = np.nan
    coarse = replace(features.coarse[0], rows=features.coarse[0].rows + np.float32(9) * far[:, None])
    broken = replace(features, pose=spoilt, coarse=(coarse, features.coarse[1]))
    none = np.zeros(len(spoilt), dtype=np.bool_)
    frames, _ = nearest_frames(broken, Key(motions[0], 20), motions[0].skeleton, none, most=8, slack=0.2)
    assert 20 in frames
    assert len(frames) == 8
