"""Sources that may not answer yet, and live frames on the clock that all cameras of a rig share."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator

from motes import Frame, Source, SourceError, open_source
from motes.video import is_remote, pauses

CLOCK_GAIN = 0.01
"""Fraction of the difference between the two clocks that each frame corrects."""
MIN_STEP = 1e-3
"""Smallest time from one frame to the next, in seconds."""


def opened(
    source: str, fps: float | None, tell: Callable[[str], None], ready: Callable[[bool], None]
) -> tuple[Source, bool]:
    """Open a source; return it, and whether it is live.

    A camera or an address that does not answer is tried again and again, and counts as live.

    Parameters
    ----------
    source, fps
        As for `open_source`.
    tell
        Called with one line of text when the source does not answer, or drops later, and when it is
        back.
    ready
        Called with whether it is live, once that is known.

    Raises
    ------
    SourceError
        If a file or folder cannot be read.
    """
    failed_at: float | None = None
    waits = pauses()
    while True:
        try:
            film = open_source(source, fps=fps, on_drop=tell)
        except SourceError as error:
            if not is_remote(source):
                raise
            if failed_at is None:
                failed_at = time.monotonic()
                ready(True)
                tell(f"{error} It is tried again, with growing pauses.")
            time.sleep(next(waits))
            continue
        if failed_at is None:
            ready(film.live)
            return film, film.live
        tell(f"{film.name} is back after {time.monotonic() - failed_at:.1f} s.")
        return film, True


def on_clock(frames: Iterable[Frame], origin: float) -> Iterator[Frame]:
    """Yield frames with times of the computer's clock, which several cameras share.

    Steps are those of the source, as frames may arrive in bursts. The frame that was underway for
    the shortest time so far shows how far the two clocks are apart; as they drift, the difference
    follows the mean slowly. Frames that were sent while the source was opened arrive all at once,
    each underway for a step less than the one before; they are old, and left out. `origin` is the
    reading of `time.monotonic` at time 0.
    """
    apart: float | None = None
    stamp = reached = 0.0
    for frame in frames:
        late = (frame.arrived or time.monotonic()) - frame.time
        step, stamp = frame.time - stamp, frame.time
        old = apart is not None and late < apart - step / 2
        if apart is None or late < apart:
            apart = late
        apart += CLOCK_GAIN * (late - apart)
        if not old:
            reached = max(reached + MIN_STEP, frame.time + apart - origin)
            yield Frame(frame.index, reached, frame.pixels)
