"""Pictures of characters: skinning and triangles with known answers, a sheet and a film."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from kinetograph import rotations as rot
from kinetograph.character import Skin
from kinetograph.drawing import _kernels, character_film, character_sheet, find_ffmpeg
from kinetograph.drawing.stage import Camera, draw, posed
from kinetograph.errors import RequestError
from kinetograph.formats.deepmimic import skeleton
from kinetograph.motion import Motion
from kinetograph.skeleton import Skeleton


def stand(frames: int = 4) -> Motion:
    rotations = rot.identity(frames, 15)
    rotations[:, 9] = rot.about("z", np.linspace(0, 0.5, frames))
    return Motion(skeleton(), np.tile([0.0, 0.9, 0.0], (frames, 1)), rotations, 10.0)


def test_points_follow_their_joints_by_weight() -> None:
    bone = Skeleton(("a", "b"), np.array([-1, 0]), np.array([[0.0, 0, 0], [0, 1, 0]]))
    rotations = rot.identity(1, 2)
    rotations[0, 1] = rot.about("z", np.pi / 2)
    skin = Skin(
        np.array([[0.0, 0, 0], [0, 2, 0], [0, 2, 0]]),
        np.tile([0.0, 1, 0], (3, 1)),
        np.array([[0, 1, 2]]),
        np.array([[0, 1, 0, 0]] * 3),
        np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [0.5, 0.5, 0, 0]]),
        np.zeros(1, dtype=np.int64),
        (("grey", (0.5, 0.5, 0.5)),),
    )
    figure = posed(Motion(bone, np.array([[5.0, 0, 0]]), rotations, 1.0), skin, np.array([[0.0, 0, 0], [0, 1, 0]]))[0]
    np.testing.assert_allclose(figure.points, [[5, 0, 0], [4, 1, 0], [4.5, 1.5, 0]], atol=1e-12)
    np.testing.assert_allclose(figure.normals[1], [-1, 0, 0], atol=1e-12)


def test_the_nearer_triangle_is_seen() -> None:
    depth, image = np.full((4, 4), np.inf), np.zeros((4, 4, 3))
    corners = np.array([[0.0, 0, 2], [8, 0, 2], [0, 8, 2], [0, 0, 1], [2, 0, 1], [0, 2, 1]])
    colours = np.repeat([[0.25, 0, 0], [0.75, 0, 0]], 3, axis=0)
    _kernels.fill(depth, image, corners, np.array([[0, 1, 2], [5, 4, 3]]), colours)
    assert image[0, 0, 0] == pytest.approx(0.75)
    assert image[3, 3, 0] == pytest.approx(0.25)
    assert depth[0, 0] == pytest.approx(1.0)


def test_a_ball_of_known_size_covers_what_it_should() -> None:
    square = Skin(
        np.array([[-0.5, -0.5, 0], [0.5, -0.5, 0], [0.5, 0.5, 0], [-0.5, 0.5, 0.0]]),
        np.tile([0.0, 0, 1], (4, 1)),
        np.array([[0, 1, 2], [0, 2, 3]]),
        np.zeros((4, 4), dtype=np.int64),
        np.tile([1.0, 0, 0, 0], (4, 1)),
        np.zeros(2, dtype=np.int64),
        (("red", (1.0, 0.0, 0.0)),),
    )
    stick = Skeleton(("a",), np.array([-1]), np.zeros((1, 3)))
    figures = posed(Motion(stick, np.array([[0.0, 1, 0]]), rot.identity(1, 1), 1.0), square, np.zeros((1, 3)))
    picture = draw(figures, Camera(np.array([0.0, 1, 5]), np.array([0.0, 1, 0]), 2.0), 80, 80)
    red = (picture[..., 0] - picture[..., 1]) > 0.3
    assert red.sum() == pytest.approx(40 * 40, rel=0.05)
    assert red[40, 40]


def test_the_floor_is_that_of_every_pixel_seen_by_itself() -> None:
    place, unit, tile = np.array([1.0, 2.0, 3.0]), 0.02, 0.5
    camera = Camera(place, np.array([0.0, 1.0, 0.0]), 2.0)
    image, floor = np.empty((60, 80, 3)), np.empty((60, 80), dtype=np.bool_)
    sky, ground, line = colours = np.array([[0.8, 0.8, 0.9], [0.6, 0.5, 0.6], [0.1, 0.2, 0.3]])
    _kernels.tile(image, floor, place, camera.axes, unit, colours, tile)
    right, up, into = camera.axes
    for row, column in np.random.default_rng(1).integers(0, 60, (200, 2)):
        ray = into + (column + 0.5 - 40) * unit * right + (30 - row - 0.5) * unit * up
        assert floor[row, column] == (ray[1] < -1e-3)
        expected = sky
        if floor[row, column]:
            reach = -place[1] / ray[1]
            x, _, z = place + reach * ray
            grain = reach * unit / max(-ray[1], 0.05)
            near = tile * min(abs(x / tile - round(x / tile)), abs(z / tile - round(z / tile)))
            share = max(1 - near / max(0.008, grain), 0) * min(0.03 / grain, 1)
            fade = np.clip((reach - 6) / 12, 0, 1)
            expected = (1 - fade) * ((1 - share) * ground + share * line) + fade * sky
        np.testing.assert_allclose(image[row, column], expected, atol=1e-9)
    assert floor.any()
    assert not floor.all()


def test_a_film_for_a_player_of_films(tmp_path: Path) -> None:
    if find_ffmpeg() is None:
        with pytest.raises(RequestError, match=r"an \.mp4 film needs ffmpeg"):
            character_film(stand(), tmp_path / "a.mp4")
        return
    character_film(stand(), tmp_path / "a.mp4", seconds=0.3)
    character_film(stand(), tmp_path / "b.mp4", seconds=0.3)
    data = (tmp_path / "a.mp4").read_bytes()
    assert data == (tmp_path / "b.mp4").read_bytes()
    assert data[4:8] == b"ftyp"
    assert data.index(b"moov") < data.index(b"mdat")  # plays before all of it has come

    def stop(done: int, total: int) -> None:
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        character_film(stand(), tmp_path / "c.mp4", progress=stop)


def test_a_sheet_and_a_film(tmp_path: Path) -> None:
    character_sheet(stand(), tmp_path / "a.png", frames=3)
    with Image.open(tmp_path / "a.png") as picture:
        assert picture.size == (720, 300)
        assert len(np.unique(np.asarray(picture).reshape(-1, 3), axis=0)) > 200
    character_film(stand(), tmp_path / "a.gif", seconds=0.2)
    with Image.open(tmp_path / "a.gif") as moving:
        assert moving.n_frames == 5


def test_what_cannot_be_drawn_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RequestError, match=r"is a \.gif or \.mp4 file"):
        character_film(stand(), tmp_path / "a.avi")
    with pytest.raises(RequestError, match=r"is a \.png file"):
        character_sheet(stand(), tmp_path / "a.jpg")
