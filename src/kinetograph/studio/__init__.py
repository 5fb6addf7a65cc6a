"""The studio: a page on this machine in which motion is made."""
