"""Whether pictures come at the pace of a camera, or as fast as a file is sent."""

from __future__ import annotations

import time

FASTER = 1.5
"""What comes so many times faster than its own clock is a recording.

A camera cannot send what has not happened yet, but some begin with a few seconds from before.
"""
SURE = 10.0
"""Seconds of film after which that is decided for good if it is so."""
LONGEST_STEP = 1.0
"""Seconds between two packets; a clock that leaps farther was set anew."""


class Pace:
    """Compares the clock of a source with ours, from before the source is opened."""

    def __init__(self) -> None:
        self._begun = self._now = time.monotonic()
        self._span = 0.0
        self._last: float | None = None
        self._sure = False

    def note(self, stamp: float | None) -> float:
        """Take note of a packet's decoding time; return the seconds since the beginning."""
        self._now = time.monotonic()
        if stamp is not None:
            step = 0.0 if self._last is None else stamp - self._last
            self._span += min(max(step, 0.0), LONGEST_STEP)
            self._last = stamp
        self._sure = self._sure or (self._span > SURE and self._fast)
        return self._now - self._begun

    @property
    def _fast(self) -> bool:
        return self._span > FASTER * (self._now - self._begun)

    @property
    def recorded(self) -> bool:
        """Whether the source is a recording, as far as its packets tell."""
        return self._sure or self._fast
