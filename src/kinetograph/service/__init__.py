"""Answers to programs that keep Kinetograph running: one line of JSON a request, on standard input and output.

`serve` runs the loop; `METHODS` has what may be asked. Libraries stay open and models fitted between requests. Large
arrays are not in the lines: they are in files, which the lines name.
"""

from kinetograph.service.methods import METHODS
from kinetograph.service.protocol import PROTOCOL
from kinetograph.service.serving import serve

__all__ = ["METHODS", "PROTOCOL", "serve"]
