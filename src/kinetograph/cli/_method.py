"""Options by which commands configure performance control, and the configuration they give."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

import typer

from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.methods.performance import Alignment, PerformanceControl

TargetTrack = Annotated[
    str | None, typer.Option("--target", "--track", help="The library's track to make, where takes have several.")
]
Continuity = Annotated[
    float | None, typer.Option(help="Weight of continuity against following the control; 0.1 as a rule.")
]
Stretch = Annotated[float | None, typer.Option(help="Seconds a segment may be stretched or squeezed.")]
Rate = Annotated[float | None, typer.Option(help="Rate of the search, Hz.")]
Span = Annotated[int | None, typer.Option(help="Cuts a segment goes on for; from 2 on, segments overlap.")]
Velocity = Annotated[
    float | None, typer.Option(help="Seconds by which a partner's velocity is weighed against position.")
]
ControlPoint = Annotated[
    list[str] | None, typer.Option(help="A partner's point that is followed: role=weight. Repeatable.")
]
TargetPoint = Annotated[list[str] | None, typer.Option(help="Compared across seams: role=weight. Repeatable.")]


@dataclass(frozen=True)
class Given:
    """What was given on the command line; None is what was not."""

    continuity: float | None = None
    stretch: float | None = None
    rate: float | None = None
    span: int | None = None
    velocity: float | None = None
    control_points: list[str] | None = None
    target_points: list[str] | None = None


def configured(given: Given, partners: bool, channels: tuple[str, ...] = ()) -> PerformanceControl:
    """The configuration for walkers or for partners, with what was given in its place.

    channels: the names of a control's channels, where it has no points.
    """
    from kinetograph.methods.performance import Channels, Fixed, PerformanceControl, PointsByRole, partner_control

    method = partner_control() if partners else PerformanceControl()
    for name in ("continuity", "stretch", "rate", "span"):
        if (value := getattr(given, name)) is not None:
            method = replace(method, **{name: value})
    if given.target_points:
        method = replace(method, targets=weights_by_role(given.target_points, "--target-point"))
    if partners and channels and given.velocity is None:
        followed = weights_by_role(given.control_points or list(channels), "--control-point")
        return replace(method, control_points=Channels(followed), alignment=Fixed())
    if isinstance(method.control_points, PointsByRole):
        points = method.control_points
        if given.velocity is not None:
            points = replace(points, velocity=given.velocity)
        if given.control_points:
            points = replace(points, roles=weights_by_role(given.control_points, "--control-point"))
        return replace(method, control_points=points)
    if given.velocity is not None or given.control_points:
        raise RequestError("--velocity and --control-point are for partners; name their track with --target")
    return method


def weights_by_role(given: list[str], option: str) -> dict[str, float]:
    """``role=weight`` options as a table; a role alone weighs 1. Raises RequestError."""
    weights = {}
    for item in given:
        role, separator, weight = item.partition("=")
        try:
            weights[role] = float(weight) if separator else 1.0
        except ValueError:
            raise RequestError(f"{option} takes role=weight, as in left_toe=1; found {item!r}") from None
    return weights


def aligned(name: str) -> Alignment:
    """The group of transforms of a name. Raises RequestError, naming them all."""
    from kinetograph.methods.performance import Fixed, Ground, Rigid, Similarity

    groups: dict[str, type[Ground | Similarity | Rigid | Fixed]] = {
        "ground": Ground,
        "similarity": Similarity,
        "rigid": Rigid,
        "fixed": Fixed,
        "none": Fixed,
    }
    if name not in groups:
        raise RequestError(f"alignment must be ground, similarity, rigid, fixed or none, found {name!r}")
    return groups[name]()
