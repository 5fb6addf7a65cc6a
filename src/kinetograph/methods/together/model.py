"""Controls together: a control is performed through keys, by the moves that are asked for, in one search.

`performed` reads as the path of a request: the control is bent to the places of keys; keys, moves, pieces and feet
become costs of the states of one segmental search; its pieces are joined; the keys are met exactly.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.keys import Key
from kinetograph.kinematics import joint_positions, role_positions
from kinetograph.methods.keyframe.key_parts import SHAPE
from kinetograph.methods.performance import (
    Control,
    Demand,
    Fitted,
    GroundPath,
    Moment,
    PerformanceModel,
    Reasons,
    at_rate,
    contact_moments,
    distances_to,
    explain,
    fitted_for,
    foot_moments,
    perform_read,
    performances,
    settle,
)
from kinetograph.methods.recordings import adopt, same_joints
from kinetograph.methods.together.asked import Asked, AskedKey, Several, middle_of, require_within, timed
from kinetograph.methods.together.filling import OnControl, filled, is_far
from kinetograph.methods.together.meeting import Met, aims_of, meet, seen_from_root
from kinetograph.methods.together.placing import bent_to
from kinetograph.methods.together.spans import Keyframes
from kinetograph.motion import Motion
from kinetograph.progress import Progress
from kinetograph.signal import Signal
from kinetograph.skeleton import same_shape
from kinetograph.synthesis import Synthesis
from kinetograph.take import Take


def performed(
    model: PerformanceModel,
    control: Take | Signal | Motion,
    asked: Asked,
    progress: Progress | None = None,
    keyframes: Keyframes | None = None,
) -> Synthesis:
    """A motion that performs a control, through keys, by the moves that are asked for.

    Parameters
    ----------
    model : PerformanceModel
    control : Take or Signal or Motion
    asked : Asked
        Nothing gives what `PerformanceModel.synthesize` does.
    progress : Progress, optional
        Called with the steps done and their number.
    keyframes : callable, optional
        Fits keyframe control to the same library where a key on a path needs it: spans around keys that no segment is
        like are filled by the timed search, as `Asked.fill` has it. Without it none are.

    Raises
    ------
    RequestError
        For a control that cannot be performed, and for keys that cannot be met, with the nearest that could.
    """
    read = _read(model, control, asked)
    if not (asked.keys or asked.feet or asked.contacts):
        return perform_read(model.fitted, read, progress, asked.rules)[0]
    keys, bent, demands = _demanded(model, read, asked)
    synthesis, settled = perform_read(model.fitted, bent, progress, demands)
    return _finished(model, (read, bent), synthesis, _at_times(keys, settled), asked, keyframes)


def performed_several(
    model: PerformanceModel,
    control: Take | Signal | Motion,
    asked: Asked,
    several: Several,
    keyframes: Keyframes | None = None,
) -> tuple[Synthesis, ...]:
    """The best motion that `performed` gives, and others that meet the same keys.

    Parameters
    ----------
    model : PerformanceModel
    control : Take or Signal or Motion
    asked : Asked
    several : Several
    keyframes : callable, optional
        See `performed`. Spans that are filled may be the same in all.

    Raises
    ------
    RequestError
        As `performed`.
    """
    read = _read(model, control, asked)
    if not (asked.keys or asked.feet or asked.contacts):
        return model.alternatives(control, several.count, asked.rules, alike=several.alike)
    keys, bent, demands = _demanded(model, read, asked)
    found = performances(model.fitted, bent, demands, several.count, alike=several.alike)
    return tuple(
        _finished(model, (read, bent), made, _at_times(keys, settled), asked, keyframes) for made, settled in found
    )


def _at_times(keys: Sequence[AskedKey], settled: Sequence[Demand]) -> list[Key]:
    """The keys at the times that the search has chosen."""
    seconds = [each.window[0] for each in settled[: len(keys)] if isinstance(each, Moment)]
    return [_at(each.key, second) for each, second in zip(keys, seconds, strict=True)]


def _finished(
    model: PerformanceModel,
    controls: tuple[Control, Control],
    synthesis: Synthesis,
    keys: Sequence[Key],
    asked: Asked,
    keyframes: Keyframes | None,
) -> Synthesis:
    """What was found for a control that was bent to keys, with its spans filled and its keys met."""
    read, bent = controls
    met = aims_of(keys, synthesis.motion.skeleton, synthesis.motion.fps)
    if keyframes is not None and asked.fill is not False and isinstance(model.method.control_points, GroundPath):
        aimed = _on_control(model, synthesis.motion, met, asked)
        synthesis, met = filled(synthesis, aimed, bent, keyframes)
    return _meeting(model, read, synthesis, met)


def explained(
    model: PerformanceModel, control: Take | Signal | Motion, asked: Asked, second: float, count: int = 10
) -> Reasons:
    """Why a piece is at a moment of a control, with all that is asked for.

    Parameters
    ----------
    model : PerformanceModel
    control : Take or Signal or Motion
    asked : Asked
    second : float
        Within the control.
    count : int
        How many pieces are compared.

    Raises
    ------
    RequestError
        As `performed`, and for a moment outside the control.
    """
    bent, demands = settled_demands(model, control, asked)
    return explain(model.fitted, bent, second, demands, count)


def settled_demands(
    model: PerformanceModel, control: Take | Signal | Motion, asked: Asked
) -> tuple[Control, tuple[Demand, ...]]:
    """The control as it is performed, and what the search is asked for, every moment at its best time.

    Parameters
    ----------
    model : PerformanceModel
    control : Take or Signal or Motion
    asked : Asked

    Raises
    ------
    RequestError
        As `performed`.
    """
    read = _read(model, control, asked)
    if not (asked.keys or asked.feet or asked.contacts):
        return read, asked.rules
    _, bent, demands = _demanded(model, read, asked)
    fitted = fitted_for(model.fitted, bent)
    x = at_rate(bent.points, bent.fps, fitted.settings.rate)
    return bent, settle(fitted, x, None, demands)[1]


def _read(model: PerformanceModel, control: Take | Signal | Motion, asked: Asked) -> Control:
    """The control, with the contacts that are asked for. Raises RequestError for spans outside it."""
    read = replace(model.read(control), contacts=asked.contacts)
    require_within(asked, read)
    return read


def _demanded(
    model: PerformanceModel, read: Control, asked: Asked
) -> tuple[tuple[AskedKey, ...], Control, list[Demand]]:
    """The keys at their times, the control bent to them, and what the search is asked for."""
    keys = tuple(_on_body(each, model.fitted) for each in timed(asked.keys, read))
    _require_ground(model, keys)
    fitted = model.fitted
    skeleton, timed_keys = fitted.sources[0].motion.skeleton, [each.key for each in keys]
    for each in timed_keys:  # what cannot be met is refused before the work
        aims_of([_at_once(each)], skeleton, read.fps)
    aims_of([each for each in timed_keys if each.time == _at_once(each).time], skeleton, read.fps)
    moments = [_moment(fitted, each) for each in keys]
    bent = bent_to(read, [_at_once(each.key) for each in keys], fitted)
    return keys, bent, [*moments, *asked.rules, *_feet(fitted, asked)]


def _require_ground(model: PerformanceModel, keys: Sequence[AskedKey]) -> None:
    """Raise RequestError for places and headings where the control is no path."""
    if isinstance(model.method.control_points, GroundPath):
        return
    for each in keys:
        if each.key.position is not None or each.key.heading is not None:
            raise RequestError(
                f"{each.key.label}: with a partner its place and heading follow from the partner; leave them out"
            )


def _on_body(asked: AskedKey, fitted: Fitted) -> AskedKey:
    """A key on the body of the result, where it has the same joints with other bones."""
    skeleton, clip = fitted.sources[0].motion.skeleton, asked.key.clip
    if same_shape(clip.skeleton, skeleton, tolerance=SHAPE) or not same_joints(clip.skeleton, skeleton):
        return asked
    return replace(asked, key=replace(asked.key, clip=replace(adopt(clip, skeleton), bones=None)))


def _at(key: Key, second: float) -> Key:
    return replace(key, time=(second, second))


def _at_once(key: Key) -> Key:
    """A key at the middle of its window."""
    assert key.time is not None
    return _at(key, 0.5 * (key.time[0] + key.time[1]))


def _moment(fitted: Fitted, asked: AskedKey) -> Moment:
    """What a key costs in the search."""
    assert asked.key.time is not None
    costs = tuple(asked.weight * each**2 for each in distances_to(fitted, asked.key))
    return Moment(asked.key.time, costs, asked.key.label)


def _feet(fitted: Fitted, asked: Asked) -> Iterator[Moment]:
    for span in asked.feet:
        yield from foot_moments(fitted, (span.start, span.stop), (span.first, span.last))
    for contact in asked.contacts:
        yield from contact_moments(fitted, contact)


def _on_control(model: PerformanceModel, motion: Motion, met: Sequence[Met], asked: Asked) -> list[OnControl]:
    """The keys of a performance: which are far from it, and which let the control wait."""
    waits = [each.placed and not model.method.keep_time for each in asked.keys]
    far = [is_far(motion, each) and (wait or bool(asked.fill)) for each, wait in zip(met, waits, strict=True)]
    return [OnControl(*each) for each in zip(met, far, waits, strict=True)]


def _meeting(model: PerformanceModel, control: Control, synthesis: Synthesis, met: Sequence[Met]) -> Synthesis:
    """A synthesis that meets keys, with what the path loses by them."""
    motion = synthesis.motion
    made, annotations = motion, synthesis.annotations
    if met:
        made, annotations = meet(motion, met, annotations, model.method.post)
    moved = edited_by(motion, made)
    off = off_path(replace(synthesis, motion=made), control)
    return replace(
        synthesis,
        motion=made,
        annotations=annotations,
        edited=synthesis.edited + moved if len(synthesis.edited) else synthesis.edited,
        met=tuple(each.frame / motion.fps for each in met),
        statistics={**synthesis.statistics, "path_off_mean": float(off.mean()), "path_off_most": float(off.max())},
    )


def edited_by(before: Motion, after: Motion) -> FloatArray:
    """How far joints were moved in the mean by an edit, metres ``(F,)``."""
    return np.asarray(np.linalg.norm(joint_positions(after) - joint_positions(before), axis=-1).mean(axis=1))


def off_path(made: Synthesis, control: Control) -> FloatArray:
    """How far the hips are from the middle of a control on the ground, metres ``(F,)``; where it waits, from there."""
    hips = role_positions(made.motion, ("left_hip", "right_hip")).mean(axis=1)
    wanted = middle_of(control.points)
    at = (made.clock if len(made.clock) else np.arange(len(hips)) / made.motion.fps) * control.fps
    z, x = (np.interp(at, np.arange(len(wanted)), each) for each in (wanted.real, wanted.imag))
    return np.asarray(np.hypot(hips[:, 2] - z, hips[:, 0] - x))


def pose_errors(model: PerformanceModel, made: Synthesis, asked: Sequence[AskedKey]) -> tuple[float, ...]:
    """How far the furthest joint of each key is from where it is in its pose, as seen from the root, in metres.

    Parameters
    ----------
    model : PerformanceModel
    made : Synthesis
        What `performed` gave.
    asked : sequence of AskedKey
        Keys of whole poses, all that it was asked for.
    """
    keys = [_on_body(each, model.fitted).key for each in asked]
    frames = [round(second * made.motion.fps) for second in made.met]
    gaps = (seen_from_root(k) - seen_from_root(Key(made.motion, f)) for k, f in zip(keys, frames, strict=True))
    return tuple(float(np.linalg.norm(gap, axis=-1).max()) for gap in gaps)
