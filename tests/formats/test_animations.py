"""Several animations in one file: chosen by name or number, all taken into libraries, their names kept."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mutations
import numpy as np
import pytest

from gltf_files import animated, spun, turned, written
from kinetograph import rotations as rot
from kinetograph.errors import RequestError
from kinetograph.formats import ReadOptions, load, read, save
from kinetograph.kinematics import joint_positions
from kinetograph.pipeline import read_takes
from kinetograph.take import Take

NODES = [{"name": "a", "children": [1]}, {"name": "b", "translation": [0, 1, 0]}]


@pytest.fixture
def three(tmp_path: Path) -> Path:
    animations = [("Idle", [spun(0)]), ("Turn", [spun(90)]), ("Turn", [spun(45)]), (None, [spun(10)])]
    return written(tmp_path / "three.gltf", animated(NODES, animations))


def last_degrees(path: Path, animation: str | None) -> float:
    motion = read(path, ReadOptions(animation=animation)).take.motion()
    return float(np.degrees(rot.twist(motion.rotations[-1, 0], "y")))


def test_the_first_is_read_and_the_others_are_named(three: Path) -> None:
    loaded = read(three)
    assert loaded.animations == ("Idle", "Turn", "Turn_2", "4")
    assert loaded.take.animation == "Idle"
    said = [note for note in loaded.notes if "animations" in note]
    assert said == ["4 animations: read 'Idle', not 'Turn', 'Turn_2', '4'; choose with --animation"]


@pytest.mark.parametrize(
    ("animation", "degrees"),
    [("Idle", 0.0), ("Turn", 90.0), ("Turn_2", 45.0), ("4", 10.0), ("1", 0.0), ("2", 90.0), ("3", 45.0)],
)
def test_one_is_chosen_by_its_name_or_its_number(three: Path, animation: str, degrees: float) -> None:
    assert last_degrees(three, animation) == pytest.approx(degrees, abs=1e-4)
    loaded = read(three, ReadOptions(animation=animation))
    assert len(loaded.animations) == 4
    assert not [note for note in loaded.notes if "animations" in note]


@pytest.mark.parametrize("animation", ["turn", "", "0", "5", "-1", "²"])
def test_an_unknown_one_is_refused_with_those_that_are_there(three: Path, animation: str) -> None:
    expected = r"no animation .*; expected 'Idle', 'Turn', 'Turn_2', '4', or a number from 1 to 4"
    with pytest.raises(RequestError, match=expected):
        read(three, ReadOptions(animation=animation))


def test_a_file_without_animations_has_none_to_choose(tmp_path: Path) -> None:
    skin = [{"joints": [0, 1]}]
    path = written(tmp_path / "still.gltf", {"asset": {"version": "2.0"}, "nodes": NODES, "skins": skin})
    loaded = read(path)
    assert (len(loaded.take.motion()), loaded.animations, loaded.take.animation) == (1, (), "")
    with pytest.raises(RequestError, match="no animation 'Walk'; expected none"):
        read(path, ReadOptions(animation="Walk"))


def test_formats_of_one_motion_say_that_a_name_means_nothing(tmp_path: Path) -> None:
    save(mutations.small_motion(), tmp_path / "a.bvh")
    loaded = read(tmp_path / "a.bvh", ReadOptions(animation="Walk"))
    assert "the file holds one motion without a name: read that, not 'Walk'" in loaded.notes
    assert loaded.animations == ()


def test_sparse_keys_are_not_the_frames(three: Path) -> None:
    loaded = read(three, ReadOptions(animation="Turn"))
    motion = loaded.take.motion()
    assert (motion.fps, len(motion)) == (30.0, 31)
    assert "rate not given: 30 frames per second, as keys are only every 1 s" in loaded.notes
    np.testing.assert_allclose(np.degrees(rot.twist(motion.rotations[:, 0], "y")), np.linspace(0, 90, 31), atol=1e-4)


def test_animations_that_stretch_bones_share_one_skeleton(tmp_path: Path) -> None:
    times = [0.0, 0.5, 1.0]
    stretched = [(1, "translation", times, [[0, 1, 0], [0, 1.2, 0], [0, 1, 0]]), spun(20)]
    rounded = [(1, "translation", times, [[0, 1 + 2e-7, 0], [0, 1 - 1e-7, 0], [0, 1, 1e-7]]), spun(10)]
    path = written(
        tmp_path / "a.gltf", animated(NODES, [("stretch", stretched), ("round", rounded), ("turn", [spun(5)])])
    )
    takes = [take for take, _ in read_takes(path, ReadOptions())]
    motions = [take.motion() for take in takes]
    assert [take.name for take in takes] == ["a:stretch", "a:round", "a:turn"]
    for motion in motions:
        np.testing.assert_array_equal(motion.skeleton.offsets, motions[2].skeleton.offsets)
    assert motions[0].bones is not None
    assert motions[0].bones[:, 1, 1].max() == pytest.approx(1.2)
    assert motions[1].bones is None


@pytest.mark.parametrize("suffix", ["glb", "usda"])
def test_the_name_of_an_animation_is_written_and_read(three: Path, tmp_path: Path, suffix: str) -> None:
    if suffix == "usda":
        pytest.importorskip("pxr", reason="usd-core is not installed")
    for animation in ("Turn", "Turn_2"):
        save(read(three, ReadOptions(animation=animation)).take, tmp_path / f"one.{suffix}")
        back = read(tmp_path / f"one.{suffix}")
        assert (back.animations, back.take.animation) == ((animation,), animation)
    named = replace(Take("walk", {"motion": mutations.small_motion()}), animation="Walk | füß 1")
    save(named, tmp_path / f"two.{suffix}")
    assert read(tmp_path / f"two.{suffix}").take.animation == "Walk | füß 1"


USDA = """#usda 1.0
(
    metersPerUnit = 1
    timeCodesPerSecond = 30
    upAxis = "Y"
)
def SkelRoot "Person" {
    def Skeleton "Rig" (%s) {
        uniform token[] joints = ["a", "a/b"]
        uniform matrix4d[] bindTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1)), ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,1,0,1))]
        uniform matrix4d[] restTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1)), ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,1,0,1))]
        %s
    }
    %s
}
"""  # noqa: E501
ANIMATION = """def SkelAnimation "%s" {
        uniform token[] joints = ["a", "a/b"]
        float3[] translations = [(0, 0, 0), (0, 1, 0)]
        half3[] scales = [(1, 1, 1), (1, 1, 1)]
        quatf[] rotations.timeSamples = { 0: [(1, 0, 0, 0), (1, 0, 0, 0)], 30: [(%s, 0, %s, 0), (1, 0, 0, 0)] }
    }
"""


def usd_animation(name: str, degrees: float) -> str:
    _, y, _, w = turned(degrees)
    return ANIMATION % (name, w, y)


@pytest.mark.parametrize("bound", ["Turn", None])
def test_usd_animations_are_chosen_by_name(tmp_path: Path, bound: str | None) -> None:
    pytest.importorskip("pxr", reason="usd-core is not installed")
    path = tmp_path / "a.usda"
    animations = usd_animation("Idle", 0) + usd_animation("Turn", 90)
    relation = f"rel skel:animationSource = </Person/{bound}>" if bound else ""
    path.write_text(USDA % ('prepend apiSchemas = ["SkelBindingAPI"]', relation, animations))
    loaded = read(path)
    # what the skeleton is bound to is the first
    assert loaded.animations == (("Turn", "Idle") if bound else ("Idle", "Turn"))
    assert last_degrees(path, None) == pytest.approx(90 if bound else 0, abs=1e-3)
    assert last_degrees(path, "Turn") == pytest.approx(90, abs=1e-3)
    assert last_degrees(path, "Idle") == pytest.approx(0, abs=1e-3)
    with pytest.raises(RequestError, match=r"a\.usda: no animation 'Run'; expected .*'Turn'"):
        read(path, ReadOptions(animation="Run"))


def test_two_people_of_one_usd_file_are_one_take(tmp_path: Path) -> None:
    pytest.importorskip("pxr", reason="usd-core is not installed")
    motion = mutations.small_motion(20)
    later = replace(motion, translation=motion.translation + 1.0)
    save(Take("pair", {"leader": motion, "follower": later}, animation="Salsa"), tmp_path / "a.usda")
    loaded = read(tmp_path / "a.usda")
    assert (loaded.animations, sorted(loaded.take.tracks)) == (("Salsa",), ["follower", "leader"])
    for name, wanted in (("leader", motion), ("follower", later)):
        np.testing.assert_allclose(joint_positions(loaded.take.motion(name)), joint_positions(wanted), atol=1e-5)


def test_the_case_of_two_animations(data_folder: Path) -> None:
    path = data_folder.parent / "cases" / "two_animations.gltf"
    if not path.is_file():
        pytest.skip("no folder of cases beside the recordings")
    assert last_degrees(path, "Turn") == pytest.approx(90, abs=1e-3)
    assert load(path, animation="Turn").animation == "Turn"
