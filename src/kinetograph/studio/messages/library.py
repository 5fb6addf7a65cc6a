"""What is said about libraries and exports."""

from __future__ import annotations

import msgspec

from kinetograph.studio.messages.frames import Message


class Export(Message, frozen=True, tag="export"):
    """Write what is shown into files.

    Parameters
    ----------
    id : int
    formats : tuple of str
        Suffixes, as in ``(".bvh", ".glb")``.
    name : str
        Of the files, without a suffix.
    together : bool
        Write what is shown with it, such as its leader, where the format holds several bodies.
    """

    id: int
    formats: tuple[str, ...]
    name: str
    together: bool = False


class AskTakes(Message, frozen=True, tag="ask_takes"):
    """Which takes a library has.

    Parameters
    ----------
    id : int
    library : str
        ``""`` for the first.
    words : str
        All are found in the name of a take or in one of its tags; one with ``*`` or ``?`` is a pattern.
    tags : tuple of str
        All are tags of a take.
    first, count : int
        The part of what is found that is sent.
    """

    id: int
    library: str = ""
    words: str = ""
    tags: tuple[str, ...] = ()
    first: int = 0
    count: int = 200


class AskThumbnails(Message, frozen=True, tag="ask_thumbnails"):
    """Thumbnails of takes of a library."""

    id: int
    takes: tuple[str, ...]
    library: str = ""


class AskClip(Message, frozen=True, tag="ask_clip"):
    """A take of a library as it was recorded; answered by a clip."""

    id: int
    take: str
    library: str = ""


class AskAlike(Message, frozen=True, tag="ask_alike"):
    """Where a library has something like a part of a take.

    Parameters
    ----------
    id : int
    take : str
        ``""`` for what is shown.
    start, stop : float
        Seconds.
    library : str
        ``""`` for the first.
    count : int
    """

    id: int
    take: str
    start: float
    stop: float
    library: str = ""
    count: int = 50


class Exported(Message, frozen=True, tag="exported"):
    """Files that were written: their names, and where the page can fetch them from."""

    id: int
    files: tuple[tuple[str, str], ...]


class TakeRow(msgspec.Struct, frozen=True):
    """A take of a library."""

    name: str
    seconds: float
    tracks: tuple[str, ...]
    tags: tuple[str, ...]


class Takes(Message, frozen=True, tag="takes"):
    """Takes of a library.

    Parameters
    ----------
    id : int
    found, all : int
        How many there are with the words and tags, and how many in the library.
    rows : tuple of TakeRow
        The part that was asked for.
    tags : tuple of (str, int)
        The tags of the library, and how many takes have each.
    """

    id: int
    found: int
    all: int
    rows: tuple[TakeRow, ...]
    tags: tuple[tuple[str, int], ...]


class FoundRow(msgspec.Struct, frozen=True):
    """A part of a take that is like an example, and how far it is from it in metres."""

    take: str
    track: str
    start: float
    stop: float
    distance: float


class Alike(Message, frozen=True, tag="alike"):
    """Parts of takes that are like an example, the nearest first, one of each track."""

    id: int
    rows: tuple[FoundRow, ...]


class ThumbnailRow(msgspec.Struct, frozen=True):
    """A moving thumbnail.

    Parameters
    ----------
    take : str
    frames, bones : int
    seconds : float
        From the first frame to the last.
    widths : tuple of int
        Of the bones, millimetres.
    sides : tuple of int
        Of each bone: 0 in the middle, 1 on the left, 2 on the right.
    """

    take: str
    frames: int
    bones: int
    seconds: float
    widths: tuple[int, ...]
    sides: tuple[int, ...]


class ThumbnailsHeader(msgspec.Struct, frozen=True, tag_field="kind", tag="thumbnails"):
    """The header of a blob of thumbnails.

    The payload has int16 numbers, take by take, frame by frame, bone by bone: millimetres to the right and above the
    floor of one end, then of the other.
    """

    id: int
    rows: tuple[ThumbnailRow, ...]
