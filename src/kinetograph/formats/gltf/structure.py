"""The parts of a glTF document that are read, as types: a document of another structure is refused at the door."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import msgspec

from kinetograph.errors import FormatError

Index = Annotated[int, msgspec.Meta(ge=0, lt=2**40)]
Number = Annotated[float, msgspec.Meta(gt=-1e12, lt=1e12)]
Vec3 = tuple[Number, Number, Number]
Vec4 = tuple[Number, Number, Number, Number]

_OBJECTS, _LETTERS = 100_000, 20  # objects that a text may have, and one more for every so many letters
_COMPRESSED = ("EXT_meshopt_compression", "KHR_meshopt_compression")


class Part(msgspec.Struct, frozen=True):
    """An object in a document; what it has besides is not read."""


class Extras(Part, frozen=True):
    """What this package notes in the node of a character: the rate and the number of frames."""

    fps: Number | None = None
    frames: Index | None = None


class Node(Part, frozen=True):
    """A node of the scene."""

    name: str | None = None
    children: tuple[Index, ...] = ()
    matrix: Annotated[tuple[Number, ...], msgspec.Meta(min_length=16, max_length=16)] | None = None
    translation: Vec3 = (0.0, 0.0, 0.0)
    rotation: Vec4 = (0.0, 0.0, 0.0, 1.0)
    scale: Vec3 = (1.0, 1.0, 1.0)
    mesh: Index | None = None
    skin: Index | None = None
    extras: msgspec.Raw = msgspec.Raw()

    @property
    def noted(self) -> Extras:
        """What this package notes in its files."""
        try:
            return msgspec.json.decode(self.extras, type=Extras) if bytes(self.extras) else Extras()
        except (msgspec.DecodeError, RecursionError):
            return Extras()  # another program's extras may be anything


class Target(Part, frozen=True):
    """What a channel moves."""

    path: str = ""
    node: Index | None = None


class Channel(Part, frozen=True):
    """A part of an animation that moves one node."""

    sampler: Index
    target: Target = Target()


class Sampler(Part, frozen=True):
    """Keys: accessors of their times and of their values."""

    input: Index
    output: Index
    interpolation: str = "LINEAR"


class Animation(Part, frozen=True):
    """An animation."""

    name: str | None = None
    channels: tuple[Channel, ...] = ()
    samplers: tuple[Sampler, ...] = ()


class View(Part, frozen=True, rename="camel"):
    """A part of a buffer."""

    buffer: Index
    byte_length: Index
    byte_offset: Index = 0
    byte_stride: Annotated[int, msgspec.Meta(ge=1, lt=2**16)] | None = None


class Place(Part, frozen=True, rename="camel"):
    """Where rows of numbers begin in a view."""

    buffer_view: Index
    byte_offset: Index = 0
    component_type: int = 0


class Sparse(Part, frozen=True):
    """Rows that replace others."""

    count: Index
    indices: Place
    values: Place


class Accessor(Part, frozen=True, rename="camel"):
    """Rows of numbers."""

    component_type: int
    count: Index
    type: str
    buffer_view: Index | None = None
    byte_offset: Index = 0
    normalized: bool = False
    sparse: Sparse | None = None


class Buffer(Part, frozen=True, rename="camel"):
    """Bytes in the file, in the text or in another file."""

    byte_length: Index
    uri: str | None = None


class SkinPart(Part, frozen=True, rename="camel"):
    """The joints of a skin and the accessor of their inverse bind matrices."""

    joints: tuple[Index, ...]
    inverse_bind_matrices: Index | None = None


class Primitive(Part, frozen=True):
    """Triangles, or other pieces, of a mesh."""

    attributes: dict[str, Index]
    indices: Index | None = None
    material: Index | None = None
    mode: int = 4


class Mesh(Part, frozen=True):
    """A mesh."""

    primitives: tuple[Primitive, ...] = ()


class Surface(Part, frozen=True, rename="camel"):
    """The colour of a material."""

    base_color_factor: Vec4 | None = None


class Material(Part, frozen=True, rename="camel"):
    """A material."""

    name: str | None = None
    pbr_metallic_roughness: Surface = Surface()


class NamedBone(Part, frozen=True):
    """A bone of a VRM 0 humanoid."""

    bone: str
    node: int


class NamedBones(Part, frozen=True, rename="camel"):
    """The humanoid of VRM 0."""

    human_bones: tuple[NamedBone, ...] = ()


class Bone(Part, frozen=True):
    """A bone of a VRM 1 humanoid."""

    node: int


class Bones(Part, frozen=True, rename="camel"):
    """The humanoid of VRM 1 and of VRM animations."""

    human_bones: dict[str, Bone | None] = {}


class Vrm0(Part, frozen=True):
    """The extension ``VRM``."""

    humanoid: NamedBones = NamedBones()


class Vrm1(Part, frozen=True):
    """The extensions ``VRMC_vrm`` and ``VRMC_vrm_animation``."""

    humanoid: Bones = Bones()


class Extensions(Part, frozen=True):
    """The extensions that are read."""

    vrm0: Vrm0 | None = msgspec.field(default=None, name="VRM")
    vrm1: Vrm1 | None = msgspec.field(default=None, name="VRMC_vrm")
    vrm_animation: Vrm1 | None = msgspec.field(default=None, name="VRMC_vrm_animation")


class Document(Part, frozen=True, rename="camel"):
    """A glTF document."""

    nodes: tuple[Node, ...] = ()
    animations: tuple[Animation, ...] = ()
    skins: tuple[SkinPart, ...] = ()
    meshes: tuple[Mesh, ...] = ()
    materials: tuple[Material, ...] = ()
    textures: tuple[Part, ...] = ()
    accessors: tuple[Accessor, ...] = ()
    buffer_views: tuple[View, ...] = ()
    buffers: tuple[Buffer, ...] = ()
    extensions: Extensions = Extensions()
    extensions_required: tuple[str, ...] = ()


def document_of(path: Path, text: bytes) -> Document:
    """The document in the text of a glTF file.

    Parameters
    ----------
    path : Path
        The file, for errors.
    text : bytes
        JSON.

    Returns
    -------
    Document

    Raises
    ------
    FormatError
        The text is not JSON, its parts are not of the types that glTF gives them, or they are compressed.
    """
    objects = text.count(b"{")
    if objects > _OBJECTS + len(text) // _LETTERS:
        raise FormatError(path, f"{objects} objects in {len(text)} bytes of JSON are too many")
    try:
        document = _decoded(text.removeprefix(b"\xef\xbb\xbf"))
    except msgspec.ValidationError as error:
        raise FormatError(path, f"not the structure of glTF: {_first(str(error))}") from None
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise FormatError(path, f"expected the JSON of a glTF file: {str(error)[:80]}") from None
    if compressed := [name for name in document.extensions_required if name in _COMPRESSED]:
        raise FormatError(path, f"its numbers are compressed ({compressed[0]}): write it without compression")
    return document


def _decoded(text: bytes) -> Document:
    try:
        return msgspec.json.decode(text, type=Document)
    except msgspec.ValidationError as error:
        if "`int`, got `float`" not in str(error):
            raise
        return msgspec.json.decode(text, type=Document, strict=False)  # some programs write 3 as 3.0


def _first(message: str) -> str:
    """A message of msgspec with the place as a reader of JSON would write it."""
    what, _, place = message.partition(" - at ")
    where = place.strip("`").removeprefix("$.").replace("[...]", "[]")
    return f"{what[:1].lower()}{what[1:]}"[:120] + (f", at {where[:60]}" if where else "")
