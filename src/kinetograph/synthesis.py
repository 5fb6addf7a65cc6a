"""The result of every method: a motion, and where each of its frames came from."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.motion import Motion
from kinetograph.take import Annotation


@dataclass(frozen=True)
class Piece:
    """A stretched and placed interval of a recording.

    take, track: where it comes from; mirrored: whether left and right are exchanged. source_start, source_stop:
    seconds in the take; in a looping clip they run on past its end, cycle after cycle. start, stop: seconds in the
    result. rotation: the quaternion it is turned by (for the ground group a turn about the vertical); shift: metres
    ``(x, y, z)``, after the turn; scale: by what its place on the ground is multiplied before the turn. cost: its
    share of the interpretation; seam: of the continuity with its forerunner.
    """

    take: str
    track: str
    source_start: float
    source_stop: float
    start: float
    stop: float
    rotation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mirrored: bool = False
    weight: float = 1.0
    cost: float = 0.0
    seam: float = 0.0
    scale: float = 1.0

    @property
    def stretch(self) -> float:
        """Duration in the result over duration in the recording; above 1 is slower."""
        return (self.stop - self.start) / (self.source_stop - self.source_start)

    @property
    def turn(self) -> float:
        """Turn about the vertical, radians."""
        return float(rot.heading(np.array(self.rotation)))

    def source_time(self, time: npt.ArrayLike) -> FloatArray:
        """Seconds in the take of ``time``, shape ``(...)`` seconds, in the result."""
        return self.source_start + (np.asarray(time, dtype=np.float64) - self.start) / self.stretch


@dataclass(frozen=True, eq=False)
class Synthesis:
    """A synthesised motion with its provenance.

    pieces: in order of time, without gaps. annotations: those carried over from the pieces' takes (contacts, ...),
    on track ``"motion"``. cost: the score of the optimisation, split into ``costs``. statistics: figures of the run.
    warnings: what a person should know, each one line. edited: shape ``(F,)`` metres, how far each frame is from the
    recording it came from (mean joint distance, the place on the ground and the heading put aside), where a method
    tells; else empty. weights: shape ``(F,)``, the share that the recording of its piece has in each frame, the rest
    being that of the neighbour it is blended with; empty where no frame mixes two recordings.
    """

    motion: Motion
    pieces: tuple[Piece, ...]
    cost: float
    costs: Mapping[str, float] = field(default_factory=dict)
    annotations: tuple[Annotation, ...] = ()
    statistics: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    edited: FloatArray = field(default_factory=lambda: np.zeros(0))
    weights: FloatArray = field(default_factory=lambda: np.zeros(0))

    def piece_at(self, frame: int) -> Piece:
        """The piece that frame ``frame`` came from; a frame on a seam belongs to the later piece."""
        time = frame / self.motion.fps
        return self.pieces[max(bisect_right(self.pieces, time + 1e-9, key=lambda piece: piece.start) - 1, 0)]

    def provenance(self) -> list[tuple[str, float]]:
        """For every frame, the take it came from and the second in that take."""
        found = []
        for frame in range(len(self.motion)):
            piece = self.piece_at(frame)
            found.append((piece.take, float(piece.source_time(frame / self.motion.fps))))
        return found
