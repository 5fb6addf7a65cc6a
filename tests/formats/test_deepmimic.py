"""DeepMimic files against hand-computed poses, and complaints that name the frame."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.errors import FormatError
from kinetograph.formats import load, read
from kinetograph.formats.deepmimic import skeleton
from kinetograph.formats.options import ReadOptions
from kinetograph.kinematics import joint_positions, landmark_positions, role_positions
from kinetograph.skeleton import Landmark

_KNEE = 20  # column of the right knee's angle
_WIDTHS = (4, 4, 4, 1, 4, 4, 1, 4, 1, 4, 4, 1)


def _row(dt: float = 1 / 30, root: tuple[float, float, float] = (0.0, 0.9, 0.0)) -> list[Any]:
    row: list[Any] = [dt, *root, 1.0, 0.0, 0.0, 0.0]
    for width in _WIDTHS:
        row += [1.0, 0.0, 0.0, 0.0] if width == 4 else [0.0]
    return row


def _write(path: Path, frames: object, loop: str = "none") -> Path:
    path.write_text(json.dumps({"Loop": loop, "Frames": frames}))
    return path


def test_the_rest_pose_stands_facing_x_with_its_right_at_plus_z(tmp_path: Path) -> None:
    motion = load(_write(tmp_path / "rest.txt", [_row(), _row()])).motion()
    roles = ["right_hip", "right_foot", "right_toe", "right_shoulder", "right_hand", "head"]
    expected = [
        [0, 0.9, 0.084887],
        [0, 0.9 - 0.421546 - 0.409870, 0.084887],
        [0.1335, 0.9 - 0.421546 - 0.409870 - 0.05, 0.084887],
        [-0.02405, 0.9 + 0.236151 + 0.24350, 0.18311],
        [-0.02405, 0.9 + 0.236151 + 0.24350 - 0.274788 - 0.258947, 0.18311],
        [0, 0.9 + 0.236151 + 0.223894 + 0.275, 0],
    ]
    np.testing.assert_allclose(role_positions(motion, roles)[0], expected, atol=1e-12)


def test_a_hinge_turns_about_z_and_a_negative_knee_bends_the_shank_back(tmp_path: Path) -> None:
    row = _row()
    row[_KNEE] = -np.pi / 2
    motion = load(_write(tmp_path / "knee.txt", [row, row])).motion()
    knee, foot = role_positions(motion, ["right_knee", "right_foot"])[0]
    np.testing.assert_allclose(foot - knee, [-0.409870, 0, 0], atol=1e-12)


def test_every_joint_reads_its_own_columns(tmp_path: Path) -> None:
    row, start, rotations = _row(), 4, {}
    names = [name for name in skeleton().names if not name.endswith("wrist")]
    for i, (name, width) in enumerate(zip(names, (4, *_WIDTHS), strict=True)):
        rotations[name] = rot.about("z" if width == 1 else "x", 0.1 * (i + 1))
        row[start : start + width] = rotations[name].tolist() if width == 4 else [0.1 * (i + 1)]
        start += width
    motion = load(_write(tmp_path / "all.txt", [row])).motion()
    for name, rotation in rotations.items():
        np.testing.assert_allclose(motion.rotations[0, motion.skeleton.index(name)], rotation, atol=1e-12)
    assert motion.rotations[0, motion.skeleton.index("left_wrist")].tolist() == [1, 0, 0, 0]


def test_rates_written_with_few_digits_are_whole(tmp_path: Path) -> None:
    rates = {0.016666: 60.0, 0.0333333015: 30.0, 0.041667: 24.0, 0.0083330004: 120.0, 0.0123: 1 / 0.0123}
    for step, fps in rates.items():
        assert load(_write(tmp_path / "a.txt", [_row(step), _row(step), _row(0)])).motion().fps == fps


def test_a_given_rate_replaces_that_of_the_file(tmp_path: Path) -> None:
    path = _write(tmp_path / "a.txt", [_row(0.5), _row(0.25), _row(0)])
    assert load(path, fps=10).motion().fps == 10
    assert len(load(path, fps=10).motion()) == 3


def test_uneven_rows_are_resampled_to_their_usual_rate(tmp_path: Path) -> None:
    frames = [_row(0.1, (x, 0.9, 0)) for x in (0, 1, 2, 4, 5)]
    frames[2][0] = 0.2
    frames[-1][0] = 0.0
    loaded = read(_write(tmp_path / "uneven.txt", frames))
    motion = loaded.take.motion()
    assert motion.fps == 10
    np.testing.assert_allclose(motion.translation[:, 0], [0, 1, 2, 3, 4, 5], atol=1e-9)
    assert "resampled to 10 frames per second" in loaded.notes[0]


def test_quaternions_come_out_unit_long_and_without_flips(tmp_path: Path) -> None:
    frames = [_row(), _row(), _row()]
    frames[1][4:8] = [-0.7 * np.cos(0.1), -0.7 * np.sin(0.1), 0, 0]
    rotations = load(_write(tmp_path / "flip.txt", frames)).motion().rotations[:, 0]
    np.testing.assert_allclose(np.linalg.norm(rotations, axis=-1), 1, atol=1e-12)
    assert (np.sum(rotations[1:] * rotations[:-1], axis=-1) > 0.9).all()


def test_a_loop_is_annotated_over_the_whole_clip(tmp_path: Path) -> None:
    take = load(_write(tmp_path / "loop.txt", [_row(0.1)] * 11, loop="wrap"))
    (note,) = take.annotated("motion", "loop")
    assert (note.label, note.start, note.stop) == ("wrap", 0.0, take.duration)
    assert not load(_write(tmp_path / "once.txt", [_row()] * 3)).annotations


def _broken(column: int, value: object) -> list[list[Any]]:
    frames = [_row(), _row(), _row()]
    frames[1][column] = value
    return frames


@pytest.mark.parametrize(
    ("frames", "message"),
    [
        ([_row()[:20]] * 3, r"expected 44 numbers in frame 0, found 20 numbers; .*another character"),
        ([_row(), _row()[:43]], r"expected 44 numbers in frame 1, found 43 numbers"),
        ([_row(), 7], r"expected 44 numbers in frame 1, found 7"),
        (_broken(3, float("nan")), r"expected a finite number in frame 1, column 3, found NaN"),
        (_broken(3, float("inf")), r"expected a finite number in frame 1, column 3, found Infinity"),
        (_broken(3, 10**400), r"expected a finite number in frame 1, column 3"),
        (_broken(3, "left"), r'expected a finite number in frame 1, column 3, found "left"'),
        (_broken(3, True), r"expected a finite number in frame 1, column 3, found true"),
        (_broken(0, 0.0), r"expected positive seconds to the next frame in frame 1, found 0"),
        (_broken(4, 0.0), r"expected a unit quaternion in frame 1, joint root, found length 0"),
        ([_row(0.0)], r"expected positive seconds per frame, found 0 in frame 0; give the rate with --fps"),
        ([], r"expected at least one frame, found none"),
        (None, r'expected a DeepMimic object with a list "Frames", found the keys Loop, Frames'),
    ],
)
def test_complaints_name_the_frame(tmp_path: Path, frames: object, message: str) -> None:
    path = _write(tmp_path / "bad.txt", frames)
    with pytest.raises(FormatError, match=message) as caught:
        load(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["", "1 2 3\n4 5 6\n", '{"Frames": [[1, 2', "[1, 2]", "[" * 100_000, "\udcff\udcfe"])
def test_what_is_not_deepmimic_is_said_so_in_one_line(tmp_path: Path, text: str) -> None:
    path = tmp_path / "other.txt"
    path.write_text(text, encoding="utf-8", errors="surrogateescape")
    with pytest.raises(FormatError, match=r"expected (a )?DeepMimic") as caught:
        load(path)
    assert "\n" not in str(caught.value)


def test_lenient_reading_ends_before_the_first_wrong_frame(tmp_path: Path) -> None:
    frames = [_row(), _row(), _row()[:9], _row()]
    loaded = read(_write(tmp_path / "cut.txt", frames, loop="wrap"), ReadOptions(lenient=True))
    assert len(loaded.take.motion()) == 2
    assert not loaded.take.annotations
    assert "left out frames 2 to 3" in loaded.notes[0]


def test_units_that_the_format_does_not_have_are_noted(tmp_path: Path) -> None:
    loaded = read(_write(tmp_path / "a.txt", [_row()] * 2), ReadOptions(units="inch"))
    assert loaded.take.motion().translation[0, 1] == 0.9
    assert "metres with Y up" in loaded.notes[0]


def _soles() -> list[Landmark]:
    body = skeleton()
    return [
        Landmark(body.index(f"{side}_ankle"), np.array([x, -0.05, z]))
        for side in ("left", "right")
        for x in (-0.045, 0.1335)
        for z in (-0.045, 0.045)
    ]


@pytest.mark.parametrize("name", ["humanoid3d_walk", "humanoid3d_run", "humanoid3d_dance_b", "humanoid3d_backflip"])
def test_real_clips_stand_on_the_floor_and_close_their_loops(clips_folder: Path, name: str) -> None:
    (path,) = clips_folder.rglob(f"{name}.txt")
    take = load(path)
    motion = take.motion()
    lowest = landmark_positions(motion, _soles())[..., 1].min(axis=1)
    assert abs(np.median(lowest)) < 0.02
    assert joint_positions(motion)[..., 1].max() < 2.2
    assert take.annotated("motion", "loop")
    # the last frame is the first pose a cycle later: at the same height, and its pose within some degrees
    assert motion.translation[-1, 1] == pytest.approx(motion.translation[0, 1], abs=1e-9)
    assert rot.angle_between(motion.rotations[0, 1:], motion.rotations[-1, 1:]).max() < np.radians(30)


def test_another_character_is_refused(clips_folder: Path) -> None:
    dogs = list(clips_folder.rglob("laikago_walk.txt"))
    if not dogs:
        pytest.skip("no laikago_walk.txt in the sample")
    with pytest.raises(FormatError, match="this is another character"):
        load(dogs[0])


def test_long_walks_are_read_whole(data_folder: Path) -> None:
    motion = load(data_folder / "walks" / "humanoid3d_long_walk1.txt").motion()
    assert motion.fps == 120
    assert motion.duration == pytest.approx(32.8, abs=0.1)
    knees = role_positions(motion, ["left_hip", "left_knee", "left_foot"])
    middle = (knees[:, 0] + knees[:, 2]) / 2
    forward = rot.rotate(motion.rotations[:, 0], np.array([1.0, 0, 0]))
    assert np.sum((knees[:, 1] - middle) * forward, axis=-1).mean() > 0.01
