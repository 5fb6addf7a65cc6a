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

    from kinetograph.formats import KeySources
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
    between: Annotated[
        list[str] | None,
        typer.Option(
            "--key",
            help="A pose in between. Here, and after --from and --to, what else is asked for may follow: 'take:walk@1; "
            "time=3; position=1,2; heading=60; roles=left_hand; left_hand=0.2,1.4,0.4; head@world=0,1.6,2'. "
            "Repeatable.",
        ),
    ] = None
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

    Example: kinetograph inbetween --from take:humanoid3d_walk@0 --to "take:humanoid3d_punch@0.5; roles=left_hand"
    -l out/clips.library -o out/d.bvh
    """
    from kinetograph.formats import KeySources, together
    from kinetograph.pipeline import fit_keyframe, inbetween_with, open_without_labels

    refuse_unknown_formats(answers.output)
    refuse_existing(answers.every_file(answers.alternatives), answers.force)
    library, without = open_without_labels(ends.library, ends.selection)
    wanted = _keys(keys, ends, KeySources(library, reading.read_options, ends.track, note=note))
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
    """The skeleton that is named, or that of the first key whose joints the library has."""
    from kinetograph.methods.bodies import skeleton_like

    known = (skeleton_like(library, key.clip.skeleton, ends.track) for key in keys)
    return replace(ends.bodies, like=ends.bodies.like or next(filter(None, known), ""))


def _keys(keys: Path | None, ends: Ends, sources: KeySources) -> tuple[Key, ...]:
    """The keys of a file, or those that are named."""
    from kinetograph.formats import key_from_text, read_keys_from

    if keys is not None and (ends.first or ends.last or ends.between or ends.seconds is not None):
        raise RequestError("give keys as a JSON file or with --from, --key and --to, not both")
    if keys is not None:
        return read_keys_from(keys, sources)
    if not ends.first or not ends.last:
        raise RequestError("give --from and --to, or a JSON file of keys")
    first, last = (
        key_from_text(text, f"--{name}", sources) for name, text in (("from", ends.first), ("to", ends.last))
    )
    between = [key_from_text(text, f"--key {number}", sources) for number, text in enumerate(ends.between or (), 1)]
    if ends.seconds is not None:
        last = replace(last, time=(ends.seconds, ends.seconds))
    return first, *between, last


def _in_words(summary: dict[str, Any]) -> dict[str, Any]:
    """What a person wants to know: the recordings, and how much of the result is as recorded."""
    return {
        "made of": summary["pieces"],
        "as recorded": f"{100 * summary['untouched_share']:.0f} % of the frames are untouched",
        **_quality_in_words(summary),
        "length": f"{summary['seconds']:.1f} s, {summary['frames']} frames",
        "cost": f"{summary['cost']:.3g}; it compares results of one set of keys only",
    }


def _quality_in_words(summary: dict[str, Any]) -> dict[str, Any]:
    """How good the result is, next to the recordings; nothing in the paper's mode, which does not measure it."""
    if "jump" not in summary:
        return {}
    lines = {
        "velocities jump": ("jump", "what is usual in the recordings"),
        "planted feet slide": ("skate", "the usual speed"),
    }
    said = {
        words: f"{summary[name]:.2f} x {of}; in 1 of 1,000 recorded frames {summary[f'{name}_in_recordings']:.2f} x"
        for words, (name, of) in lines.items()
    }
    return {**said, "furthest edit": f"{100 * summary['furthest_edit']:.1f} cm, the mean over the joints"}


def _summary(synthesis: Synthesis) -> dict[str, Any]:
    known = ("jump", "jump in recordings", "skate", "skate in recordings", "furthest edit")
    quality = {name.replace(" ", "_"): synthesis.statistics[name] for name in known if name in synthesis.statistics}
    return {
        "seconds": synthesis.motion.duration,
        "frames": len(synthesis.motion),
        "pieces": [f"{p.take} {p.source_start:.2f}-{p.source_stop:.2f} s" for p in synthesis.pieces],
        "cost": synthesis.cost,
        "untouched_share": synthesis.statistics["untouched"],
        **quality,
    }
