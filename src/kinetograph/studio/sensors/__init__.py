"""The section of sensors: readings to a motion, live sources, and how sensors are worn."""
