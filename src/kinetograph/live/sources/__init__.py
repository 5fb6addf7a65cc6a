"""Devices and files as streams: one module per protocol, a pure function from bytes to rows or poses, and its loop."""

from kinetograph.live.sources.listening import Deliver, Source, parse_source, speed_of

__all__ = ["Deliver", "Source", "parse_source", "speed_of"]
