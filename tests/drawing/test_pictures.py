"""Contact sheets and strobe pictures: they exist, fit, are not blank, and show what they were given."""

from __future__ import annotations

import gc
import weakref
from pathlib import Path

import numpy as np
import pytest

from kinetograph import rotations as rot
from kinetograph.drawing import contact_sheet, strobe
from kinetograph.drawing.figures import cast_at, set_stage
from kinetograph.drawing.views import course, view_along
from kinetograph.errors import RequestError
from kinetograph.formats import load
from kinetograph.kinematics import joint_positions
from kinetograph.motion import Motion, cut, place
from kinetograph.signal import Signal
from kinetograph.skeleton import Landmark, Skeleton
from kinetograph.take import Annotation, Take

BLUE, VERMILION, GREEN, SEAM, PALE = (0, 114, 178), (213, 94, 0), (0, 158, 115), (194, 24, 91), (243, 201, 105)


def person() -> Skeleton:
    names = ("hips", "chest", "head", "l_hip", "l_knee", "l_foot", "r_hip", "r_knee", "r_foot")
    parents = np.array([-1, 0, 1, 0, 3, 4, 0, 6, 7])
    leg = [(0, -0.42, 0), (0, -0.42, 0)]
    offsets = np.array([(0, 0, 0), (0, 0.25, 0), (0, 0.3, 0), (0.09, 0, 0), *leg, (-0.09, 0, 0), *leg])
    roles = {"hips": Landmark(0), "chest": Landmark(1), "head": Landmark(2)}
    for first, side in ((3, "left"), (6, "right")):
        roles |= {f"{side}_{part}": Landmark(first + k) for k, part in enumerate(("hip", "knee", "foot"))}
    return Skeleton(names, parents, offsets, roles=roles)


def walk(seconds: float = 3.0, fps: float = 30.0, skeleton: Skeleton | None = None) -> Motion:
    """A stiff walk along +z at 1.2 m/s."""
    skeleton = skeleton or person()
    t = np.arange(round(seconds * fps) + 1) / fps
    rotations = rot.identity(len(t), len(skeleton))
    if len(skeleton) > 6:
        rotations[:, 3], rotations[:, 6] = (rot.about("x", s * 0.5 * np.sin(2 * np.pi * t)) for s in (1, -1))
    path = np.stack([0 * t, 0.86 + 0 * t, 1.2 * t], axis=-1)
    return Motion(skeleton, path, rotations, fps)


def lone(frames: int) -> Motion:
    return Motion(
        Skeleton(("only",), np.array([-1]), np.zeros((1, 3))), np.zeros((frames, 3)), rot.identity(frames, 1), 30
    )


def lying() -> Motion:
    motion = walk(0.5)
    rotations = motion.rotations.copy()
    rotations[:, 0] = rot.multiply(rot.about("z", np.pi / 2), rotations[:, 0])
    return Motion(motion.skeleton, motion.translation * (1, 0.1, 0), rotations, motion.fps)


def bare() -> Skeleton:
    skeleton = person()
    return Skeleton(skeleton.names, skeleton.parents, skeleton.offsets)


CASES: dict[str, Motion | list[Motion]] = {
    "walk": walk(),
    "no roles": walk(skeleton=bare()),
    "one frame": cut(walk(), 10, 11),
    "two frames": cut(walk(), 10, 12),
    "lone joint": lone(20),
    "lone joint, one frame": lone(1),
    "lying": lying(),
    "far below the floor": place(walk(), 0.0, (0.0, -40.0, 0.0)),
    "two characters": [walk(), place(walk(2.0, 60.0), np.pi, (0.6, 0.0, 2.0))],
}


def pixels(path: Path) -> np.ndarray:
    from matplotlib.image import imread

    assert path.read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
    return np.round(imread(path)[..., :3] * 255).astype(int)


def ink(image: np.ndarray) -> float:
    """Share of the pixels that are not white."""
    return float(np.mean(image.min(axis=-1) < 250))


def share(image: np.ndarray, colour: tuple[int, int, int]) -> float:
    """Share of the pixels of a colour, faded by up to two thirds."""
    ink, full = (255 - image.reshape(-1, 3)).astype(float), 255 - np.array(colour, dtype=float)
    amount = ink @ full / (full @ full)
    return float(np.mean((amount > 0.33) & (np.abs(ink - amount[:, None] * full).max(axis=-1) < 12)))


@pytest.mark.parametrize("case", CASES)
def test_a_contact_sheet_has_ink_in_each_panel(case: str, tmp_path: Path) -> None:
    contact_sheet(CASES[case], tmp_path / "sheet.png")
    image = pixels(tmp_path / "sheet.png")
    height, width = image.shape[:2]
    assert width == 1760
    assert 700 < height < 3500
    grid, below = image[80 : height - 560], image[height - 520 :]
    assert np.mean(grid.min(axis=-1) < 215) > 0.005  # darker than the floor
    assert len(np.unique(grid @ np.array([65536, 256, 1]))) > 20
    assert ink(below[:, : width * 2 // 5]) > 0.005
    assert ink(below[:, width * 2 // 5 :]) > 0.005
    # nothing is cut off: the sheet keeps a white rim
    assert image[:, :3].min() == 255
    assert image[:, -3:].min() == 255


@pytest.mark.parametrize("case", CASES)
def test_a_strobe_picture_is_a_strip_with_whole_figures(case: str, tmp_path: Path) -> None:
    strobe(CASES[case], tmp_path / "strip.png", title="strip")
    image = pixels(tmp_path / "strip.png")
    height, width = image.shape[:2]
    assert width == 1760
    assert height < 900
    assert 0.01 < ink(image) < 0.8
    assert np.mean(image.min(axis=-1) < 215) > 0.01  # darker than the floor
    assert np.ptp(image[:, :3], axis=-1).max() == 0  # the rim has only the grey lines of the floor on white
    assert image[:, :3].min() >= 221


def test_left_and_right_a_second_character_the_path_and_seams_have_their_colours(tmp_path: Path) -> None:
    path = Signal(walk().translation[:, None] + (0.1, 0, 0), ("path",), "m", 30.0)
    contact_sheet(walk(), tmp_path / "plain.png")
    contact_sheet(walk(), tmp_path / "full.png", path_signal=path, seams=(1.0, 2.0))
    contact_sheet(CASES["two characters"], tmp_path / "pair.png")
    plain, full, pair = (pixels(tmp_path / f"{name}.png") for name in ("plain", "full", "pair"))
    assert min(share(plain, BLUE), share(plain, VERMILION)) > 1e-4
    for colour, picture in ((SEAM, full), (PALE, full), (GREEN, pair)):
        assert share(picture, colour) > 10 * share(plain, colour) + 1e-4


def test_contacts_are_bars_and_dots(tmp_path: Path) -> None:
    notes = [
        Annotation("motion", "contact", "left_foot", 0.0, 1.0),
        Annotation("motion", "contact", "no such role", 1.0, 2.0),
        Annotation("motion", "move", "right_foot", 0.0, 3.0),
    ]
    stage = set_stage(walk(), notes)
    cast = cast_at(stage, np.array([0.5, 2.5]))
    assert [len(dots) for dots in cast.planted] == [1, 0]
    foot = joint_positions(walk())[15, 5]
    assert np.allclose(cast.planted[0][0], foot)
    contact_sheet(walk(), tmp_path / "sheet.png", contacts=notes)
    contact_sheet(Take("t", {"motion": walk()}, tuple(notes)), tmp_path / "take.png")
    assert np.array_equal(pixels(tmp_path / "sheet.png"), pixels(tmp_path / "take.png"))


def test_the_projection_keeps_lengths_across_the_picture_and_right_is_right() -> None:
    view = view_along(np.asarray(0.0), np.deg2rad(12))  # +z to the right
    assert np.allclose(view.project(np.array([0.0, 0.0, 1.0])), [1, 0, 0])
    frame = np.stack([view.right, view.up, view.near])
    assert np.allclose(frame @ frame.T, np.eye(3))
    assert np.linalg.det(frame) == pytest.approx(1.0)
    # a walker who comes along +z is seen from its right, so that the right hip is the nearer one
    hips = joint_positions(walk())[0, [3, 6]]
    left, right = view.project(hips)[:, 2]
    assert right > left


def test_the_view_follows_a_walk_that_turns_and_stays_for_one_in_place() -> None:
    straight = set_stage(walk(), ())
    assert np.allclose(course(straight, np.array([0.5, 2.5])), 0, atol=1e-6)
    turned = set_stage(place(walk(), 1.0, (0, 0, 0)), ())
    assert np.allclose(course(turned, np.array([0.5, 2.5])), 1.0, atol=1e-6)
    still = walk()
    spin = still.rotations.copy()
    spin[:, 0] = rot.about("y", np.linspace(0, 6, len(still)))
    in_place = Motion(still.skeleton, still.translation * (1, 1, 0), spin, still.fps)
    assert np.ptp(course(set_stage(in_place, ()), np.array([0.5, 1.5, 2.5]))) == 0


def test_requests_that_a_picture_cannot_meet(tmp_path: Path) -> None:
    with pytest.raises(RequestError, match=r"expected \.png, found '\.jpg'"):
        contact_sheet(walk(), tmp_path / "a.jpg")
    with pytest.raises(RequestError, match="1 pose or more, found frames=0"):
        contact_sheet(walk(), tmp_path / "a.png", frames=0)
    with pytest.raises(RequestError, match="1 pose or more, found poses=0"):
        strobe(walk(), tmp_path / "a.png", poses=0)
    with pytest.raises(RequestError, match="no motion to draw"):
        strobe([], tmp_path / "a.png")
    with pytest.raises(RequestError, match="points in metres, found the channels speed"):
        contact_sheet(walk(), tmp_path / "a.png", path_signal=Signal(np.zeros((3, 1)), ("speed",), "m/s", 30.0))
    assert list(tmp_path.iterdir()) == []


def test_no_figure_outlives_its_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    from matplotlib.figure import Figure

    alive: list[weakref.ref[Figure]] = []
    begin = Figure.__init__

    def note(self: Figure, *args: object, **options: object) -> None:
        alive.append(weakref.ref(self))
        begin(self, *args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(Figure, "__init__", note)
    contact_sheet(walk(), tmp_path / "a.png", frames=4)
    strobe(walk(), tmp_path / "b.png", poses=3)
    gc.collect()
    assert len(alive) == 2
    assert [ref() for ref in alive] == [None, None]
    pyplot = sys.modules.get("matplotlib.pyplot")
    assert pyplot is None or pyplot.get_fignums() == []


def test_recorded_motions(data_folder: Path, tmp_path: Path) -> None:
    for recording in ("walks/15_01.bvh", "walks/humanoid3d_long_walk3.txt", "actions/humanoid3d_getup_facedown.txt"):
        contact_sheet(load(data_folder / recording), tmp_path / "sheet.png")
        strobe(load(data_folder / recording), tmp_path / "strip.png")
        for name in ("sheet.png", "strip.png"):
            image = pixels(tmp_path / name)
            assert min(share(image, BLUE), share(image, VERMILION)) > 1e-5
