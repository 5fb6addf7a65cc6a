"""SMPL poses in other spellings: every form of one walk is the same walk, and what a file lacks is asked for."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats import ReadOptions, load, read
from kinetograph.formats.smpl import average_body
from kinetograph.kinematics import joint_positions
from kinetograph.motion import Motion

_FRAMES, _FPS = 90, 30.0
_ANKLES = (7, 8)


def walk() -> tuple[FloatArray, FloatArray]:
    """Rotation vectors ``(F, 24, 3)`` and translations ``(F, 3)``, Y up, of someone whose lower foot does not move."""
    phase = 2 * np.pi * 0.9 * np.arange(_FRAMES) / _FPS
    poses = np.zeros((_FRAMES, 24, 3))
    for side, shift in ((1, 0.0), (2, np.pi)):
        poses[:, side, 0] = 0.45 * np.sin(phase + shift)
        poses[:, side + 3, 0] = 0.3 + 0.3 * np.sin(phase + shift + 1.0)  # knees
        poses[:, 15 + side, 2] = -1.2 if side == 1 else 1.2
    poses[:, 0, 1] = 0.3
    body = average_body()
    still = Motion(body, np.zeros((_FRAMES, 3)), rot.exp(poses[:, :22]), _FPS)
    feet = joint_positions(still)[:, _ANKLES]
    steps = np.diff(feet, axis=0)
    planted = np.argmin(feet[:-1, :, 1] + feet[1:, :, 1], axis=1)
    path = np.concatenate([np.zeros((1, 3)), -np.cumsum(steps[np.arange(_FRAMES - 1), planted], axis=0)])
    return poses, path + np.array([0.4, 0.9 - path[:, 1].mean(), -0.7])


def expected() -> FloatArray:
    poses, path = walk()
    return joint_positions(Motion(average_body(), path, rot.exp(poses[:, :22]), _FPS))


def matrices(vectors: FloatArray) -> FloatArray:
    return Rotation.from_rotvec(vectors.reshape(-1, 3)).as_matrix().reshape(*vectors.shape[:-1], 3, 3)


def columns(vectors: FloatArray) -> FloatArray:
    m = matrices(vectors)
    return np.concatenate([m[..., :, 0], m[..., :, 1]], axis=-1)


_FORMS: dict[str, Callable[[FloatArray, FloatArray], dict[str, np.ndarray]]] = {
    "72": lambda p, t: {"poses": p.reshape(_FRAMES, 72), "trans": t},
    "66": lambda p, t: {"pose": p[:, :22].reshape(_FRAMES, 66), "transl": t},
    "smpl-h": lambda p, t: {"fullpose": np.pad(p.reshape(_FRAMES, 72)[:, :66], ((0, 0), (0, 90))), "trans": t},
    "smpl-x": lambda p, t: {"poses": np.pad(p.reshape(_FRAMES, 72)[:, :66], ((0, 0), (0, 99))), "trans": t},
    "joints": lambda p, t: {"poses": p, "root_translation": t},
    "batch": lambda p, t: {"poses": p.reshape(1, _FRAMES, 72), "trans": t[None]},
    "matrices": lambda p, t: {"poses": matrices(p), "trans": t},
    "flat matrices": lambda p, t: {"poses": matrices(p).reshape(_FRAMES, -1), "trans": t},
    "two arrays": lambda p, t: {"global_orient": p[:, 0], "body_pose": p[:, 1:].reshape(_FRAMES, 69), "transl": t},
    "two of SMPL-X": lambda p, t: {"root_orient": p[:, 0], "pose_body": p[:, 1:22].reshape(_FRAMES, 63), "trans": t},
    "two of matrices": lambda p, t: {"global_orient": matrices(p[:, :1]), "body_pose": matrices(p[:, 1:]), "transl": t},
    "columns": lambda p, t: {"poses": columns(p), "trans": t},
    "flat columns": lambda p, t: {"poses": columns(p[:, :22]).reshape(_FRAMES, -1), "trans": t},
    "side by side": lambda p, t: {"poses": matrices(p)[..., :2].reshape(_FRAMES, 24, 6), "trans": t},
    "rows": lambda p, t: {"poses": matrices(p)[..., :2, :].reshape(_FRAMES, 24, 6), "trans": t},
    "centimetres": lambda p, t: {"poses": p, "trans": 100 * t},
    "millimetres": lambda p, t: {"poses": p, "trans": 1000 * t},
}


def saved(folder: Path, arrays: dict[str, np.ndarray]) -> Path:
    np.savez(folder / "a.npz", **arrays)
    return folder / "a.npz"


@pytest.mark.parametrize("form", list(_FORMS))
def test_every_form_of_a_walk_is_the_walk(form: str, tmp_path: Path) -> None:
    loaded = read(saved(tmp_path, _FORMS[form](*walk())), ReadOptions(fps=_FPS))
    motion = loaded.take.motion()
    assert motion.fps == _FPS
    np.testing.assert_allclose(joint_positions(motion), expected(), atol=1e-6)
    assert any("guessed y" in note for note in loaded.notes)
    assert any("units of the translation" in note for note in loaded.notes) == form.endswith("metres")


def test_the_keys_of_aist_are_60_frames_per_second_in_centimetres(tmp_path: Path) -> None:
    poses, path = walk()
    body = joint_positions(Motion(average_body(), np.zeros((_FRAMES, 3)), rot.exp(poses[:, :22]), _FPS))
    keys = {"smpl_poses": poses.reshape(_FRAMES, 72), "smpl_trans": 93.0 * path, "smpl_scaling": np.array([93.0])}
    loaded = read(saved(tmp_path, keys))
    motion = loaded.take.motion()
    assert motion.fps == 60.0
    np.testing.assert_allclose(joint_positions(motion), 0.93 * (body + path[:, None]), atol=1e-6)
    for word in ("60 frames per second", "0.93 times its size", "guessed centimetre", "y, as in AIST"):
        assert any(word in note for note in loaded.notes), word
    assert load(tmp_path / "a.npz", fps=30.0).motion().fps == 30.0


def test_units_given_are_those_of_the_translation(tmp_path: Path) -> None:
    poses, path = walk()
    given = read(saved(tmp_path, {"poses": poses, "trans": path}), ReadOptions(units="inch", fps=_FPS)).take.motion()
    np.testing.assert_allclose(given.translation, 0.0254 * path, atol=1e-9)
    np.testing.assert_allclose(given.skeleton.offsets[1:], average_body().offsets[1:])


def test_a_body_that_does_not_step_keeps_metres_or_what_puts_it_near(tmp_path: Path) -> None:
    still = np.zeros((20, 72))
    for factor in (1.0, 100.0, 1000.0):
        arrays = {"poses": still, "trans": np.tile([0.1, 0.95 * factor, 0.0], (20, 1))}
        motion = read(saved(tmp_path, arrays), ReadOptions(fps=30, up="y")).take.motion()
        assert motion.translation[0, 1] == pytest.approx(0.95)
    nothing = read(saved(tmp_path, {"poses": still, "trans": np.zeros((20, 3))}), ReadOptions(fps=30, up="y"))
    assert not any("units of the translation" in note for note in nothing.notes)


def test_a_body_in_the_axes_of_a_camera_is_stood_up(tmp_path: Path) -> None:
    poses, path = walk()
    over = rot.about("x", np.pi)
    poses[:, 0] = rot.log(rot.multiply(over, rot.exp(poses[:, 0])))
    arrays = {"poses": poses, "trans": rot.rotate(over, path)}
    loaded = read(saved(tmp_path, arrays), ReadOptions(fps=_FPS))
    np.testing.assert_allclose(joint_positions(loaded.take.motion()), expected(), atol=1e-6)
    assert any("upside down" in note for note in loaded.notes)


def test_what_is_not_in_the_file_is_asked_for_or_noted(tmp_path: Path) -> None:
    poses, path = walk()
    with pytest.raises(FormatError, match=r"gives no rate \(mocap_framerate\); give it with --fps"):
        load(saved(tmp_path, {"poses": poses, "trans": path}))
    loaded = read(saved(tmp_path, {"body_pose": poses[:, 1:22].reshape(_FRAMES, 63)}), ReadOptions(fps=_FPS))
    for word in ("no orientation of the body", "no translation", "average body"):
        assert any(word in note for note in loaded.notes), word


@pytest.mark.parametrize(
    ("arrays", "expected"),
    [
        ({"poses": np.zeros((2, 9, 72))}, "expected one recording in poses, found 2"),
        ({"poses": np.full((4, 24, 3, 3), 0.5)}, r"expected poses as rotation vectors .* found \(4, 24, 3, 3\)"),
        ({"poses": np.zeros((4, 24, 6))}, "six numbers per joint, found"),
        ({"poses": np.zeros((4, 63)), "global_orient": np.zeros((3, 3))}, "expected global_orient of 4 frames"),
        ({"poses": np.zeros((4, 72)), "trans": np.zeros((4, 2))}, r"expected trans \(4, 3\), found \(4, 2\)"),
        ({"poses": np.zeros((4, 72)), "smpl_scaling": np.zeros(2)}, "expected one positive number as smpl_scaling"),
        ({"poses": np.zeros(72)}, "expected rows of poses"),
        ({"poses": np.full((4, 72), np.inf)}, "expected finite numbers"),
        ({"betas": np.zeros(10)}, "expected poses"),
    ],
)
def test_odd_arrays_are_refused_in_a_line(arrays: dict[str, np.ndarray], expected: str, tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=expected) as caught:
        read(saved(tmp_path, arrays), ReadOptions(fps=30))
    assert "\n" not in str(caught.value)


def test_pickles_are_refused_and_the_remedy_is_said(tmp_path: Path) -> None:
    for suffix in (".pkl", ".pt"):
        with pytest.raises(RequestError, match=r"pickled objects, which can run programs, .* numpy\.savez"):
            load(tmp_path / f"a{suffix}")
    buffer = io.BytesIO()
    np.savez(buffer, poses=np.array([{"a": 1}], dtype=object))
    (tmp_path / "a.npz").write_bytes(buffer.getvalue())
    with pytest.raises(FormatError, match="pickled objects, which can run programs"):
        load(tmp_path / "a.npz")
