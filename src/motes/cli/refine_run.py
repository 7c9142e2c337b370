"""Rows that are corrected, or finished: only the stretches that change are tracked again."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from motes.cli.correct_run import run_stretches
from motes.cli.progress import FrameProgress
from motes.core.track import Track
from motes.correction.history import History, history_path, line_count
from motes.correction.join import Stretch
from motes.correction.keyframes import check_keyframes
from motes.correction.refine import changed, kept
from motes.correction.rows import KnownRows
from motes.video.film import Film


class Refined(NamedTuple):
    """Rows made anew, and the interrupt that ended the run, or None."""

    rows: int
    interrupted: KeyboardInterrupt | None


def refine_rows(
    film: Film,
    table: KnownRows,
    before: History,
    after: History,
    goal: Path,
    *,
    quiet: bool = False,
    bar: FrameProgress | None = None,
) -> Refined:
    """Track what changes and what is not finished; write rows and history.

    The history is written first, with all of these stretches as not finished, then the rows, then
    the history again. A run that is killed at any moment can so be finished.

    Parameters
    ----------
    film
        The film, with the frames of the rows.
    table
        The rows.
    before, after
        The history before the correction and after it; the same one, to finish rows.
    goal
        The file of the new rows.
    quiet, bar
        As in `run_stretches`.

    Raises
    ------
    ConfigError
        If keyframes contradict each other, or are outside of the film.
    FormatError
        If a file cannot be written.
    """
    old, new = before.keys, after.keys
    check_keyframes(new, film.name, film.frames, film.width, film.height)
    parts = changed(film.frames, old, new, before.unfinished)
    half_done = set(before.unfinished)
    made = set[int]()

    def replace(stretch: Stretch, tracks: list[Track]) -> None:
        unfinished = (stretch.first, stretch.last) in half_done
        same = set() if unfinished else kept(stretch, old)
        found = [track for track in tracks if track.frame not in same]
        table.replace(found, after.real_units)
        made.update(track.frame for track in found)

    after.unfinished_with(parts).save(history_path(goal))
    left = parts
    try:
        done, interrupted = run_stretches(
            film, parts, after.tracker, after.seed, replace, quiet=quiet, bar=bar
        )
        left = parts[done:]
    finally:
        table.write(goal)
    after.unfinished_with(left).save(history_path(goal), None if left else line_count(goal))
    return Refined(len(made), interrupted)
