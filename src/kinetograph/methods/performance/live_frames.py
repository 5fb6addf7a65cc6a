"""Frames of a body that drives another, as they arrive: checked, the latest at hand, and all of them where wanted."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.motion import Motion, concatenate
from kinetograph.rows import KeptRows
from kinetograph.skeleton import Skeleton

_ALIKE = 1e-3  # metres within which the bones of two frames are alike


@dataclass(eq=False)
class LatestFrames:
    """Motions of one frame, one after another.

    Parameters
    ----------
    keep : bool
        Whether all are kept.
    count : int
        How many there were.
    """

    keep: bool
    count: int = 0
    _latest: deque[Motion] = field(default_factory=lambda: deque(maxlen=3))
    _kept: KeptRows | None = None

    def with_next(self, frame: Motion, count: int) -> Motion:
        """The latest frames with one that is not taken yet, ``count`` of them or as many as there are.

        Raises
        ------
        RequestError
            For a motion of several frames, and for another skeleton than that of the frames before.
        """
        if len(frame) != 1:
            raise RequestError(f"expected a motion of one frame, found one of {len(frame)}; step through them")
        if self._latest:
            check_alike(self._latest[-1], frame)
        before = list(self._latest)[max(len(self._latest) - count + 1, 0) :] if count > 1 else []
        return concatenate([*before, frame])

    def add(self, frame: Motion) -> None:
        """Take the next frame."""
        if self.keep:
            row = np.concatenate([values.ravel() for values in _arrays(frame)])
            self._kept = self._kept or KeptRows(row.shape)
            self._kept.add(row)
        self._latest.append(frame)
        self.count += 1

    def latest(self, count: int) -> Motion:
        """The latest frames, ``count`` of them or as many as there are."""
        return concatenate(list(self._latest)[-count:])

    def all(self) -> Motion:
        """All frames that were kept."""
        assert self._kept is not None
        rows, last = self._kept.all(), self._latest[-1]
        widths = [values.size for values in _arrays(last)]
        parts = np.split(rows, np.cumsum(widths)[:-1], axis=1)
        shaped = [part.reshape(len(rows), *v.shape[1:]) for part, v in zip(parts, _arrays(last), strict=True)]
        bones = shaped[2] if len(shaped) > 2 else None
        return Motion(last.skeleton, shaped[0], shaped[1], last.fps, bones)


def _arrays(frame: Motion) -> list[FloatArray]:
    return [frame.translation, frame.rotations, *([] if frame.bones is None else [frame.bones])]


def check_alike(before: Motion, frame: Motion) -> None:
    """Raise RequestError where a frame is of another skeleton than one before it.

    Parameters
    ----------
    before : Motion
    frame : Motion

    Raises
    ------
    RequestError
        For other joints, other lengths of bones, and bones that are rigid in one of them only.
    """
    one, other = before.skeleton, frame.skeleton
    if one is not other and not _same_body(one, other):
        raise RequestError(
            f"expected a frame of the skeleton that the control began with ({_described(one)}), found another "
            f"({_described(other)}); start anew for another body"
        )
    if (before.bones is None) != (frame.bones is None):
        raise RequestError("expected frames that all have bones of their own lengths, or none of them")


def _same_body(one: Skeleton, other: Skeleton) -> bool:
    return (
        one.names == other.names
        and np.array_equal(one.parents, other.parents)
        and np.allclose(one.offsets, other.offsets, atol=_ALIKE)
    )


def _described(skeleton: Skeleton) -> str:
    return f"{len(skeleton)} joints, the root {skeleton.names[0]}"
