"""`motes track` with keyframes: in both directions, or backward, and smoothed."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from motes.cli.correct_run import run_stretches
from motes.cli.exit_codes import DONE
from motes.cli.frame_loop import summarize
from motes.cli.keyframe_options import KeyframeOptions, Marks
from motes.cli.messages import counted
from motes.cli.options import OutputOptions
from motes.cli.progress import Progress
from motes.cli.track_loop import Step
from motes.cli.track_outputs import AsObjects, Output, Overlay, Rows
from motes.cli.watch_outputs import format_of, objects_output, row_form
from motes.core import interrupts
from motes.core.errors import ConfigError
from motes.core.frame import Frame
from motes.core.track import Status, Track
from motes.core.types import Floats
from motes.correction.correct import stretches
from motes.correction.history import History, history_path
from motes.correction.join import Stretch
from motes.correction.keyframes import check_keyframes, keyframes
from motes.output.track_rows import CORRECTED, check_writable
from motes.sot.presets import TrackerConfig
from motes.video.film import Film


class Hindsight(NamedTuple):
    """What is known of a frame in hindsight, in the form of a `StepInfo`: no particles."""

    track: Track
    ellipses: Floats = np.empty((0, 5))
    weights: Floats = np.empty(0)
    n_supporting: None = None
    models: Mapping[str, Any] = {}
    cue_weights: Mapping[str, float] = {}


def track_keyframes(
    film: Film,
    options: KeyframeOptions,
    region: Sequence[float] | None,
    marks: Marks,
    config: TrackerConfig,
    seed: int,
    output: str | None,
    outputs: OutputOptions,
) -> int:
    """Track a target between keyframes, and write its rows.

    Parameters
    ----------
    film
        The film, with the frames that are used.
    options
        The options of the keyframes.
    region
        The target of --init or --ellipse.
    marks
        The other keyframes.
    config, seed
        The tracker.
    output, outputs
        Where the results go.
    """
    if region is not None:
        marks = [(_frame_of_init(film, options), region), *marks]
    keys = keyframes(marks)
    check_keyframes(keys, film.name, film.frames, film.width, film.height)
    opened: list[Output] = []
    if outputs.overlay is not None:
        opened.append(Overlay(outputs.overlay, film, 1, overwrite=outputs.overwrite))
    if output is not None:
        opened.append(rows_output(output, film, outputs))
    path = None if output is None else history_of(output, outputs)
    history = History.begin(film, config, seed, [*keys.items()])
    pictures = outputs.overlay is not None
    run = write_stretches(film, history, opened, pictures=pictures, quiet=output == "-")
    if path is not None and run.states:
        history.unfinished_with(run.left).save(path)
    if run.states or run.interrupted is None:
        summarize([str(run)], film, opened, run.interrupted)
    return interrupts.code(run.interrupted) if run.interrupted else DONE


class Run(NamedTuple):
    """A run over a film.

    Attributes
    ----------
    keys
        Number of keyframes.
    states
        Number of frames of each status.
    left
        The stretches that are not finished.
    interrupted
        The interrupt that ended the run, or None.
    """

    keys: int
    states: Counter[Status]
    left: list[tuple[int, int]]
    interrupted: KeyboardInterrupt | None

    def __str__(self) -> str:
        counts = [f"{status} in {number}" for status, number in self.states.most_common()]
        return ", ".join(
            [counted(self.states.total(), "frame"), counted(self.keys, "keyframe"), *counts]
        )


def write_stretches(
    film: Film,
    history: History,
    opened: Sequence[Output],
    *,
    pictures: bool = False,
    quiet: bool = False,
    bar: Progress | None = None,
) -> Run:
    """Track a target between its keyframes, and write its frames in order.

    Parameters
    ----------
    film
        The film.
    history
        The keyframes and the tracker.
    opened
        The outputs; they are closed at the end.
    pictures
        Whether an output needs the pixels of the frames.
    quiet, bar
        As in `run_stretches`.
    """
    parts, states = stretches(film.frames, history.keys), Counter[Status]()
    following = film.frames.start
    with contextlib.ExitStack() as stack:
        for each in opened:
            stack.enter_context(each)

        def write(stretch: Stretch, tracks: list[Track]) -> None:
            nonlocal following
            new = [track for track in tracks if track.frame >= following]
            for step in _steps(film, new, pictures=pictures):
                for each in opened:
                    each.write(step)
                states[step.status] += 1
            following = stretch.last + 1

        done, interrupted = run_stretches(
            film, parts, history.tracker, history.seed, write, quiet=quiet, bar=bar
        )
    left = [(part.first, part.last) for part in parts[done:]]
    return Run(len(history.keys), states, left, interrupted)


def rows_output(output: str, film: Film, outputs: OutputOptions) -> Output:
    """Return the output of rows or of another format."""
    form = format_of(output, outputs.format)
    if rows := row_form(form):
        return Rows(output, rows, overwrite=outputs.overwrite, columns=CORRECTED)
    return AsObjects(
        objects_output(
            output, film, overwrite=outputs.overwrite, form=form, label=outputs.label,
            keyframe_error=outputs.keyframe_error,
        )
    )  # fmt: skip


def history_of(output: str, outputs: OutputOptions) -> Path | None:
    """Return the path of the history of rows in a file; None for other outputs.

    Raises
    ------
    FormatError
        If it exists and must not be overwritten.
    """
    if output == "-" or format_of(output, outputs.format) not in ("csv", "jsonl"):
        return None
    path = history_path(Path(output))
    check_writable(path, outputs.overwrite)
    return path


def _frame_of_init(film: Film, options: KeyframeOptions) -> int:
    if options.from_ is not None:
        return options.from_
    return film.frames.stop - 1 if options.backward else film.frames.start


def _steps(film: Film, tracks: Sequence[Track], *, pictures: bool) -> Iterator[Step]:
    """Yield tracks with their frames; without pictures, these are black."""
    if not tracks:
        return
    black = np.zeros((film.height, film.width, 3), np.uint8)
    frames: Iterator[Frame] = (
        film.forward(tracks[0].frame, tracks[-1].frame)
        if pictures
        else (Frame(track.frame, track.time, black) for track in tracks)
    )
    for frame, track in zip(frames, tracks, strict=True):
        yield Step(frame, Hindsight(track), 0.0)


def open_film(source: str, start: int, end: int | None, options: KeyframeOptions) -> Film:
    """Return the film with the frames that these options use.

    Raises
    ------
    ConfigError
        If options contradict each other.
    """
    if options.backward and (options.keyframes or options.at or options.absent):
        raise ConfigError(
            "Between keyframes, the target is tracked in both directions; omit --backward."
        )
    if options.from_ is not None and options.from_ < start:
        raise ConfigError(f"--from is {options.from_}, before the first frame {start}.")
    if options.backward and options.from_ is not None:
        end = options.from_ + 1 if end is None else min(end, options.from_ + 1)
    return Film(source, start=start, end=end)
