"""Keys that are set one after another."""

from __future__ import annotations

import numpy as np
import pytest

import kinetograph as kg
from kinetograph.errors import RequestError
from kinetograph.evaluation.keyframe import key_miss
from kinetograph.keys import Key, key_at
from kinetograph.methods.keyframe import ClusterChain, KeyframeModel
from kinetograph.take import Take
from walkers import walk


@pytest.fixture(scope="module")
def walks(tmp_path_factory: pytest.TempPathFactory) -> kg.Library:
    library = kg.Library.create(tmp_path_factory.mktemp("live_keys") / "walks")
    library.add(Take("slow", {"motion": walk(6.0, speed=0.8)}))
    library.add(Take("quick", {"motion": walk(6.0, speed=1.2)}))
    return library


@pytest.fixture(scope="module")
def model(walks: kg.Library) -> KeyframeModel:
    return kg.KeyframeControl().fit(walks)


@pytest.fixture
def keys(walks: kg.Library) -> list[Key]:
    slow, quick = walks.take("slow").motion(), walks.take("quick").motion()
    at = [(slow, 0.5, 0.0), (quick, 2.0, 3.0), (slow, 3.2, 6.0)]
    return [key_at(clip, s, time=(t, t), label=f"key {i}") for i, (clip, s, t) in enumerate(at)]


def test_without_haste_the_whole_is_the_offline_one_bit_by_bit(model: KeyframeModel, keys: list[Key]) -> None:
    live = model.start(now=False)
    assert [live.step(key) for key in keys] == [()] * len(keys)
    result, offline = live.finish(), model.synthesize(keys)
    assert (result.motion.rotations == offline.motion.rotations).all()
    assert (result.motion.translation == offline.motion.translation).all()
    assert result.pieces == offline.pieces


def test_motion_to_each_key_is_settled_when_it_is_set(model: KeyframeModel, keys: list[Key]) -> None:
    live = model.start()
    assert live.step(keys[0]) == ()
    poses = [pose for key in keys[1:] for pose in live.step(key)]
    result = live.finish()
    assert len(poses) == len(result.motion) == 181
    assert np.allclose([pose.time for pose in poses], np.arange(181) / 30)
    assert (np.array([pose.rotations for pose in poses]) == result.motion.rotations).all()  # never revised
    assert (np.array([pose.translation for pose in poses]) == result.motion.translation).all()
    for key, frame in zip(keys, (0, 90, 180), strict=True):
        assert key_miss(result, key, frame) < 1e-3
    steps = np.linalg.norm(np.diff(result.motion.translation, axis=0), axis=1)
    assert steps.max() < 0.08  # no leap at a key


def test_a_key_that_cannot_be_met_is_not_set_and_another_may_be(model: KeyframeModel, keys: list[Key]) -> None:
    live = model.start()
    live.step(keys[0])
    live.step(keys[1])
    with pytest.raises(RequestError, match="to be met by 2 s, and the motion is at 3 s"):
        live.step(key_at(keys[2].clip, 0.5, time=(2.0, 2.0), label="late"))
    assert len(live.step(keys[2])) == 90


def test_a_chain_of_clusters_needs_all_keys_at_once(walks: kg.Library, keys: list[Key]) -> None:
    with pytest.raises(RequestError, match="all keys at once"):
        kg.KeyframeControl(solver=ClusterChain()).fit(walks).start()
    with pytest.raises(RequestError, match="2 keys or more"):
        kg.KeyframeControl().fit(walks).start().finish()
