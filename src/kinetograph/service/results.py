"""What a method made, for a client: on its body and at its rate, with where everything comes from."""

from __future__ import annotations

from dataclasses import replace

import msgspec

from kinetograph.character import Character
from kinetograph.motion import Motion, resample
from kinetograph.post import retarget
from kinetograph.post.rest_pose import leg_length
from kinetograph.service.bodies import Body, Moving, wearer_of, written
from kinetograph.skeleton import Skeleton, same_shape
from kinetograph.synthesis import Piece, Synthesis
from kinetograph.take import Annotation

SHAPE = 1e-3
"""Metres by which bones may differ for a body to be the library's own."""


class Output(msgspec.Struct, forbid_unknown_fields=True, kw_only=True):
    """What every request that makes a motion says of its result.

    Parameters
    ----------
    folder : str
        Where its arrays are written to.
    body : Body, optional
        The skeleton that it is made for; the library's unless given.
    fps : float, optional
        Frames per second; those of the library unless given.
    """

    folder: str
    body: Body | None = None
    fps: float | None = None


class Source(msgspec.Struct):
    """A part of a result, and the recording that it was.

    Parameters
    ----------
    start, stop : float
        Seconds of the result.
    take : str
    source_start, source_stop : float
        Seconds of the take.
    mirrored : bool
    """

    start: float
    stop: float
    take: str
    source_start: float
    source_stop: float
    mirrored: bool


class Contact(msgspec.Struct):
    """A span in which a part of the body is planted or holds.

    Parameters
    ----------
    kind, label : str
    start, stop : float
        Seconds of the result.
    """

    kind: str
    label: str
    start: float
    stop: float


class Driven(msgspec.Struct):
    """A part of the body that a layer drives.

    Parameters
    ----------
    name : str
    joints : tuple of str
        Of the library's body.
    start, stop : float
        Seconds of the result.
    """

    name: str
    joints: tuple[str, ...]
    start: float
    stop: float


class Made(msgspec.Struct):
    """A result.

    Parameters
    ----------
    motion : Moving
    frames : int
    sources : tuple of Source
    contacts : tuple of Contact
    cost : float
    warnings : tuple of str
    met : tuple of float
        Seconds at which keys are met.
    result : str
        What later requests call it; empty where none may.
    costs : dict of str to float
        The parts of the cost, where they are known.
    layers : tuple of Driven
    """

    motion: Moving
    frames: int
    sources: tuple[Source, ...]
    contacts: tuple[Contact, ...]
    cost: float
    warnings: tuple[str, ...] = ()
    met: tuple[float, ...] = ()
    result: str = ""
    costs: dict[str, float] = msgspec.field(default_factory=dict)
    layers: tuple[Driven, ...] = ()


def own_body(given: Body | None, library: Skeleton) -> Skeleton | Character | None:
    """The body of a client where it is another than the library's, or has a skin; None otherwise."""
    if given is None:
        return None
    body = wearer_of(given)
    return None if isinstance(body, Skeleton) and same_shape(body, library, SHAPE) else body


def ratio_of(body: Skeleton | Character | None, library: Skeleton) -> float:
    """How much longer the legs of a client's body are than the library's."""
    if body is None:
        return 1.0
    return leg_length(body.skeleton if isinstance(body, Character) else body) / leg_length(library)


def worn(
    motion: Motion,
    body: Skeleton | Character | None,
    fps: float | None,
    notes: tuple[Annotation, ...] = (),
    scale: float | None = None,
) -> Motion:
    """A motion of the library's body on a client's, at its rate.

    Parameters
    ----------
    motion : Motion
    body : Skeleton, Character or None
        None for the library's own.
    fps : float or None
        None for that of the motion.
    notes : tuple of Annotation
        Contacts and handholds.
    scale : float, optional
        Of the root path on the ground; that of the legs unless given.
    """
    if fps is not None and fps != motion.fps:
        motion = resample(motion, fps)
    return motion if body is None else retarget(motion, body, scale=scale, handholds=notes).motion


def made_of(synthesis: Synthesis, motion: Motion, output: Output, result: str = "") -> Made:
    """A synthesis for a client, with the motion that it became.

    Parameters
    ----------
    synthesis : Synthesis
    motion : Motion
        The synthesis' own, or on the client's body.
    output : Output
    result : str
        What later requests call it.
    """
    return Made(
        written(replace(motion, bones=None), output.folder),
        len(motion),
        tuple(_source(piece, motion.duration) for piece in synthesis.pieces if piece.start < motion.duration),
        tuple(Contact(n.kind, n.label, n.start, n.stop) for n in synthesis.annotations if n.kind != "cut"),
        float(synthesis.cost),
        synthesis.warnings,
        tuple(float(time) for time in synthesis.met),
        result,
        {name: float(cost) for name, cost in synthesis.costs.items()},
        tuple(Driven(each.name, each.joints, each.start, each.stop) for each in synthesis.layers),
    )


def _source(piece: Piece, end: float) -> Source:
    """A piece without what of it lies before or after the result."""
    start, stop = max(piece.start, 0.0), min(piece.stop, end)
    first, last = (piece.source_start,) * 2 if piece.held else piece.source_time([start, stop]).tolist()
    return Source(start, stop, piece.take, first, last, piece.mirrored)
