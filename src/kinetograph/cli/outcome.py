"""What a person wants to know of a performance when its command ends: what is good and bad about it, with units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from kinetograph.cli.output import summarize

if TYPE_CHECKING:
    from kinetograph.methods.performance import PerformanceModel, ShardedModel
    from kinetograph.motion import Motion
    from kinetograph.signal import Signal
    from kinetograph.synthesis import Synthesis

COSTS = {
    "interpretation": "off the control",
    "continuity": "jumps at seams",
    "reuse": "reuse",
    "change": "changes of person or style",
    "unusual": "not walked or run",
    "keys": "recordings unlike the keys",
    "moves": "moves not asked for",
    "filled": "spans filled around keys",
}
"""What the parts of a cost are called."""


def outcome(synthesis: Synthesis, model: PerformanceModel | ShardedModel, control: Signal | Motion) -> dict[str, Any]:
    """The figures of a performance, for machines; lengths are metres.

    Parameters
    ----------
    synthesis : Synthesis
    model : PerformanceModel or ShardedModel
        What made it.
    control : Signal or Motion
        What it was made of.

    Returns
    -------
    dict of str to Any
        What every synthesis has, and before it how far the hips are from a path or a walker that they follow, and how
        fast planted feet move, where there are any: in the result, and in the recordings that it is made of.
    """
    from kinetograph.evaluation import contact_speed, control_distances
    from kinetograph.methods.performance import GroundPath
    from kinetograph.post import contacts_of

    first: dict[str, Any] = {}
    if isinstance(model.method.control_points, GroundPath):
        read = model.read(control)
        errors = control_distances(synthesis.motion, read.points, read.fps, synthesis.clock)
        first = {"hips_off_mean": float(errors.mean()), "hips_off_most": float(errors.max())}
    planted = contacts_of(synthesis.annotations)
    if planted:
        first["planted_feet_speed"] = contact_speed(synthesis.motion, planted)
        first["planted_feet_speed_recorded"] = _recorded_speed(synthesis, model)
    summary = {**first, **summarize(synthesis)}
    if synthesis.layers:
        summary["layers"] = [
            {"name": layer.name, "start": layer.start, "stop": layer.stop, "joints": list(layer.joints)}
            for layer in synthesis.layers
        ]
    for name in ("filled_spans", "filled_seconds", "waited_seconds"):
        if name in synthesis.statistics:
            summary[name] = synthesis.statistics[name]
    if "untouched" in synthesis.statistics:
        summary["untouched_share"] = synthesis.statistics["untouched"]
    return summary


def without_keys(synthesis: Synthesis, model: PerformanceModel, control: Signal | Motion) -> dict[str, Any]:
    """How far the hips are from a path on which no keys are met, where a performance meets some, in metres."""
    from kinetograph.evaluation import control_distances
    from kinetograph.methods.performance import GroundPath

    if not synthesis.met or not isinstance(model.method.control_points, GroundPath):
        return {}
    read = model.read(control)
    errors = control_distances(model.synthesize(control).motion, read.points, read.fps)
    return {"hips_off_mean_without_keys": float(errors.mean()), "hips_off_most_without_keys": float(errors.max())}


def _recorded_speed(synthesis: Synthesis, model: PerformanceModel | ShardedModel) -> float:
    """The mean speed of planted feet in the recordings that a performance uses."""
    import numpy as np

    from kinetograph.evaluation import contact_speed
    from kinetograph.post import contacts_of

    used = {piece.take for piece in synthesis.pieces}
    sources = [s for s in model.fitted.sources if s.take in used and not s.mirrored and contacts_of(s.annotations)]
    speeds = [contact_speed(s.motion, contacts_of(s.annotations)) for s in sources]
    return float(np.mean(speeds)) if speeds else float("nan")


def in_words(summary: dict[str, Any]) -> dict[str, str]:
    """The same for people: what matters first, with units, and with what to compare it.

    Parameters
    ----------
    summary : dict
        As `outcome` or `summarize` gives it.

    Returns
    -------
    dict of str to str
    """
    rows: dict[str, str] = {}
    if "hips_off_mean" in summary:
        mean, most = 100 * summary["hips_off_mean"], 100 * summary["hips_off_most"]
        rows["hips from the path"] = f"{mean:.1f} cm in the mean, {most:.1f} cm at most"
    if "hips_off_mean_without_keys" in summary:
        mean, most = (100 * summary[f"hips_off_{which}_without_keys"] for which in ("mean", "most"))
        rows["hips from the path"] += f"; without keys {mean:.1f} and {most:.1f}"
    if "planted_feet_speed" in summary:
        ours, theirs = 100 * summary["planted_feet_speed"], 100 * summary["planted_feet_speed_recorded"]
        compared = f"; in the recordings {theirs:.1f}" if theirs == theirs else ""
        rows["planted feet"] = f"move at {ours:.1f} cm/s in the mean{compared}"
    if "handhold_residual_median" in summary:
        median, high = (100 * summary[f"handhold_residual_{q}"] for q in ("median", "p95"))
        rows["held hands"] = f"{median:.1f} cm from where they hold in the median, {high:.1f} cm in 95 % of frames"
    for number, layer in enumerate(summary.get("layers", ()), start=1):
        span = f"{layer['start']:.1f} to {layer['stop']:.1f} s"
        rows[f"layer {number}"] = f"{layer['name']} drives {len(layer['joints'])} joints from {span}"
    if summary.get("filled_spans"):
        spans = summary["filled_spans"]
        rows["filled"] = f"{spans:.0f} span{'s' if spans != 1 else ''} around keys, {summary['filled_seconds']:.1f} s"
        if summary.get("waited_seconds", 0.0) > 0.05:
            rows["filled"] += f", in which the path waits {summary['waited_seconds']:.1f} s"
    return {**rows, **_as_recorded(summary), **_made_of(summary), **_search(summary)}


def _as_recorded(summary: dict[str, Any]) -> dict[str, str]:
    if "untouched_share" not in summary:
        return {}
    text = f"{100 * summary['untouched_share']:.0f} % of the frames are untouched"
    if "constraints_moved_mean" in summary:
        mean, most = 100 * summary["constraints_moved_mean"], 100 * summary["constraints_moved_most"]
        text += f"; holding feet and hands moved joints by {mean:.1f} cm in the mean, {most:.1f} cm at most"
    return {"as recorded": text}


def _made_of(summary: dict[str, Any]) -> dict[str, str]:
    takes = summary["takes_used"]
    pieces = summary["pieces"]
    text = f"{pieces} piece{'s' if pieces != 1 else ''} of {takes} recording{'s' if takes != 1 else ''}"
    if "most_used" in summary and pieces > 1:
        running = summary["times_running"]
        text += f"; the most used is {100 * summary['most_used']:.0f} % of them"
        text += f", at most {running} times running" if running > 1 else ", never twice running"
    length = f"{summary['seconds']:.1f} s, {summary['frames']} frames"
    return {"length": length, "made of": text}


def _search(summary: dict[str, Any]) -> dict[str, str]:
    shares = ", ".join(
        f"{name} {summary[f'cost_of_{key}']:.3g}" for key, name in COSTS.items() if f"cost_of_{key}" in summary
    )
    cost = f"{summary['cost']:.3g} ({shares}); it compares results of one control only"
    rows = {"cost": cost if shares else f"{summary['cost']:.3g}"}
    gap = summary.get("gap")
    if summary.get("optimal"):
        rows["search"] = "no sequence of these segments costs less"
    elif gap is not None:
        share = f"{100 * gap:.0f} %" if gap >= 0.01 else "less than 1 %"
        rows["search"] = f"costs {share} more than the cheapest sequence, so that steps vary"
    return rows


def sensed_in_words(summary: dict[str, Any]) -> dict[str, str]:
    """What a person wants to know of a motion that sensors drove.

    Parameters
    ----------
    summary : dict
        As the command ``sense`` gives it to machines.

    Returns
    -------
    dict of str to str
    """
    lost = f"{100 * summary['missing']:.0f} % missing, {summary['spikes']:.0f} spikes left out"
    held = f", none for {summary['held']:.1f} s" if summary["held"] else ""
    like = f"{100 * (1 - summary['far']):.0f} % of the frames have readings near recorded ones"
    expected = {"like the library": like}
    if "expected" in summary:
        usual = f"the library's own people, left out: {summary['usual']:.0f}"
        expected = {"expected error": f"{summary['expected']:.0f} degrees at a joint in the mean ({usual})"}
    return {
        "uncertainty": f"{summary['uncertainty_degrees']:.1f} degrees at a joint in the mean",
        **expected,
        "readings": lost + held,
        "look-ahead": f"{1000 * summary['latency']:.0f} ms",
        **_made_of(summary),
    }
