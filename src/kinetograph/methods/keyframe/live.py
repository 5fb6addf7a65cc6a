"""Live keyframe control: keys that are set one after another, and motion to each as soon as it is set."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.methods.keyframe.around import Solve, clip_synthesis, frame_as_key, joined
from kinetograph.synthesis import LivePose, Synthesis


@dataclass(eq=False)
class LiveKeys:
    """Keys under way. Made by `KeyframeModel.start`; `step` it key by key and `finish` it once.

    Parameters
    ----------
    solve : callable
        Makes a motion through keys.
    now : bool
        Whether motion to each key is settled when the key is set. Otherwise nothing is before `finish`, which then sees
        all keys at once.
    """

    solve: Solve
    now: bool = True
    _keys: list[Key] = field(default_factory=list)
    _parts: list[Synthesis] = field(default_factory=list)
    _frames: int = 0

    def step(self, key: Key) -> tuple[LivePose, ...]:
        """Set one more key, and give the frames up to it that are settled.

        Parameters
        ----------
        key : Key
            Its time, if any, counts from the first key.

        Returns
        -------
        tuple of LivePose

        Raises
        ------
        RequestError
            Where no motion leads to the key; it is then not set, and another may be.
        """
        if self.now and self._keys:
            part = self._led_to(key)
            poses = self._poses(part)
            self._parts.append(part)
        else:
            poses = ()
        self._keys.append(key)
        return poses

    def finish(self) -> Synthesis:
        """The whole motion; without ``now``, the best through all keys."""
        if not self.now:
            return self.solve(tuple(self._keys))
        if not self._parts:
            raise RequestError(f"expected 2 keys or more, found {len(self._keys)}")
        return joined(self._parts)

    def _led_to(self, key: Key) -> Synthesis:
        """From where the motion is to one more key."""
        if not self._parts:
            return self.solve((self._keys[0], key))
        last, fps = self._parts[-1].motion, self._parts[-1].motion.fps
        past = (self._frames - 1) / fps
        if key.time is not None:
            if key.time[1] <= past:
                raise RequestError(
                    f"{key.label}: it is to be met by {key.time[1]:g} s, and the motion is at {past:g} s"
                )
            key = replace(key, time=(max(key.time[0] - past, 0.0), key.time[1] - past))
        part = self.solve((frame_as_key(last, len(last) - 1, 0.0, "the motion so far"), key))
        return clip_synthesis(part, 1, len(part.motion) - 1, self._frames / fps)

    def _poses(self, part: Synthesis) -> tuple[LivePose, ...]:
        motion, first = part.motion, self._frames
        self._frames += len(motion)
        return tuple(
            LivePose((first + i) / motion.fps, motion.translation[i], motion.rotations[i]) for i in range(len(motion))
        )
