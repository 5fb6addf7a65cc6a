# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work in slices, so that the interface goes on between them: generators that yield None when a slice is over."""

import time


class Slice:
    """A clock: whether what is done at a time has taken long enough."""

    def __init__(self, seconds=0.03):
        self._seconds = seconds
        self._end = time.monotonic() + seconds

    def over(self):
        """Whether it is over; if so, the next begins."""
        now = time.monotonic()
        if now < self._end:
            return False
        self._end = now + self._seconds
        return True


def at_a_stretch(work):
    """Do the work of a generator without a pause; what it returns."""
    try:
        while True:
            next(work)
    except StopIteration as end:
        return end.value
