"""Molina-Tanco & Hilton 2000: figures 2 to 9, the numbers of section 4, and the next stage of section 5.

The paper's four recordings (standing up and then walking, running, walking and then running, walking; 465 frames) are
not published. The most similar recordings of CMU are used where they are available, else clips of the sample.
"""

from kinetograph.evaluation.reproduce.molina_tanco2000.next_stage import Stage
from kinetograph.evaluation.reproduce.molina_tanco2000.reproduction import Effort, reproduce
from kinetograph.evaluation.reproduce.molina_tanco2000.section4 import Numbers

__all__ = ["Effort", "Numbers", "Stage", "reproduce"]
