"""glTF 2.0 (``.glb``, ``.gltf``): scenes with skeletons and skinned characters, read and written."""

from kinetograph.formats.gltf.reader import read
from kinetograph.formats.gltf.writer import encode, write

__all__ = ["encode", "read", "write"]
