"""From a film into outputs: the loop of `motes track` and `motes watch`."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import AbstractContextManager
from typing import Protocol, TypeVar

from motes.cli.progress import Progress
from motes.core.frame import Frame
from motes.core.interrupts import check, deferred
from motes.video.prefetch import prefetch
from motes.video.sources import Source

T = TypeVar("T")
T_contra = TypeVar("T_contra", contravariant=True)


class Sink(AbstractContextManager[object], Protocol[T_contra]):
    """Takes what became of each frame; ends as a context manager."""

    def write(self, step: T_contra, /) -> None:
        """Add a frame."""
        ...


def run(
    film: Source,
    outputs: Sequence[Sink[T]],
    steps: Callable[[Iterator[Frame]], Generator[T, None, None]],
    note: Callable[[T], str],
    *,
    quiet: bool = False,
) -> KeyboardInterrupt | None:
    """Write what becomes of each frame into all outputs, and close them.

    Parameters
    ----------
    film
        Decoded ahead, in a thread.
    outputs
        Opened here, all of them before the first frame.
    steps
        Makes of the frames what outputs take; closed before the film.
    note
        Takes note of a step that is written; returns how things are, for the progress bar.
    quiet
        Whether there is no progress bar.

    Returns
    -------
    The interrupt that ended it, if one did; all outputs are then closed as at the end.
    """
    interrupted: KeyboardInterrupt | None = None
    try:
        with (
            contextlib.ExitStack() as opened,
            prefetch(film) as frames,
            contextlib.ExitStack() as reading,
        ):
            reading.callback(film.stop)
            for output in outputs:
                opened.enter_context(output)
            making = opened.enter_context(contextlib.closing(steps(frames)))
            with Progress(film, quiet=quiet) as progress:
                try:
                    for step in making:
                        with deferred():
                            for output in outputs:
                                output.write(step)
                            state = note(step)
                        progress.count(state)
                        check()
                except KeyboardInterrupt as interrupt:
                    interrupted = interrupt
    except KeyboardInterrupt as interrupt:
        interrupted = interrupt
    return interrupted
