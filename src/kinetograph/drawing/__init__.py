"""Pictures and films of motion: stick figures, and dressed characters drawn in software."""
