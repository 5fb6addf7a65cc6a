"""Programs and files that take motion frame by frame."""

from kinetograph.live.sinks.sending import Sink, parse_sink

__all__ = ["Sink", "parse_sink"]
