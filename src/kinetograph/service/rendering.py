"""A request that comes as a document: a path or a partner with keys, moves, contacts and layers, in one search."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from kinetograph.formats import KeySources, Request
from kinetograph.formats.keys_json import key_of_row
from kinetograph.formats.request_json import OnPathRow
from kinetograph.library import Library
from kinetograph.methods.together.meeting import aims_of, meet
from kinetograph.motion import Motion, resample, sample
from kinetograph.pipeline import Fitting, Rendered, fit_keyframe, fit_performance, render_request
from kinetograph.post import retarget
from kinetograph.service.bodies import Moving, motion_of
from kinetograph.service.job import Job
from kinetograph.service.recordings import Recordings
from kinetograph.service.results import SHAPE, Made, Output, made_of, own_body, ratio_of, worn
from kinetograph.skeleton import Skeleton, same_shape


class Render(Output, forbid_unknown_fields=True, kw_only=True):
    """A motion that a request asks for.

    Parameters
    ----------
    recordings : Recordings
        What it is made of; a library that the request names is not used.
    request : Request
        See `kinetograph.formats.request_json`. Lengths are those of the client's world, whatever its body.
    motions : tuple of Moving
        The client's own: poses of keys, layers and a partner have their names in place of files, as in
        ``"pose": "motion@2.5"``.
    files : str
        The folder in which the request's files are.
    """

    recordings: Recordings
    request: Request
    motions: tuple[Moving, ...] = ()
    files: str = "."


def render(asked: Render, job: Job) -> Made:
    """What a request asks for, on the body that is asked for; the poses of the client's motions are met exactly."""
    library = asked.recordings.opened(job)
    theirs = {moving.name: motion_of(moving) for moving in asked.motions}
    own = _own_skeleton(asked, library)
    body = own_body(asked.body, own)
    request = _resized(asked, 1.0 / ratio_of(body, own))
    poses = _worn_by(own, theirs, request)
    sources = KeySources(library, folder=Path(asked.files), note=job.note, motions=poses)
    made = render_request(request, library, sources, job.progress, _fitting(job))
    motion = worn(_at_rate(made, asked.fps), body, None, made.synthesis.annotations)
    return made_of(made.synthesis, _exact(made, motion, asked, poses if body is None else theirs), asked)


def _own_skeleton(asked: Render, library: Library) -> Skeleton:
    """The body that the library's recordings are made on."""
    return library.take(library.names()[0]).motion(asked.request.target or None).skeleton


def _fitting(job: Job) -> Fitting:
    """Models are fitted once, and stay."""

    def performance(method: Any, library: Library, **given: Any) -> Any:
        return job.warm.fitted(
            library, ("performance", method, given.get("track")), partial(fit_performance, method, library, **given)
        )

    def keyframe(method: Any, library: Library, **given: Any) -> Any:
        return job.warm.fitted(
            library, ("keyframe", method, given.get("track")), partial(fit_keyframe, method, library, **given)
        )

    return Fitting(performance, keyframe)


def _worn_by(own: Skeleton, theirs: Mapping[str, Motion], request: Request) -> dict[str, Motion]:
    """The client's motions; those that poses are taken from, on the library's body."""
    posed = {row.pose.rpartition("@")[0] for row in request.keys}
    return {name: retarget(motion, own).motion if name in posed else motion for name, motion in theirs.items()}


def _resized(asked: Render, factor: float) -> Request:
    """The request with its lengths as the library's body goes them."""
    request = asked.request
    path = request.path
    if path is not None and not isinstance(path, str):
        path = tuple((t, x * factor, z * factor) for t, x, z in path)
    return msgspec.structs.replace(
        request,
        path=path,
        keys=tuple(_key_resized(row, factor) for row in request.keys),
        mirror=request.mirror or asked.recordings.mirror,
        smooth_space=request.smooth_space * factor,
    )


def _key_resized(row: OnPathRow, factor: float) -> OnPathRow:
    lengths: dict[str, Any] = {name: _times(getattr(row, name), factor) for name in ("position", "near")}
    along = None if row.along is None else row.along * factor
    parts = tuple(msgspec.structs.replace(part, position=_times(part.position, factor)) for part in row.parts)
    return msgspec.structs.replace(row, along=along, parts=parts, **lengths)


def _times(place: tuple[float, ...] | None, factor: float) -> Any:
    return None if place is None else tuple(value * factor for value in place)


def _at_rate(made: Rendered, fps: float | None) -> Motion:
    """A motion at a rate; one as long as its path has as many frames, so that the last is held for less than one."""
    motion, rate = made.synthesis.motion, fps or made.synthesis.motion.fps
    duration = motion.duration if made.control is None else made.control.duration
    frames = round(duration * rate) + 1
    if rate == motion.fps and frames == len(motion):
        return motion
    if abs(motion.duration - duration) > 1.5 / motion.fps:
        return resample(motion, rate)
    times = np.arange(frames) / rate
    return sample(motion, np.minimum(times, motion.duration), rate)


def _exact(made: Rendered, motion: Motion, asked: Render, theirs: Mapping[str, Motion]) -> Motion:
    """A motion that meets the client's own poses on its body and at its frames, by edits that fade away from them."""
    sources = KeySources(motions=theirs)
    keys = [
        replace(key_of_row(row, row.name or f"key {number}", sources), time=(second, second))
        for number, (row, second) in enumerate(zip(asked.request.keys, made.synthesis.met, strict=False), start=1)
        if row.pose.rpartition("@")[0] in theirs
    ]
    keys = [key for key in keys if same_shape(key.clip.skeleton, motion.skeleton, SHAPE)]
    met = aims_of(keys, motion.skeleton, motion.fps)
    return meet(motion, met, made.synthesis.annotations, made.model.method.post)[0] if met else motion
