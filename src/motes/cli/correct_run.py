"""Stretches of a film, tracked one after the other, and rows that they correct or finish."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from msgspec.structs import replace

from motes.cli.frame_loop import FrameProgress
from motes.cli.streams import log
from motes.core.errors import MotesError
from motes.core.interrupts import deferred
from motes.core.track import Track
from motes.correction.correct import changed, passes_over, reader_of
from motes.correction.history import History
from motes.correction.join import Stretch
from motes.correction.keyframes import check_keyframes
from motes.correction.passes import Course
from motes.correction.rows import KnownRows
from motes.sot.algorithm import StepInfo
from motes.video.film import Film


def run_stretches(
    film: Film,
    parts: Sequence[Stretch],
    history: History,
    done: Callable[[Stretch, list[Track]], None],
    *,
    quiet: bool = False,
) -> tuple[int, KeyboardInterrupt | None]:
    """Track stretches; call `done` after each one, and with the beginning of an interrupted one.

    The beginning is also passed on where an error ends the run. `done` is not interrupted. Returns
    the number of stretches that are done, and the interrupt that ended the run, or None.
    """
    count = sum((each.last - each.first + 1) * len(each.keys) for each in parts)
    finished, so_far, said = 0, list[Track](), set[str]()
    try:
        with FrameProgress(count, quiet=quiet) as progress:
            for each in parts:

                def count_frame(info: StepInfo, each: Stretch = each) -> None:
                    if info.note is not None and info.note not in said:
                        said.add(info.note)  # a keyframe begins a pass to either side
                        log(info.note)
                    progress.count(f"frames {each.first} to {each.last}")

                so_far.clear()
                reader = reader_of(film, each)
                passes = passes_over(
                    reader, each, history.tracker, history.seed, so_far, count_frame
                )
                tracks = each.joined(film.times, *passes)
                with deferred():
                    so_far.clear()
                    done(each, tracks)
                    finished += 1
    except (KeyboardInterrupt, MotesError) as error:
        if so_far:
            part = parts[finished].begun(so_far[-1].frame)
            done(part, part.joined(film.times, Course.of(so_far), None))
        if isinstance(error, MotesError):
            raise
        return finished, error
    return finished, None


def refine_rows(
    film: Film,
    table: KnownRows,
    before: History,
    after: History,
    goal: Path,
    whole: History | None = None,
) -> tuple[int, KeyboardInterrupt | None]:
    """Track what changes and what is not finished; write rows and history.

    The history is written first, with all of these stretches as not finished, then the rows, then
    the history again. A run that is killed at any moment can so be finished. Raises a ConfigError
    if keyframes contradict each other, or are outside of the film; and a FormatError if a file
    cannot be written, or that of the rows has changed since they were read. To finish rows,
    `before` and `after` are the same history; `whole` is that of all objects, where the rows are
    those of one among several. Returns the number of rows made anew, and the interrupt that ended
    the run, or None.
    """
    check_keyframes(after.keys, film.name, film.frames, film.width, film.height)
    parts = changed(film.frames, before.keys, after.keys, before.unfinished)
    made = set[int]()

    def take(_: Stretch, tracks: list[Track]) -> None:
        table.replace(tracks, after.units)
        made.update(track.frame for track in tracks)

    def noted(left: Sequence[Stretch]) -> History:
        history = after.unfinished_with(left)
        if whole is None:
            return history
        return replace(whole, objects={**whole.objects, table.identity: history})

    table.check_unchanged(goal)  # a history is not replaced by that of older rows
    noted(parts).save(goal)
    left = parts
    try:
        done, interrupted = run_stretches(film, parts, after, take)
        left = parts[done:]
    finally:
        table.write(goal)
    noted(left).save(goal, whole=not left)
    return len(made), interrupted
