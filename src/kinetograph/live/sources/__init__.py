"""Devices and files as streams: one module per protocol, a pure function from bytes to rows or poses, and its loop."""

from kinetograph.live.sources.listening import Source, parse_source, speed_of

__all__ = ["Source", "parse_source", "speed_of"]
