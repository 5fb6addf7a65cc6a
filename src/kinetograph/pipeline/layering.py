"""Layers from files, motions and readings, and a synthesis that wears them."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from kinetograph.errors import RequestError
from kinetograph.library import Library
from kinetograph.methods.keyframe import KeyframeModel
from kinetograph.methods.performance import PerformanceModel
from kinetograph.methods.recordings import adopt
from kinetograph.methods.sensor import SensorControl
from kinetograph.motion import Motion
from kinetograph.pipeline.sensing import fit_sensor
from kinetograph.post import (
    Layer,
    LayerSettings,
    driven_joints,
    layer_weights,
    learn_following,
    limbs_of,
    retarget,
    seen_ranges,
    with_layer,
)
from kinetograph.progress import Progress
from kinetograph.sensing import Layout, Readings, attach, keep_sensors
from kinetograph.skeleton import Skeleton
from kinetograph.synthesis import DrivenPart, Synthesis
from kinetograph.take import Annotation


def sensors_of_parts(layout: Layout, skeleton: Skeleton, parts: Sequence[str]) -> Layout:
    """The sensors of a layout that say something of some parts of the body: those on them, and on the trunk.

    Parameters
    ----------
    layout : Layout
    skeleton : Skeleton
    parts : sequence of str
        See `kinetograph.post.Layer`.

    Raises
    ------
    RequestError
        Where none is left.
    """
    limbs = {landmark.joint for role, landmark in skeleton.roles.items() if role.split("_")[0] in ("left", "right")}
    driven, joints = driven_joints(skeleton, parts), attach(layout, skeleton)[0].tolist()
    pairs = zip(layout.names, joints, strict=True)
    names = tuple(name for name, joint in pairs if joint in driven or joint not in limbs)
    if not names:
        raise RequestError(
            f"layout {layout.name!r} has no sensor on {', '.join(parts)}; it has {', '.join(layout.names)}"
        )
    return keep_sensors(layout, names)


def rows_of(readings: Readings, names: Sequence[str]) -> Readings:
    """The rows of some sensors, those that are there.

    Raises
    ------
    RequestError
        Where there is none of them.
    """
    kept = [i for i, name in enumerate(readings.names) if name in names]
    if not kept:
        raise RequestError(f"expected readings of {', '.join(names)}, found {', '.join(readings.names)}")
    rows = np.isin(readings.sensors, kept)
    angular, orientation = (None if each is None else each[rows] for each in (readings.angular, readings.orientation))
    numbers = np.searchsorted(kept, readings.sensors[rows])
    worn = readings.mounting
    if worn is not None:
        worn = replace(worn, rotations=worn.rotations[kept], biases=worn.biases[kept])
    return Readings(
        tuple(readings.names[i] for i in kept),
        readings.times[rows],
        numbers,
        readings.force[rows],
        angular,
        orientation,
        worn,
    )


def sense_layer(
    readings: Readings,
    parts: Sequence[str],
    library: Library,
    method: SensorControl | None = None,
    *,
    exclude: Iterable[str] = (),
    note: Callable[[str], None] | None = None,
    progress: Progress | None = None,
) -> Layer:
    """A layer that sensors drive: of a layout, those on its parts and on the trunk.

    Parameters
    ----------
    readings : Readings
    parts : sequence of str
        See `kinetograph.post.Layer`.
    library : Library
        What poses are learnt from.
    method : SensorControl, optional
    exclude : iterable of str
        Names of takes to leave out.
    note : callable, optional
        Called with one line where what was learnt cannot be kept.
    progress : Progress, optional
        Called with what is done and the whole.

    Returns
    -------
    Layer
        It begins with the result.

    Raises
    ------
    RequestError
        For a layout without a sensor on the parts, and as `SensorControl.fit`.
    """
    method, left_out = method or SensorControl(), tuple(exclude)
    takes = [name for name in library.names() if name not in left_out]
    if not takes:
        raise RequestError("a layer of readings needs takes to learn poses from, found none")
    skeleton = library.take(takes[0]).motion().skeleton
    worn = sensors_of_parts(method.layout, skeleton, parts)
    model = fit_sensor(replace(method, layout=worn), library, exclude=left_out, note=note)
    made = model.synthesize(rows_of(readings, worn.names), progress)
    return Layer(made.motion, tuple(parts), pieces=made.pieces)


def recordings_of(model: PerformanceModel | KeyframeModel, synthesis: Synthesis) -> list[Motion]:
    """The recordings that a synthesis is made of, as its model has them, none mirrored."""
    used = {piece.take for piece in synthesis.pieces}
    if isinstance(model, PerformanceModel):
        return [source.motion for source in model.fitted.sources if source.take in used and not source.mirrored]
    return [example.motion for example in model.examples if example.take in used and not example.mirrored]


def layered(synthesis: Synthesis, layers: Sequence[Layer], recordings: Sequence[Motion] = ()) -> Synthesis:
    """A synthesis with parts of the body as layers have them.

    Parameters
    ----------
    synthesis : Synthesis
    layers : sequence of Layer
        In order; of two that drive a joint, the later one counts. Motions of other skeletons are retargeted.
    recordings : sequence of Motion
        Of the result's skeleton: those by which hips follow what is above them, besides the layers' own motions.

    Returns
    -------
    Synthesis
        Planted feet are where they were; handholds of hands that are driven are gone.

    Raises
    ------
    RequestError
        For a part that the body does not have, and a layer that lies outside the result.
    """
    motion, parts = synthesis.motion, list(synthesis.layers)
    ranges = seen_ranges([motion, *recordings], itertools.chain(*limbs_of(motion.skeleton)))
    for layer in layers:
        worn = replace(layer, motion=_on_body(layer.motion, motion.skeleton))
        weights = layer_weights(worn, len(motion), motion.fps)
        if not (weights > 0).any():
            raise RequestError(
                f"layer {layer.name!r} begins at {layer.start:g} s and lasts {layer.motion.duration:.2f} s: the "
                f"result, of {motion.duration:.2f} s, has none of it"
            )
        following = learn_following([*recordings, worn.motion])
        motion = with_layer(motion, worn, LayerSettings(following, ranges=ranges))
        frames = np.flatnonzero(weights > 0) / motion.fps
        joints = tuple(motion.skeleton.names[joint] for joint in driven_joints(motion.skeleton, layer.parts))
        moved = (replace(p, start=p.start + layer.start, stop=p.stop + layer.start) for p in layer.pieces)
        parts.append(DrivenPart(layer.name, joints, float(frames[0]), float(frames[-1]), tuple(moved)))
    notes = tuple(note for note in synthesis.annotations if not _let_go(note, parts, motion.skeleton))
    return replace(synthesis, motion=motion, layers=tuple(parts), annotations=notes)


def _on_body(motion: Motion, skeleton: Skeleton) -> Motion:
    own = motion.skeleton
    if len(own) == len(skeleton) and np.array_equal(own.parents, skeleton.parents) and own.names == skeleton.names:
        return adopt(motion, skeleton)
    return retarget(motion, skeleton).motion


def _let_go(note: Annotation, parts: Sequence[DrivenPart], skeleton: Skeleton) -> bool:
    """Whether a handhold is of a hand that a layer drives while it lasts."""
    hand = note.label.split(":")[0]
    if note.kind != "handhold" or hand not in skeleton.roles:
        return False
    joint = skeleton.names[skeleton.roles[hand].joint]
    return any(joint in part.joints and note.start < part.stop and note.stop > part.start for part in parts)
