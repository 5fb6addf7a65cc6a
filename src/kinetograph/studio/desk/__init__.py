"""The desk: the one project that is open, its past, its pages, and what is being made of it."""
