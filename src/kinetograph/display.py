"""How a notebook shows motions: by whoever can draw them.

What draws is above the layers of data, and says so in an entry point of the group ``kinetograph.displays``: a function
from a motion, take or synthesis to HTML. The package's own is the player of ``kinetograph.studio``.
"""

from __future__ import annotations

from html import escape

GROUP = "kinetograph.displays"
"""The group of entry points; ``html`` is the name of the one that notebooks use."""


def notebook_html(shown: object) -> str:
    """What a notebook shows for a motion, a take or a synthesis.

    Parameters
    ----------
    shown : object

    Returns
    -------
    str
        HTML: the motion in a player where it can be drawn, else a line of text.
    """
    from importlib.metadata import entry_points  # slow to load, and of use in notebooks only

    for entry in entry_points(group=GROUP, name="html"):
        return str(entry.load()(shown))
    return f"<pre>{escape(summary(shown))}</pre>"


def summary(shown: object) -> str:
    """A motion, a take or a synthesis in a line of text.

    Parameters
    ----------
    shown : object

    Returns
    -------
    str
    """
    motion = getattr(shown, "motion", None)
    timed = shown if hasattr(shown, "duration") else motion  # a synthesis lasts as long as its motion
    return f"{type(shown).__name__}, {getattr(timed, 'duration', 0.0):.1f} s"
