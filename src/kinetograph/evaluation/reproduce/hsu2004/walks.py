"""Held-out walks compared with simpler methods, and a walk along a drawn path (Hsu 2004, section 6.1)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from kinetograph.evaluation.metrics import control_error
from kinetograph.evaluation.protocol import WalkRow, leave_one_take_out, mean_walks
from kinetograph.evaluation.reproduce.hsu2004.data import held_out
from kinetograph.evaluation.reproduce.page import Section, Value, drawn, paragraph, table, with_recorded
from kinetograph.kinematics import on_ground
from kinetograph.library import Library
from kinetograph.methods.performance import PerformanceControl, points_of
from kinetograph.motion import cut, place
from kinetograph.post.contacts import contacts_of
from kinetograph.progress import Report

COLUMNS = (
    *("take", "method", "control cm", "joints cm", "root-relative cm", "planted feet m/s (recorded)"),
    *("jerk, times recorded", "distinct source", "largest acceleration near seams (recorded)", "times real time"),
)
PAPER = """The thesis, 6.1: new walks, their hips on the ground as the control; the motion was judged by eye, highly
realistic for short walks. No distances are given."""
BASELINES = """Frame-by-frame methods stand on the control by construction, and an average of frames is near every
frame: their joint error is small, but their jerk shows that no one could move like that. Without continuity each
segment is the one nearest the control, and seams jump."""
DRAWN = """The thesis, 6.1 and figure 6-1: mouse trajectories at 30 Hz, Frenet frames as the control."""


def held_out_section(library: Library, tick: Report) -> Section:
    """Leave one take out, with the baselines."""
    rows = leave_one_take_out(PerformanceControl(reuse=0.0, stand=False), library, baselines=True)
    rows += mean_walks(rows)
    tick("held-out walks")
    parts = (
        paragraph(PAPER, "paper"),
        table("Leave one take out", COLUMNS, [_cells(row) for row in rows]),
        paragraph(BASELINES),
        drawn(lambda path: _side_by_side(library, path), "Generated, and recorded, moved 1.2 m ahead."),
    )
    return Section("Walks, held out", parts, {"rows": [vars(row) for row in rows]})


def _cells(row: WalkRow) -> tuple[Value, ...]:
    return (
        *(
            row.take,
            row.method,
            row.control_cm,
            row.joint_cm,
            row.relative_cm,
            with_recorded(row.slide, row.slide_recorded),
        ),
        *(row.jerk, row.distinct, with_recorded(row.seam, row.seam_recorded), row.times_real_time),
    )


def _side_by_side(library: Library, path: Path) -> None:
    from kinetograph.drawing import contact_sheet

    name, motion = held_out(library)[0]
    motion = cut(motion, 0, min(len(motion), round(12 * motion.fps)))
    result = PerformanceControl(reuse=0.0, stand=False).fit(library, exclude=(name,)).synthesize(motion)
    travel = motion.translation[len(motion) // 4] - motion.translation[0]
    aside = on_ground(1.2 * travel / max(float(np.hypot(travel[0], travel[2])), 1e-9))
    contact_sheet(
        [result.motion, place(motion, 0.0, aside)],
        path,
        contacts=contacts_of(result.annotations),
        seams=[piece.start for piece in result.pieces[1:]],
        title=f"{name}: generated from its hips (blue, orange), and recorded 1.2 m ahead (green, purple)",
        frames=16,
    )


def path_section(library: Library, tick: Report) -> Section:
    """Figure 6-1: a walk along a drawn path."""
    from kinetograph.drawing import contact_sheet, strobe
    from kinetograph.pipeline import winding_path

    control = winding_path()
    model = PerformanceControl(reuse=0.0, stand=False, mirror=True).fit(library)
    result = model.synthesize(control)
    error = 100 * control_error(result.motion, points_of(model.method, control), control.fps)
    tick("drawn path")
    takes = ", ".join(library.names())
    text = [f"Made of {takes}. The hips are {error:.1f} cm from the path on average, {len(result.pieces)} pieces."]
    text += result.warnings
    contacts = contacts_of(result.annotations)
    parts = (
        paragraph(DRAWN, "paper"),
        paragraph(" ".join(text)),
        drawn(lambda path: strobe(result.motion, path, path_signal=control), "A walk along a path that turns twice."),
        drawn(
            lambda path: contact_sheet(result.motion, path, path_signal=control, contacts=contacts, frames=16),
            "The same, with the path from above.",
        ),
    )
    return Section("A drawn path", parts, {"control_cm": error, "pieces": len(result.pieces)})
