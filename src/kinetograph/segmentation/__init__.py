"""Where recordings are cut into segments: at footplants, at labels, or at fixed lengths."""

from kinetograph.segmentation.cuts import cuts_at_labels, cuts_by_length
from kinetograph.segmentation.footplants import ContactThresholds, detect_contacts, footplant_cuts

__all__ = ["ContactThresholds", "cuts_at_labels", "cuts_by_length", "detect_contacts", "footplant_cuts"]
