"""The command library tap: cuts by a person, tapped while a take plays back or given as times."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from kinetograph.cli._shell import AsJson, result
from kinetograph.errors import KinetographError, RequestError

if TYPE_CHECKING:
    from kinetograph.motion import Motion

_RATE = 15.0  # drawings a second
_WIDTH = 48  # letters


def tap(
    folder: Annotated[Path, typer.Argument(metavar="LIB", help="The library's folder.")],
    take: Annotated[str, typer.Argument(help="The take to cut.")],
    source: Annotated[
        Path | None, typer.Option("--from", help="Times in seconds from this CSV, one a line, in place of keys.")
    ] = None,
    track: Annotated[str | None, typer.Option(help="Cut this motion; without it, all of the take.")] = None,
    latency: Annotated[float, typer.Option(help="Seconds by which you press late; taken off every tap.")] = 0.0,
    speed: Annotated[float, typer.Option(help="Play back slower (below 1) or faster.")] = 1.0,
    countdown: Annotated[float, typer.Option(help="Seconds before it begins.")] = 3.0,
    picture: Annotated[Path | None, typer.Option(help="Contact sheet to draw and open first, .png.")] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Take the place of cuts that are there, and of a picture.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Cut a take where you tap a key while it plays back, as to its beats or its steps.

    Any key taps, Backspace takes a tap back, Enter or q ends early, Ctrl-C gives up and writes nothing. What is told
    at the end, how long after the beats found in the feet you tapped, is an estimate of your latency.

    Example: kinetograph library tap dances salsa_1 --latency 0.05
    Example: kinetograph library tap dances salsa_1 --from beats.csv
    """
    from kinetograph.library.annotations_csv import read_times
    from kinetograph.motion import Motion
    from kinetograph.pipeline import cut_by_hand, open_library, refuse_cuts

    library = open_library(folder)
    found = library.take(take)
    motions = {name: t for name, t in found.tracks.items() if isinstance(t, Motion) and track in (None, name)}
    if not motions:
        found.motion(track)  # says which there are
    if not force:
        refuse_cuts(found, motions)
    if source:
        times = list(read_times(source))
    else:
        if not speed > 0:
            raise RequestError(f"speed must be a positive number, found {speed}")
        if picture:
            _open_picture(picture, list(motions.values()), take, force)
        taps = (speed * (t - latency) for t in _play(list(motions.values()), speed, countdown))
        times = [time for time in taps if time >= 0]
    kept = cut_by_hand(library, found, tuple(motions), times)
    result({"take": take, "cuts": len(kept), **_rhythm(kept), "after_beats": _late(motions, kept)}, as_json)


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


def _open_picture(path: Path, motions: list[Motion], title: str, force: bool) -> None:
    from kinetograph.cli._shell import refuse_existing
    from kinetograph.drawing.pictures import contact_sheet

    refuse_existing([path], force)
    contact_sheet(motions, path, title=title)
    typer.launch(str(path))


def _play(motions: list[Motion], speed: float, countdown: float) -> list[float]:
    """Seconds of playback at which keys were pressed. Raises RequestError without a terminal, or at Ctrl-C."""
    from kinetograph.cli._keys import single_keys, taps

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
