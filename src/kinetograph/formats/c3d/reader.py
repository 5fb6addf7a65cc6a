"""Reading C3D: from the parameters and the block of data to a signal of points."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from kinetograph.arrays import BoolArray, FloatArray
from kinetograph.errors import FormatError
from kinetograph.formats.c3d.parameters import Parameters, parse_parameters, reals
from kinetograph.formats.conventions import UNITS, check_up, points_from_up, unit_factor
from kinetograph.formats.names import unique
from kinetograph.formats.options import Loaded, ReadOptions
from kinetograph.signal import Signal
from kinetograph.take import Take

_BLOCK = 512
_NAMES = {"mm": "millimetre", "cm": "centimetre", "m": "metre", "in": "inch", "inch": "inch", "ft": "foot"}
_LARGEST = 1e12


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """Read a ``.c3d`` file as a take in metres, Y up, with the track ``markers``.

    Parameters
    ----------
    path : str or Path
    options : ReadOptions, optional

    Returns
    -------
    Loaded

    Raises
    ------
    FormatError
        The file is not C3D, or holds fewer frames than it says.
    """
    path = Path(path)
    options = options or ReadOptions()
    data = path.read_bytes()
    if len(data) < 2 * _BLOCK or data[1] != 0x50:
        raise FormatError(path, "expected a C3D file: its second byte is not 0x50")
    parameters = parse_parameters(path, data)
    notes: list[str] = []
    values, valid = _points(path, data, parameters, options.lenient, notes)
    fps = options.fps if options.fps is not None else parameters.number("POINT", "RATE", parameters.header_rate)
    if not (np.isfinite(fps) and 0 < fps < 1e6):
        raise FormatError(path, f"fps must be a positive number, found {fps}; give it with --fps")
    units = options.units or _units(parameters, values, valid, notes)
    values = values * unit_factor(units)
    up = check_up(options.up) if options.up else _up(values, valid, notes)
    names = _labels(parameters, values.shape[1], notes)
    signal = Signal(points_from_up(values, up), tuple(names), "m", fps, valid)
    return Loaded(Take(path.stem, {"markers": signal}), tuple(notes))


def _points(
    path: Path, data: bytes, parameters: Parameters, lenient: bool, notes: list[str]
) -> tuple[FloatArray, BoolArray]:
    """Positions ``(F, P, 3)`` in the file's units, and which of them are valid ``(F, P)``."""
    count, first, last = parameters.points, parameters.first, parameters.last
    frames = int(parameters.number("POINT", "FRAMES", 0)) or last - first + 1
    if last - first + 1 > 0 and last < 65535:
        frames = last - first + 1
    elif frames <= 0 or frames == 65535:  # longer than the header can say
        frames = int(parameters.long_frames())
    scale = parameters.number("POINT", "SCALE", parameters.header_scale)
    real = scale < 0
    width = 4 if real else 2
    row = (4 * count + parameters.analog) * width
    start = (int(parameters.number("POINT", "DATA_START", 0)) or parameters.data_block) - 1
    start *= _BLOCK  # some programs write 0 into the parameter
    if count <= 0 or frames <= 0 or start < _BLOCK or not np.isfinite(scale):
        raise FormatError(path, f"expected markers and frames, found {count} markers in {frames} frames")
    present = max(len(data) - start, 0) // row
    if present < frames:
        message = f"{frames} frames of {count} markers take {frames * row} bytes, there are {max(len(data) - start, 0)}"
        if not lenient or present == 0:
            raise FormatError(path, f"{message}; is the file cut short? --lenient takes the frames that are there")
        notes.append(f"{message}: took {present} frames")
        frames = present
    raw = np.frombuffer(data, np.uint8, frames * row, start).reshape(frames, row)[:, : 4 * count * width]
    return _numbers(path, raw, count, scale, parameters.processor, notes)


def _numbers(
    path: Path, raw: npt.NDArray[np.uint8], count: int, scale: float, processor: int, notes: list[str]
) -> tuple[FloatArray, BoolArray]:
    frames = len(raw)
    if scale < 0:
        numbers = reals(raw, processor).reshape(frames, count, 4)
        values, flags = numbers[..., :3], numbers[..., 3]
    else:
        order = ">i2" if processor == 3 else "<i2"
        whole = np.ascontiguousarray(raw).view(order).reshape(frames, count, 4).astype(np.float64)
        values, flags = whole[..., :3] * scale, whole[..., 3]
    with np.errstate(invalid="ignore"):
        valid: BoolArray = (flags >= 0) & np.all(np.abs(values) < _LARGEST, axis=-1)
    nowhere = valid & ~values.any(axis=-1)
    if nowhere.any():
        notes.append(f"{nowhere.any(axis=0).sum()} markers are at the very origin at times: taken as not seen there")
        valid = valid & ~nowhere
    if not valid.any():
        raise FormatError(path, "expected markers somewhere, found none in any frame")
    return np.where(valid[..., None], values, 0.0), valid


def _units(parameters: Parameters, values: FloatArray, valid: BoolArray, notes: list[str]) -> str:
    said = parameters.text("POINT", "UNITS").strip().lower()
    if said in _NAMES:
        return _NAMES[said]
    size = float(np.median(np.ptp(np.where(valid[..., None], values, np.nan)[valid.any(axis=1)][:1], axis=1)))
    spread = float(np.nanmax(np.ptp(values[valid].reshape(-1, 3), axis=0))) if not np.isfinite(size) else size
    units = min(UNITS, key=lambda name: abs(np.log(max(spread, 1e-9) * UNITS[name] / 1.5)))
    notes.append(f"units not given: guessed {units}, from how far apart the markers are")
    return units


def _up(values: FloatArray, valid: BoolArray, notes: list[str]) -> str:
    """The axis along which the lowest markers move least, as they do on a floor."""
    complete = valid.all(axis=1)
    points = np.where(valid[..., None], values, np.nan)[complete if complete.any() else slice(None)]
    frames = points[:: max(len(points) // 64, 1)]
    frames = frames[~np.isnan(frames).all(axis=(1, 2))]
    low, high = np.nanmin(frames, axis=1), np.nanmax(frames, axis=1)
    tall = np.nanmedian(high - low, axis=0)
    spread = np.nanpercentile(low, 90, axis=0) - np.nanpercentile(low, 10, axis=0)
    axis = "xyz"[int(np.argmin((spread + 0.02) / np.maximum(tall, 1e-6)))]
    notes.append(f"up axis not given: guessed {axis}, from where the markers' floor is")
    return axis


def _labels(parameters: Parameters, count: int, notes: list[str]) -> list[str]:
    labels = parameters.texts("POINT", "LABELS")[:count]
    labels = [label.strip() or f"marker_{i}" for i, label in enumerate(labels)]
    labels += [f"marker_{i}" for i in range(len(labels), count)]
    return unique(labels, "marker", notes)
