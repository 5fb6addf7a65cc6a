"""The command library tap: cuts by a person, tapped while a take plays back or given as times."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kinetograph.cli.options import AsJson, LibraryArgument, options
from kinetograph.cli.output import refuse_existing, result
from kinetograph.errors import KinetographError, RequestError

if TYPE_CHECKING:
    from kinetograph.motion import Motion
    from kinetograph.take import Take

_RATE = 15.0  # drawings per second
_WIDTH = 48  # letters


@options()
class Taps:
    """Where the cuts come from."""

    source: Annotated[
        Path | None, typer.Option("--from", help="CSV of times in seconds, one per line, in place of keys.")
    ] = None
    track: Annotated[str | None, typer.Option(help="Cut this motion; without it, all of the take.")] = None
    force: Annotated[bool, typer.Option("--force", help="Replace cuts that exist, and a picture that exists.")] = False


@options("Playback")
class Playback:
    """How the take plays back."""

    latency: Annotated[float, typer.Option(help="Seconds by which you press late; subtracted from every tap.")] = 0.0
    speed: Annotated[float, typer.Option(help="Play back slower (below 1) or faster.")] = 1.0
    countdown: Annotated[float, typer.Option(help="Seconds before it begins.")] = 3.0
    picture: Annotated[Path | None, typer.Option(help="Contact sheet to draw and open first, .png.")] = None


def tap(
    folder: LibraryArgument,
    take: Annotated[str, typer.Argument(help="The take to cut.")],
    taps: Taps,
    playback: Playback,
    as_json: AsJson = False,
) -> None:
    """Cut a take where you tap a key while it plays back, for example to its beats or its steps.

    Any key taps, Backspace removes the last tap, Enter or q ends early, Ctrl-C stops and writes nothing. "after beats"
    is the median time from the beats found in the feet to your taps: an estimate of your latency.

    Example: kinetograph library tap out/clips.library humanoid3d_punch --speed 0.5

    Example: kinetograph library tap out/clips.library humanoid3d_punch --from out/steps.csv
    """
    from kinetograph.library.annotations_csv import read_times
    from kinetograph.pipeline import cut_by_hand, open_library, refuse_cuts

    if playback.picture:
        refuse_existing([playback.picture], taps.force)
    library = open_library(folder)
    recorded = library.take(take)
    motions = _motions(recorded, taps.track)
    if not taps.force:
        refuse_cuts(recorded, motions)
    times = list(read_times(taps.source)) if taps.source else _tapped(motions, take, playback)
    cuts = cut_by_hand(library, recorded, tuple(motions), times)
    result({"take": take, "cuts": len(cuts), **_rhythm(cuts), "after_beats": _late(motions, cuts)}, as_json)


def _motions(take: Take, track: str | None) -> dict[str, Motion]:
    """The motions to cut. Raises RequestError, naming the motions there are, where the one named is none."""
    from kinetograph.motion import Motion

    motions = {name: t for name, t in take.tracks.items() if isinstance(t, Motion) and track in (None, name)}
    return motions or {str(track): take.motion(track)}


def _tapped(motions: dict[str, Motion], title: str, playback: Playback) -> list[float]:
    """Seconds of the take at which a person taps."""
    if not playback.speed > 0:
        raise RequestError(f"speed must be a positive number, found {playback.speed}")
    if playback.picture:
        _open_picture(playback.picture, list(motions.values()), title)
    pressed = _play(list(motions.values()), playback.speed, playback.countdown)
    taps = (playback.speed * (time - playback.latency) for time in pressed)
    return [time for time in taps if time >= 0]


def _rhythm(times: tuple[float, ...]) -> dict[str, float]:
    return {"first": times[0], "last": times[-1], "apart": (times[-1] - times[0]) / (len(times) - 1)}


def _late(motions: dict[str, Motion], times: tuple[float, ...]) -> float | str:
    """Median seconds after the nearest beat found in the motion, or that none was found."""
    import numpy as np

    from kinetograph.segmentation import detect_beats

    try:
        beats = np.array(detect_beats(list(motions.values())))
    except KinetographError:
        return "no beats found"
    offsets = np.array(times)[:, None] - beats
    return float(np.median(offsets[np.arange(len(times)), np.abs(offsets).argmin(axis=1)]))


def _open_picture(path: Path, motions: list[Motion], title: str) -> None:
    from kinetograph.drawing.pictures import contact_sheet

    contact_sheet(motions, path, title=title)
    typer.launch(str(path))


def _play(motions: list[Motion], speed: float, countdown: float) -> list[float]:
    """Seconds of playback at which keys were pressed. Raises RequestError without a terminal, or at Ctrl-C."""
    from kinetograph.cli.keystrokes import single_keys, taps

    keys, duration = sys.stdin.fileno(), max(m.duration for m in motions) / speed
    with single_keys(keys):
        screen = _Screen(motions, speed)
        try:
            taps(keys, countdown, lambda now, _: screen.draw(now - countdown, 0))
            return taps(keys, duration, screen.draw)
        except KeyboardInterrupt:
            raise RequestError("stopped by Ctrl-C; nothing was written") from None


class _Screen:
    """Draws moments of a playback on stderr, one over the other."""

    def __init__(self, motions: list[Motion], speed: float) -> None:
        from kinetograph.drawing.text import bones_over_time

        self._bones = bones_over_time(motions, _RATE)
        self._speed = speed
        self._count = 0
        self._drawn = False

    def draw(self, now: float, count: int) -> None:
        """The moment ``now`` seconds after the beginning, before which it counts down, ``count`` taps so far."""
        from kinetograph.drawing.text import draw_bones

        total = (len(self._bones) - 1) / _RATE
        second = min(max(now * self._speed, 0.0), total)
        figure = draw_bones(self._bones[min(round(second * _RATE), len(self._bones) - 1)], _WIDTH)
        done = round(_WIDTH * second / max(total, 1e-9))
        clock = f"begins in {-now:.1f} s" if now < 0 else f"{second:6.2f} of {total:.2f} s"
        mark = "●" if count > self._count else " "
        rows = [*figure, "━" * done + "─" * (_WIDTH - done), f"{mark} {clock}   {count} taps"]
        up = f"\x1b[{len(rows)}A" if self._drawn else ""
        sys.stderr.write(up + "".join(f"\x1b[2K{row}\n" for row in rows))
        sys.stderr.flush()
        self._count, self._drawn = count, True
