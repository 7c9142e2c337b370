"""Whether a source sends pictures in real time, as a camera, or faster, as a recording."""

from __future__ import annotations

import time

RECORDING_SPEED = 1.5
"""A source that sends this many times faster than real time is a recording.

A camera cannot send the future, but some cameras begin with a few seconds of the past.
"""
DECISION_SPAN = 10.0
"""Seconds of video after which the decision for a recording is final."""
LONGEST_STEP = 1.0
"""Longest time between two packets, in seconds; after a longer jump the clock was reset."""


class Pace:
    """Compares the clock of a source with the computer's; create it before the source is opened."""

    def __init__(self) -> None:
        self._started = self._now = time.monotonic()
        self._span = 0.0
        self._last: float | None = None
        self._decided = False

    def note(self, stamp: float | None) -> float:
        """Record a packet's decoding time, in seconds; return the seconds since the start."""
        self._now = time.monotonic()
        if stamp is not None:
            step = 0.0 if self._last is None else stamp - self._last
            self._span += min(max(step, 0.0), LONGEST_STEP)
            self._last = stamp
        self._decided = self._decided or (self._span > DECISION_SPAN and self._fast)
        return self._now - self._started

    @property
    def _fast(self) -> bool:
        return self._span > RECORDING_SPEED * (self._now - self._started)

    @property
    def settled(self) -> bool:
        """Whether a recording would have shown itself by now."""
        return self._now - self._started > DECISION_SPAN

    @property
    def recorded(self) -> bool:
        """Whether the packets so far show that the source is a recording."""
        return self._decided or self._fast
