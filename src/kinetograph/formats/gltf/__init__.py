"""glTF 2.0 (``.glb``, ``.gltf``): motions and skinned characters, read, and written for viewers, engines and browsers.

glTF's conventions are those of this package (metres, seconds, Y up, right-handed), except that quaternions are x, y, z,
w.
"""

from kinetograph.formats.gltf.character import read_character
from kinetograph.formats.gltf.reader import read
from kinetograph.formats.gltf.writer import encode, write

__all__ = ["encode", "read", "read_character", "write"]
