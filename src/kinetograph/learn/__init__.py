"""Functions of arrays that the three methods share; nothing here knows what a motion is."""
