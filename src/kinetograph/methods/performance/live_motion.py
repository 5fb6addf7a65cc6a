"""From what a live search has decided to frames: each is played once, joined, placed and held, and never revised."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from kinetograph import rotations as rot
from kinetograph.arrays import FloatArray
from kinetograph.kinematics import forward, landmark_positions
from kinetograph.methods.performance.fitted import Fitted
from kinetograph.methods.performance.live_search import Link
from kinetograph.methods.performance.pieces import pieces_of
from kinetograph.motion import Motion
from kinetograph.post.hand_follow import HandFollow
from kinetograph.post.playing import Player, Repertoire
from kinetograph.sampling import interpolate
from kinetograph.synthesis import LivePose, Piece

_STILL = 1e-6  # rate of playing a pose that is held
_RATES = (0.6, 1.6)  # of playing, between which the end of a piece is made for
_FASTEST = 0.3  # metres per second that a piece's place is corrected by at most, as more of its control is seen
_QUICKEST = float(np.radians(45.0))  # radians per second, its heading
_KEPT = 8.0  # seconds of a partner that are kept


@dataclass(eq=False)
class Partner:
    """The latest frames of a partner.

    Parameters
    ----------
    fps : float
    """

    fps: float
    _frames: deque[Motion] = field(default_factory=deque, init=False)
    _count: int = field(default=0, init=False)

    def add(self, frame: Motion) -> None:
        """Take the next frame."""
        self._frames.append(frame)
        self._count += 1
        if len(self._frames) > _KEPT * self.fps:
            self._frames.popleft()

    def at(self, time: float) -> Motion | None:
        """The frame that is nearest to a time in seconds, None where it is not kept."""
        index = round(time * self.fps) - (self._count - len(self._frames))
        return self._frames[index] if 0 <= index < len(self._frames) else None


@dataclass(eq=False)
class LiveMotion:
    """The frames of decided pieces.

    Parameters
    ----------
    fitted : Fitted
    partner : Partner, optional
        Whose hands are held.
    """

    fitted: Fitted
    partner: Partner | None = None

    def __post_init__(self) -> None:
        sources = self.fitted.sources
        self.fps = sources[0].motion.fps
        self.frames = 0
        self._player = Player(Repertoire.of([s.motion for s in sources], [s.annotations for s in sources]))
        self._links: deque[Link] = deque()
        self._piece: Piece | None = None
        self._start: int | None = None  # first steps may lie before the control
        self._hands = {side: HandFollow(side) for side in ("left", "right")}

    def decide(self, link: Link, samples: FloatArray, first: int) -> None:
        """Take what is decided: a piece that begins, or the end and the place of the one that goes on.

        Parameters
        ----------
        link : tuple of int
            State, first and last step.
        samples : ndarray, shape (T, P, 3)
            The latest control points at the search's rate.
        first : int
            The step of the first of them.
        """
        if self._links and self._links[-1][1] == link[1]:
            self._links[-1] = link
        else:
            self._links.append(link)
        if self._start == link[1]:
            self._piece = self._placed(link, samples, first)
        self._samples, self._first = samples, first

    def until(self, time: float) -> list[LivePose]:
        """The frames up to a time in seconds."""
        poses = []
        while self._links and self.frames / self.fps <= time + 1e-9:
            poses.append(self._next(self.frames / self.fps))
            self.frames += 1
        return poses

    def _next(self, now: float) -> LivePose:
        rate, dt = self.fitted.settings.rate, 1.0 / self.fps
        while len(self._links) > 1 and self._links[1][1] / rate <= now + 1e-9:
            self._links.popleft()
        link = self._links[0]
        if link[1] != self._start:
            self._begin(link, now - dt)
        assert self._piece is not None
        segment = self.fitted.segment_of(link[0])
        left, ahead = segment.stop - self._player.second, link[2] / rate - (now - dt)
        speed = _STILL if segment.held else float(np.clip(left / ahead if ahead > dt else 1.0, *_RATES))
        self._correct(dt)
        pose = self._player.step(dt, speed)
        frame = Motion(self._player.repertoire.skeleton, pose.translation[None], pose.rotations[None], self.fps)
        frame = self._with_hands(frame, now, dt)
        return LivePose(now, frame.translation[0], frame.rotations[0])

    def _begin(self, link: Link, now: float) -> None:
        """Jump to a piece, whose first frame may lie a little before or after the moment that is shown last."""
        segment = self.fitted.segment_of(link[0])
        self._start, self._piece = link[1], self._placed(link, self._samples, self._first)
        second = segment.start
        if not segment.held:
            stretch = (link[2] - link[1]) / self.fitted.settings.rate / segment.duration
            second += (now - link[1] / self.fitted.settings.rate) / stretch
        rotation, shift = np.array(self._piece.rotation), self._shift(self._piece, segment.source, second)
        if self.fitted.settings.alignment.continues and self.frames:
            rotation, shift = self._continued(segment.source, second)
        self._player.jump(segment.source, second, rotation, shift)

    def _placed(self, link: Link, samples: FloatArray, first: int) -> Piece:
        """The piece where the control seen so far puts it."""
        borders = np.array([link[1] - first, link[2] - first], dtype=float)
        segment = self.fitted.segment_of(link[0])
        return pieces_of(self.fitted, samples, self.fitted.settings.rate, [segment], borders)[0]

    def _continued(self, source: int, second: float) -> tuple[FloatArray, FloatArray]:
        """Rotation and shift by which a recording goes on from where the body is."""
        shown, coming = self._player.played().row, self._player.repertoire.at(source, second).row
        heading = float(rot.heading(shown[3:7]) - rot.heading(coming[3:7]))
        rotation = rot.about("y", heading)
        return rotation, (shown[:3] - rot.rotate(rotation, coming[:3])) * [1.0, 0.0, 1.0]

    def _shift(self, piece: Piece, source: int, second: float) -> FloatArray:
        """The shift that puts the root where the scaled and rotated recording has it."""
        shift = np.array(piece.shift)
        if piece.scale == 1.0:
            return shift
        root = self._player.repertoire.at(source, second).row[:3] * [1.0, 0.0, 1.0]
        return np.asarray(shift + rot.rotate(np.array(piece.rotation), root * (piece.scale - 1.0)))

    def _correct(self, dt: float) -> None:
        """Move what plays nearer to where its piece now belongs, by no more than a person would miss."""
        assert self._piece is not None
        player = self._player
        if self.fitted.settings.alignment.continues:
            return
        root = player.repertoire.at(player.recording, player.second).row[:3]
        wanted = np.array(self._piece.rotation)
        turn = rot.log(rot.multiply(wanted, rot.conjugate(player.rotation)))
        angle = float(np.linalg.norm(turn))
        share = 1.0 if angle < 1e-9 else min(1.0, _QUICKEST * dt / angle)
        rotation = rot.multiply(rot.exp(turn * share), player.rotation)
        here = rot.rotate(player.rotation, root) + player.shift
        there = rot.rotate(wanted, root) + self._shift(self._piece, player.recording, player.second)
        gap = there - here
        far = float(np.linalg.norm(gap))
        step = gap if far <= _FASTEST * dt else gap * (_FASTEST * dt / far)
        player.place(rotation, here + step - rot.rotate(rotation, root))

    def _with_hands(self, frame: Motion, now: float, dt: float) -> Motion:
        """The frame with hands on the partner's where the recording holds hands."""
        partner = None if self.partner is None else self.partner.at(now)
        source = self.fitted.sources[self._player.recording]
        second = self._player.second
        held = [n for n in source.annotations if n.kind == "handhold" and n.start <= second <= n.stop]
        for side, follow in self._hands.items():
            labels = [n.label for n in held if n.label.startswith(f"{side}_hand:") and n.label in source.grips]
            goal = None
            if partner is not None and labels:
                grip = interpolate(source.grips[labels[0]], np.array([second * source.motion.fps]))[0]
                goal = _hand_goal(partner, labels[0].split(":")[1], grip)
            frame = follow.step(frame, goal, dt)
        return frame


def _hand_goal(partner: Motion, role: str, grip: FloatArray) -> FloatArray | None:
    """Where a hand is to be that holds a partner's hand, None where the partner has none."""
    landmark = partner.skeleton.roles.get(role)
    if landmark is None:
        return None
    place = landmark_positions(partner, [landmark])[0, 0]
    return np.asarray(place + rot.rotate(forward(partner)[1][0, landmark.joint], grip))
