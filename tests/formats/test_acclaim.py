"""Acclaim files: a textbook chain, every frame, and what is refused."""

from __future__ import annotations

from pathlib import Path

import mutations
import numpy as np
import pytest

from kinetograph.errors import FormatError
from kinetograph.formats import ReadOptions, load, read
from kinetograph.kinematics import end_positions, joint_positions

INCH = 0.0254 / 0.45


def files(folder: Path, amc: str = mutations.AMC, asf: str = mutations.ASF) -> Path:
    (folder / "small.asf").write_text(asf)
    (folder / "small_01.amc").write_text(amc)
    return folder / "small_01.amc"


def matrix(axis: str, degrees: float) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    out = np.eye(3)
    out[i, i], out[j, j], out[i, j], out[j, i] = c, c, -s, s
    return out


def test_a_chain_by_hand(tmp_path: Path) -> None:
    # the specification: L = C M C^-1, M of "rx ry rz" is Rz Ry Rx, and C of "axis 0 0 20 XYZ" is a rotation about z
    loaded = read(files(tmp_path))
    motion = loaded.take.motion()
    root = matrix("z", 30) @ matrix("y", 20) @ matrix("x", 10)
    c = matrix("z", 20)
    leg = root @ c @ matrix("z", 7) @ matrix("y", 6) @ matrix("x", 5) @ c.T
    shin = leg @ matrix("x", 10) @ matrix("x", 20) @ matrix("x", 10).T
    start = np.array([1.0, 17, 2])
    knee = start + leg @ [0, -7, 0]
    assert motion.skeleton.names == ("root", "leg", "shin")
    np.testing.assert_allclose(joint_positions(motion)[0] / INCH, [start, start, knee], atol=1e-9)
    np.testing.assert_allclose(end_positions(motion)[0, 0] / INCH, knee + shin @ [0, -6, 0], atol=1e-9)
    assert len(motion) == 2
    assert motion.fps == 120
    assert any("rate not given" in note for note in loaded.notes)


def test_radians_and_another_order(tmp_path: Path) -> None:
    degrees = load(files(tmp_path)).motion()
    words = [line.split() for line in mutations.AMC.splitlines()]
    rows = []
    for row in words:
        angles = {"root": 3, "leg": 0, "shin": 0}.get(row[0])
        scaled = [repr(float(np.radians(float(v)))) for v in row[1:][angles:]] if angles is not None else []
        rows.append(" ".join([*row[: 1 + (angles or 0)], *scaled]))
    asf = mutations.ASF.replace("angle deg", "angle rad").replace("0 0 20 XYZ", f"0 0 {np.radians(20)} XYZ")
    asf = asf.replace("10 0 0 XYZ", f"{np.radians(10)} 0 0 XYZ")
    (tmp_path / "other").mkdir()
    radians = load(files(tmp_path / "other", "\n".join(rows), asf)).motion()
    np.testing.assert_allclose(radians.rotations, degrees.rotations, atol=1e-12)


def test_bones_that_move_and_stretch(tmp_path: Path) -> None:
    asf = mutations.ASF.replace("dof rx ry rz", "dof rx ry rz l").replace("dof rx\n", "dof tx tz rx\n")
    amc = mutations.AMC.replace("leg 5 6 7", "leg 5 6 7 0.5").replace("leg 5.5 6.5 7.5", "leg 5.5 6.5 7.5 -1")
    amc = amc.replace("shin 20", "shin 0.2 0.3 20").replace("shin 25", "shin 0 0 25")
    loaded = read(files(tmp_path, amc, asf))
    root = matrix("z", 30) @ matrix("y", 20) @ matrix("x", 10)
    c = matrix("z", 20)
    leg = root @ c @ matrix("z", 7) @ matrix("y", 6) @ matrix("x", 5) @ c.T
    own = matrix("x", 10)  # of the shin's axes
    knee = np.array([1.0, 17, 2]) + leg @ ([0, -7.5, 0] + own @ [0.2, 0, 0.3])
    motion = loaded.take.motion()
    np.testing.assert_allclose(joint_positions(motion)[0, 2] / INCH, knee, atol=1e-9)
    lengths = np.linalg.norm(np.diff(joint_positions(motion)[:, 1:], axis=1)[:, 0], axis=1) / INCH
    assert lengths[1] == pytest.approx(6.0)
    assert any("change their length: both are kept" in note for note in loaded.notes)


def test_the_skeleton_alone_is_its_rest_pose(tmp_path: Path) -> None:
    motion = load(files(tmp_path).with_name("small.asf")).motion()
    np.testing.assert_allclose(joint_positions(motion)[0, 2], [0, -7 * INCH, 0], atol=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("shin 20\n", "", r"frame 2 has other bones than the first one"),
        ("shin 20", "shin 20 1", r"small_01\.amc:6: expected 1 numbers after 'shin', found 2"),
        ("leg 5 6 7", "leg 5 six 7", r"expected numbers after 'leg', found '5 six 7'"),
        ("leg 5 6 7", "arm 5 6 7", r"expected a bone of the skeleton, found 'arm'"),
        ("shin 25\n", "", r"frame 2 has other bones than the first one; is the file cut short"),
        ("leg 5 6 7", "leg 5 6 nan", r"expected finite numbers after 'leg'"),
    ],
)
def test_damaged_motions_say_where(tmp_path: Path, old: str, new: str, expected: str) -> None:
    path = files(tmp_path, mutations.AMC.replace(old, new))
    with pytest.raises(FormatError, match=expected):
        load(path)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("leg shin", "leg leg", "bone 'leg' has two parents"),
        ("root leg\n    leg shin", "leg shin\n    shin leg", "form a ring or have no parent"),
        ("axis 10 0 0 XYZ", "axis 10 0 0 XYX", "expected an order of axes such as XYZ, found 'xyx'"),
        ("length 6", "length six", "expected a finite number, found 'six'"),
        (":hierarchy", ":tree", "expected the sections :bonedata and :hierarchy"),
        ("dof rx\n", "dof rq\n", "expected degrees of freedom"),
    ],
)
def test_damaged_skeletons_say_what(tmp_path: Path, old: str, new: str, expected: str) -> None:
    with pytest.raises(FormatError, match=expected):
        load(files(tmp_path, asf=mutations.ASF.replace(old, new)))


def amc(frames: int, damage: dict[int, tuple[str, str]]) -> str:
    """Frames whose root moves by 1 each, some with text replaced."""
    head, _, rest = mutations.AMC.partition("1\nroot")
    block = "root" + rest.split("2\n", 1)[0]
    text = head
    for number in range(1, frames + 1):
        one = f"{number}\n" + block.replace("root 1 ", f"root {number} ")
        text += one.replace(*damage[number]) if number in damage else one
    return text


DAMAGE = {
    "a bone is missing": ("shin 20\n", ""),
    "a bone is another's": ("shin 20", "tail 20"),
    "a bone is there twice": ("shin 20", "shin 20\nshin 20"),
    "a word": ("leg 5 6 7", "leg 5 six 7"),
    "not finite": ("leg 5 6 7", "leg 5 nan 7"),
    "one number more": ("leg 5 6 7", "leg 5 6 7 8"),
    "one number fewer": ("leg 5 6 7", "leg 5 6"),
    "a root of three numbers": (" 17 2 10 20 30", " 17 2"),
    "three angles for one": ("shin 20", "shin 20 0 0"),
    "bytes of another file": ("leg 5 6 7", "l\xffg\0 \x7f"),
}


@pytest.mark.parametrize("at", [1, 2, 4, 5])
@pytest.mark.parametrize("case", DAMAGE)
def test_lenient_takes_the_frames_that_are_whole(tmp_path: Path, case: str, at: int) -> None:
    path = files(tmp_path, amc(5, {at: DAMAGE[case]}))
    with pytest.raises(FormatError):
        read(path)
    loaded = read(path, ReadOptions(lenient=True, units="metre"))
    motion = loaded.take.motion()
    expected = {1: [2, 3, 4, 5], 2: [1, 1, 3, 4, 5], 4: [1, 2, 3, 3, 5], 5: [1, 2, 3, 4]}[at]
    assert motion.translation[:, 0].round(9).tolist() == expected
    assert np.ptp(motion.rotations, axis=0).max() < 1e-12  # those of one frame are those of all
    assert any("took the 4 whole frames" in note for note in loaded.notes)


def test_lenient_says_what_is_left_out_and_where(tmp_path: Path) -> None:
    path = files(tmp_path, amc(6, {2: DAMAGE["a word"], 3: DAMAGE["not finite"], 6: DAMAGE["a bone is missing"]}))
    notes = read(path, ReadOptions(lenient=True)).notes
    assert any(
        "line 9: expected numbers after 'leg', found '5 six 7': took the 3 whole frames, 2 repeat the frame"
        " before, 1 at an end are left out" in note
        for note in notes
    )


def test_lenient_refuses_where_no_frame_is_whole_and_where_fewer_than_half_are(tmp_path: Path) -> None:
    path = files(tmp_path, amc(3, dict.fromkeys((1, 2, 3), DAMAGE["a word"])))
    with pytest.raises(FormatError, match=r"small_01\.amc:5: expected numbers after 'leg'"):
        read(path, ReadOptions(lenient=True))
    path.write_text(amc(6, dict.fromkeys((2, 3, 4, 5), DAMAGE["a word"])))
    with pytest.raises(FormatError, match=r"4 frames are damaged and 2 whole; line \d+: .*'5 six 7'"):
        read(path, ReadOptions(lenient=True))


def test_a_frame_with_fewer_bones_in_the_middle_is_refused(tmp_path: Path) -> None:
    path = files(tmp_path, amc(3, {2: DAMAGE["a bone is missing"]}))
    with pytest.raises(FormatError, match="frame 2 has other bones than the first one"):
        read(path)


def test_damaged_files_are_read_leniently_or_refused(tmp_path: Path) -> None:
    path = files(tmp_path, "")
    rng = np.random.default_rng(13)
    good, some, one_line = amc(8, {}).encode(), 0, True
    for _ in range(300):
        path.write_bytes(mutations.mutate(good, rng))
        try:
            some += 0 < len(read(path, ReadOptions(lenient=True)).take.motion()) <= 12
        except FormatError as error:
            one_line = one_line and "\n" not in str(error)
    assert some > 150
    assert one_line


def test_damaged_skeletons_are_read_or_refused(tmp_path: Path) -> None:
    path = files(tmp_path)
    asf = path.with_name("small.asf")
    rng, one_line = np.random.default_rng(14), True
    for _ in range(300):
        asf.write_bytes(mutations.mutate(mutations.ASF.encode(), rng))
        for each in (asf, path):
            try:
                assert len(read(each, ReadOptions(lenient=True)).take.motion()) > 0
            except FormatError as error:
                one_line = one_line and "\n" not in str(error)
    assert one_line


def test_a_missing_skeleton_is_named(tmp_path: Path) -> None:
    path = files(tmp_path)
    path.with_name("small.asf").unlink()
    with pytest.raises(FormatError, match=r"expected its skeleton small_01\.asf in its folder, found 0 others"):
        load(path)
    path.with_name("elsewhere").mkdir()
    (tmp_path / "elsewhere" / "x.asf").write_text(mutations.ASF)
    assert len(read(path, ReadOptions(skeleton=tmp_path / "elsewhere" / "x.asf")).take.motion()) == 2


def test_every_frame_of_the_recordings_is_read(data_folder: Path) -> None:
    for path in sorted((data_folder / "acclaim").glob("*.amc"))[:4]:
        frames = sum(line.strip().isdigit() for line in path.read_text().splitlines())
        motion = load(path).motion()
        assert len(motion) == frames
        assert 1.4 < motion.skeleton.height < 2.0
