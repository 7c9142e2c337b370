"""`motes track` with keyframes: in both directions, or backward, smoothed, and how it is resumed.

The rows come first, stretch by stretch. What is drawn of them is made when all of them are there.
"""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from motes.cli.correct_run import refine_rows, run_stretches
from motes.cli.exit_codes import DONE
from motes.cli.frame_loop import Tally, summarize
from motes.cli.messages import counted
from motes.cli.moment import Hindsight, Moment, Sink
from motes.cli.progress import FrameProgress
from motes.cli.track_options import TrackOutputs, TrackRequest
from motes.cli.track_outputs import pictures_outputs
from motes.cli.track_units import check_size, motion_names
from motes.cli.watch_outputs import STREAMED, format_of, rows_output
from motes.core import interrupts
from motes.core.errors import ConfigError, FormatError
from motes.core.files import is_special
from motes.core.frame import Frame
from motes.core.interrupts import deferred
from motes.core.track import Status, Track
from motes.correction.correct import stretches
from motes.correction.history import History, Marks, history_path, line_count, rows_path
from motes.correction.join import Stretch
from motes.correction.keyframes import check_keyframes
from motes.correction.rows import KnownRows, as_read
from motes.mot.analytics.real_units import PIXELS, GroundMotion
from motes.rows.schema import GROUND, HINDSIGHT
from motes.rows.writer import check_writable
from motes.video.film import Film


def track_between(asked: TrackRequest, film: Film, marks: Marks) -> int:
    """Track a target between keyframes, write the outputs and print a summary.

    With --resume, only what is missing is tracked.

    Raises
    ------
    ConfigError
        If keyframes contradict each other or do not fit the film, or the lens does not.
    """
    history = History.begin(film, asked.config, asked.seed, marks, asked.units, asked.preset)
    check_keyframes(history.keys, film.name, film.frames, film.width, film.height)
    check_size(asked.units, film)
    output, outputs, units = asked.output, asked.outputs, asked.units
    quiet = output == "-"
    path = _history_of(output, outputs)
    table = _begun_rows(output, path, history, film) if outputs.resume else None
    others = pictures_outputs(asked, film)
    motion = None
    if units is not None or motion_names(outputs.figures):
        motion = GroundMotion(units or PIXELS)
    run, opened = KeyframeRun(film, motion, len(history.keys)), [*others]
    try:
        try:
            if table is not None:
                run.finish(table, Path(str(output)), quiet=quiet)
            else:
                rows = None
                if output is not None:
                    further = HINDSIGHT if units is None else (*HINDSIGHT, *GROUND)
                    anew = replace(outputs, overwrite=outputs.overwrite or outputs.resume)
                    rows = rows_output(output, film, anew, further=further)
                    opened.append(rows)
                run.track(history, path, rows, quiet=quiet)
        finally:  # also what an error or an interrupt has left
            pictures = any((outputs.overlay, outputs.masks, outputs.show))
            run.draw(others, pictures=pictures, quiet=quiet)
    finally:
        summarize(run, film, opened, run.interrupted)
    return interrupts.code(run.interrupted) if run.interrupted else DONE


class KeyframeRun(Tally):
    """A run between keyframes, which grows.

    Parameters
    ----------
    film
        The film.
    motion
        Measures places on the ground; None if they are not asked for.
    keys
        The number of keyframes.

    Attributes
    ----------
    interrupted
        The interrupt that ended the run, or None.
    """

    def __init__(self, film: Film, motion: GroundMotion | None, keys: int) -> None:
        super().__init__()
        self.interrupted: KeyboardInterrupt | None = None
        self._film, self._motion, self._keys = film, motion, keys
        self._black = np.zeros((film.height, film.width, 3), np.uint8)
        self._moments: dict[int, Moment] = {}
        self._states = Counter[Status]()
        self._anew = ""

    def track(self, history: History, path: Path | None, rows: Sink | None, *, quiet: bool) -> None:
        """Track the target between its keyframes, and write its rows in order.

        Before the first row, the history notes all stretches as not finished, and each one as
        finished after its rows. So `motes refine` can finish a run that was killed.

        Parameters
        ----------
        history, path
            The keyframes and the tracker, and the file that remembers them; None without one.
        rows
            The rows, or another format; None without. It is closed at the end.
        quiet
            As in `run_stretches`.
        """
        parts = stretches(self._film.frames, history.keys)
        left, following = [*parts], self._film.frames.start

        def write(stretch: Stretch, tracks: list[Track]) -> None:
            nonlocal following
            if path is not None and not self.frames:
                history.unfinished_with(left).save(path)
            for moment in self._take(track for track in tracks if track.frame >= following):
                if rows is not None:
                    rows.write(moment)
            following = stretch.last + 1
            if stretch == left[0]:  # and not only its forward pass, at an interrupt
                left.pop(0)
                if path is not None:
                    history.unfinished_with(left).save(path)

        with contextlib.nullcontext() if rows is None else rows:
            _, self.interrupted = run_stretches(
                self._film, parts, history.tracker, history.seed, write, quiet=quiet
            )
        if path is not None and not left:
            history.save(path, line_count(rows_path(path)))

    def finish(self, table: KnownRows, goal: Path, *, quiet: bool) -> None:
        """Track what is missing of the rows of an earlier run, which their history remembers."""
        old = History.load(history_path(goal))
        made, self.interrupted = refine_rows(self._film, table, old, old, goal, quiet=quiet)
        for _ in self._take(table.tracks):
            pass
        self._anew = f"; {goal} has {counted(made, 'row')} made anew" if made else ""

    def _take(self, tracks: Iterable[Track]) -> Iterator[Moment]:
        """Yield tracks as moments, whose frames are black; count and keep each of them."""
        for track in tracks:
            place = None if self._motion is None else self._motion.update(as_read(track))
            frame = Frame(track.frame, track.time, self._black)
            moment = Moment(frame, Hindsight(track), 0.0, place)
            yield moment
            self.add(moment)

    def add(self, moment: Moment) -> str:
        """Count and keep a frame."""
        self._moments[moment.frame.index] = moment
        self._states[moment.status] += 1
        return super().add(moment)

    def draw(self, outputs: Sequence[Sink], *, pictures: bool, quiet: bool) -> None:
        """Write all frames so far into the outputs beside the rows.

        Parameters
        ----------
        outputs
            The outputs.
        pictures
            Whether these need the pixels of the frames.
        quiet
            Whether there is no progress bar.
        """
        moments = self._moments
        if not (outputs and moments):
            return
        with contextlib.ExitStack() as stack:
            for output in outputs:
                stack.enter_context(output)
            frames: Iterator[Frame] = (moment.frame for moment in moments.values())
            if pictures:
                every = self._film.forward(min(moments), max(moments))
                frames = stack.enter_context(contextlib.closing(every))
            progress = stack.enter_context(FrameProgress(len(moments), quiet=quiet))
            try:
                for frame in frames:
                    if frame.index not in moments:  # rows of an earlier run may lack frames
                        continue
                    with deferred():
                        for output in outputs:
                            output.write(replace(moments[frame.index], frame=frame))
                    progress.count("drawn")
            except KeyboardInterrupt as interrupt:
                self.interrupted = interrupt

    def __str__(self) -> str:
        counts = [f"{status} in {number}" for status, number in self._states.most_common()]
        return ", ".join([super().__str__(), counted(self._keys, "keyframe"), *counts]) + self._anew


def _history_of(output: str | None, outputs: TrackOutputs) -> Path | None:
    """Return the path of the history of rows in a file; None for other outputs.

    Raises
    ------
    FormatError
        If it exists and must not be overwritten.
    """
    special = output in (None, "-") or is_special(str(output))
    form = None if special else format_of(str(output), outputs.format)
    if outputs.resume and form not in ("csv", "jsonl"):
        raise ConfigError(f"--resume continues rows; {output} holds none, make it anew.")
    if form not in STREAMED:
        return None
    rows = Path(str(output))
    for path in (rows, history_path(rows)):
        check_writable(path, outputs.overwrite or outputs.resume)
    return history_path(rows)


def _begun_rows(
    output: str | None, path: Path | None, history: History, film: Film
) -> KnownRows | None:
    """Return the rows of an earlier run; None if it has not written any.

    Raises
    ------
    InputError
        If the rows or their history cannot be read.
    FormatError
        If the rows are of another run.
    """
    rows = Path(str(output))
    if path is None or not rows.exists() or not rows.stat().st_size:
        return None
    if not path.exists():
        raise FormatError(
            f"{rows} cannot be resumed: without {path.name} its keyframes are not known; write to "
            f"another file."
        )
    old = History.load(path)
    old.check(film)
    if not old.repeats(history):
        raise FormatError(
            f"{rows} cannot be resumed: its keyframes, its tracker or its units are not these; "
            f"repeat them, or write to another file. motes refine adds keyframes."
        )
    if old.unfinished and rows.read_bytes().count(b"\n") < 2:
        return None
    table = KnownRows(rows, growing=bool(old.unfinished))
    table.check(film)
    return table
