"""Reading USD: what a child process reads with usd-core, as motions."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.errors import FormatError, RequestError
from kinetograph.formats import scene
from kinetograph.formats.conventions import scale_motion, to_metres_y_up
from kinetograph.formats.names import unique
from kinetograph.formats.options import Loaded, ReadOptions
from kinetograph.formats.usd.child import REASON, REQUEST
from kinetograph.motion import Motion
from kinetograph.take import Take

_PATIENCE = 120  # seconds
_LARGEST = 1e12

Arrays = dict[str, npt.NDArray[Any]]


def read(path: str | Path, options: ReadOptions | None = None) -> Loaded:
    """Read a USD file as a take in metres, Y up, with one motion per skeleton (UsdSkel).

    Parameters
    ----------
    path : str or Path
    options : ReadOptions, optional

    Returns
    -------
    Loaded
        At the file's time codes. The rest pose of a skeleton is its bind pose.

    Raises
    ------
    RequestError
        usd-core is missing, or there is no animation of the name in ``options``.
    FormatError
        usd-core cannot read the file, it has no skeleton, it has composition arcs (references, payloads, sublayers,
        inherits, specializes, variants, value clips), or claims more than a file of its size can hold.
    """
    path = Path(path)
    options = options or ReadOptions()
    if importlib.util.find_spec("pxr") is None:
        raise RequestError("USD needs the package usd-core: pip install 'kinetograph[usd]'")
    path.open("rb").close()
    arrays = _read_in_child(path, options.animation)
    fps = options.fps or float(arrays["fps"])
    if not (np.isfinite(fps) and 0 < fps < 1e5):
        raise FormatError(path, f"fps must be a positive number, found {fps}; give it with --fps")
    notes: list[str] = [str(note) for note in arrays["notes"]]
    if not arrays["animations"].size:
        notes.append("the file has no animation: read its pose")
    motions = [_motion(path, arrays, f"{i}/", fps, notes) for i in range(int(arrays["count"]))]
    if not motions:
        raise FormatError(path, "expected a skeleton (UsdSkel), found none")
    if options.units is None:
        motions = [scale_motion(motion, float(arrays["scale"])) for motion in motions]
    keep = replace(options.keep, shared=arrays["animations"].size > 1)
    converted = to_metres_y_up(motions, options.units or "metre", options.up or str(arrays["up"]), keep)
    labels = [str(arrays[f"{i}/label"]) for i in range(len(motions))]
    take = Take(path.stem, converted.tracks(labels, notes), animation=str(arrays["animation"]))
    return Loaded(take, (*notes, *converted.notes), tuple(map(str, arrays["animations"])))


def _read_in_child(path: Path, animation: str | None) -> Arrays:
    with tempfile.TemporaryDirectory(prefix="kinetograph-") as folder:
        out = Path(folder) / "scene.npz"
        command = [sys.executable, "-m", "kinetograph.formats.usd.child", str(path.resolve()), str(out)]
        command += [] if animation is None else [animation]
        try:
            ran = subprocess.run(
                command, capture_output=True, text=True, errors="replace", timeout=_PATIENCE, check=False
            )
        except subprocess.TimeoutExpired:
            raise FormatError(path, f"usd-core has not read it in {_PATIENCE} s") from None
        if ran.returncode != 0 or not out.is_file():
            for line in ran.stderr.splitlines():
                if line.startswith(REQUEST):
                    raise RequestError(line.removeprefix(REQUEST).replace(str(path.resolve()), str(path)))
            reasons = [line.removeprefix(REASON)[:160] for line in ran.stderr.splitlines() if line.startswith(REASON)]
            raise FormatError(path, reasons[0] if reasons else "usd-core cannot read it; is the file damaged?")
        with np.load(out, allow_pickle=False) as arrays:
            return dict(arrays)


def _motion(path: Path, arrays: Arrays, key: str, fps: float, notes: list[str]) -> Motion:
    local, places, bind = (arrays[key + part].astype(np.float64) for part in ("local", "places", "bind"))
    parents = arrays[f"{key}parents"].astype(np.int64)
    if not all(np.isfinite(part).all() and np.abs(part).max() < _LARGEST for part in (local, places, bind)):
        raise FormatError(path, "expected finite numbers in the transforms of joints")
    if np.any(parents >= np.arange(len(parents))):
        raise FormatError(path, "expected joints whose parents come before them")
    shifts, rotations, scales = (np.empty((len(local), len(parents) + 1, n)) for n in (3, 4, 3))
    shifts[:, 0], rotations[:, 0], scales[:, 0] = _parts(path, places)
    shifts[:, 1:], rotations[:, 1:], scales[:, 1:] = _parts(path, local)
    names = unique(["", *(str(name) or "joint" for name in arrays[f"{key}names"])], "joint", notes)
    nodes = scene.Nodes(tuple(names), np.array([-1, *(parents + 1)]), shifts, rotations, scales)
    bound = _parts(path, bind @ places[0])
    whole = (np.concatenate([shifts[0, :1], bound[0]]), np.concatenate([rotations[0, :1], bound[1]]))
    motions = scene.motions(
        nodes, list(range(1, len(names))), whole, fps, scene.Rest(*whole, shared=arrays["animations"].size > 1)
    )
    if len(motions) > 1:
        notes.append(f"{len(motions)} roots in one skeleton: read the first one")
    return motions[0]


def _parts(path: Path, matrices: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Translations, rotations and scales of transposed matrices, ``(..., 4, 4)``."""
    axes = np.swapaxes(matrices[..., :3, :3], -1, -2)
    scales = np.linalg.norm(axes, axis=-2)
    if np.any(scales < 1e-9):
        raise FormatError(path, "a transform of a joint is flat")
    return matrices[..., 3, :3], rot.from_matrix(axes / scales[..., None, :]), scales
