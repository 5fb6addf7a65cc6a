"""``python -m kinetograph``."""

from kinetograph.cli import main

main()
