"""The section of walks: a drawn path, the pieces that walk it, and a body that follows the pen."""
