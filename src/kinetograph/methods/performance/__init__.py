"""Performance control (Hsu 2004): a control is interpreted as stretched, placed segments of recordings."""

from kinetograph.methods.performance.model import PerformanceControl, PerformanceModel, only_track, partner_control

__all__ = ["PerformanceControl", "PerformanceModel", "only_track", "partner_control"]
