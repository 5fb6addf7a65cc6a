"""Options that put a motion on another body, and doing so."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kinetograph.cli.options import options
from kinetograph.cli.output import note, notes, progress_bar, write_text
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kinetograph.character import Character
    from kinetograph.motion import Motion
    from kinetograph.post import JointTable
    from kinetograph.skeleton import Skeleton
    from kinetograph.take import Annotation, Take, Track

CharacterName = Annotated[
    str | None, typer.Option("--character", help="The body to show: human, capsules, or a .glb file with a skin.")
]


@options("Another body")
class AnotherBody:
    """The body or skeleton that motions are moved onto."""

    character: CharacterName = None
    onto: Annotated[
        Path | None, typer.Option("--retarget", help="A motion file with the skeleton to move the motion onto.")
    ] = None
    joint_table: Annotated[
        Path | None, typer.Option(help="Which joint goes with which; the file is written where it does not exist.")
    ] = None
    scale: Annotated[
        float | None, typer.Option(help="Scale of the root path; default the ratio of the lengths of the legs.")
    ] = None
    handholds: Annotated[
        str | None,
        typer.Option(help="When hands hold: a CSV (library annotate --export), or find, for two dancers in one file."),
    ] = None


@dataclass(frozen=True)
class Body:
    """What a motion is to be put on.

    Parameters
    ----------
    character : Character or None
        The body to show, if any.
    skeleton : Skeleton or None
        The skeleton to move the motion onto, if it is another one.
    capsules : bool
        Whether to stand each motion's own body of capsules on the floor.
    """

    character: Character | None
    skeleton: Skeleton | None
    capsules: bool = False

    @property
    def other(self) -> bool:
        """Whether motions are moved onto anything."""
        return self.capsules or self.character is not None or self.skeleton is not None

    def target(self, motion: Motion) -> Character | Skeleton | None:
        """What a motion is moved onto, if anything."""
        if self.capsules:
            from kinetograph.formats import capsule_character

            legs = {"hips", "left_hip", "right_hip"} <= motion.skeleton.roles.keys()
            return capsule_character(motion.skeleton) if legs else None
        return self.character or self.skeleton


def body(name: str | None, onto: Path | None = None) -> Body:
    """The body that the options name.

    Raises
    ------
    RequestError
        For a character and a skeleton at once, and for a name that is not known.
    """
    if name is None or (name == "capsules" and onto is not None):
        return Body(None, _skeleton(onto) if onto else None)
    if name == "capsules":
        return Body(None, None, capsules=True)
    if onto is not None:
        raise RequestError("--character brings its own skeleton: leave --retarget out")
    if name == "human":
        return _human()
    path = Path(str(name))
    if path.suffix.lower() not in (".glb", ".gltf", ".vrm"):
        raise RequestError(f"unknown character {name!r}; expected human, capsules or a .glb or .vrm file with a skin")
    from kinetograph.formats import read_character

    left_out: list[str] = []
    character = read_character(path, left_out)
    notes(left_out, path)
    return Body(character, character.skeleton)


def _human() -> Body:
    from kinetograph.samples import CHARACTER, human
    from kinetograph.samples import fetching as samples

    if samples.where(CHARACTER) is None:
        note(f"fetching the sample {CHARACTER}")
    with progress_bar("fetching the character") as progress:
        character = human(progress=progress)
    return Body(character, character.skeleton)


def _skeleton(path: Path) -> Skeleton:
    from kinetograph.formats import read
    from kinetograph.motion import Motion

    take = read(path).take
    motion = next((track for track in take.tracks.values() if isinstance(track, Motion)), None)
    if motion is None:
        raise RequestError(f"{path}: expected a file with a skeleton, found a signal")
    return motion.skeleton


def with_handholds(take: Take, source: str | None) -> Take:
    """The take with the handholds and contacts of a CSV, or with the handholds detected between its two motions."""
    from dataclasses import replace

    if source is None:
        return take
    added = _detected(take) if source == "find" else _annotated(take, source)
    return replace(take, annotations=(*take.annotations, *added))


def _annotated(take: Take, source: str) -> Sequence[Annotation]:
    from kinetograph.library.annotations_csv import read_annotations

    annotations = read_annotations(source, take.name)
    unknown = sorted({annotation.track for annotation in annotations} - take.tracks.keys())
    if unknown:
        raise RequestError(f"{source}: no track {unknown[0]!r}; the file has {', '.join(take.tracks)}")
    return annotations


def _detected(take: Take) -> Sequence[Annotation]:
    from kinetograph.motion import Motion
    from kinetograph.segmentation import detect_handholds

    motions = {name: track for name, track in take.tracks.items() if isinstance(track, Motion)}
    if len(motions) != 2:
        raise RequestError(f"--handholds find is for two dancers in one file, found {len(motions)} motions")
    (one, first), (other, second) = motions.items()
    holds = (*detect_handholds(first, second, track=one), *detect_handholds(second, first, track=other))
    note(f"found {len(holds) // 2} handholds, {sum(n.stop - n.start for n in holds) / 2:.1f} s in all")
    return holds


def dressed(take: Take, worn: Body, path: Path | None = None, scale: float | None = None) -> Take:
    """The take with its motions on a body.

    Parameters
    ----------
    take : Take
        What is moved.
    worn : Body
        What its motions are moved onto, if anything.
    path : Path or None
        A table of joints, which is read where it exists, and written where it does not.
    scale : float or None
        Scale of the root path; ``None`` for the ratio of the lengths of the legs.

    Raises
    ------
    RequestError
        For a table or a scale without a skeleton.
    """
    if not worn.other:
        if path is not None or scale is not None:
            raise RequestError("--joint-table and --scale go with --retarget or --character")
        return take
    from dataclasses import replace

    from kinetograph.motion import Motion
    from kinetograph.post import joint_table, read_table
    from kinetograph.skeleton import Skeleton

    known = read_table(path) if path and path.exists() else None
    tracks: dict[str, Track] = {}
    for name, track in take.tracks.items():
        target = worn.target(track) if isinstance(track, Motion) else None
        if not isinstance(track, Motion) or target is None:
            tracks[name] = track
            continue
        pairs = known or joint_table(track.skeleton, target if isinstance(target, Skeleton) else target.skeleton)
        tracks[name] = _retargeted(take, name, target, pairs, scale)
        if path and known is None:
            write_text(str(pairs), path, force=False)
            note(f"wrote {path}: edit it and run again to map other joints")
    return replace(take, tracks=tracks)


def _retargeted(take: Take, name: str, target: Character | Skeleton, pairs: JointTable, scale: float | None) -> Track:
    from kinetograph.post import retarget

    holds = (*take.annotated(name, "handhold"), *take.annotated(name, "contact"))
    done = retarget(take.motion(name), target, table=pairs, scale=scale, handholds=holds)
    joints = len(done.motion.skeleton)
    note(f"{name}: {len(pairs.pairs)} of {joints} joints mapped, root path scaled by {done.scale:.3f}")
    return done.motion
