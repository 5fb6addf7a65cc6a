"""A few hundred damaged files of every kind; `mutations` reads as many as one likes."""

from __future__ import annotations

from pathlib import Path

import mutations
import pytest

from kinetograph.formats import read


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, bytes]]:
    folder = tmp_path_factory.mktemp("good")
    return folder, mutations.good_files(folder)


NAMES = ("small.amc", "skeleton.asf", "path.csv", "markers.c3d", "small.bvh", "small.glb", "small.fbx", "small.npz")
OTHERS = (
    "clip.json",
    "pose.npz",
    "aist.npz",
    "positions.npy",
    "sparse.gltf",
    "two.gltf",
    "avatar.vrm",
    "old_avatar.vrm",
)


SCENES = ("layers.fbx", "text.fbx", "text6.fbx", "binary6.fbx")


@pytest.mark.parametrize("name", [*NAMES, *SCENES, *OTHERS])
def test_damaged_files_are_read_or_refused(good: tuple[Path, dict[str, bytes]], name: str) -> None:
    folder, files = good
    (folder / name).write_bytes(files[name])
    read(folder / name)
    fine, refused, _ = mutations.fuzz(name, files[name], 200, 20041, folder)
    assert fine + refused == 200
    assert refused > 50
