"""Contact sheets and films of characters, drawn in software."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from kinetograph.arrays import FloatArray, IntArray
from kinetograph.character import Character
from kinetograph.drawing.stage import Camera, Figure, draw, posed
from kinetograph.errors import RequestError
from kinetograph.formats import body_of
from kinetograph.motion import Motion, cut, resample
from kinetograph.progress import Progress
from kinetograph.take import Take

_CELL = (240, 300)
_FRAME = (400, 400)
_FILM_RATE = 25.0  # a GIF counts in hundredths of a second
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
    cast = [_cast(motion, character, chosen) for motion in motions]
    columns = min(len(chosen), 6)
    width, height = _CELL
    page = Image.new("RGB", (columns * width, -(-len(chosen) // columns) * height), "white")
    pen = ImageDraw.Draw(page)
    for i, frame in enumerate(chosen.tolist()):
        figures = [figures[i] for figures in cast]
        at = (i % columns * width, i // columns * height)
        page.paste(_image(draw(figures, _camera(figures), width, height)), at)
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
        A ``.gif`` file.
    character : Character, optional
        Whose skin the motions wear; they must have its skeleton. Without one, capsules.
    seconds : float
        Length of the film, from the start of the motion.
    progress : Progress, optional
        Called with frames drawn and their number.

    Raises
    ------
    RequestError
        There is no motion, the file is not ``.gif``, or a skeleton is not the character's.
    """
    if Path(path).suffix.lower() != ".gif" or not seconds > 0:
        raise RequestError(f"{path}: a film of some seconds is a .gif file")
    motions = [resample(motion, _FILM_RATE) for motion in _motions(what)]
    count = min(max(len(motion) for motion in motions), max(int(seconds * _FILM_RATE), 1))
    cast = [_cast(motion, character, np.arange(count)) for motion in motions]
    target: FloatArray | None = None
    palette = _palette(cast)
    pictures = []
    for i in range(count):
        figures = [figures[i] for figures in cast]
        camera = _camera(figures)
        # the camera follows slowly, as steps would shake it
        target = camera.target if target is None else target + 0.15 * (camera.target - target)
        camera = Camera(camera.place - camera.target + target, target, camera.tall)
        picture = _image(draw(figures, camera, *_FRAME))
        pictures.append(picture.quantize(palette=palette, dither=Image.Dither.NONE))
        if progress is not None:
            progress(i + 1, count)
    pictures[0].save(path, save_all=True, append_images=pictures[1:], duration=round(1000 / _FILM_RATE), loop=0)


def _palette(cast: list[list[Figure]]) -> Image.Image:
    """The colours of all frames of a film: half of them for what is vivid, half for floor, sky and greys.

    If they were chosen by how often they occur, most would go to the floor, and faces would be grey.
    """
    pixels = []
    for i in np.unique(np.linspace(0, len(cast[0]) - 1, _TRIED).astype(int)).tolist():
        figures = [figures[i] for figures in cast]
        pixels.append(np.asarray(_image(draw(figures, _camera(figures), *_CELL))).reshape(-1, 3))
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


def _cast(motion: Motion, character: Character | None, frames: IntArray) -> list[Figure]:
    """The figures of some frames of a motion; its last frame is repeated for those after it."""
    skin, rest = body_of(motion, character)
    picked = [cut(motion, i, i + 1) for i in np.minimum(frames, len(motion) - 1).tolist()]
    return [posed(frame, skin, rest)[0] for frame in picked]


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


def _image(pixels: FloatArray) -> Image.Image:
    return Image.fromarray((np.clip(pixels, 0, 1) * 255 + 0.5).astype(np.uint8))
