"""Where recordings are cut into segments, and the contacts and handholds that are detected in them.

Cuts are at footplants, at beats, at labels or at fixed lengths; `compare_cuts` and `compare_labels` compare them with
those that a person made. `Couple` names what two dancers do between their cuts.
"""

from kinetograph.segmentation.agreement import CutAgreement, compare_cuts, compare_labels, even_cuts
from kinetograph.segmentation.beats import BeatSettings, detect_beats, strongest_phase, subdivide
from kinetograph.segmentation.cuts import cuts_at_labels, cuts_by_length
from kinetograph.segmentation.footplants import CONTACT_ROLES, ContactThresholds, detect_contacts, footplant_cuts
from kinetograph.segmentation.handholds import HANDS, HoldThresholds, detect_handholds
from kinetograph.segmentation.intervals import runs
from kinetograph.segmentation.partners import Couple, StanceThresholds, find_thresholds, notation, transition_of
from kinetograph.segmentation.uncut import UncutError

__all__ = [
    "CONTACT_ROLES",
    "HANDS",
    "BeatSettings",
    "ContactThresholds",
    "Couple",
    "CutAgreement",
    "HoldThresholds",
    "StanceThresholds",
    "UncutError",
    "compare_cuts",
    "compare_labels",
    "cuts_at_labels",
    "cuts_by_length",
    "detect_beats",
    "detect_contacts",
    "detect_handholds",
    "even_cuts",
    "find_thresholds",
    "footplant_cuts",
    "notation",
    "runs",
    "strongest_phase",
    "subdivide",
    "transition_of",
]
