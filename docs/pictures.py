"""The moving picture of the README: a person, made of free recordings, walks along a winding path again and again.

``make pictures`` writes ``docs/images/walk.gif``. The clips are MIT, the body is CC0: see ``kinetograph data list``.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

import kinetograph as kg
from kinetograph.arrays import FloatArray
from kinetograph.character import Character, Skin
from kinetograph.cli.demo import sample_library
from kinetograph.drawing.stage import Camera, Figure, draw, posed
from kinetograph.formats import body_of
from kinetograph.kinematics import joint_positions
from kinetograph.motion import cut, resample
from kinetograph.post import retarget
from kinetograph.samples import human

IMAGES = Path(__file__).parent / "images"
SIZE = (640, 300)
FPS = 100 / 7  # a GIF counts in hundredths of a second
SPEED = 1.0  # m/s; at this one the best walk is the same in every lap, which is 220 frames long
WIDTH, LIFT = 0.14, 0.001  # metres, of the path on the floor
PATH, RIM = np.array([0.93, 0.66, 0.20]), 0.55
COLOURS, VIVID = 96, 24  # a colour whose parts differ by more than this of 255 is no grey


def main() -> None:
    """Make the picture."""
    path, lap = winding_loop()
    with tempfile.TemporaryDirectory() as folder:
        walks = sample_library(Path(folder) / "walks")
        result = kg.PerformanceControl(mirror=True).fit(walks).synthesize(path)
    motion = one_lap(resample(result.motion, FPS), lap)
    character = human()
    dressed = retarget(motion, character.skeleton).motion
    IMAGES.mkdir(exist_ok=True)
    write(frames_of(dressed, character, ground_of(path, lap)), IMAGES / "walk.gif")
    sys.stdout.write(f"{IMAGES / 'walk.gif'}: {(IMAGES / 'walk.gif').stat().st_size / 1e6:.2f} MB\n")


def winding_loop() -> tuple[kg.Signal, float]:
    """A closed path that winds, walked three times at one speed, and the seconds of a lap."""
    from scipy.interpolate import CubicSpline

    corners = np.array(
        [(-2.9, 0.0), (-1.75, -1.35), (-0.1, -0.3), (1.6, -1.35), (2.9, -0.2), (1.9, 1.0), (0.0, 0.45), (-1.9, 1.15)]
    )
    closed = np.concatenate([corners, corners[:1]])
    dense = CubicSpline(np.arange(len(closed)), closed, bc_type="periodic")(np.linspace(0, len(corners), 8001))
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(dense, axis=0), axis=1))])
    lap = round(along[-1] / SPEED * 10) / 10  # whole steps of the search, so that the laps come out alike
    times = np.arange(int(3 * lap * 30) + 1) / 30
    at = times / lap % 1.0 * along[-1]
    x, z = (np.interp(at, along, dense[:, i]) for i in (0, 1))
    return kg.Signal(np.stack([x, 0 * x, z], axis=-1)[:, None], ("path",), "m", 30.0), lap


def one_lap(motion: kg.Motion, lap: float) -> kg.Motion:
    """A lap of the middle of a motion, from a frame whose pose comes again a lap later, the rest spread over it."""
    count = round(lap * FPS)
    joints = joint_positions(motion)
    first = int(0.4 * lap * FPS)
    starts = np.arange(first, len(joints) - count - 1)
    gaps = np.linalg.norm(joints[starts + count] - joints[starts], axis=-1).mean(axis=1)
    begin = int(starts[gaps.argmin()])
    sys.stdout.write(f"the lap closes within {100 * gaps.min():.1f} cm\n")
    return cut(motion, begin, begin + count)


def ground_of(path: kg.Signal, lap: float) -> Figure:
    """The path as a ribbon just above the floor."""
    line = path.values[: round(lap * path.fps) + 1, 0]
    line = np.concatenate([line[:-1], line[:1]])
    along = np.roll(line[:-1], -1, axis=0) - np.roll(line[:-1], 1, axis=0)
    along = np.concatenate([along, along[:1]])
    across = np.stack([along[:, 2], 0 * along[:, 0], -along[:, 0]], axis=1)
    across *= 0.5 * WIDTH / np.linalg.norm(across, axis=1, keepdims=True)
    points = np.concatenate([line - across, line + across]) + np.array([0.0, LIFT, 0.0])
    n = len(line)
    i = np.arange(n - 1)
    triangles = np.concatenate([np.stack([i, i + 1, n + i], axis=1), np.stack([i + 1, n + i + 1, n + i], axis=1)])
    normals = np.tile([0.0, 1.0, 0.0], (2 * n, 1))
    joints, weights = np.zeros((2 * n, 4), dtype=np.int64), np.tile([1.0, 0.0, 0.0, 0.0], (2 * n, 1))
    tints = np.zeros(len(triangles), dtype=np.int64)
    skin = Skin(points, normals, triangles, joints, weights, tints, (("path", (1.0, 1.0, 1.0)),))
    return Figure(skin, points, normals)


def frames_of(motion: kg.Motion, character: Character, ribbon: Figure) -> list[FloatArray]:
    """Every frame, the path tinted on the floor where nobody stands before it."""
    skin, rest = body_of(motion.skeleton, character)
    camera = Camera(np.array([0.6, 3.1, 8.4]), np.array([0.0, 0.62, 0.0]), 3.05)
    pictures = []
    for figure in posed(motion, skin, rest):
        bare = draw([figure], camera, *SIZE)
        marked = draw([ribbon, figure], camera, *SIZE)
        share = np.clip(np.abs(marked - bare).max(axis=-1, keepdims=True) / 0.25, 0.0, 1.0)
        light = bare.mean(axis=-1, keepdims=True) / 0.61  # the floor's own, so that shadows stay
        pictures.append(bare * (1 - share) + np.clip(PATH * light, 0.0, 1.0) * share)
    return pictures


def write(pictures: list[FloatArray], path: Path) -> None:
    """A GIF whose frames share their colours, and keep what does not change."""
    images = [Image.fromarray((np.clip(p, 0, 1) * 255 + 0.5).astype(np.uint8)) for p in pictures]
    palette = palette_of(np.concatenate([np.asarray(image).reshape(-1, 3) for image in images[:: len(images) // 6]]))
    first, *others = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    first.save(path, save_all=True, append_images=others, duration=round(1000 / FPS), loop=0, optimize=True)


def palette_of(pixels: npt.NDArray[np.uint8]) -> Image.Image:
    """The colours of pixels ``(N, 3)``, half of them for what is coloured: else the floor would take them all."""
    vivid = np.ptp(pixels.astype(np.int64), axis=1) > VIVID
    colours: list[int] = []
    for part in (pixels[vivid], pixels[~vivid]):
        page = Image.fromarray(np.ascontiguousarray(part[None]))
        found = page.quantize(COLOURS // 2, method=Image.Quantize.MEDIANCUT, kmeans=2).getpalette() or []
        colours += found[: 3 * COLOURS // 2]
    palette = Image.new("P", (1, 1))
    palette.putpalette(colours)
    return palette


if __name__ == "__main__":
    main()
