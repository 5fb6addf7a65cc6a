"""A path with times becomes a walk, and a leader is answered by a follower."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.formats.csv import path_of
from kinetograph.library import Library
from kinetograph.methods.performance import PerformanceControl, PerformanceModel, partner_control, with_settings
from kinetograph.motion import Motion, resample, sample
from kinetograph.pipeline import Smoothing, fit_performance, has_partners, perform_with
from kinetograph.post import OntoPath, PostSettings
from kinetograph.service.bodies import Moving, motion_of
from kinetograph.service.job import Job
from kinetograph.service.recordings import Recordings
from kinetograph.service.results import Made, Output, made_of, own_body, ratio_of, worn
from kinetograph.signal import Signal

Row = tuple[float, float, float]


class Walk(Output, forbid_unknown_fields=True, kw_only=True):
    """A walk along a path.

    Parameters
    ----------
    recordings : Recordings
    path : tuple of (float, float, float)
        Seconds, and metres x and z on the ground, with Y up.
    keep_time : bool
        Keep the path's times where it is faster than the recordings.
    smooth_time : float
        Seconds over which the path is smoothed.
    onto_path : float, optional
        Seconds over which the hips sway about the path that they are brought onto, 0 for not at all; without it they
        are where the recordings have them. See `kinetograph.post.OntoPath`.
    """

    recordings: Recordings
    path: tuple[Row, ...]
    keep_time: bool = True
    smooth_time: float = 0.0
    onto_path: float | None = None


class Follow(Output, forbid_unknown_fields=True, kw_only=True):
    """A follower of a leader.

    Parameters
    ----------
    recordings : Recordings
        Takes of two people.
    leader : Moving
    target : str
        The track of the one who follows.
    """

    recordings: Recordings
    leader: Moving
    target: str = "follower"


def walk(asked: Walk, job: Job) -> Made:
    """A walk along a path, on the body that is asked for.

    The path is walked on the scale of the library's legs, so that steps keep their length against the body's and the
    path comes out as it was asked for.
    """
    library = asked.recordings.opened(job)
    path = _path(asked.path)
    post = PostSettings(onto_path=None if asked.onto_path is None else OntoPath(asked.onto_path))
    method = replace(PerformanceControl(), mirror=asked.recordings.mirror, keep_time=asked.keep_time, post=post)
    model = _model(method, library, None, job)
    own = model.fitted.sources[0].motion.skeleton
    body = own_body(asked.body, own)
    control = _longer(path, 1.0 / model.fitted.sources[0].motion.fps)
    control = replace(control, values=control.values / ratio_of(body, own))
    made = perform_with(model, control, smoothing=Smoothing(asked.smooth_time), progress=job.progress)
    motion = _as_long(made.motion, path.duration, asked.fps)
    return made_of(made, worn(motion, body, None, made.annotations), asked)


def _as_long(motion: Motion, seconds: float, fps: float | None) -> Motion:
    """A motion at a rate, with as many frames as its path has; one that is reached later has all of its own."""
    rate = motion.fps if fps is None else fps
    if abs(motion.duration - seconds) > 1.5 / motion.fps:
        return resample(motion, rate)
    times = np.arange(round(seconds * rate) + 1) / rate
    return sample(motion, np.minimum(times, motion.duration), rate)


def _longer(path: Signal, seconds: float) -> Signal:
    """A path that goes straight on at its end, so that frames between its last two are frames of the motion as well."""
    steps = np.arange(1, int(np.ceil(seconds * path.fps - 1e-6)) + 1)[:, None, None]
    more = path.values[-1] + steps * (path.values[-1] - path.values[-2])
    return Signal(np.concatenate([path.values, more]), path.names, path.units, path.fps)


def _path(rows: tuple[Row, ...]) -> Signal:
    points = np.array(rows, dtype=np.float64).reshape(-1, 3)
    if len(points) < 2:
        raise RequestError(f"a path has two points or more, found {len(points)}; draw a longer one")
    if float(np.linalg.norm(np.ptp(points[:, 1:], axis=0))) < 0.05:
        raise RequestError("the path goes nowhere: all its points are within 5 cm; draw a longer one")
    return path_of(rows, "the path")


def follow(asked: Follow, job: Job) -> Made:
    """A follower of a leader, in whose hands its hands are as in the recordings."""
    library = asked.recordings.opened(job)
    leader = motion_of(asked.leader)
    has_partners(library, asked.target)
    method = replace(partner_control(), mirror=asked.recordings.mirror)
    model = _model(method, library, asked.target, job)
    own = model.fitted.sources[0].motion.skeleton
    body = own_body(asked.body, own)
    made = perform_with(model, leader, progress=job.progress)
    return made_of(made, worn(made.motion, body, asked.fps, made.annotations, scale=1.0), asked)


def _model(method: PerformanceControl, library: Library, target: str | None, job: Job) -> PerformanceModel:
    """A model that is fitted once for all that is done after its search."""
    plain = replace(method, post=PostSettings(), keep_time=False)
    model = job.warm.fitted(
        library, (plain, target), lambda: fit_performance(plain, library, track=target, note=job.note)
    )
    return replace(model, fitted=with_settings(model.fitted, method))
