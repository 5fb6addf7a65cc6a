"""Devices and files as streams: one module per protocol, a pure function from bytes to rows or poses, and its loop."""

from kinetograph.live.sources.listening import StreamSource, parse_source, speed_of

__all__ = ["StreamSource", "parse_source", "speed_of"]
