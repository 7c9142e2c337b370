"""`motes track` with keyframes: in both directions, or backward, and smoothed."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from motes.cli.correct_run import run_stretches
from motes.cli.exit_codes import DONE
from motes.cli.frame_loop import summarize
from motes.cli.keyframe_options import KeyframeOptions, Marks
from motes.cli.messages import counted
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

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from motes.cli.options import OutputOptions
    from motes.cli.progress import Progress


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
    progress: AbstractContextManager[Progress] | None = None,
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
    progress
        The bar of several films; by default this film has one.
    """
    if region is not None:
        marks = [(_frame_of_init(film, options), region), *marks]
    keys = keyframes(marks)
    check_keyframes(keys, film.name, film.frames, film.width, film.height)
    history, path = History.begin(film, config, seed, [*keys.items()]), None
    opened: list[Output] = []
    if outputs.overlay is not None:
        opened.append(Overlay(outputs.overlay, film, 1, overwrite=outputs.overwrite))
    if output is not None:
        form = format_of(output, outputs.format)
        rows = row_form(form)
        if rows:
            opened.append(Rows(output, rows, overwrite=outputs.overwrite, columns=CORRECTED))
        else:
            inner = objects_output(
                output, film, overwrite=outputs.overwrite, form=form, label=outputs.label,
                keyframe_error=outputs.keyframe_error,
            )  # fmt: skip
            opened.append(AsObjects(inner))
        if rows and output != "-":
            path = history_path(Path(output))
            check_writable(path, outputs.overwrite)

    parts, written = stretches(film.frames, keys), Counter[Status]()
    following = film.frames.start
    with contextlib.ExitStack() as stack:
        for each in opened:
            stack.enter_context(each)

        def write(stretch: Stretch, tracks: list[Track]) -> None:
            nonlocal following
            new = [track for track in tracks if track.frame >= following]
            for step in _steps(film, new, pictures=outputs.overlay is not None):
                for each in opened:
                    each.write(step)
                written[step.status] += 1
            following = stretch.last + 1

        done, interrupted = run_stretches(
            film, parts, config, seed, write, quiet=output == "-", progress=progress
        )
    left = [(part.first, part.last) for part in parts[done:]]
    if path is not None and written:
        history.unfinished_with(left).save(path)
    parts_of_line = [counted(sum(written.values()), "frame"), counted(len(keys), "keyframe")]
    parts_of_line += [f"{status} in {number}" for status, number in written.most_common()]
    if written or interrupted is None:
        summarize([", ".join(parts_of_line)], film, opened, interrupted)
    return interrupts.code(interrupted) if interrupted else DONE


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
