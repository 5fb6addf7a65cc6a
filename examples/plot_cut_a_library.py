"""
Cut a library and edit the cuts
===============================

Performance control uses recordings in segments. Where they are cut is an annotation: found at footplants, stored in
the library, and yours to edit.
"""

import matplotlib.pyplot as plt
import numpy as np

import kinetograph as kg
from clips import library, picture, save_figure
from kinetograph.kinematics import role_positions
from kinetograph.library import export_annotations, import_annotations
from kinetograph.motion import repeat
from kinetograph.pipeline import segment_take

# %%
# Find the cuts
# -------------
#
# A walk of several cycles is cut where a foot is planted; the contacts of the feet are found on the way.

walks = library("cut", ())
walk = repeat(library("walks", ("humanoid3d_walk",)).take("humanoid3d_walk").motion(), 4)
take = kg.Take("walk", {"motion": walk})
walks.add(take, replace=True)
notes = segment_take(take, "motion", "footplants")
walks.annotate("walk", notes)

# %%
# Look at them
# ------------
#
# Heights of the toes, the contacts below, and the cuts as lines.


def draw(annotations: tuple[kg.Annotation, ...], name: str, title: str) -> None:
    """Heights of the toes with contacts and cuts."""
    heights = 100 * role_positions(walk, ("left_toe", "right_toe"))[..., 1]
    figure, axes = plt.subplots(figsize=(10, 3), layout="constrained")
    for i, (label, colour) in enumerate((("left_toe", "#0072b2"), ("right_toe", "#d55e00"))):
        axes.plot(np.arange(len(walk)) / walk.fps, heights[:, i], color=colour, label=label)
        spans = [(n.start, n.stop - n.start) for n in annotations if n.kind == "contact" and n.label == label]
        axes.broken_barh(spans, (-2.0 - 1.5 * i, 1.2), color=colour)
    for note in annotations:
        if note.kind == "cut":
            axes.axvline(note.start, color="#c2185b", linewidth=1)
    axes.set(xlabel="seconds", ylabel="cm", title=title)
    axes.legend(loc="upper right")
    save_figure(figure, name)


draw(walks.take("walk").annotations, "cut_a_library.png", "cuts found at footplants")

# %%
# Edit them
# ---------
#
# The annotations go out as a table and come back: ``kinetograph library annotate walks --export cuts.csv``, edit,
# ``--from cuts.csv``. Here every second cut is dropped, so that a segment is a whole stride.

table = picture("cuts.csv")
export_annotations(walks, table, kind="cut")
header, *rows = table.read_text().splitlines()
print("\n".join([header, *rows[:3], "..."]))
table.write_text("\n".join([header, *rows[::2], ""]))
import_annotations(walks, table)
draw(walks.take("walk").annotations, "cut_a_library_edited.png", "every second cut, edited in the table")
