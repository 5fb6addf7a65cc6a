"""Options that configure the three methods, and the configurations they give: nothing else of the package does."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from kinetograph.cli.options import Floor, Footskate, options
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.methods.keyframe import KeyframeControl, Solver
    from kinetograph.methods.performance import Alignment, PerformanceControl
    from kinetograph.methods.sensor import PoseSynthesis, SensorControl
    from kinetograph.work import Workers

# ---- performance control ----


@options("Control")
class Partner:
    """What of a partner is followed."""

    control_point: Annotated[
        list[str] | None, typer.Option(help="A point of the partner, or a channel, to follow: role=weight. Repeatable.")
    ] = None
    velocity: Annotated[
        float | None, typer.Option(help="Weight of a partner's velocity against its position (seconds); default 0.2.")
    ] = None


@options("Search")
class Search:
    """The search for segments."""

    continuity: Annotated[
        float | None, typer.Option(help="Weight of continuity against following the control; default 0.1.")
    ] = None
    stretch: Annotated[
        float | None,
        typer.Option(help="Seconds that a segment may be stretched or squeezed; default 0.2, partners 0.15."),
    ] = None
    rate: Annotated[float | None, typer.Option(help="Rate of the search (Hz); default 10, partners 7.5.")] = None
    span: Annotated[
        int | None, typer.Option(help="Cuts that a segment spans; from 2 on, segments overlap; default 1, partners 2.")
    ] = None
    target_point: Annotated[
        list[str] | None, typer.Option(help="A point compared where segments meet: role=weight. Repeatable.")
    ] = None
    beam: Annotated[float | None, typer.Option(help="Width of a beam search; without it the search is exact.")] = None
    cluster: Annotated[
        list[str] | None,
        typer.Option(
            help="Cluster segments closer than this (metres), for speed; or the Dask scheduler whose "
            "workers share the work: tcp://HOST:PORT. Repeatable, for both."
        ),
    ] = None
    reuse: Annotated[
        float | None,
        typer.Option(help="How much dearer a step is that was used lately, a share; 0: free; default 0.5, partners 0."),
    ] = None
    change: Annotated[
        float | None,
        typer.Option(help="What it costs to go over to another person or style (subject or folder, tags); 0: free."),
    ] = None
    unusual: Annotated[
        float | None,
        typer.Option(help="What a second costs in which a drawn path is not walked or run; 0: nothing is preferred."),
    ] = None

    @property
    def clustering(self) -> float | None:
        """Metres within which segments are clustered. Raises RequestError for what is neither that nor an address."""
        given = [text for text in self.cluster or () if "://" not in text]
        if len(given) > 1:
            raise RequestError(f"--cluster: expected one distance in metres, found {', '.join(given)}")
        try:
            return float(given[0]) if given else None
        except ValueError:
            raise RequestError(
                f"--cluster: expected metres, or the address of a Dask scheduler, tcp://HOST:PORT; found {given[0]!r}"
            ) from None

    def require_here(self) -> None:
        """Raise RequestError for a cluster, where a command works in this process."""
        if self.workers(1).cluster is not None:
            raise RequestError("--cluster: this command works on this machine only; it takes a distance in metres here")

    def workers(self, jobs: int) -> Workers:
        """Who does the work. Raises RequestError for several clusters."""
        from kinetograph.work import Workers

        given = [text for text in self.cluster or () if "://" in text]
        if len(given) > 1:
            raise RequestError(f"--cluster: expected one address, found {', '.join(given)}")
        return Workers(jobs, given[0] if given else None)


@options("After the search")
class Finish:
    """What happens to the segments that are chosen."""

    blend: Annotated[str, typer.Option(help="Blend at seams: inertialised, linear or none.")] = "inertialised"
    footskate: Footskate = True
    handholds: Annotated[bool, typer.Option(help="Bring hands together with the partner's, as in the recordings.")] = (
        True
    )
    limits: Annotated[bool, typer.Option(help="Keep arms and legs within the recorded ranges of their joints.")] = True
    floor: Floor = True


def performance_control(
    search: Search, partner: Partner, *, mirror: bool, partners: bool, channels: Sequence[str] = ()
) -> PerformanceControl:
    """The configuration that follows a path, or a partner, with the options that were given.

    Parameters
    ----------
    search : Search
        How segments are searched for.
    partner : Partner
        What of a partner is followed.
    mirror : bool
        Whether recordings are used mirrored as well.
    partners : bool
        Whether the library's takes have partners.
    channels : sequence of str
        The names of the control's channels, where it has no points.

    Raises
    ------
    RequestError
        For options of partners where there are none, and for weights that cannot be read.
    """
    from kinetograph.methods.performance import PerformanceControl, partner_control

    method = partner_control() if partners else PerformanceControl()
    names = ("continuity", "stretch", "rate", "span", "reuse", "change", "unusual")
    method = replace(method, **{name: value for name in names if (value := getattr(search, name)) is not None})
    if search.target_point:
        method = replace(method, targets=weights_by_role(search.target_point, "--target-point"))
    method = _following(method, partner, channels if partners else ())
    return replace(method, beam=search.beam, cluster=search.clustering, mirror=mirror)


def _following(method: PerformanceControl, partner: Partner, channels: Sequence[str]) -> PerformanceControl:
    """The configuration with the control points of a partner, or with channels."""
    from kinetograph.methods.performance import Channels, Fixed, PointsByRole

    if channels and partner.velocity is None:
        weights = weights_by_role(partner.control_point or channels, "--control-point")
        return replace(method, control_points=Channels(weights), alignment=Fixed())
    points = method.control_points
    if isinstance(points, PointsByRole):
        if partner.velocity is not None:
            points = replace(points, velocity=partner.velocity)
        if partner.control_point:
            points = replace(points, roles=weights_by_role(partner.control_point, "--control-point"))
        return replace(method, control_points=points)
    if partner.velocity is not None or partner.control_point:
        raise RequestError("--velocity and --control-point are for partners; name their track with --target")
    return method


def finished(method: PerformanceControl, alignment: str | None, finish: Finish) -> PerformanceControl:
    """The configuration with an alignment, if one is named, and with what happens after the search."""
    from kinetograph.post import HoldSettings, JointLimits, PostSettings

    post = PostSettings(
        blend=finish.blend,
        footskate=finish.footskate,
        handholds=HoldSettings() if finish.handholds else None,
        limits=JointLimits() if finish.limits else None,
        floor=finish.floor,
    )
    return replace(method, alignment=aligned(alignment) if alignment else method.alignment, post=post)


def onto(method: PerformanceControl, sway: float) -> PerformanceControl:
    """The configuration that brings the hips onto the path.

    Parameters
    ----------
    method : PerformanceControl
    sway : float
        Seconds; see `kinetograph.post.OntoPath`.

    Raises
    ------
    RequestError
        For less than 0 s, and for partners.
    """
    from kinetograph.post import OntoPath

    return replace(method, post=replace(method.post, onto_path=OntoPath(sway)))


def aligned(name: str) -> Alignment:
    """The group of transforms of a name.

    Raises
    ------
    RequestError
        For another name; the message has them all.
    """
    from kinetograph.methods.performance import Affine, Fixed, Ground, Rigid, Similarity

    groups: dict[str, type[Ground | Similarity | Affine | Rigid | Fixed]] = {
        "ground": Ground,
        "similarity": Similarity,
        "affine": Affine,
        "rigid": Rigid,
        "fixed": Fixed,
        "none": Fixed,
    }
    if name not in groups:
        raise RequestError(f"alignment must be ground, similarity, affine, rigid, fixed or none, found {name!r}")
    return groups[name]()


def weights_by_role(items: Sequence[str], option: str) -> dict[str, float]:
    """``role=weight`` options as a table; a role alone weighs 1.

    Raises
    ------
    RequestError
        For a weight that is no number.

    Examples
    --------
    >>> weights_by_role(["left_toe=2", "hips"], "--target-point")
    {'left_toe': 2.0, 'hips': 1.0}
    """
    weights = {}
    for item in items:
        role, separator, weight = item.partition("=")
        try:
            weights[role] = float(weight) if separator else 1.0
        except ValueError:
            raise RequestError(f"{option} takes role=weight, as in left_toe=1; found {item!r}") from None
    return weights


# ---- keyframe control ----


@options("Search")
class InbetweenSearch:
    """The search from pose to pose."""

    mode: Annotated[str, typer.Option(help="search, or paper (Molina-Tanco and Hilton 2000).")] = "search"
    meet: Annotated[float, typer.Option(help="Greatest distance (metres) between poses where recordings change.")] = (
        0.65
    )
    rate: Annotated[float, typer.Option(help="Frames per second of the search and of the result.")] = 30.0
    move: Annotated[
        list[str] | None,
        typer.Option(
            help="Go by way of this, in place of standing, walking and turning: a take, the label of a move or style, "
            "a word of one, or a pattern. Repeatable."
        ),
    ] = None
    filler: Annotated[bool, typer.Option(help="Let any recording fill in, at no cost.")] = False
    force_timing: Annotated[
        bool, typer.Option("--force-timing", help="Make motion that is worse than the recordings, with a warning.")
    ] = False
    clusters: Annotated[int, typer.Option(help="Number of clusters in the paper's mode.")] = 15
    seed: Annotated[int, typer.Option(help="Seed of the clusters in the paper's mode.")] = 0


def keyframe_control(
    search: InbetweenSearch, without: tuple[str, ...] = (), *, mirror: bool, footskate: bool, floor: bool = True
) -> KeyframeControl:
    """The configuration that goes from pose to pose, without what is called by some names."""
    from kinetograph.methods.keyframe import KeyframeControl
    from kinetograph.post import PostSettings

    post = PostSettings(footskate=footskate, floor=floor)
    return KeyframeControl(solver=_solver(search, without), rate=search.rate, mirror=mirror, post=post)


def _solver(search: InbetweenSearch, without: tuple[str, ...]) -> Solver:
    from kinetograph.methods.keyframe import ClusterChain, TimedSearch

    if search.mode == "search":
        moves = tuple(search.move or ())
        named = TimedSearch(meet=search.meet, moves=moves, without=without, force_timing=search.force_timing)
        return replace(named, begin_unasked=0.0, unasked=0.0) if search.filler else named
    if search.mode == "paper":
        if search.move or without:
            raise RequestError("the paper's mode knows no names of moves; use --move and --without with --mode search")
        return ClusterChain(clusters=search.clusters)
    raise RequestError(f"mode must be one of search, paper, found {search.mode!r}")


def own_control(mode: str, clusters: int, rate: float, mirror: bool) -> KeyframeControl:
    """The configuration in a mode, all else as it is by default."""
    from kinetograph.methods.keyframe import ClusterChain, KeyframeControl, TimedSearch

    solvers: dict[str, Solver] = {"search": TimedSearch(), "paper": ClusterChain(clusters=clusters)}
    if mode not in solvers:
        raise RequestError(f"mode must be one of search, paper, found {mode!r}")
    return KeyframeControl(solver=solvers[mode], rate=rate, mirror=mirror)


def gap_filling_control(rate: float, mirror: bool) -> KeyframeControl:
    """The configuration that fills gaps in recordings."""
    from kinetograph.methods.keyframe import KeyframeControl

    return KeyframeControl(rate=rate, mirror=mirror)


# ---- sensor control ----

LayoutName = Annotated[str, typer.Option(help="Which sensor is worn where: a .toml file, or wii, phone, imu, ideal.")]


@options("Sensors")
class Sensors:
    """What is worn, and what of it is used."""

    layout: LayoutName = "wii"
    use: Annotated[
        list[str] | None, typer.Option(help="Kinds of columns to use: force, angular, tilt. Repeatable.")
    ] = None


@options("Estimation")
class Estimation:
    """How poses are estimated."""

    reduction: Annotated[str, typer.Option(help="Reduction of the local models: pca or lle.")] = "pca"
    smoothing: Annotated[str | None, typer.Option(help="Smoothing: window, causal or none.")] = None


@options("Settings of the synthesis")
class Tuning:
    """Settings that one synthesis or the other has."""

    memory: Annotated[
        float | None, typer.Option(help="Continuity: seconds after which a reading's weight has fallen to 1/e.")
    ] = None
    jump: Annotated[
        float | None, typer.Option(help="Continuity: what going on at another place costs (squared deviations).")
    ] = None
    warp: Annotated[float | None, typer.Option(help="Continuity: what a step that is not one frame costs.")] = None
    lag: Annotated[float | None, typer.Option(help="Continuity: seconds by which answers look back.")] = None
    paths: Annotated[int | None, typer.Option(help="Continuity: number of paths that are averaged.")] = None
    cautious: Annotated[
        bool | None, typer.Option(help="Continuity: shrink towards the mean pose where paths differ.")
    ] = None
    ahead: Annotated[
        float | None, typer.Option(help="Optimisation: seconds looked ahead; 0: frame by frame, as in the thesis.")
    ] = None
    smoothness: Annotated[float | None, typer.Option(help="Optimisation: weight of smoothness (thesis, 6.3).")] = None
    control_weight: Annotated[
        float | None, typer.Option(help="Optimisation: weight of the readings (thesis, 6.4).")
    ] = None
    choice: Annotated[
        str | None, typer.Option(help="Local models: cluster for readings, by density, or by the nearest mean.")
    ] = None
    clusters: Annotated[int | None, typer.Option(help="Local models: clusters to begin with.")] = None

    @property
    def given(self) -> dict[str, float | int | str]:
        """The settings that were given, by name."""
        return {name: value for name, value in vars(self).items() if value is not None}


def sensor_control(
    sensors: Sensors,
    estimation: Estimation,
    synthesis: str,
    kinds: Sequence[str],
    rate: float = 60.0,
    tuning: Tuning | None = None,
) -> SensorControl:
    """The configuration that estimates poses from readings.

    Parameters
    ----------
    sensors : Sensors
        What is worn.
    estimation : Estimation
        How poses are estimated.
    synthesis : str
        One of `kinetograph.methods.sensor.SYNTHESES`.
    kinds : sequence of str
        The kinds of columns to use where none are named.
    rate : float
        Frames per second.
    tuning : Tuning, optional
        Settings of the synthesis.

    Raises
    ------
    RequestError
        For settings that the synthesis does not have.
    """
    from kinetograph.formats.readings import read_layout
    from kinetograph.methods.sensor import SensorControl, smoothing_named, tuned

    return SensorControl(
        layout=read_layout(sensors.layout),
        kinds=tuple(sensors.use or kinds),
        synthesis=tuned(syntheses(estimation, (synthesis,))[synthesis], {} if tuning is None else tuning.given),
        smoothing=smoothing_named(estimation.smoothing),
        rate=rate,
    )


def syntheses(estimation: Estimation, names: Iterable[str] | None) -> dict[str, PoseSynthesis]:
    """The syntheses of some names, or all."""
    from kinetograph.methods.sensor import SYNTHESES, synthesis_named

    return {name: synthesis_named(name, estimation.reduction) for name in names or SYNTHESES}
