"""Strokes of a racket for ``reproduce xie2009``, from recordings of markers: bodies are fitted, and strokes cut out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.signal import find_peaks

from kinetograph.errors import KinetographError, RequestError
from kinetograph.formats import read
from kinetograph.kinematics import role_positions, velocities
from kinetograph.markers import fitted_take
from kinetograph.methods.sensor import Motions
from kinetograph.motion import Motion, cut
from kinetograph.sensing import PRESETS, Layout

BEFORE, AFTER = 2.0, 1.0
"""Seconds of a stroke before and after the hand is fastest."""
FAST = 6.0
"""Metres per second, against the hips, that a hand reaches in a stroke."""
CLIP = 8
"""How many times wider the range of the sensors is that are compared with the device's own, with steps as fine."""


@dataclass(frozen=True, eq=False)
class Strokes:
    """The strokes of several files.

    Parameters
    ----------
    takes : dict
        Strokes by file, each file's of one body.
    notes : tuple of str
        How well the bodies fit, and files that were left out.
    """

    takes: dict[str, Motions]
    notes: tuple[str, ...]


def find_strokes(folder: str | Path) -> Strokes:
    """Strokes of every C3D file in a folder whose markers a body can be fitted to; the others are named."""
    folder = Path(folder)
    takes: dict[str, Motions] = {}
    notes: list[str] = []
    for path in sorted(folder.glob("*.c3d")):
        try:
            takes[path.stem], lines = _of_file(path)
        except KinetographError as error:
            notes.append(f"{path.name} is left out: {error}")
            continue
        notes += [f"{path.name}: {line}" for line in lines]
    if not takes and not notes:
        notes.append(f"{folder}: expected C3D files of markers, found none")
    return Strokes(takes, tuple(notes))


def cut_strokes(motion: Motion) -> list[Motion]:
    """A motion's strokes, none of them overlapping: from 2 s before to 1 s after a hand is fastest.

    Strokes that the recording does not hold in whole are left out.
    """
    hands = role_positions(motion, ("left_hand", "right_hand")) - role_positions(motion, ("hips",))
    speed = np.linalg.norm(velocities(hands, motion.fps), axis=-1).max(axis=1)
    peaks, _ = find_peaks(speed, height=FAST, distance=max(round((BEFORE + AFTER) * motion.fps), 1))
    starts = peaks - round(BEFORE * motion.fps)
    stops = peaks + round(AFTER * motion.fps)
    return [cut(motion, int(a), int(b)) for a, b in zip(starts, stops, strict=True) if a >= 0 and b <= len(motion)]


def wide_layout() -> Layout:
    """The preset ``wii`` with a range eight times as wide and steps as fine, so that only clipping differs."""
    layout = PRESETS["wii"]
    bits = layout.device.bits
    finer = None if bits is None else bits + round(np.log2(CLIP))
    return replace(layout, device=replace(layout.device, span=CLIP * layout.device.span, bits=finer))


def _of_file(path: Path) -> tuple[Motions, list[str]]:
    _, fits = fitted_take(read(path).take)
    if len(fits) != 1:
        raise RequestError(f"expected the markers of one body, found {len(fits)}")
    (key, fit), *_ = fits.items()
    strokes = cut_strokes(fit.motion)
    if len(strokes) < 2:
        raise RequestError(f"expected two strokes or more (a hand faster than {FAST:g} m/s), found {len(strokes)}")
    misses = fit.residuals()[-1]
    line = f"{len(strokes)} strokes; the body misses its markers by {misses['mean_mm']:.1f} mm in the mean"
    return {(f"{path.stem}_{i}", key): stroke for i, stroke in enumerate(strokes, start=1)}, [line, *fit.notes]
