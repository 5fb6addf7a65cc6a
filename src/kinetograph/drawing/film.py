"""Contact sheets and films of characters, drawn in software."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from kinetograph.arrays import FloatArray
from kinetograph.character import Character, Skin
from kinetograph.drawing.stage import Camera, Figure, draw, posed
from kinetograph.drawing.video import write_video
from kinetograph.errors import RequestError
from kinetograph.formats import dressed, rest_positions
from kinetograph.motion import Motion, cut, resample
from kinetograph.progress import Progress
from kinetograph.take import Take

_CELL = (240, 300)
_FRAME = (400, 400)
_FILM_RATE = 25.0  # a GIF counts in hundredths of a second
_VIDEO_RATE = 30.0
_FOLLOW = 0.15  # of the way to where it should be, a frame
_TRIED = 4  # frames of a film that its colours are chosen from
_VIVID = 24  # of 255: the least difference between the channels of a colour that is not a grey
_DIRECTION = np.array([0.55, 0.28, 0.85])
_AIR = 1.35  # of the character's height in the picture


def character_sheet(
    what: Take | Motion,
    path: str | Path,
    character: Character | None = None,
    *,
    frames: int = 12,
    progress: Progress | None = None,
) -> None:
    """Draw evenly spaced poses of characters with their skins.

    Parameters
    ----------
    what : Take or Motion
        All motions of a take are drawn together.
    path : str or Path
        A ``.png`` file.
    character : Character, optional
        Whose skin the motions wear; they must have its skeleton. Without one, capsules.
    frames : int
        Number of poses.
    progress : Progress, optional
        Called with poses drawn and their number.

    Raises
    ------
    RequestError
        There is no motion, the file is not ``.png``, or a skeleton is not the character's.
    """
    if Path(path).suffix.lower() != ".png" or frames < 1:
        raise RequestError(f"{path}: a contact sheet of at least one pose is a .png file")
    motions = _motions(what)
    length = max(len(motion) for motion in motions)
    chosen = np.unique(np.linspace(0, length - 1, frames).round().astype(int))
    cast = [_Actor(*dressed(motion, character)) for motion in motions]
    columns = min(len(chosen), 6)
    width, height = _CELL
    page = Image.new("RGB", (columns * width, -(-len(chosen) // columns) * height), "white")
    pen = ImageDraw.Draw(page)
    for i, frame in enumerate(chosen.tolist()):
        figures = [actor.at(frame) for actor in cast]
        at = (i % columns * width, i // columns * height)
        page.paste(Image.fromarray(_pixels(draw(figures, _camera(figures), width, height))), at)
        pen.text((at[0] + 8, at[1] + height - 18), f"{frame / motions[0].fps:.2f} s", fill=(40, 40, 40))
        if progress is not None:
            progress(i + 1, len(chosen))
    page.save(path)


def character_film(
    what: Take | Motion,
    path: str | Path,
    character: Character | None = None,
    *,
    seconds: float = 8.0,
    progress: Progress | None = None,
) -> None:
    """Draw a film of characters with their skins that plays in real time.

    Parameters
    ----------
    what : Take or Motion
        All motions of a take are drawn together.
    path : str or Path
        A ``.gif`` file, or ``.mp4`` where this machine has ffmpeg, see `find_ffmpeg`.
    character : Character, optional
        Whose skin the motions wear; they must have its skeleton. Without one, capsules.
    seconds : float
        Length of the film, from the start of the motion.
    progress : Progress, optional
        Called with frames drawn and their number.

    Raises
    ------
    RequestError
        There is no motion, the file is of another kind or needs ffmpeg, or a skeleton is not the character's.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in (".gif", ".mp4") or not seconds > 0:
        raise RequestError(f"{path}: a film of some seconds is a .gif or .mp4 file")
    rate = _FILM_RATE if suffix == ".gif" else _VIDEO_RATE
    motions = [resample(motion, rate) for motion in _motions(what)]
    cast = [_Actor(*dressed(motion, character)) for motion in motions]
    count = int(min(max(len(motion) for motion in motions), max(seconds * rate, 1)))
    frames = _frames(cast, count, progress)
    if suffix == ".mp4":
        write_video(frames, path, _FRAME, rate)
        return
    palette = _palette(cast, count)
    pictures = [Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=round(1000 / rate), loop=0)


@dataclass(frozen=True, eq=False)
class _Actor:
    """A motion and its skin."""

    motion: Motion
    skin: Skin

    def at(self, frame: int) -> Figure:
        """The figure of a frame; the last one is repeated for those after it."""
        frame = min(frame, len(self.motion) - 1)
        return posed(cut(self.motion, frame, frame + 1), self.skin, rest_positions(self.motion.skeleton))[0]


def _frames(cast: list[_Actor], count: int, progress: Progress | None) -> Iterator[npt.NDArray[np.uint8]]:
    target: FloatArray | None = None
    for i in range(count):
        figures = [actor.at(i) for actor in cast]
        camera = _camera(figures)
        # the camera follows slowly, as steps would shake it
        target = camera.target if target is None else target + _FOLLOW * (camera.target - target)
        camera = Camera(camera.place - camera.target + target, target, camera.tall)
        yield _pixels(draw(figures, camera, *_FRAME))
        if progress is not None:
            progress(i + 1, count)


def _palette(cast: list[_Actor], count: int) -> Image.Image:
    """The colours of all frames of a film: half of them for what is vivid, half for floor, sky and greys.

    If they were chosen by how often they occur, most would go to the floor, and faces would be grey.
    """
    pixels = []
    for i in np.unique(np.linspace(0, count - 1, _TRIED).astype(int)).tolist():
        figures = [actor.at(i) for actor in cast]
        pixels.append(_pixels(draw(figures, _camera(figures), *_CELL)).reshape(-1, 3))
    flat = np.concatenate(pixels)
    vivid = np.ptp(flat.astype(np.int64), axis=1) > _VIVID
    colours = [_quantized(part) for part in (flat[vivid], flat[~vivid]) if len(part)]
    out = Image.new("P", (1, 1))
    out.putpalette([value for part in colours for value in part])
    return out


def _quantized(pixels: npt.NDArray[np.uint8]) -> list[int]:
    """At most 128 colours, three numbers each, that represent pixels ``(N, 3)``."""
    page = Image.fromarray(np.ascontiguousarray(pixels[None]))
    palette = page.quantize(128, method=Image.Quantize.MEDIANCUT, kmeans=2).getpalette() or []
    return palette[: 3 * 128]


def _motions(what: Take | Motion) -> list[Motion]:
    motions = [what] if isinstance(what, Motion) else [t for t in what.tracks.values() if isinstance(t, Motion)]
    if not motions:
        raise RequestError("a picture of a character needs a motion, found only signals")
    return motions


def _camera(figures: list[Figure]) -> Camera:
    """A camera in front and a little above, that looks at the middle of the figures."""
    points = np.concatenate([figure.points for figure in figures])
    low, high = points.min(axis=0), points.max(axis=0)
    skin = figures[0].skin
    tall = float(np.ptp(skin.points[:, 1]))
    middle = np.array([(low[0] + high[0]) / 2, tall / 2, (low[2] + high[2]) / 2])
    seen = max(tall, float(np.hypot(high[0] - low[0], high[2] - low[2])) * 0.9, float(high[1])) * _AIR
    direction = _DIRECTION / np.linalg.norm(_DIRECTION)
    return Camera(middle + direction * 3.2 * seen, middle, seen)


def _pixels(image: FloatArray) -> npt.NDArray[np.uint8]:
    return (np.clip(image, 0, 1) * 255 + 0.5).astype(np.uint8)
