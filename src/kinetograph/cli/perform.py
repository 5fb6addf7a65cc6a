"""The command perform: a control becomes a motion."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from kinetograph.cli.compilation import compilation_announced
from kinetograph.cli.configurations import Finish, Partner, Search, finished, onto, performance_control
from kinetograph.cli.layers import Layers, read_layers, wearing
from kinetograph.cli.options import Chosen, Jobs, LibraryOption, Mirror, Skeletons, TargetTrack, Written, add, options
from kinetograph.cli.outcome import in_words, outcome, without_keys
from kinetograph.cli.output import (
    left_out,
    note,
    notes,
    progress_bar,
    refuse_existing,
    refuse_unknown_formats,
    result,
    table,
    write_synthesis,
    write_text,
)
from kinetograph.cli.reading import TimedReading, read_file
from kinetograph.cli.why import answers_at, as_data, require_within, say_answers
from kinetograph.errors import RequestError

if TYPE_CHECKING:
    from kinetograph.formats import KeySources
    from kinetograph.formats.request_json import MoveRow
    from kinetograph.library import Library
    from kinetograph.methods.performance import PerformanceControl, PerformanceModel, Rule
    from kinetograph.methods.together import Asked, Keyframes
    from kinetograph.motion import Motion
    from kinetograph.pipeline import Answer
    from kinetograph.signal import Signal
    from kinetograph.synthesis import Synthesis
    from kinetograph.take import Take
    from kinetograph.work import Workers


def register(app: typer.Typer) -> None:
    """Add this module's commands."""
    add(app, perform, panel="Make motion")


@options()
class Inputs(Skeletons, Chosen):
    """The control, and the recordings that the motion is made of."""

    control: Annotated[Path, typer.Argument(help="A path (CSV with t,x,z in s and m) or a motion file.")]
    library: LibraryOption
    target: TargetTrack = None
    mirror: Mirror = False


@options("Output")
class Answers(Written):
    """What is written and shown."""

    alternatives: Annotated[
        int, typer.Option(help="How many motions to write: out.bvh, out_2.bvh, ...; the best is the first.", min=1)
    ] = 1
    alike: Annotated[
        bool,
        typer.Option("--alike", help="Alternatives may share pieces, reuse being free; without it, they share none."),
    ] = False
    pieces: Annotated[
        bool, typer.Option("--pieces", help="List every piece: where it comes from and what it costs.")
    ] = False
    transcript: Annotated[
        Path | None, typer.Option(help="CSV to write: the moves of the motion, with their margins.")
    ] = None
    why: Annotated[
        list[float] | None,
        typer.Option(help="Say what is there at this second and why, and what else could be. Repeatable."),
    ] = None

    def refuse(self) -> None:
        """Raise RequestError where a file cannot be written."""
        refuse_unknown_formats(self.output)
        refuse_existing(self.every_file(self.alternatives), self.force)

    def every_file(self, count: int) -> list[Path]:
        """The files of ``count`` syntheses, and of what the control is seen to be."""
        files = super().every_file(count)
        transcript = [self.transcript] if self.transcript else []
        return [*self.files, *transcript, *files[len(self.files) :]]


@options("Control")
class Following(Partner):
    """How the control is followed."""

    alignment: Annotated[
        str | None,
        typer.Option(help="How segments are placed: ground, similarity, affine, rigid or none; default ground."),
    ] = None
    keep_time: Annotated[
        bool, typer.Option("--keep-time", help="Keep a path's times where it is faster than the recordings.")
    ] = False
    stand: Annotated[bool, typer.Option(help="Hold a calm pose where a path stands still for long.")] = True
    smooth_time: Annotated[float, typer.Option(help="Smooth a drawn path over this many seconds.")] = 0.0
    smooth_space: Annotated[float, typer.Option(help="Smooth a drawn path over this many metres.")] = 0.0
    onto_path: Annotated[
        float | None,
        typer.Option(
            help="Bring the hips onto the path, and plant the feet anew. They sway about it by what is shorter than "
            "these seconds: 0.3 leaves a walker's sway, 0.12 keeps within 2 cm, 0 leaves none."
        ),
    ] = None

    facing: Annotated[
        float | None, typer.Option(help="Begin a drawn path facing this way, degrees from z to x; it is turned into.")
    ] = None

    def performed(self, control: Signal | Motion) -> Signal | Motion:
        """The control as it is performed: a drawn path is smoothed, and turned into where it begins facing away."""
        from kinetograph.methods.performance import begin_facing, smooth_path
        from kinetograph.signal import Signal

        if isinstance(control, Signal):
            path = smooth_path(control, self.smooth_time, self.smooth_space)
            return path if self.facing is None else begin_facing(path, math.radians(self.facing))
        if self.facing is not None:
            raise RequestError("--facing is for a drawn path; a motion faces by itself")
        return control

    def placed(self, method: PerformanceControl, finish: Finish) -> PerformanceControl:
        """The configuration with what happens after the search."""
        method = finished(method, self.alignment, finish)
        return method if self.onto_path is None else onto(method, self.onto_path)


@options("Together with the control")
class Along:
    """What is asked for along the control."""

    key: Annotated[
        list[str] | None,
        typer.Option(
            help="A pose to pass through: 'take:wave@1; time=4', or time=3..5, along=6 (metres), near=1,2; what else "
            "keys have may follow, see inbetween. Repeatable, in order of time."
        ),
    ] = None
    move: Annotated[
        list[str] | None,
        typer.Option(
            help="Only this from second to second: 4-7=run, a name of a take, a tag or a label; !run: none of it; "
            "run:0.5: at a cost a second; run/left or run/left/right: which foot first and last; "
            "like:take:NAME@2-3.5 or like:FILE@2-3.5: what is like an example. Repeatable."
        ),
    ] = None

    fill: Annotated[
        bool | None,
        typer.Option(
            "--fill/--no-fill",
            help="Play the recordings that have a key's pose around it, where no segment does. Without either: around "
            "keys at a place (along, near), where the path waits.",
        ),
    ] = None

    def asked(self, sources: KeySources, rules: Sequence[Rule], mirror: bool) -> Asked:
        """The same for the methods, with rules for pieces."""
        from kinetograph.formats.keys_json import row_from_text
        from kinetograph.formats.request_json import OnPathRow
        from kinetograph.methods.together import Asked, Span
        from kinetograph.pipeline import asked_key, rules_of

        moves = [move(text) for text in self.move or ()]
        rows = [row_from_text(text, f"--key {number}", OnPathRow) for number, text in enumerate(self.key or (), 1)]
        return Asked(
            tuple(asked_key(row, f"--key {number}", sources) for number, row in enumerate(rows, 1)),
            (*rules, *(rule for row in moves for rule in rules_of(row, sources, mirror=mirror))),
            tuple(Span(row.start, row.stop, row.first, row.last) for row in moves if row.first or row.last),
            fill=self.fill,
        )


@options("Search")
class RuledSearch(Search):
    """The search, with rules for parts of the control."""

    gap: Annotated[bool, typer.Option("--gap", help="Report what a beam gives up, and reuse in a large library.")] = (
        False
    )
    pin: Annotated[
        list[str] | None, typer.Option(help="Use only this take there: take@start-stop, in seconds. Repeatable.")
    ] = None
    forbid: Annotated[
        list[str] | None, typer.Option(help="Use nothing of this take there: take@start-stop. Repeatable.")
    ] = None

    @property
    def rules(self) -> list[Rule]:
        """What is pinned and what is forbidden."""
        return [*(rule(text, False) for text in self.pin or ()), *(rule(text, True) for text in self.forbid or ())]


def perform(
    inputs: Inputs,
    answers: Answers,
    following: Following,
    along: Along,
    search: RuledSearch,
    finish: Finish,
    layers: Layers,
    reading: TimedReading,
    work: Jobs,
) -> None:
    """Perform a control: a character, made of recordings, follows a path, another walker, or a dance partner.

    Example: kinetograph perform out/path.csv -l out/walks.library -o out/mine.bvh --mirror

    Example: kinetograph perform out/walk.bvh -l out/walks.library -o out/mine.glb --picture out/mine.png --pieces

    Example: kinetograph perform out/path.csv -l out/walks.library -o out/posed.bvh
    --key "take:humanoid3d_walk@0.3; time=4"

    Example: kinetograph perform out/path.csv -l out/walks.library -o out/like.bvh
    --move 2-4=like:take:humanoid3d_walk@0.2-1

    Example: kinetograph perform out/path.csv -l out/walks.library -o out/near.bvh --onto-path 0.15

    Example: kinetograph perform out/path.csv -l out/walks.library -o out/why.bvh --why 3.2

    Example: kinetograph perform out/path.csv -l out/walks.library -o out/two.bvh --layer arms=out/walk.bvh@2

    Example: kinetograph perform leader.bvh -l dances --target follower -o follower.bvh
    """
    from kinetograph.formats import KeySources
    from kinetograph.library import Shards
    from kinetograph.methods.performance import only_track, read_control
    from kinetograph.pipeline import Rendered, filler, fit_performance, open_library

    answers.refuse()
    layers.refuse()
    wanted = only_track(read_file(inputs.control, reading))
    library = open_library(inputs.library, inputs.selection)
    sources = KeySources(library, reading.read_options, inputs.target, note=note)
    asked = along.asked(sources, search.rules, inputs.mirror)
    method = following.placed(_configuration(wanted, library, inputs, following, search), finish)
    performed = following.performed(wanted)
    read_control(method, performed)  # what cannot be performed is refused before the library is read
    require_within(answers.why or (), performed, waits=any(each.placed for each in asked.keys))
    workers = search.workers(work.jobs)
    if workers.cluster is not None or (workers.jobs > 1 and isinstance(library, Shards)):
        made, summary = _over_shards(method, library, workers, (inputs, answers, search, layers), performed, asked)
        _end(made, summary, (wanted, inputs, answers))
        return
    with compilation_announced():
        model = fit_performance(method, library, track=inputs.target, note=note)
        made = _synthesised(model, performed, answers, asked, filler(model, library, track=inputs.target, note=note))
    made = wearing(made, read_layers(layers, library, reading), model)
    moves = transcribed(model, performed, asked.rules) if answers.transcript else ""
    reasons = answers_at(Rendered(made[0], performed, model, asked), answers.why or ())
    summary = _figures(made[0], model, performed, asked, search.gap)
    _end(made, summary, (wanted, inputs, answers), moves, reasons)


def _end(
    made: Sequence[Synthesis],
    summary: dict[str, Any],
    given: tuple[Signal | Motion, Inputs, Answers],
    moves: str = "",
    reasons: Sequence[Answer] = (),
) -> None:
    """Write what was made, and show what a person wants to know of it."""
    control, inputs, answers = given
    _written(made, moves, control, inputs, answers, reasons)
    _show(made, summary, answers, reasons)


def _figures(
    made: Synthesis, model: PerformanceModel, control: Signal | Motion, asked: Asked, gap: bool
) -> dict[str, Any]:
    """What ends the command."""
    summary = outcome(made, model, control) | without_keys(made, model, control)
    return summary | ({"gap": model.gap(control, asked.rules)} if gap and "gap" not in summary else {})


def _over_shards(
    method: PerformanceControl,
    library: Library,
    workers: Workers,
    given: tuple[Inputs, Answers, RuledSearch, Layers],
    control: Signal | Motion,
    asked: Asked,
) -> tuple[tuple[Synthesis, ...], dict[str, Any]]:
    """A synthesis of a library whose shards, or ranges of takes, have processes of their own, and its figures."""
    from kinetograph.methods.performance import over_shards
    from kinetograph.pipeline import noted

    inputs, answers, search, layers = given
    layers.refuse_any("shards in processes of their own make no layers: leave out --layer, or --jobs and --cluster")
    if asked.keys or asked.feet:
        raise RequestError("shards in processes of their own know no keys and no feet; leave out --jobs and --cluster")
    if answers.alternatives > 1 or answers.transcript or answers.why or search.gap:
        raise RequestError(
            "shards in processes of their own give one motion: leave out --alternatives, --transcript, --why and "
            "--gap, or leave out --jobs and --cluster tcp://HOST:PORT"
        )
    with (
        compilation_announced(),
        over_shards(method, library, workers, track=inputs.target) as model,
        progress_bar("searching") as progress,
    ):
        made = noted(model.synthesize(control, progress, asked.rules), model.notes, model.fitted.left_out)
        return (made,), outcome(made, model.holding({piece.take for piece in made.pieces}), control)


def _written(
    made: Sequence[Synthesis],
    moves: str,
    control: Signal | Motion,
    inputs: Inputs,
    answers: Answers,
    reasons: Sequence[Answer] = (),
) -> None:
    """Write all files or none, and say what a person should know."""
    from kinetograph.formats import together

    notes(made[0].warnings)
    more = {"why": as_data(reasons)} if reasons else {}
    with together():
        for number, synthesis in enumerate(made, start=1):
            write_synthesis(synthesis, answers, control, inputs.control.name, number, more)
        if answers.transcript:
            write_text(moves, answers.transcript, answers.force)


def _configuration(
    control: Signal | Motion, library: Library, inputs: Inputs, following: Following, search: Search
) -> PerformanceControl:
    from kinetograph.methods.performance import FIRST_FACING
    from kinetograph.pipeline import has_partners
    from kinetograph.signal import Signal

    partners = has_partners(library, inputs.target)
    channels = control.names if isinstance(control, Signal) and not control.spatial else ()
    method = performance_control(search, following, mirror=inputs.mirror, partners=partners, channels=channels)
    first = 0.0 if following.facing is None else FIRST_FACING
    method = replace(method, keep_time=following.keep_time, stand=following.stand, first_facing=first)
    return replace(method, bodies=inputs.bodies)


def _synthesised(
    model: PerformanceModel,
    control: Signal | Motion,
    answers: Answers,
    asked: Asked,
    keyframes: Keyframes | None = None,
) -> tuple[Synthesis, ...]:
    from kinetograph.methods.performance import require_moves
    from kinetograph.methods.together import Several
    from kinetograph.pipeline import perform_asked, perform_several

    if answers.transcript:
        require_moves(model.fitted)
    if answers.alternatives > 1:
        return perform_several(model, control, asked, Several(answers.alternatives, answers.alike), keyframes)
    with progress_bar("searching") as progress:
        return (perform_asked(model, control, asked, progress, keyframes),)


def _show(made: Sequence[Synthesis], summary: dict[str, Any], answers: Answers, reasons: Sequence[Answer] = ()) -> None:
    rows = breakdown(made[0]) if answers.pieces else []
    if answers.pieces and not answers.as_json:
        table(rows, as_json=False)
    if reasons and not answers.as_json:
        say_answers(reasons)
    costs = {f"cost_{number}": synthesis.cost for number, synthesis in enumerate(made[1:], start=2)}
    listed = {"breakdown": rows} if rows and answers.as_json else {}
    listed |= {"why": as_data(reasons)} if reasons and answers.as_json else {}
    wrote = [str(path) for path in answers.every_file(len(made))]
    ending = summary if answers.as_json else in_words(summary)
    left = left_out(made[0], answers.as_json)
    result({**ending, **costs, **listed, **left, "wrote": wrote}, answers.as_json)


def breakdown(synthesis: Synthesis) -> list[dict[str, Any]]:
    """One row per piece: when, where from, its stretch, and its two shares of the cost."""
    return [
        {
            "start": piece.start,
            "stop": piece.stop,
            "take": f"{piece.take}, mirrored" if piece.mirrored else piece.take,
            "from": piece.source_start,
            "to": piece.source_stop,
            "stretch": "held" if piece.held else piece.stretch,
            "interpretation": piece.cost,
            "continuity": piece.seam,
        }
        for piece in synthesis.pieces
    ]


def transcribed(model: PerformanceModel, control: Take | Signal | Motion, rules: Sequence[Rule] = ()) -> str:
    """The moves of the motion that is made of a control as CSV: move, start and stop in seconds, margin.

    Moves that are units of partner dances stand in the thesis' notation as well.
    """
    from kinetograph.segmentation import notation

    moves = model.transcribe(control, rules)
    rows = [f"{m.move},{m.start:.3f},{m.stop:.3f},{m.margin:.4f}" for m in moves]
    symbols = [notation([m.move]) for m in moves]
    if symbols == [m.move for m in moves]:
        return "\n".join(["move,start,stop,margin", *rows]) + "\n"
    rows = [f"{row},{symbol}" for row, symbol in zip(rows, symbols, strict=True)]
    return "\n".join(["move,start,stop,margin,notation", *rows]) + "\n"


def rule(text: str, forbid: bool) -> Rule:
    """``take@start-stop`` as a rule.

    Raises
    ------
    RequestError
        For text of another form.
    """
    from kinetograph.methods.performance import Rule

    take, _, span = text.rpartition("@")
    start, _, stop = span.partition("-")
    try:
        return Rule(float(start), float(stop), take=take or None, forbid=forbid)
    except ValueError:
        raise RequestError(f"a rule is take@start-stop in seconds, as in waltz@1.5-3; found {text!r}") from None


def move(text: str) -> MoveRow:
    """``start-stop=name``, with what else is asked of the span, as a row of a request.

    Raises
    ------
    RequestError
        For text of another form.

    Examples
    --------
    >>> row = move("4-7=run/left:0.5")
    >>> row.start, row.stop, row.name, row.weight, row.first
    (4.0, 7.0, 'run', 0.5, 'left')
    >>> row = move("4-7=!like:take:wave@2-3.5; within=0.3")
    >>> row.like, row.within, row.forbid
    ('take:wave@2-3.5', 0.3, True)
    """
    import msgspec

    from kinetograph.formats.request_json import MoveRow

    span, separator, asked = text.partition("=")
    start, _, stop = span.partition("-")
    found = _MOVE.fullmatch(asked.strip())
    try:
        if found is None or not separator:
            raise ValueError
        given = {name: value for name, value in found.groupdict("").items() if value}
        values: dict[str, object] = {"start": float(start), "stop": float(stop), "forbid": "forbid" in given}
        values |= {name: given[name].strip() for name in ("name", "like") if name in given}
        values |= {name: float(given[name]) for name in ("weight", "within") if name in given}
        values |= dict(zip(("first", "last"), given.get("feet", "").split("/")[1:], strict=False))
        return msgspec.convert(values, MoveRow)
    except (ValueError, msgspec.ValidationError):
        raise RequestError(
            "a move is start-stop=name in seconds, as in 4-7=run, 4-7=!run, 4-7=run:0.5 or 4-7=walk/left, or like an "
            f"example, as in 4-7=like:take:wave@2-3.5 or 4-7=like:wave.bvh@2-3.5; within=0.3; found {text!r}"
        ) from None


_MOVE = re.compile(
    r"(?P<forbid>!)?"
    r"(?:like:(?P<like>.+@[\d.]+-[\d.]+)|(?P<name>[^/:]*))"
    r"(?P<feet>(?:/\w+){0,2})"
    r"(?::(?P<weight>[^;]+))?"
    r"(?:;\s*within=(?P<within>.+))?"
)
"""What a move's text has after its span."""
