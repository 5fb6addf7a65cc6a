"""Xie 2009: tables 7.1 and 7.2 and figures 7.5 and 7.6, on a library at hand, as one page.

The thesis' recordings (5,082 frames of tennis, basketball, golf and karate with real Wii remotes) are not published.
Here the sensors are simulated, one take is left out at a time, and every number is next to the thesis' own.
"""

from kinetograph.evaluation.reproduce.xie2009.methods import METHODS, TakeRow
from kinetograph.evaluation.reproduce.xie2009.page import ClipRow
from kinetograph.evaluation.reproduce.xie2009.run import reproduce

__all__ = ["METHODS", "ClipRow", "TakeRow", "reproduce"]
