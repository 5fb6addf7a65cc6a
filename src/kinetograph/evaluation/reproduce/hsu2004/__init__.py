"""Hsu 2004, chapters 4 to 6: the walk and the dance, on recordings at hand, as one page with the thesis' numbers.

The thesis' recordings (2 minutes of walking, 5 minutes of Lindy Hop) are not published. The page says what takes their
place, what is missing and what had to be chosen.
"""

from kinetograph.evaluation.reproduce.hsu2004.data import Recordings
from kinetograph.evaluation.reproduce.hsu2004.report import lines, reproduce

__all__ = ["Recordings", "lines", "reproduce"]
