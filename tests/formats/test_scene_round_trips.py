"""GLB, FBX and USD there and back: places, names of joints, tracks and animations, rates and lengths."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mutations
import numpy as np
import pytest

from kinetograph.formats import read, save
from kinetograph.kinematics import joint_positions
from kinetograph.motion import Motion
from kinetograph.take import Take

WALK = mutations.small_motion(50)
ODD_NAMES = ("Hips:a b", "mixamorig:Chest", "Head/Top", "左腕", "R|Arm", "1leg", "a.b", "a-b", "a_b", " x ")


def shorter(frames: int, fps: float) -> Motion:
    return Motion(WALK.skeleton, WALK.translation[:frames] + 1.0, WALK.rotations[:frames], fps)


def stretched() -> Motion:
    wobble = 1 + 0.1 * np.sin(np.arange(50))[:, None, None]
    return replace(WALK, bones=WALK.skeleton.offsets * wobble)


CASES: dict[str, dict[str, Motion]] = {
    "odd names of joints": {"motion": replace(WALK, skeleton=replace(WALK.skeleton, names=ODD_NAMES))},
    "23.976 frames per second": {"motion": replace(WALK, fps=24_000 / 1001)},
    "119.88 frames per second": {"motion": replace(WALK, fps=120_000 / 1001)},
    "a frame every three seconds": {"motion": replace(WALK, fps=1 / 3)},
    "a frame": {"motion": shorter(1, 30.0)},
    "two minutes": {"motion": mutations.small_motion(4000)},
    "stretching bones": {"motion": stretched()},
    "two people with one skeleton": {"leader one": WALK, "follower/2": shorter(50, 30.0)},
    "two lengths": {"a": WALK, "b": shorter(20, 30.0)},
    "two rates": {"a": WALK, "b": shorter(20, 60.0)},
}


@pytest.mark.parametrize("suffix", ["glb", "fbx", "usdc"])
@pytest.mark.parametrize("case", CASES)
def test_what_is_written_is_read(tmp_path: Path, case: str, suffix: str) -> None:
    if suffix == "usdc":
        pytest.importorskip("pxr", reason="usd-core is not installed")
    if case == "two rates" and suffix != "glb":
        pytest.skip("USD and FBX have one rate")
    if case.startswith("two ") and suffix == "fbx":
        pytest.skip("FBX has one length, and its joints one name each")
    save(Take("take", CASES[case], animation="Walk | 1 ü"), tmp_path / f"a.{suffix}")
    loaded = read(tmp_path / f"a.{suffix}")
    assert (loaded.take.animation, loaded.animations) == ("Walk | 1 ü", ("Walk | 1 ü",))
    assert not [note for note in loaded.notes if "rate" in note or "occurs again" in note]
    assert sorted(loaded.take.tracks) == sorted(CASES[case])
    for track, wanted in CASES[case].items():
        back = loaded.take.motion(track)
        assert (len(back), back.fps, back.skeleton.names) == (len(wanted), wanted.fps, wanted.skeleton.names)
        assert (back.bones is None) == (wanted.bones is None)
        assert np.abs(joint_positions(back) - joint_positions(wanted)).max() < 2e-5
