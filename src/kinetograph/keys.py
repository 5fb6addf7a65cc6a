"""Keys: poses that a motion is to pass through, and what is asked of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.motion import Motion, sample


@dataclass(frozen=True, eq=False)
class Key:
    """A pose to be met.

    clip, frame: the pose is that frame; its neighbours in the clip, where it has any, tell how fast it moves. time:
    the earliest and latest second of the result at which it is to be met, from the first key's on; None leaves it
    free. position: ``(x, z)`` metres where the root joint is to be above the ground; None leaves it free. heading:
    the root's turn about the vertical in radians, see `kinetograph.motion.heading`; None leaves it free. roles: the
    parts of the body that count; None for the whole pose. label: what messages call it.

    Raises RequestError for a frame outside its clip, or times that are negative or out of order.
    """

    clip: Motion
    frame: int = 0
    time: tuple[float, float] | None = None
    position: tuple[float, float] | None = None
    heading: float | None = None
    roles: tuple[str, ...] | None = None
    label: str = "key"

    def __post_init__(self) -> None:
        if not 0 <= self.frame < len(self.clip):
            raise RequestError(
                f"{self.label}: frame {self.frame} is outside its clip, which has frames 0 to {len(self.clip) - 1}"
            )
        if self.time is not None:
            low, high = float(self.time[0]), float(self.time[1])
            if not (np.isfinite(low) and np.isfinite(high) and 0 <= low <= high):
                raise RequestError(f"{self.label}: a time window is 0 <= earliest <= latest seconds, found {self.time}")
            object.__setattr__(self, "time", (low, high))
        for role in self.roles or ():
            self.clip.skeleton.landmark(role)


def key_at(
    clip: Motion,
    second: float,
    *,
    time: tuple[float, float] | None = None,
    position: tuple[float, float] | None = None,
    heading: float | None = None,
    roles: tuple[str, ...] | None = None,
    label: str = "key",
) -> Key:
    """The pose of a clip at a second of it, with its neighbours half a second either side.

    Raises RequestError for a second outside the clip.
    """
    if not 0 <= second <= clip.duration + 1e-6:
        raise RequestError(f"{label}: {second:g} s is outside its clip, which lasts from 0 to {clip.duration:.3f} s")
    before = int(np.floor(min(second, 0.5) * clip.fps + 1e-6))
    after = int(np.floor(min(clip.duration - second, 0.5) * clip.fps + 1e-6))
    times = second + np.arange(-before, max(after, 0) + 1) / clip.fps
    return Key(sample(clip, times, clip.fps), before, time, position, heading, roles, label)


def check_order(keys: tuple[Key, ...]) -> None:
    """Raises RequestError unless there are two keys or more whose times can follow one another."""
    if len(keys) < 2:
        raise RequestError(f"keyframe control goes from one key to another: expected 2 keys or more, found {len(keys)}")
    earliest, before = 0.0, keys[0].label
    for number, key in enumerate(keys, start=1):
        if key.time is None:
            continue
        if number > 1 and key.time[1] <= earliest:
            raise RequestError(
                f"keys are out of order: {key.label} (number {number}) is to be met by {key.time[1]:g} s, "
                f"but {before} not before {earliest:g} s; sort them by time"
            )
        earliest, before = max(earliest, key.time[0]), key.label
