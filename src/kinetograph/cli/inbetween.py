"""The command inbetween: poses become a motion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.configurations import InbetweenSearch, keyframe_control
from kinetograph.cli.options import (
    Chosen,
    Floor,
    Footskate,
    LibraryOption,
    Mirror,
    Skeletons,
    Track,
    Written,
    add,
    options,
)
from kinetograph.cli.output import (
    left_out,
    note,
    notes,
    refuse_existing,
    refuse_unknown_formats,
    result,
    write_synthesis,
)
from kinetograph.cli.reading import Reading
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kinetograph.formats import ReadOptions
    from kinetograph.keys import Key
    from kinetograph.library import Library
    from kinetograph.methods.bodies import Bodies
    from kinetograph.synthesis import Synthesis


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    add(app, inbetween, panel="Make motion")


@options()
class Ends(Skeletons, Chosen):
    """The poses to go through, and what the motion is made of."""

    first: Annotated[str | None, typer.Option("--from", help="First pose: FILE@SECOND or take:NAME@SECOND.")] = None
    last: Annotated[str | None, typer.Option("--to", help="Last pose: FILE@SECOND or take:NAME@SECOND.")] = None
    seconds: Annotated[
        float | None, typer.Option(help="Duration from --from to --to; without it, as long as the recordings take.")
    ] = None
    library: LibraryOption
    track: Track = None
    mirror: Mirror = False


@options("Output")
class Answers(Written):
    """What is written."""

    alternatives: Annotated[
        int, typer.Option(help="How many different motions to write: out.bvh, out_2.bvh, ...", min=1)
    ] = 1


@options("After the search")
class Finish:
    """What happens to the recordings that are chosen."""

    footskate: Footskate = True
    floor: Floor = True


def inbetween(
    keys: Annotated[Path | None, typer.Argument(help="Keys as JSON, in place of --from and --to.")] = None,
    *,
    ends: Ends,
    answers: Answers,
    search: InbetweenSearch,
    finish: Finish,
    reading: Reading,
) -> None:
    """Fill in between poses: a motion, made of recordings, that passes through every key.

    Example: kinetograph inbetween --from out/rise.bvh@0 --to take:humanoid3d_run@0.4 -l out/clips.library -o out/a.bvh

    Example: kinetograph inbetween out/keys.json -l out/clips.library -o out/b.bvh

    Example: kinetograph inbetween out/keys.json -l out/clips.library -o out/c.bvh --move walk --without punch
    """
    from kinetograph.formats import together
    from kinetograph.pipeline import fit_keyframe, inbetween_with, open_without_labels

    refuse_unknown_formats(answers.output)
    refuse_existing(answers.every_file(answers.alternatives), answers.force)
    library, without = open_without_labels(ends.library, ends.selection)
    wanted = _keys(keys, ends, library, reading.read_options)
    method = keyframe_control(search, without, mirror=ends.mirror, footskate=finish.footskate, floor=finish.floor)
    method = replace(method, bodies=_bodies(ends, wanted, library))
    model = fit_keyframe(method, library, track=ends.track, seed=search.seed, note=note)
    made = inbetween_with(model, wanted, answers.alternatives)
    notes(made[0].warnings)
    with together():
        for number, synthesis in enumerate(made, start=1):
            write_synthesis(synthesis, answers, None, "in between", number)
    others = {f"cost_{number}": synthesis.cost for number, synthesis in enumerate(made[1:], start=2)}
    wrote = [str(path) for path in answers.every_file(len(made))]
    summary = _summary(made[0])
    ending = summary if answers.as_json else _in_words(summary)
    left = left_out(made[0], answers.as_json)
    result({**ending, **others, **left, "wrote": wrote}, answers.as_json)


def _bodies(ends: Ends, keys: Sequence[Key], library: Library) -> Bodies:
    """The skeleton that is named, or that of the first key where the library has it."""
    from kinetograph.methods.bodies import skeleton_like

    return replace(ends.bodies, like=ends.bodies.like or skeleton_like(library, keys[0].clip.skeleton, ends.track))


def _keys(keys: Path | None, ends: Ends, library: Library, options: ReadOptions) -> tuple[Key, ...]:
    """The keys of a file, or the two that are named."""
    from kinetograph.formats.keys_json import find_pose, read_keys
    from kinetograph.keys import key_at

    if keys is not None and (ends.first or ends.last or ends.seconds is not None):
        raise RequestError("give keys as a JSON file or with --from and --to, not both")
    if keys is not None:
        return read_keys(keys, library, options)
    if not ends.first or not ends.last:
        raise RequestError("give --from and --to, or a JSON file of keys")
    time = None if ends.seconds is None else (ends.seconds, ends.seconds)
    first = find_pose(ends.first, "--from", Path(), library, options)
    last = find_pose(ends.last, "--to", Path(), library, options)
    return key_at(*first, label="--from"), key_at(*last, time=time, label="--to")


def _in_words(summary: dict[str, Any]) -> dict[str, Any]:
    """What a person wants to know: the recordings, and how much of the result is as recorded."""
    return {
        "made of": summary["pieces"],
        "as recorded": f"{100 * summary['untouched_share']:.0f} % of the frames are untouched",
        "length": f"{summary['seconds']:.1f} s, {summary['frames']} frames",
        "cost": f"{summary['cost']:.3g}; it compares results of one set of keys only",
    }


def _summary(synthesis: Synthesis) -> dict[str, Any]:
    return {
        "seconds": synthesis.motion.duration,
        "frames": len(synthesis.motion),
        "pieces": [f"{p.take} {p.source_start:.2f}-{p.source_stop:.2f} s" for p in synthesis.pieces],
        "cost": synthesis.cost,
        "untouched_share": synthesis.statistics["untouched"],
    }
