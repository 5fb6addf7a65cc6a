"""The result of every method: a motion, and the recorded frame that each of its frames came from."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.display import notebook_html
from kinetograph.motion import Motion
from kinetograph.take import Annotation


@dataclass(frozen=True)
class Piece:
    """A stretched and placed interval of a recording.

    Parameters
    ----------
    take, track : str
        Where it comes from.
    source_start, source_stop : float
        Seconds in the take; the same where one pose is held. In a looping clip they run on past its end, cycle after
        cycle.
    start, stop : float
        Seconds in the result.
    rotation : tuple of float, (w, x, y, z)
        Unit quaternion that it is rotated by; about the vertical, for the ground group.
    shift : tuple of float, (x, y, z)
        Metres that it is moved by after the rotation.
    mirrored : bool
        Whether left and right are exchanged.
    weight : float
        Its share in the frames that it covers, from 0 to 1; every method leaves it at 1.
    cost : float
        Its part of the cost of interpreting the control.
    seam : float
        The cost of continuity with the piece before it.
    scale : float
        Factor of its place on the ground, applied before the rotation.
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
    def held(self) -> bool:
        """Whether it is one pose of the take, held."""
        return self.source_stop == self.source_start

    @property
    def stretch(self) -> float:
        """Duration in the result over duration in the recording; above 1 is slower, infinite for a held pose."""
        if self.held:
            return float("inf")
        return (self.stop - self.start) / (self.source_stop - self.source_start)

    @property
    def turn(self) -> float:
        """The rotation about the vertical, in radians."""
        return float(rot.heading(np.array(self.rotation)))

    def source_time(self, time: npt.ArrayLike) -> FloatArray:
        """Times in the take that times in the result come from.

        Parameters
        ----------
        time : array_like, shape (...)
            Seconds in the result.

        Returns
        -------
        ndarray, shape (...)
            Seconds in the take.
        """
        return self.source_start + (np.asarray(time, dtype=np.float64) - self.start) / self.stretch


@dataclass(frozen=True, eq=False)
class LivePose:
    """A frame of a live run that is settled: it is never revised.

    Parameters
    ----------
    time : float
        Seconds since the run's first frame.
    translation : ndarray, shape (3,)
        The root's, in metres.
    rotations : ndarray, shape (J, 4)
    uncertainty : ndarray, shape (J,), optional
        Standard deviation of each joint in radians, where the method has it.
    """

    time: float
    translation: FloatArray
    rotations: FloatArray
    uncertainty: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class DrivenPart:
    """A part of the body that a control of its own drives: a layer.

    Parameters
    ----------
    name : str
        What drives it.
    joints : tuple of str
    start, stop : float
        Seconds of the result.
    pieces : tuple of Piece
        Where it comes from, in seconds of the result; empty where that is not recordings.
    """

    name: str
    joints: tuple[str, ...]
    start: float
    stop: float
    pieces: tuple[Piece, ...] = ()


@dataclass(frozen=True, eq=False)
class Synthesis:
    """A synthesised motion with its provenance.

    Parameters
    ----------
    motion : Motion
    pieces : tuple of Piece
        In order of time, without gaps.
    cost : float
        The score of the optimisation; lower is better.
    costs : mapping of str to float, optional
        The parts that it is the sum of; those of a performance are of durations that are adjusted after the search,
        which makes them a little less.
    annotations : tuple of Annotation, optional
        Contacts and others carried over from the takes of the pieces, on track ``"motion"``.
    statistics : mapping of str to float, optional
        Figures of the run.
    warnings : tuple of str, optional
        What a person should know, each one line.
    edited : ndarray, shape (F,), optional
        Distance of each frame from the recording it came from: the mean distance of joints in metres, without the
        place on the ground and the heading. Empty where a method does not measure it.
    weights : ndarray, shape (F,), optional
        The share of the recording of its piece in each frame; the rest is that of the neighbour it is blended with.
        Empty where no frame mixes two recordings.
    met : tuple of float, optional
        Seconds at which the keys of keyframe control are met, one per key; empty for other controls.
    left_out : mapping of str to tuple of str, optional
        Takes of the library that were not used, by reason.
    layers : tuple of DrivenPart, optional
        Parts of the body that other controls drive; of two that drive a joint, the later one counts. Pieces and edits
        are those of the rest.
    filled : tuple of (float, float), optional
        Seconds from and to which a performance is left around keys, and the timed search goes instead.
    clock : ndarray, shape (F,), optional
        Seconds of the control that frames are at; empty where these are their own, as where no control waits.
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
    met: tuple[float, ...] = ()
    left_out: Mapping[str, Sequence[str]] = field(default_factory=dict)
    layers: tuple[DrivenPart, ...] = ()
    filled: tuple[tuple[float, float], ...] = ()
    clock: FloatArray = field(default_factory=lambda: np.zeros(0))

    def _repr_html_(self) -> str:
        return notebook_html(self)

    def piece_at(self, frame: int) -> Piece:
        """The piece that a frame came from; a frame on a seam belongs to the later piece.

        Parameters
        ----------
        frame : int
            Frame of the result.

        Returns
        -------
        Piece
        """
        time = frame / self.motion.fps
        return self.pieces[max(bisect_right(self.pieces, time + 1e-9, key=lambda piece: piece.start) - 1, 0)]

    def clock_at(self, frame: int) -> float:
        """The second of the control that a frame is at.

        Parameters
        ----------
        frame : int
            Frame of the result.
        """
        return float(self.clock[frame]) if len(self.clock) else frame / self.motion.fps

    def layer_at(self, joint: str, frame: int) -> DrivenPart | None:
        """The layer that a joint's rotation comes from in a frame; None where it comes from the pieces.

        Parameters
        ----------
        joint : str
        frame : int
            Frame of the result.
        """
        time = frame / self.motion.fps
        there = (each for each in self.layers if joint in each.joints and each.start <= time + 1e-9 <= each.stop + 2e-9)
        return next(iter(list(there)[::-1]), None)

    def provenance(self) -> list[tuple[str, float]]:
        """For every frame, the name of the take it came from and the second in that take.

        Returns
        -------
        list of (str, float)
            One pair per frame.
        """
        sources = []
        for frame in range(len(self.motion)):
            piece = self.piece_at(frame)
            sources.append((piece.take, float(piece.source_time(frame / self.motion.fps))))
        return sources
