"""`motes track` with several films: one after the other, with one bar and one summary."""

from __future__ import annotations

import glob
import time
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from motes.cli.exit_codes import DONE, PARTIAL
from motes.cli.frame_loop import run
from motes.cli.input_checks import prepare_folder
from motes.cli.messages import counted, log
from motes.cli.options import FrameOptions, OutputOptions
from motes.cli.progress import Progress, RunStatistics
from motes.cli.track_loop import Step
from motes.cli.track_outputs import AsObjects, Output, Rows
from motes.cli.watch_outputs import format_of, objects_output
from motes.core import interrupts
from motes.core.errors import ConfigError, MotesError
from motes.core.frame import Frame
from motes.correction.keyframes import Keyframes, check_keyframes, read_keyframes
from motes.formats.registry import named
from motes.sot.tracker import Tracker
from motes.video.sources import IMAGE_ENDINGS

if TYPE_CHECKING:
    from motes.sot.presets import TrackerConfig


@dataclass(frozen=True, slots=True)
class Film:
    """A film of a batch: its name, its keyframes, its output, and its number of frames if known."""

    name: str
    marks: Keyframes
    output: str
    frames: int | None


def films_of(sources: Sequence[str]) -> list[str]:
    """Return the films of names and patterns; a pattern of images is one film.

    Raises
    ------
    ConfigError
        If a film is there twice.
    """
    films: list[str] = []
    for source in sources:
        found = sorted(glob.glob(source)) if glob.has_magic(source) else []
        images = all(Path(name).suffix.lower() in IMAGE_ENDINGS for name in found)
        films += [source] if images else found
    for name in films:
        if films.count(name) > 1:
            raise ConfigError(f"{name} is given twice; give each film once.")
    return films


def marks_of_films(films: Sequence[str], file: Path) -> dict[str, Keyframes]:
    """Return the keyframes of each film from a file whose rows name the films.

    A row may have the film's whole name, the name of its file, or that without its ending.

    Raises
    ------
    ConfigError
        If a film has no keyframes, or keyframes have no film or several.
    FormatError
        If the file cannot be read.
    """
    given = read_keyframes(file)
    if "" in given:
        raise ConfigError(f"{file}: a row names no film; begin each row with the film's name.")
    marks: dict[str, Keyframes] = {}
    for name, each in given.items():
        fitting = [film for film in films if name in (film, Path(film).name, Path(film).stem)]
        if len(fitting) != 1:
            what = "none of the films" if not fitting else " and ".join(fitting)
            raise ConfigError(f"{file}: {name} is {what}; name one of the films that are given.")
        marks[fitting[0]] = each
    missing = [film for film in films if film not in marks]
    if missing:
        raise ConfigError(
            f"{file} has no keyframe of {missing[0]}; add a row {Path(missing[0]).name},0,x,y,w,h."
        )
    return marks


def track_films(
    marks: Mapping[str, Keyframes],
    frames: FrameOptions,
    outputs: OutputOptions,
    config: TrackerConfig,
    seed: int,
) -> int:
    """Track the target of each film by its keyframes, into a folder.

    A film that fails does not end the others: its error is printed, and counted in the summary.

    Returns
    -------
    The exit code.

    Raises
    ------
    ConfigError
        If the folder or the format is missing or wrong, or keyframes do not fit their film.
    FormatError
        If an output exists or cannot be written.
    """
    chosen, failed = _checked(marks, frames, outputs)
    known = [film.frames for film in chosen]
    total = sum(count for count in known if count is not None)
    done: list[str] = []
    tracked, interrupted = 0, None
    with Progress(None if None in known else total) as bar:
        for film in chosen:
            tally = RunStatistics()
            try:
                interrupted = _track(film, frames, outputs, Tracker(config, seed), tally, bar)
            except MotesError as error:
                failed += 1
                log(f"{film.name} failed: {error}")
                continue
            tracked += tally.frames
            done.append(film.output)
            log(f"{film.name}: {tally}; wrote {film.output}.")
            if interrupted is not None:
                break
    log(
        f"{interrupts.word(interrupted)}{counted(len(marks), 'film')}, {len(done)} done, "
        f"{failed} failed, {counted(tracked, 'frame')}; wrote {counted(len(done), 'file')} in "
        f"{outputs.output}."
    )
    if interrupted is not None:
        return interrupts.code(interrupted)
    return PARTIAL if failed else DONE


def _checked(
    marks: Mapping[str, Keyframes], frames: FrameOptions, outputs: OutputOptions
) -> tuple[list[Film], int]:
    """Return the films that can be read, and the number of the others, before any is tracked."""
    if outputs.output is None or outputs.output == "-":
        raise ConfigError("Several films need a folder for their rows; give one with -o.")
    if outputs.overlay is not None:
        raise ConfigError("--overlay is for one film; omit it.")
    folder, form = Path(outputs.output), format_of("rows.csv", outputs.format)
    stems = [Path(film).stem for film in marks]
    for stem in stems:
        if stems.count(stem) > 1:
            raise ConfigError(f"Two films have the name {stem}, and so had their rows; rename one.")
    ending = named(form).endings[0]
    prepare_folder(folder, [f"{stem}{ending}" for stem in stems], outputs.overwrite)
    chosen, failed = [], 0
    for (name, each), stem in zip(marks.items(), stems, strict=True):
        try:
            with frames.open(name) as film:
                count = film.frame_count
                stop = frames.start + (count if count is not None else 10**9) * frames.stride
                used = range(frames.start, stop)
                check_keyframes(each, name, used, film.width, film.height)
        except ConfigError:
            raise
        except MotesError as error:
            failed += 1
            log(f"{name} failed: {error}")
            continue
        chosen.append(Film(name, each, str(folder / f"{stem}{ending}"), count))
    return chosen, failed


def _track(
    film: Film,
    frames: FrameOptions,
    outputs: OutputOptions,
    tracker: Tracker,
    tally: RunStatistics,
    bar: Progress,
) -> KeyboardInterrupt | None:
    """Track the target of a film into its output; return the interrupt that ended it, if any."""
    form = format_of("rows.csv", outputs.format)
    with frames.open(film.name) as source:
        output: Output
        if form == "csv" or form == "jsonl":
            output = Rows(film.output, form, overwrite=outputs.overwrite, resume=False)
        else:
            output = AsObjects(
                objects_output(
                    film.output, source, overwrite=outputs.overwrite, form=form,
                    label=outputs.label, keyframe_error=outputs.keyframe_error,
                )
            )  # fmt: skip

        def steps(pictures: Iterator[Frame]) -> Generator[Step, None, None]:
            return follow_keyframes(tracker, film.marks, pictures)

        return run(source, [output], steps, tally.add, progress=nullcontext(bar))


def follow_keyframes(
    tracker: Tracker, marks: Keyframes, frames: Iterator[Frame]
) -> Generator[Step, None, None]:
    """Yield a step for each frame: the tracker starts anew in each keyframe.

    Before the first region, and where the target is marked as absent, there is no target.
    """
    begun = False
    for frame in frames:
        clock = time.perf_counter()
        if frame.index in marks:
            region = marks[frame.index]
            begun = region is not None
            if region is not None:
                tracker.init(frame, region)
        elif begun:
            tracker.update(frame)
        yield Step(frame, tracker.info if begun else None, time.perf_counter() - clock)
