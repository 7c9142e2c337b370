"""`motes track` with keyframes: in both directions, or backward, and smoothed."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from motes.cli.correct_run import run_stretches
from motes.cli.messages import counted
from motes.cli.moment import Hindsight, Moment, Sink
from motes.core.frame import Frame
from motes.core.interrupts import deferred
from motes.core.track import Status, Track
from motes.correction.correct import stretches
from motes.correction.history import History, line_count, rows_path
from motes.correction.join import Stretch
from motes.correction.rows import as_read
from motes.mot.analytics.real_units import GroundMotion
from motes.video.film import Film


@dataclass
class Run:
    """A run over a film, which grows.

    Attributes
    ----------
    keys
        Number of keyframes.
    states
        Number of frames of each status.
    interrupted
        The interrupt that ended the run, or None.
    """

    keys: int
    states: Counter[Status] = field(default_factory=Counter)
    interrupted: KeyboardInterrupt | None = None

    def __str__(self) -> str:
        counts = [f"{status} in {number}" for status, number in self.states.most_common()]
        return ", ".join(
            [counted(self.states.total(), "frame"), counted(self.keys, "keyframe"), *counts]
        )


@dataclass(frozen=True)
class Outputs:
    """The outputs of a run.

    Attributes
    ----------
    rows
        The rows, or another format; None without.
    history
        The file of their history; None without.
    others
        Outputs that may take long: an overlay, masks, figures.
    pictures
        Whether these need the pixels of the frames.
    """

    rows: Sink | None
    history: Path | None
    others: Sequence[Sink]
    pictures: bool


def write_stretches(
    film: Film,
    history: History,
    outputs: Outputs,
    motion: GroundMotion | None,
    run: Run,
    *,
    quiet: bool = False,
) -> None:
    """Track a target between its keyframes, and write its frames in order.

    Before the first row, the history notes all stretches as not finished, and each one as finished
    after its rows. So `motes refine` can finish a run that was killed.

    Parameters
    ----------
    film
        The film.
    history
        The keyframes and the tracker.
    outputs
        The outputs; they are closed at the end.
    motion
        The places on the ground, if they are measured.
    run
        Counts the frames; it also holds where an error ends the run.
    quiet
        As in `run_stretches`.
    """
    parts = stretches(film.frames, history.keys)
    left = list(parts)
    following, moments = film.frames.start, list[Moment]()

    def write(stretch: Stretch, tracks: list[Track]) -> None:
        nonlocal following
        if outputs.history is not None and not run.states:
            history.unfinished_with(left).save(outputs.history)
        new = [track for track in tracks if track.frame >= following]
        moments.clear()
        for moment in moments_of(film, new, motion):
            if outputs.rows is not None:
                outputs.rows.write(moment)
            if outputs.others:
                moments.append(moment)
            run.states[moment.status] += 1
        following = stretch.last + 1
        if stretch == left[0]:  # and not only its forward pass, at an interrupt
            left.pop(0)
            if outputs.history is not None:
                history.unfinished_with(left).save(outputs.history)

    def show() -> None:
        write_others(film, outputs, moments)

    with contextlib.ExitStack() as stack:
        for each in (*outputs.others, *([] if outputs.rows is None else [outputs.rows])):
            stack.enter_context(each)
        _, run.interrupted = run_stretches(
            film, parts, history.tracker, history.seed, write, show, quiet=quiet
        )
    if outputs.history is not None and not left:
        history.save(outputs.history, line_count(rows_path(outputs.history)))


def moments_of(
    film: Film, tracks: Sequence[Track], motion: GroundMotion | None
) -> Iterator[Moment]:
    """Yield tracks as moments, whose frames are black."""
    black = np.zeros((film.height, film.width, 3), np.uint8)
    for track in tracks:
        place = None if motion is None else motion.update(as_read(track))
        yield Moment(Frame(track.frame, track.time, black), Hindsight(track), 0.0, place)


def write_others(film: Film, outputs: Outputs, moments: Sequence[Moment]) -> None:
    """Write moments of frames in a row into the outputs beside the rows."""
    if not moments:
        return
    frames: Iterator[Frame] = (moment.frame for moment in moments)
    with contextlib.ExitStack() as stack:
        if outputs.pictures:
            first, last = moments[0].frame.index, moments[-1].frame.index
            frames = stack.enter_context(contextlib.closing(film.forward(first, last)))
        for frame, moment in zip(frames, moments, strict=False):
            with deferred():
                for each in outputs.others:
                    each.write(Moment(frame, moment.info, 0.0, moment.place))
