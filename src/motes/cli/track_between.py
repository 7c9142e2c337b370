"""The run of `motes track` with keyframes: its outputs, how it is resumed, and its summary."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from pathlib import Path

from motes.cli.correct_run import refine_rows
from motes.cli.exit_codes import DONE
from motes.cli.frame_loop import summarize
from motes.cli.moment import Sink
from motes.cli.track_keyframes import Outputs, Run, moments_of, write_others, write_stretches
from motes.cli.track_options import TrackOutputs
from motes.cli.track_outputs import pictures_outputs
from motes.cli.track_request import TrackRequest
from motes.cli.track_units import check_size, motion_names
from motes.cli.watch_outputs import STREAMED, format_of, rows_output
from motes.core import interrupts
from motes.core.errors import ConfigError, FormatError
from motes.core.files import is_special
from motes.correction.history import History, Marks, history_path
from motes.correction.keyframes import check_keyframes
from motes.correction.rows import KnownRows
from motes.mot.analytics.real_units import PIXELS, GroundMotion
from motes.rows.schema import GROUND, HINDSIGHT
from motes.rows.writer import check_writable
from motes.video.film import Film


def track_between(asked: TrackRequest, film: Film, marks: Marks) -> int:
    """Track a target between keyframes, write the outputs and print a summary.

    Raises
    ------
    ConfigError
        If keyframes contradict each other or do not fit the film, or the lens does not.
    """
    history = History.begin(film, asked.config, asked.seed, marks, asked.units, asked.preset)
    check_keyframes(history.keys, film.name, film.frames, film.width, film.height)
    check_size(asked.units, film)
    run, opened = Run(len(history.keys)), list[Sink]()
    try:
        _track(asked, film, history, run, opened)
    finally:
        if run.states:
            summarize([str(run)], film, opened, run.interrupted)
    return interrupts.code(run.interrupted) if run.interrupted else DONE


def _track(asked: TrackRequest, film: Film, history: History, run: Run, opened: list[Sink]) -> None:
    """Track a target between keyframes; with --resume, only what is missing.

    `run` counts the frames, and `opened` gets the outputs, for a summary.
    """
    output, outputs, units = asked.output, asked.outputs, asked.units
    quiet = output == "-"
    path = _history_of(output, outputs)
    table = None if not outputs.resume else _begun_rows(output, path, history, film)
    if outputs.resume:
        outputs = replace(outputs, overwrite=True)
    others = pictures_outputs(film, asked.source, output, outputs, units)
    pictures = any((outputs.overlay, outputs.masks, outputs.show))
    motion = None
    if units is not None or motion_names(outputs.figures):
        motion = GroundMotion(units or PIXELS)
    opened += others
    if table is not None and output is not None:
        opened.append(finished := _Finished(output))
        old = History.load(history_path(Path(output)))
        finished.rows, run.interrupted = refine_rows(
            film, table, old, old, Path(output), quiet=quiet
        )
        run.states.update(track.status for track in table.tracks)
        _replay(Outputs(None, None, others, pictures), film, table, motion, run)
        return
    rows = None
    if output is not None:
        further = HINDSIGHT if units is None else (*HINDSIGHT, *GROUND)
        rows = rows_output(output, film, outputs, further=further)
        opened.append(rows)
    each = Outputs(rows, path, others, pictures)
    write_stretches(film, history, each, motion, run, quiet=quiet)


class _Finished(Sink):
    """The rows of an earlier run, for the summary."""

    def __init__(self, name: str) -> None:
        self._name, self.rows = name, 0

    def write(self, moment: object) -> None:
        """Do nothing: the rows are written."""

    @property
    def result(self) -> str:
        """The file, and how many of its rows are new."""
        return f"{self._name} ({self.rows or 'none'} of its rows made anew)"

    def __exit__(self, *_: object) -> None:
        """Do nothing."""


def _replay(
    outputs: Outputs, film: Film, table: KnownRows, motion: GroundMotion | None, run: Run
) -> None:
    """Make the outputs beside the rows anew, of rows that are complete."""
    if run.interrupted is not None or not outputs.others:
        return
    with contextlib.ExitStack() as stack:
        for each in outputs.others:
            stack.enter_context(each)
        try:
            write_others(film, outputs, [*moments_of(film, table.tracks, motion)])
        except KeyboardInterrupt as interrupt:
            run.interrupted = interrupt


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
