"""Where recordings are cut into segments: at footplants, beats, labels, or at fixed lengths; and what they are labelled
with: contacts and handholds."""

from kinetograph.segmentation.agreement import CutAgreement, compare_cuts, compare_labels, even_cuts
from kinetograph.segmentation.beats import BeatSettings, detect_beats, subdivide
from kinetograph.segmentation.cuts import cuts_at_labels, cuts_by_length
from kinetograph.segmentation.footplants import ContactThresholds, detect_contacts, footplant_cuts
from kinetograph.segmentation.handholds import HoldThresholds, detect_handholds

__all__ = [
    "BeatSettings",
    "ContactThresholds",
    "CutAgreement",
    "HoldThresholds",
    "compare_cuts",
    "compare_labels",
    "cuts_at_labels",
    "cuts_by_length",
    "detect_beats",
    "detect_contacts",
    "detect_handholds",
    "even_cuts",
    "footplant_cuts",
    "subdivide",
]
