"""Pictures and films of dressed characters, drawn in software."""

from kinetograph.rendering.film import film, sheet

__all__ = ["film", "sheet"]
