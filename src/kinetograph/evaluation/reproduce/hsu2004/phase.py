"""Does a generated gait keep the phase of the real one, and what tells it to? (Hsu 2004, section 6.1)"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

from kinetograph.arrays import FloatArray
from kinetograph.errors import KinetographError
from kinetograph.evaluation.metrics import joint_error
from kinetograph.evaluation.phase import (
    Locking,
    Phase,
    ankles_apart,
    cadence_ratio,
    foot_agreement,
    gait_phase,
    locking,
    phase_difference,
    plant_phase,
)
from kinetograph.evaluation.reproduce.hsu2004 import figures
from kinetograph.evaluation.reproduce.hsu2004.data import held_out
from kinetograph.evaluation.reproduce.page import Section, paragraph, picture, records, table
from kinetograph.kinematics import role_positions
from kinetograph.library import Library
from kinetograph.methods.performance import GroundPath, PerformanceControl, PerformanceModel
from kinetograph.motion import Motion, cut
from kinetograph.signal import Signal

Tick = Callable[[str], None]
HIPS, PATH = "hips", "path alone"
CALM = 0.6
"""Seconds (Gaussian) over which the sway of the hips is taken out of a control: at a stride a second, 99.9 % of it."""
LENGTHS = (2.0, 4.0, 8.0, 16.0, 32.0)
SHARP, STRAIGHT = np.deg2rad(60.0), np.deg2rad(20.0)
"""Turning, radians a second: where a turn is sharp, and below which a walk is straight."""
SIGMAS = (0.0, 0.15, 0.3, 0.45, 0.6, 0.9)

CLAIM = """The thesis, 6.1: on short walks the gait had nearly the source's frequency but not its phase, since the
control tells nothing of it; on longer ones, to the author's surprise, it was often nearly in phase. The explanation
given is that the subject turned sharply with the same footwork each time, and that the global optimum spreads what a
turn says of the phase over the whole walk. No figure is given."""
TOLD = """What the control holds is the two hip joints on the ground. Their distance is set to one value, but where
their middle goes and how their line turns is kept, and a walking pelvis sways sideways and turns with every stride.
So the experiment is run twice: with the hips as in the thesis, and with the path alone, where sway and turn of the
hips within a stride are smoothed away on both sides, the control and the library (Gaussian of 0.6 s)."""
NULL = """In phase is within a quarter turn; a gait that knows nothing is so half of the time. The null moves the
generated gait round in time by 5 s or more, 999 times: it walks as it does, but starts elsewhere."""
SMOOTHED = """How much sway is needed: the share in phase as the hips are smoothed more, on both sides. A stride a
second keeps exp(-2 π² s²) of its sway."""


@dataclass(frozen=True)
class CalmPath(GroundPath):
    """The hips on the ground without their sway: middle and direction smoothed over ``seconds``."""

    seconds: float = CALM

    def points(self, control: Motion | Signal) -> FloatArray:
        """See `ControlReading`."""
        pair, sigma = super().points(control), self.seconds * control.fps
        middle = gaussian_filter1d(pair.mean(axis=1), sigma, axis=0, mode="nearest")
        half = 0.5 * (pair[:, 0] - pair[:, 1])
        angle = gaussian_filter1d(np.unwrap(np.arctan2(half[:, 2], half[:, 0])), sigma, mode="nearest")
        half = 0.5 * self.hip_distance * np.stack([np.cos(angle), np.zeros_like(angle), np.sin(angle)], axis=-1)
        return np.stack([middle + half, middle - half], axis=1)


@dataclass(frozen=True, eq=False)
class Walked:
    """A held-out walk performed: by which control, its motions and how it kept phase."""

    take: str
    control: str
    real: Motion
    made: Motion
    kept: Locking

    @property
    def phases(self) -> tuple[Phase, Phase]:
        """Of the made and of the real gait."""
        return gait_phase(self.made), gait_phase(self.real)


def methods() -> dict[str, PerformanceControl]:
    """The two controls that are compared."""
    return {HIPS: PerformanceControl(), PATH: PerformanceControl(control_points=CalmPath())}


def phase_section(title: str, library: Library, quick: bool, tick: Tick, *, first: bool = True) -> Section:
    """All that is said of phase on one library of walks; first: with what the thesis says of it."""
    models = {
        (name, control): method.fit(library, exclude=(name,))
        for name in library.names()
        for control, method in methods().items()
    }
    takes = held_out(library)
    walked = [w for name, motion in takes for c in methods() if (w := _walk(models[name, c], name, c, motion))]
    tick("whole walks")
    if not walked:
        text = "No take walks for long enough, or with steps wide enough, to have a phase."
        return Section(title, (paragraph(text, "missing"),))
    rows = [_row(w) for w in walked]
    sway = sway_by_phase(takes[0][1])
    excerpts = in_step_by_length(takes, models, 3 if quick else 8, LENGTHS[:3] if quick else LENGTHS)
    tick("excerpts")
    turns = turn_footwork([motion for _, motion in takes])
    smoothed = in_phase_by_smoothing(library, takes[:1] if quick else takes)
    tick("smoothing")
    parts = (
        *((paragraph(CLAIM, "paper"), paragraph(TOLD)) if first else ()),
        table("Phase of the generated gait less that of the real one, held-out takes", _COLUMNS, rows),
        paragraph(_verdict(walked)),
        picture(figures.draw_differences(_tracks(walked)), "The difference of phase over time, longest take."),
        picture(figures.draw_sway(*sway), "What the hips say of the phase: mean and spread over the strides."),
        paragraph(_sway_text(sway)),
        table("Excerpts that come out on the right foot, by their length", _EXCERPT_COLUMNS, excerpts),
        picture(figures.draw_excerpts(excerpts), "Excerpts in step by length, 95 % intervals (Wilson)."),
        paragraph(_turn_text(turns)),
        table("Gait phase where turns are sharpest", _TURN_COLUMNS, turns),
        paragraph(SMOOTHED),
        table("Share in phase by smoothing", _SMOOTHED_COLUMNS, smoothed),
    )
    numbers = {"rows": records(_COLUMNS, rows), "excerpts": excerpts, "turns": turns, "smoothed": smoothed}
    return Section(title, parts, numbers)


_COLUMNS = (
    *("take", "control", "seconds walking", "in phase %", "by footplants %", "mean cosine", "resultant"),
    *("mean difference °", "slips", "cadence, times real", "null's 95th percentile", "p", "joints cm"),
)
_EXCERPT_COLUMNS = ("seconds", "excerpts", f"{HIPS}: in step %", f"{PATH}: in step %")
_SMOOTHED_COLUMNS = ("Gaussian, seconds", "sway kept at a stride a second %", "in phase %", "joints cm")
_TURN_COLUMNS = ("turns", "count", "mean phase °", "resultant", "Rayleigh p")


def _walk(model: PerformanceModel, name: str, control: str, motion: Motion) -> Walked | None:
    try:
        made = model.synthesize(motion).motion
        kept = locking(gait_phase(made), gait_phase(motion), np.random.default_rng(0))
    except KinetographError:
        return None
    return Walked(name, control, motion, made, kept)


def _row(walked: Walked) -> tuple[str | float | int, ...]:
    kept = walked.kept
    return (
        *(walked.take, walked.control, kept.seconds, 100 * kept.in_phase, 100 * _by_plants(walked)),
        *(kept.agreement, kept.resultant, float(np.rad2deg(kept.mean)), kept.slips, cadence_ratio(*walked.phases)),
        *(kept.null_p95, kept.p, 100 * joint_error(walked.made, walked.real)),
    )


def _by_plants(walked: Walked) -> float:
    """The share in phase by the times of footplants instead, which know nothing of the ankles' swing."""
    made, real = plant_phase(walked.made), plant_phase(walked.real)
    frames = min(len(made), len(real))
    difference = np.abs(np.angle(np.exp(1j * (made[:frames] - real[:frames]))))
    known = difference[~np.isnan(difference)]
    return float((known < np.pi / 2).mean()) if len(known) else float("nan")


def _tracks(walked: list[Walked]) -> list[tuple[str, FloatArray, FloatArray]]:
    """Of the first take: by control, times and differences where both walk."""
    found = []
    for one in (w for w in walked if w.take == walked[0].take):
        difference, both = phase_difference(*one.phases)
        times = np.flatnonzero(both) / one.real.fps
        found.append((f"{one.take}, {one.control}", times, difference[both]))
    return found


def _verdict(walked: list[Walked]) -> str:
    said = []
    for control in dict.fromkeys(w.control for w in walked):
        mine = [w.kept for w in walked if w.control == control]
        seconds = sum(k.seconds for k in mine)
        share = 100 * sum(k.in_phase * k.seconds for k in mine) / seconds
        surer = sum(k.p < 0.05 for k in mine)
        told = sum(not np.isnan(k.p) for k in mine)
        beyond = f"beyond chance (p < 0.05) in {surer} of {told} takes that are long enough to tell"
        said.append(f"{control}: {share:.0f} % of {seconds:.0f} s in phase, {beyond}")
    return f"{NULL} {'; '.join(said)}."


def sway_by_phase(motion: Motion, bins: int = 24) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Centres of phase ``(B,)``, and by bin the mean and deviation ``(B, 2)`` of what the hips do within a stride.

    The two are the sideways distance of their middle, cm to the left, and their turn, degrees to the left, from the
    smoothed path.
    """
    reading, calm = GroundPath(), CalmPath()
    raw, path = reading.points(motion), calm.points(motion)
    left = (path[:, 0] - path[:, 1]) / reading.hip_distance
    aside = 100 * np.sum((raw.mean(axis=1) - path.mean(axis=1)) * left, axis=1)
    across = raw[:, 0] - raw[:, 1]
    turn = np.arctan2(-across[:, 2], across[:, 0]) - np.arctan2(-left[:, 2], left[:, 0])
    values = np.stack([aside, np.rad2deg(np.angle(np.exp(1j * turn)))], axis=1)
    phase = gait_phase(motion)
    edges = np.linspace(-np.pi, np.pi, bins + 1)
    which = np.clip(np.digitize(phase.angle, edges) - 1, 0, bins - 1)
    straight = phase.walking & (np.abs(turning(motion)) < STRAIGHT)
    groups = [values[(which == b) & straight] for b in range(bins)]
    none = np.full(2, np.nan)
    mean = np.array([g.mean(axis=0) if len(g) else none for g in groups])
    spread = np.array([g.std(axis=0) if len(g) else none for g in groups])
    return 0.5 * (edges[1:] + edges[:-1]), mean, spread


def _sway_text(sway: tuple[FloatArray, FloatArray, FloatArray]) -> str:
    _, mean, spread = sway
    swing = np.nanmax(mean, axis=0) - np.nanmin(mean, axis=0)
    rest = np.nanmean(spread, axis=0)
    return (
        f"Within a stride the middle of the hips goes {swing[0]:.1f} cm from side to side and their line turns by "
        f"{swing[1]:.1f}°, where the walk is straight; about that mean single strides spread by {rest[0]:.1f} cm and "
        f"{rest[1]:.1f}°. Projecting the hips and setting their distance leaves both in the control."
    )


def in_step_by_length(
    takes: list[tuple[str, Motion]],
    models: dict[tuple[str, str], PerformanceModel],
    count: int,
    lengths: tuple[float, ...],
) -> list[tuple[float, int, float, float]]:
    """By length in seconds: the number of excerpts and the shares in per cent that are in step, by hips and by path.

    ``count`` excerpts are spread evenly over each take; one in step has ankles that swing as the real ones do rather
    than oppositely.
    """
    rows = []
    for length in lengths:
        found: dict[str, list[bool]] = {HIPS: [], PATH: []}
        for name, motion in takes:
            for excerpt in _excerpts(motion, length, count):
                for control, agreed in found.items():
                    made = models[name, control].synthesize(excerpt).motion
                    agreed.append(foot_agreement(made, excerpt) > 0)
        if found[HIPS]:
            hips, path = (100 * float(np.mean(found[control])) for control in (HIPS, PATH))
            rows.append((length, len(found[HIPS]), hips, path))
    return rows


def _excerpts(motion: Motion, length: float, count: int) -> list[Motion]:
    """Excerpts in which the person walks at least half of the time."""
    frames = int(length * motion.fps) + 1
    if frames > len(motion):
        return []
    starts = np.unique(np.linspace(0, len(motion) - frames, count).astype(int))
    found = [cut(motion, int(a), int(a) + frames) for a in starts]
    return [m for m in found if np.mean(np.abs(ankles_apart(m)) > 0.08) > 0.5]


def in_phase_by_smoothing(library: Library, takes: list[tuple[str, Motion]]) -> list[tuple[float, float, float, float]]:
    """By the smoothing of control and library: the sway that is left, and means over the takes."""
    rows = []
    for sigma in SIGMAS:
        method = PerformanceControl(control_points=CalmPath(seconds=sigma) if sigma else GroundPath())
        walked = [_walk(method.fit(library, exclude=(name,)), name, "", motion) for name, motion in takes]
        known = [w for w in walked if w is not None]
        if known:
            joints = float(np.mean([100 * joint_error(w.made, w.real) for w in known]))
            share = 100 * float(np.mean([w.kept.in_phase for w in known]))
            rows.append((sigma, 100 * float(np.exp(-2 * (np.pi * sigma) ** 2)), share, joints))
    return rows


def turn_footwork(motions: list[Motion]) -> list[tuple[str, int, float, float, float]]:
    """Real gait phase where a turn is sharpest, faster than 60 degrees a second: left turns, right turns, and both with
    the phase of right ones moved on by half a stride, which is the same footwork mirrored.

    Rayleigh's test: p is the chance of phases so much alike if they were even.
    """
    phases: dict[str, list[float]] = {"left": [], "right": []}
    for motion in motions:
        if motion.duration < 2.0:
            continue
        phase = gait_phase(motion)
        rate = turning(motion)
        for side, signed in (("left", rate), ("right", -rate)):
            peaks, _ = find_peaks(signed, height=SHARP, distance=max(int(motion.fps), 1))
            phases[side] += [float(phase.angle[p]) for p in peaks if phase.walking[p]]
    phases["both, right mirrored"] = phases["left"] + [angle + np.pi for angle in phases["right"]]
    rows = []
    for side, angles in phases.items():
        vector = complex(np.exp(1j * np.array(angles)).mean()) if angles else 0j
        chance = float(np.exp(-len(angles) * abs(vector) ** 2)) if angles else float("nan")
        rows.append((side, len(angles), float(np.rad2deg(np.angle(vector))), abs(vector), chance))
    return rows


def turning(motion: Motion) -> FloatArray:
    """How fast the smoothed line of the hips turns to the left, radians a second ``(F,)``."""
    hips = role_positions(motion, ("left_hip", "right_hip"))
    across = hips[:, 0] - hips[:, 1]
    angle = np.unwrap(np.arctan2(-across[:, 2], across[:, 0]))
    calm = gaussian_filter1d(angle, CALM * motion.fps, mode="nearest")
    return np.asarray(np.gradient(calm, 1 / motion.fps))


def _turn_text(turns: list[tuple[str, int, float, float, float]]) -> str:
    told = [f"{side}: {r:.2f} over {n} turns" for side, n, _, r, _ in turns]
    return (
        "The thesis' explanation can be looked at by itself: if turns are made with the same footwork, the gait is at "
        f"one phase whenever a turn is sharpest. Resultant of these phases, 1 for always the same: {'; '.join(told)}."
    )
