"""The options that put a motion on another body: --character, --retarget, --joint-table."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kinetograph.cli._shell import note, progress_bar
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.character import Character
    from kinetograph.skeleton import Skeleton
    from kinetograph.take import Take, Track

Wear = Annotated[
    str | None, typer.Option("--character", help="Whose body to wear: human, capsules, or a .glb file with a skin.")
]
Onto = Annotated[
    Path | None, typer.Option("--retarget", help="A motion file with the skeleton to move the motion onto.")
]
Table = Annotated[
    Path | None,
    typer.Option("--joint-table", help="Which joints go together; written there where it does not exist yet."),
]
Scale = Annotated[float | None, typer.Option("--scale", help="Scale of the way; that of the legs without it.")]
Holds = Annotated[
    str | None,
    typer.Option("--handholds", help="When hands hold: a CSV (library annotate --export), or find, for two dancers."),
]


@dataclass(frozen=True)
class Body:
    """What a motion is to be put on: the body to wear, if any, and the skeleton, if it is another."""

    character: Character | None
    skeleton: Skeleton | None


def body(wear: str | None, onto: Path | None) -> Body:
    """The body that the options name. Raises RequestError for both at once and for names that are not known."""
    if wear in (None, "capsules"):
        return Body(None, _skeleton(onto) if onto else None)
    if onto is not None:
        raise RequestError("--character brings its own skeleton: leave --retarget out")
    if wear == "human":
        return _human()
    path = Path(str(wear))
    if path.suffix.lower() not in (".glb", ".gltf"):
        raise RequestError(f"unknown character {wear!r}; expected human, capsules or a .glb file with a skin")
    from kinetograph.formats import read_character

    notes: list[str] = []
    character = read_character(path, notes)
    for text in notes:
        note(f"{path}: {text}")
    return Body(character, character.skeleton)


def _human() -> Body:
    from kinetograph import samples
    from kinetograph.samples import CHARACTER, human

    if samples.where(CHARACTER) is None:
        note(f"fetching the sample {CHARACTER}")
    with progress_bar("fetching the character") as progress:
        character = human(progress=progress)
    return Body(character, character.skeleton)


def _skeleton(path: Path) -> Skeleton:
    from kinetograph.formats import read
    from kinetograph.motion import Motion

    loaded = read(path)
    motion = next((track for track in loaded.take.tracks.values() if isinstance(track, Motion)), None)
    if motion is None:
        raise RequestError(f"{path}: expected a file with a skeleton, found a signal")
    return motion.skeleton


def held(take: Take, holds: str | None) -> Take:
    """The take with the handholds and contacts of a CSV, or with the handholds found between its two motions."""
    from kinetograph.motion import Motion
    from kinetograph.take import Take

    if holds is None:
        return take
    if holds != "find":
        from kinetograph.library.annotations_csv import read_annotations

        marks = read_annotations(holds, take.name)
        unknown = sorted({mark.track for mark in marks} - take.tracks.keys())
        if unknown:
            raise RequestError(f"{holds}: no track {unknown[0]!r}; the file has {', '.join(take.tracks)}")
        return Take(take.name, take.tracks, (*take.annotations, *marks))
    from kinetograph.segmentation import detect_handholds

    motions = {name: track for name, track in take.tracks.items() if isinstance(track, Motion)}
    if len(motions) != 2:
        raise RequestError(f"--handholds find is for two dancers in one file, found {len(motions)} motions")
    (one, first), (other, second) = motions.items()
    found = (*detect_handholds(first, second, track=one), *detect_handholds(second, first, track=other))
    note(f"found {len(found) // 2} handholds, {sum(n.stop - n.start for n in found) / 2:.1f} s in all")
    return Take(take.name, take.tracks, (*take.annotations, *found))


def dressed(take: Take, skeleton: Skeleton | None, table: Path | None, scale: float | None) -> Take:
    """The take with its motions on a skeleton; the joint table is read where it exists, else written."""
    from kinetograph.motion import Motion
    from kinetograph.take import Take

    if skeleton is None:
        if table is not None or scale is not None:
            raise RequestError("--joint-table and --scale go with --retarget or --character")
        return take
    from kinetograph.post import joint_table, parse_table, retarget

    given = parse_table(table.read_text(encoding="utf-8"), table) if table and table.exists() else None
    tracks: dict[str, Track] = {}
    for name, track in take.tracks.items():
        if isinstance(track, Motion):
            pairs = given or joint_table(track.skeleton, skeleton)
            holds = (*take.annotated(name, "handhold"), *take.annotated(name, "contact"))
            done = retarget(track, skeleton, table=pairs, scale=scale, handholds=holds)
            note(f"{name}: {len(pairs.pairs)} of {len(skeleton)} joints mapped, way scaled by {done.scale:.3f}")
            if table and given is None:
                table.write_text(str(pairs), encoding="utf-8")
                note(f"wrote {table}: edit it and run again to map other joints")
            tracks[name] = done.motion
        else:
            tracks[name] = track
    return Take(take.name, tracks, take.annotations)
