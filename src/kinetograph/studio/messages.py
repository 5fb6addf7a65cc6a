"""What the page and the server say to each other.

Small messages are JSON text with a ``kind``; motion, files and live poses are binary frames (`blob`). The page's types
are generated from these classes: ``python -m kinetograph.studio.typescript``.

A message with an ``id`` is a question: its answer, a `Failed` or another message or blob, has the same ``id``. Others
are answered by what they change, which every open page is sent.
"""

from __future__ import annotations

import struct
from typing import Any, Literal

import msgspec
import numpy as np

from kinetograph.arrays import FloatArray
from kinetograph.errors import RequestError
from kinetograph.studio.project import KeyRow, Mode, Project, RuleRow

BLOB, POSE = 1, 2
"""The first number of a binary frame."""


class Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="kind", rename=None):
    """A message, whose kind is the name of its class in small letters."""


# ---- from the page ----


class Edit(Message, frozen=True, tag="edit"):
    """A section, or a field, of the project in a new state.

    Parameters
    ----------
    part : str
        ``walk``, ``keys``, ``duet``, ``sensors``, ``mode`` or ``character``.
    value : object
        The whole part.
    label : str
        What undo calls it.
    merge : bool
        Whether it goes on from the edit before, as a slider's steps do: both are undone as one.
    solve : bool
        Whether the section is made anew.
    number : int
        Counts the page's edits; `State` has it again.
    """

    part: str
    value: Any
    label: str = "edit"
    merge: bool = False
    solve: bool = True
    number: int = 0


class Undo(Message, frozen=True, tag="undo"):
    """Take the last edit back."""


class Redo(Message, frozen=True, tag="redo"):
    """Make the edit that was taken back again."""


class Solve(Message, frozen=True, tag="solve"):
    """Make the section that is shown."""


class Cancel(Message, frozen=True, tag="cancel"):
    """Stop what is being made."""


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


class StopRun(Message, frozen=True, tag="stop_run"):
    """End what runs live."""


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


# ---- to the page ----


class LibraryRow(msgspec.Struct, frozen=True):
    """A library of the project: its takes, and what can be done with it."""

    name: str
    takes: int
    seconds: float
    tracks: tuple[str, ...]
    partners: bool


class Welcome(Message, frozen=True, tag="welcome"):
    """The first message to a page, sent again when what it says changes."""

    version: str
    formats: tuple[str, ...]
    films: tuple[str, ...]
    libraries: tuple[LibraryRow, ...]
    files: tuple[str, ...]


class State(Message, frozen=True, tag="state"):
    """The project, whenever it changes.

    Parameters
    ----------
    project : Project
    revision : int
        Counts its changes.
    undo, redo : str, optional
        What would be taken back or made again.
    number : int
        That of the edit which this answers, on the page that made it.
    """

    project: Project
    revision: int
    undo: str | None = None
    redo: str | None = None
    number: int = 0


class Working(Message, frozen=True, tag="working"):
    """Something is being made or fetched: how far it is; ``done`` is ``total`` at its end."""

    label: str
    done: float
    total: float
    section: Mode | None = None


class Nothing(Message, frozen=True, tag="nothing"):
    """A section asks for nothing that could be made yet."""

    section: Mode


class Failed(Message, frozen=True, tag="failed"):
    """Something could not be done, in one line."""

    message: str
    id: int | None = None
    section: Mode | None = None


class Said(Message, frozen=True, tag="said"):
    """Something a person should know, in one line."""

    message: str


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


# ---- headers of blobs ----


class PieceRow(msgspec.Struct, frozen=True, omit_defaults=True):
    """A piece of the motion shown; see `kinetograph.Piece`."""

    take: str
    track: str
    start: float
    stop: float
    source_start: float
    source_stop: float
    cost: float
    seam: float
    mirrored: bool = False
    layer: str = ""


class Span(msgspec.Struct, frozen=True, omit_defaults=True):
    """A span of a lane of the timeline."""

    start: float
    stop: float
    label: str = ""
    title: str = ""


class Lane(msgspec.Struct, frozen=True, omit_defaults=True):
    """A lane of the timeline: spans, or the values of a signal at even times.

    Parameters
    ----------
    name : str
    role : str
        ``contacts``, ``moves``, ``handholds``, ``error``, ``edited``, ``readings``, ``uncertainty``.
    spans : tuple of Span
    values : tuple of float
        From the first second to the last.
    unit : str
        Of the values.
    """

    name: str
    role: str
    spans: tuple[Span, ...] = ()
    values: tuple[float, ...] = ()
    unit: str = ""


class Figure(msgspec.Struct, frozen=True, omit_defaults=True):
    """A figure about what was made, as a person reads it: ``"path error"``, ``"3.2 cm"``."""

    name: str
    value: str
    title: str = ""


class MadeHeader(msgspec.Struct, frozen=True, tag_field="kind", tag="made", omit_defaults=True):
    """The header of a blob whose payload is the GLB of what was made.

    Parameters
    ----------
    section : str
    key : str
        Names what was made: the same for the same section of a project.
    seconds, fps : float
    floor : float
        Metres: where the ground is.
    characters : tuple of str
        The names of the bodies in the GLB; the first is what was made, others are ``leader``, ``truth``.
    pieces, lanes, figures, warnings : tuple
    path : tuple of (float, float, float)
        The path that was performed: seconds, metres x and z.
    costs : dict of str to float
        Of each alternative, the first being the one that is chosen.
    """

    section: Mode
    key: str
    seconds: float
    fps: float
    floor: float = 0.0
    characters: tuple[str, ...] = ("motion",)
    pieces: tuple[PieceRow, ...] = ()
    lanes: tuple[Lane, ...] = ()
    figures: tuple[Figure, ...] = ()
    warnings: tuple[str, ...] = ()
    path: tuple[tuple[float, float, float], ...] = ()
    costs: tuple[float, ...] = ()
    chosen: int = 0


class ClipHeader(msgspec.Struct, frozen=True, tag_field="kind", tag="clip", omit_defaults=True):
    """The header of a blob whose payload is a GLB that answers a question: a ghost, an alternative, a take.

    Parameters
    ----------
    id : int
    name : str
    floor : float
        Metres.
    start : float
        The second of what is shown at which it begins.
    """

    id: int
    name: str = ""
    floor: float = 0.0
    start: float = 0.0


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


class LiveHeader(msgspec.Struct, frozen=True, tag_field="kind", tag="live", omit_defaults=True):
    """The header of a blob whose payload is a body as GLB, which the pose frames after it move."""

    section: Mode
    floor: float = 0.0
    characters: tuple[str, ...] = ("motion",)


class FileHeader(msgspec.Struct, frozen=True, tag_field="kind", tag="file", forbid_unknown_fields=True):
    """The header of a blob from the page: a file that was dropped onto it.

    Parameters
    ----------
    id : int
    name : str
        Its name, without a folder.
    role : str
        What it is to be: ``character``, ``leader``, ``readings``, ``layout`` or ``recording``.
    """

    id: int
    name: str
    role: Literal["character", "leader", "readings", "layout", "recording"]


class Kept(Message, frozen=True, tag="kept"):
    """A file was taken into the project, under this name; the project's files."""

    id: int
    name: str
    files: tuple[str, ...]


def blob(header: msgspec.Struct, payload: bytes) -> bytes:
    """A binary frame: the number 1, the header's length, the header as JSON, the payload from a multiple of 4 on."""
    text = msgspec.json.encode(header)
    text += b" " * (-len(text) % 4)
    return struct.pack("<2I", BLOB, len(text)) + text + payload


class AskPace(Message, frozen=True, tag="ask_pace"):
    """How fast are the library's people? Answered by `Pace`; its model is fitted by then."""

    id: int


class NextBest(Message, frozen=True, tag="next_best"):
    """What could take the place of the piece at a time of the walk? Answered by `Candidates`.

    Parameters
    ----------
    id : int
    time : float
        Seconds.
    count : int
        Others at most.
    """

    id: int
    time: float
    count: int = 4


class CandidateClip(Message, frozen=True, tag="candidate_clip"):
    """The walk as a clip under rules besides its own: those of a candidate."""

    id: int
    rules: tuple[RuleRow, ...]


class PieceSource(Message, frozen=True, tag="piece_source"):
    """The recording behind the piece at a time of the walk, placed where the piece is, as a clip."""

    id: int
    time: float


class PlayTake(Message, frozen=True, tag="play_take"):
    """A take of the library as a clip, at its own pace, from where the path begins."""

    id: int
    take: str


class WalkLive(Message, frozen=True, tag="walk_live"):
    """A person begins to draw: a body is to follow."""


class WalkDrawn(Message, frozen=True, tag="walk_drawn"):
    """Points that were drawn since the last: seconds, and metres x and z."""

    points: tuple[tuple[float, float, float], ...]


class TakePace(msgspec.Struct, frozen=True):
    """A take of a library: how long it is, and its mean speed over the ground, metres per second."""

    name: str
    seconds: float
    speed: float


class Pace(Message, frozen=True, tag="pace"):
    """How fast the library's people walk, metres per second.

    Parameters
    ----------
    id : int
    slowest, fastest : float
        Between which a path is walked at its own times.
    usual : tuple of float
        The 5th, 50th and 95th percentiles of the steps that were recorded.
    stands : bool
        Whether there is a pose to hold where a path stands still.
    takes : tuple of TakePace
    """

    id: int
    slowest: float
    fastest: float
    usual: tuple[float, float, float]
    stands: bool
    takes: tuple[TakePace, ...]


class CandidateRow(msgspec.Struct, frozen=True):
    """A piece that could be at a time of the walk, and what the best walk with it costs.

    Parameters
    ----------
    take : str
    mirrored : bool
    source_start, source_stop : float
        Seconds of the take.
    start, stop : float
        Seconds of the walk.
    cost, interpretation, continuity, reuse : float
        What the whole walk costs, and the terms that this is the sum of.
    more : float
        How much more than the walk with the first.
    rules : tuple of RuleRow
        Besides the walk's own, under which it is the best.
    """

    take: str
    mirrored: bool
    source_start: float
    source_stop: float
    start: float
    stop: float
    cost: float
    interpretation: float
    continuity: float
    reuse: float
    more: float
    rules: tuple[RuleRow, ...]


class Candidates(Message, frozen=True, tag="candidates"):
    """What could be at a time of the walk; the first is what is there."""

    id: int
    time: float
    rows: tuple[CandidateRow, ...]


class JointUncertainty(Message, frozen=True, tag="joint_uncertainty"):
    """Ask for the uncertainty of every joint of what was sensed last; answered by a blob with a `JointsHeader`."""

    id: int


class Listen(Message, frozen=True, tag="listen"):
    """Sense live: what the section's source sends drives a body."""


class Calibrate(Message, frozen=True, tag="calibrate"):
    """Calibrate the sensors of the section's layout, and save the layout as a file of the project.

    Parameters
    ----------
    source : str
        A file of the project with readings, or what is listened to live.
    still : (float, float), optional
        Of a file: the seconds between which its wearer stands still.
    ready, standing, moving : float
        Live: seconds before standing still, of standing still, and of moving as in the library.
    layout : str
        The file that is written, ending in .toml.
    """

    source: str
    still: tuple[float, float] | None = None
    ready: float = 3.0
    standing: float = 4.0
    moving: float = 20.0
    layout: str = "worn.toml"


class CallSensors(Message, frozen=True, tag="call_sensors"):
    """Call sensors by other names from now on, while listening.

    Parameters
    ----------
    names : dict of str to str
        Names of the layout by the names under which sensors are heard.
    """

    names: dict[str, str]


class HeardRow(msgspec.Struct, frozen=True):
    """What is heard of a sensor: rows a second, the share that was lost, rows that came late, and its latest force.

    Parameters
    ----------
    sensor : str
    rate : float
        Hz.
    lost : str
        Per cent.
    late : int
    force : float
        Its magnitude, m/s^2.
    known : bool
        Whether the layout has a sensor of that name.
    """

    sensor: str
    rate: float
    lost: str
    late: int
    force: float
    known: bool


class Heard(Message, frozen=True, tag="heard"):
    """Who is heard, once a second, and the layout's sensors."""

    rows: tuple[HeardRow, ...]
    sensors: tuple[str, ...]


class PhoneLink(Message, frozen=True, tag="phone_link"):
    """The link that a phone has to open, and its QR code.

    Parameters
    ----------
    link : str
    code : tuple of str
        Rows of ``1`` for dark and ``0`` for light modules; none without the extra.
    """

    link: str
    code: tuple[str, ...] = ()


class LiveEnded(Message, frozen=True, tag="live_ended"):
    """What ran live has come to its end, after so many frames."""

    section: Mode
    frames: int


class CalibrationStep(Message, frozen=True, tag="calibration_step"):
    """Where a calibration is: what the wearer does now, and the seconds that are left of it.

    Parameters
    ----------
    step : str
    left, total : float
        Seconds.
    """

    step: Literal["ready", "still", "moving", "solving"]
    left: float
    total: float


class CalibratedRow(msgspec.Struct, frozen=True, omit_defaults=True):
    """How a sensor was calibrated.

    Parameters
    ----------
    sensor : str
    verdict : str
        ``good``, ``fair``, ``put it on again`` or ``not heard``.
    before, residual : float
        m/s^2, without and with calibration.
    like : float
        How much like another sensor's its readings are: 1 is as much as like its own.
    other : str
        That other sensor.
    apart : float
        Degrees between the rotations that halves of the movement give.
    rotated : float
        Degrees from the layout.
    """

    sensor: str
    verdict: str
    before: float = 0.0
    residual: float = 0.0
    like: float = 0.0
    other: str = ""
    apart: float = 0.0
    rotated: float = 0.0


class Calibrated(Message, frozen=True, tag="calibrated"):
    """Sensors that were calibrated.

    Parameters
    ----------
    layout : str
        The file that was written; empty where calibration is worse than none for every sensor.
    rows : tuple of CalibratedRow
    files : tuple of str
        The project's.
    """

    layout: str
    rows: tuple[CalibratedRow, ...]
    files: tuple[str, ...]


class JointsHeader(msgspec.Struct, frozen=True, tag_field="kind", tag="joints"):
    """The header of a blob whose payload is a value for every joint at even times, as float32.

    Parameters
    ----------
    id : int
    fps : float
    joints : tuple of str
        Names of the joints, in order.
    frames : int
    """

    id: int
    fps: float
    joints: tuple[str, ...]
    frames: int


class KeyPose(Message, frozen=True, tag="key_pose"):
    """Asks for the pose of a key as a clip of one frame: the root above the origin, with the heading 0."""

    id: int
    row: KeyRow


class KeyEnds(Message, frozen=True, tag="key_ends"):
    """Asks where the hands and feet of a key are (`EndPlaces`)."""

    id: int
    row: KeyRow


class KeysMet(Message, frozen=True, tag="keys_met"):
    """Asks when and where the project's keys are met in what is shown (`Met`)."""

    id: int


class Alternative(Message, frozen=True, tag="alternative"):
    """Asks for one of the motions through the keys as a clip; the first is number 0."""

    id: int
    number: int


class KeyTrouble(Message, frozen=True, tag="key_trouble"):
    """Asks which of the project's keys cannot be met (`Trouble`)."""

    id: int


class EndPlaces(Message, frozen=True, tag="end_places"):
    """Where the hands and feet of a key are.

    Parameters
    ----------
    id : int
    ends : dict of str to (float, float, float)
        By role: metres from the root's place on the ground, in the frame of the root's heading.
    roles : tuple of str
        The parts of the body that may count.
    position : (float, float)
        Where the root is in its recording, metres x and z.
    heading : float
        Of the root in its recording, degrees.
    said : tuple of str
        What a person should know of them.
    """

    id: int
    ends: dict[str, tuple[float, float, float]]
    roles: tuple[str, ...]
    position: tuple[float, float]
    heading: float
    said: tuple[str, ...] = ()


class MetRow(msgspec.Struct, frozen=True):
    """When and where a key is met: seconds, metres x and z of the root, and its heading in degrees."""

    time: float
    position: tuple[float, float]
    heading: float


class Met(Message, frozen=True, tag="met"):
    """When and where the keys are met, one row per key."""

    id: int
    rows: tuple[MetRow, ...]


class Trouble(Message, frozen=True, tag="trouble"):
    """Why keys cannot be met.

    Parameters
    ----------
    id : int
    message : str
        Empty where they can.
    row : int, optional
        The key that it is about.
    seconds : float, optional
        How much later that key can be met.
    """

    id: int
    message: str = ""
    row: int | None = None
    seconds: float | None = None


class AskLeaders(Message, frozen=True, tag="ask_leaders"):
    """Ask for the takes that can lead a duet: of a library, the project's unless given."""

    id: int
    library: str | None = None


class AskLeader(Message, frozen=True, tag="ask_leader"):
    """Ask who the leader of the project is."""

    id: int


class ShowLeader(Message, frozen=True, tag="show_leader"):
    """Ask for the leader of the project as a clip."""

    id: int


class AskHands(Message, frozen=True, tag="ask_hands"):
    """Ask which hands of the follower that was made last hold which of the leader's."""

    id: int


class Transcribe(Message, frozen=True, tag="transcribe"):
    """Ask for the moves of the follower that was made last."""

    id: int


class Rehearse(Message, frozen=True, tag="rehearse"):
    """Let the leader of the project dance now, and the follower answer live.

    Parameters
    ----------
    lag : float
        Seconds after which motion is decided.
    """

    lag: float = 0.5


class LeaderRow(msgspec.Struct, frozen=True, omit_defaults=True):
    """A take that can lead, and the people in it who can."""

    take: str
    seconds: float
    persons: tuple[str, ...]


class LeaderTakes(Message, frozen=True, tag="leader_takes"):
    """The takes of a library that can lead.

    Parameters
    ----------
    id : int
    library : str
    takes : tuple of LeaderRow
    target : str
        The track that is made unless another is named.
    targets : tuple of str
        The tracks that can be made.
    advice : str
        What to do where there is none.
    """

    id: int
    library: str
    takes: tuple[LeaderRow, ...] = ()
    target: str = ""
    targets: tuple[str, ...] = ()
    advice: str = ""


class LeaderFacts(Message, frozen=True, tag="leader_facts"):
    """The leader of the project.

    Parameters
    ----------
    id : int
    name : str
        Of the take or the file.
    seconds : float
    person : str
        Who of ``persons`` leads.
    persons : tuple of str
    truth : bool
        Whether the one who followed is known.
    notes : tuple of str
        What was guessed.
    """

    id: int
    name: str
    seconds: float
    person: str
    persons: tuple[str, ...] = ()
    truth: bool = False
    notes: tuple[str, ...] = ()


class HandsRow(msgspec.Struct, frozen=True, omit_defaults=True):
    """Hands that hold each other: the joints, as the bodies that are shown call them.

    Parameters
    ----------
    start, stop : float
    own, theirs : str
        The follower's joint, and the leader's.
    met : bool
        Whether they are as near as hands that hold each other.
    """

    start: float
    stop: float
    own: str
    theirs: str
    met: bool = True


class Hands(Message, frozen=True, tag="hands"):
    """The handholds of the follower and the leader."""

    id: int
    holds: tuple[HandsRow, ...] = ()


class MoveRow(msgspec.Struct, frozen=True, omit_defaults=True):
    """A move of a transcript.

    Parameters
    ----------
    move : str
        Empty where the recordings name none.
    start, stop : float
    margin : float, optional
        What the best interpretation without it costs more, as a share; None where there is no other.
    notation : str
        The move in the thesis' symbols.
    """

    move: str
    start: float
    stop: float
    margin: float | None = None
    notation: str = ""


class Transcribed(Message, frozen=True, tag="transcribed"):
    """The moves of the follower in order, or what to do to have them."""

    id: int
    moves: tuple[MoveRow, ...] = ()
    advice: str = ""


class Rehearsed(Message, frozen=True, tag="rehearsed"):
    """How a rehearsal goes.

    Parameters
    ----------
    second : float
        Where the leader is now.
    seconds : float
        How long the leader dances.
    lag : float
        Seconds by which the follower shown is behind the leader.
    load : float
        Seconds of work for a second of dance; above 1, the leader has to wait.
    running : bool
        False at its end.
    error : float, optional
        Centimetres: at the end, the mean distance of joints from the recorded follower's.
    """

    second: float
    seconds: float
    lag: float
    load: float = 0.0
    running: bool = True
    error: float | None = None


def pose_frame(time: float, translation: FloatArray, rotations: FloatArray, deviations: FloatArray | None) -> bytes:
    """A pose as a binary frame of float32 values after the number 2.

    Parameters
    ----------
    time : float
        Seconds.
    translation : ndarray, shape (3,)
        The root's, metres.
    rotations : ndarray, shape (J, 4)
    deviations : ndarray, shape (J,), optional
        Standard deviation of each joint, radians.
    """
    parts = [np.array([time]), translation, rotations.ravel(), *([] if deviations is None else [deviations])]
    return struct.pack("<I", POSE) + np.concatenate(parts).astype("<f4").tobytes()


def read_blob(data: bytes) -> tuple[FileHeader, bytes]:
    """The header and payload of a binary frame from the page.

    Raises
    ------
    RequestError
        For bytes that are none.
    """
    if len(data) < 8:
        raise RequestError(f"expected a binary frame of 8 bytes or more, found {len(data)}")
    kind, length = struct.unpack_from("<2I", data)
    if kind != BLOB or length > len(data) - 8:
        raise RequestError(f"expected a binary frame of kind {BLOB} with its header, found kind {kind}")
    try:
        return msgspec.json.decode(data[8 : 8 + length], type=FileHeader), data[8 + length :]
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise RequestError(f"expected the header of a file, found: {error}") from None
