"""The stretches of a film, one after the other, with a progress bar."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import nullcontext, suppress

from motes.cli.progress import FrameProgress
from motes.core.errors import MotesError
from motes.core.frame import Frame
from motes.core.interrupts import deferred
from motes.core.track import Track
from motes.correction.correct import correct_stretch, partial, reader_of, tracks_of
from motes.correction.join import Stretch
from motes.sot.presets import TrackerConfig
from motes.video.film import Film
from motes.video.shared import FrameReader


class _Counted:
    """A film that counts the frames that it gives."""

    def __init__(self, film: FrameReader, count: Callable[[], None]) -> None:
        self._film, self._count = film, count

    def forward(self, first: int, last: int) -> Iterator[Frame]:
        """Yield the frames from `first` to `last`."""
        return self._each(self._film.forward(first, last))

    def backward(self, last: int, first: int) -> Iterator[Frame]:
        """Yield the frames from `last` down to `first`."""
        return self._each(self._film.backward(last, first))

    def _each(self, frames: Iterator[Frame]) -> Iterator[Frame]:
        for frame in frames:
            yield frame
            self._count()


def run_stretches(
    film: Film,
    parts: Sequence[Stretch],
    config: TrackerConfig,
    seed: int,
    done: Callable[[Stretch, list[Track]], None],
    show: Callable[[], None] | None = None,
    *,
    quiet: bool = False,
    bar: FrameProgress | None = None,
) -> tuple[int, KeyboardInterrupt | None]:
    """Track stretches; call `done` after each one, and with the beginning of an interrupted one.

    The beginning is also passed on where an error ends the run.

    Parameters
    ----------
    film
        The film.
    parts
        The stretches.
    config, seed
        The tracker.
    done
        Takes a stretch and its tracks; it is not interrupted.
    show
        Is called after `done`; it may be interrupted.
    quiet
        Whether there is no progress bar.
    bar
        A bar that is shown already; by default one for these stretches.

    Returns
    -------
    The number of stretches that are done, and the interrupt that ended the run, or None.
    """
    # Each pass reads the frame at its end beforehand, if that is a keyframe too.
    count = sum((each.last - each.first + len(each.keys)) * len(each.keys) for each in parts)
    finished, so_far = 0, list[Track]()
    try:
        with nullcontext(bar) if bar else FrameProgress(count, quiet=quiet) as progress:
            for each in parts:
                state = f"frames {each.first} to {each.last}"
                counted = _Counted(
                    reader_of(film, each),
                    lambda state=state: progress.count(state),  # type: ignore[misc]
                )
                so_far.clear()
                joined = correct_stretch(counted, each, config, seed, so_far)
                tracks = tracks_of(each, joined, film.times)
                with deferred():
                    so_far.clear()
                    done(each, tracks)
                    finished += 1
                if show is not None:
                    show()
    except (KeyboardInterrupt, MotesError) as error:
        if so_far:
            part, joined = partial(parts[finished], so_far)
            done(part, tracks_of(part, joined, film.times))
            if show is not None:
                with suppress(KeyboardInterrupt):  # a second one ends it
                    show()
        if isinstance(error, MotesError):
            raise
        return finished, error
    return finished, None
