"""The loop of `motes track` and `motes watch`: from a source of frames into outputs."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence

from motes.cli.exit_codes import DONE, NOT_FOUND
from motes.cli.messages import log
from motes.cli.moment import Moment, Moments, Sink
from motes.cli.progress import FrameProgress
from motes.core import interrupts
from motes.core.errors import MotesError
from motes.core.interrupts import check, deferred
from motes.video.film import Film
from motes.video.newest import Newest
from motes.video.prefetch import prefetch
from motes.video.sources import Source


def run(
    film: Source,
    outputs: Sequence[Sink],
    moments: Moments,
    note: Callable[[Moment], str],
    report: Callable[[KeyboardInterrupt | None], None],
    *,
    quiet: bool = False,
) -> KeyboardInterrupt | None:
    """Write the result of each frame into all outputs, close them, and report.

    Parameters
    ----------
    film
        The frames; a thread decodes them ahead, and leaves out those of a live source that the
        results are too slow for.
    outputs
        The outputs; all of them are opened here, before the first frame.
    moments
        Makes the results from the frames; it is closed before the film.
    note
        Counts a result that is written; returns the state of the run, for the progress bar.
    report
        Prints a summary at the end, also where an error ends the run; it takes the interrupt that
        ended the run, or None.
    quiet
        Whether there is no progress bar.

    Returns
    -------
    The interrupt that ended the run, or None. All outputs are closed in either case.
    """
    interrupted: KeyboardInterrupt | None = None
    try:
        with (
            contextlib.ExitStack() as opened,
            Newest(film) if film.live else prefetch(film) as frames,
            contextlib.ExitStack() as reading,
        ):
            reading.callback(film.stop)
            for output in outputs:
                opened.enter_context(output)
            making = opened.enter_context(contextlib.closing(moments(iter(frames))))
            with FrameProgress(film.frame_count, quiet=quiet) as bar:
                try:
                    for moment in making:
                        with deferred():
                            for output in outputs:
                                output.write(moment)
                            state = note(moment)
                        bar.count(state)
                        check()
                except KeyboardInterrupt as interrupt:
                    interrupted = interrupt
    except KeyboardInterrupt as interrupt:
        interrupted = interrupt
    except MotesError:
        report(None)
        raise
    report(interrupted)
    return interrupted


def exit_code(interrupted: KeyboardInterrupt | None, found: bool, missing: str) -> int:
    """Return the exit code of a run that is over; log what is missing if nothing was found."""
    if interrupted:
        return interrupts.code(interrupted)
    if not found:
        log(f"error: {missing}")
        return NOT_FOUND
    return DONE


def summarize(
    parts: Sequence[str],
    film: Source | Film,
    outputs: Sequence[Sink],
    interrupted: KeyboardInterrupt | None,
) -> None:
    """Print a line on a run that is over.

    Parameters
    ----------
    parts
        The statistics of the run.
    film
        The source; its problems are added.
    outputs
        The outputs; their files are added.
    interrupted
        The interrupt that ended the run, if one did.
    """
    written = [output.result for output in outputs if output.result is not None]
    line = [interrupts.word(interrupted) + parts[0], *parts[1:]]
    if written:
        line.append("wrote " + ", ".join(written))
    if film.report.problems:
        line.append(f"{film.name}: {film.report.problems}")
    log("; ".join(line) + ".")
