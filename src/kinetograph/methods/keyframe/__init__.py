"""Keyframe control (Molina-Tanco and Hilton 2000): recordings lead from one pose to the next."""

from kinetograph.methods.keyframe.model import KeyframeControl, KeyframeModel, PaperSettings, SearchSettings

__all__ = ["KeyframeControl", "KeyframeModel", "PaperSettings", "SearchSettings"]
