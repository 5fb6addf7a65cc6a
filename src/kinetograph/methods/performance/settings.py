"""The configuration of performance control, as data: `PerformanceControl` in ``model`` adds what it does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.learn import Alignment, Ground
from kinetograph.methods.bodies import Bodies
from kinetograph.methods.performance.control_points import ControlPoints, GroundPath
from kinetograph.methods.recordings import SIDES
from kinetograph.post.assemble import PostSettings

END_EFFECTORS: Mapping[str, float] = MappingProxyType(
    {"left_toe": 1.0, "right_toe": 1.0, "left_hand": 1.0, "right_hand": 1.0}
)
"""Weights of the roles that are compared across seams of walks."""

BODY: Mapping[str, float] = MappingProxyType(
    {"hips": 2.0, "chest": 2.0, "left_toe": 0.5, "right_toe": 0.5, "left_hand": 0.5, "right_hand": 0.5}
)
"""Weights of the roles that are compared across seams of dances."""


@dataclass(frozen=True)
class PerformanceSettings:
    """What performance control is configured by.

    Parameters
    ----------
    continuity : float
        k, the weight of continuity against interpretation, seconds (D is integrated over time).
    stretch : float
        How far a segment may be stretched or squeezed, seconds.
    rate : float
        Rate of the search, Hz.
    fine_rate : float, optional
        Rate of the constrained search that adjusts durations, Hz (section 4.4.3); None leaves them.
    alignment : Alignment
        Group of transforms by which segments are placed: `Ground`, `Similarity`, `Affine`, `Rigid`,
        `Fixed` or `Continued`.
    control_points : ControlPoints
        What of a control is compared with the recordings: `GroundPath` for walks, `PointsByRole` for partners,
        `Channels` for what does not lie in space.
    span : int
        Cuts that a segment goes on for; from 2 on, segments begin at every cut and overlap.
    targets : mapping of str to float
        Weights of the roles whose positions are compared across seams.
    beam : float, optional
        Width of the beam search (section 4.4.1); None searches exactly. From 5,000 states on, the best 0.3 % of a step
        are kept at most.
    cluster : float, optional
        Segments closer than this to one another are represented by one of them, metres (section 4.4.2).
    mirror : bool
        Use every recording mirrored as well.
    sides : tuple of (str, str)
        Words in the names of moves that are each other's mirror image.
    longest : float
        Longest segment used, seconds.
    reuse : float
        How much dearer a segment is that was used lately, as a share of its cost: 1.6 times this within a stride, and
        then less and less until 40 pieces later. 0 searches without, and exactly.
    change : float
        What it costs to go over to another person or style, m^2 s; 0 makes it free. Who a recording is of is its
        subject or else its folder, its style is its tags and the annotations of that kind.
    unusual : float
        What it costs, where a path is drawn, to do something else than walk, run, stand and turn, m^2 s per second.
    stand : bool
        Hold a calm pose of the recordings where a path stands still for long; otherwise steps are taken on the spot.
    keep_time : bool
        Follow a drawn path at its own times, even where it is faster than anybody in the recordings walks; otherwise
        it is followed in space there, and its end is reached later.
    first_facing : float
        How much it costs, of a control that is known as a whole, to face another way than it does at its first sample,
        m^2 s per squared radian; see `begin_facing`.
    post : PostSettings
        What happens to the chosen segments afterwards.
    bodies : Bodies
        Which skeleton is used of a library that has several.

    Raises
    ------
    RequestError
        For values out of range, and for channels with an alignment that moves points in space.
    """

    continuity: float = 0.1
    stretch: float = 0.2
    rate: float = 10.0
    fine_rate: float | None = 30.0
    alignment: Alignment = field(default_factory=Ground)
    control_points: ControlPoints = field(default_factory=GroundPath)
    span: int = 1
    targets: Mapping[str, float] = field(default_factory=lambda: END_EFFECTORS)
    beam: float | None = None
    cluster: float | None = None
    mirror: bool = False
    sides: tuple[tuple[str, str], ...] = SIDES
    longest: float = 2.5
    reuse: float = 0.5
    change: float = 0.002
    unusual: float = 0.005
    stand: bool = True
    keep_time: bool = False
    first_facing: float = 0.0
    post: PostSettings = field(default_factory=PostSettings)
    bodies: Bodies = field(default_factory=Bodies)

    def __post_init__(self) -> None:
        if not self.targets:
            raise RequestError("targets must name at least one role, found none")
        for name in ("continuity", "stretch", "reuse", "change", "unusual", "first_facing"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise RequestError(f"{name} must be 0 or more, found {getattr(self, name)}")
        for name in ("rate", "longest"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise RequestError(f"{name} must be a positive number, found {getattr(self, name)}")
        if not callable(getattr(self.alignment, "align", None)):
            raise RequestError(
                "alignment must be Ground(), Similarity(), Affine(), Rigid(), Fixed() or Continued(), "
                f"found {self.alignment!r}"
            )
        if self.alignment.moves and not self.control_points.spatial:
            raise RequestError(
                "channels do not lie in space: alignment must be Fixed() or Continued() (on the command line: none), "
                f"found {self.alignment}"
            )
        if self.post.onto_path is not None and not isinstance(self.control_points, GroundPath):
            raise RequestError(
                "hips are brought onto a path on the ground, and partners and channels have none: leave out onto_path "
                "(on the command line: --onto-path)"
            )
        if self.span < 1:
            raise RequestError(f"span must be 1 cut or more, found {self.span}")
        object.__setattr__(self, "targets", MappingProxyType(dict(self.targets)))
