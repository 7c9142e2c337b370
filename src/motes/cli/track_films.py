"""`motes track` with several films: one after the other, with one bar and one summary."""

from __future__ import annotations

import glob
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from motes.cli.exit_codes import DONE, PARTIAL
from motes.cli.input_checks import prepare_folder, refuse
from motes.cli.keyframe_options import other_format_named
from motes.cli.messages import counted, log
from motes.cli.options import FrameOptions, say_rate
from motes.cli.progress import FrameProgress
from motes.cli.track_between import Between, TrackingChoice, track_film
from motes.cli.track_keyframes import Run
from motes.cli.track_options import TrackOutputs
from motes.cli.watch_outputs import format_of
from motes.core import interrupts
from motes.core.errors import ConfigError, MotesError
from motes.correction.keyframes import Keyframes, check_keyframes, read_keyframes
from motes.formats.registry import FORMATS
from motes.video.film import Film
from motes.video.image_files import IMAGE_ENDINGS


@dataclass(frozen=True, slots=True)
class FilmToTrack:
    """A film of a batch: its name, keyframes, outputs, and its number of frames if known."""

    name: str
    marks: Keyframes
    output: str
    masks: Path | None
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
    with other_format_named(file):
        given = read_keyframes(file)
    if "" in given:
        raise ConfigError(f"{file}: a row names no film; begin each row with the film's name.")
    marks: dict[str, Keyframes] = {}
    for name, each in given.items():
        fitting = [film for film in films if name in (film, Path(film).name, Path(film).stem)]
        if len(fitting) != 1:
            what = f"fits {' and '.join(fitting)}" if fitting else "is not one of the films"
            raise ConfigError(f"{file}: {name} {what}; name one of the films that are given.")
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
    outputs: TrackOutputs,
    choice: TrackingChoice,
) -> int:
    """Track the target of each film by its keyframes, into a folder.

    Masks of each film are in a folder of their own, and figures are beside its rows. A film that
    fails does not end the others: its error is printed, and counted in the summary.

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
    both = 2 * sum(count for count in known if count is not None)  # forward and backward
    done: list[str] = []
    tracked, interrupted = 0, None
    with FrameProgress(None if None in known else both) as bar:
        for film in chosen:
            try:
                run = _track(film, frames, outputs, choice, bar)
            except MotesError as error:
                failed += 1
                log(f"{film.name} failed: {error}")
                continue
            tracked += run.states.total()
            interrupted = run.interrupted
            if run.states:
                done.append(film.output)
                log(f"{film.name}: {run}; wrote {film.output}.")
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
    marks: Mapping[str, Keyframes], frames: FrameOptions, outputs: TrackOutputs
) -> tuple[list[FilmToTrack], int]:
    """Return the films that can be read, and the number of the others, before any is tracked."""
    if outputs.output is None or outputs.output == "-":
        raise ConfigError("Several films need a folder for their rows; give one with -o.")
    refuse({"--overlay": outputs.overlay, "--show": outputs.show}, "for one film")
    if outputs.masks is not None and outputs.masks.suffix:
        raise ConfigError(f"--masks {outputs.masks}: several films need a folder; give its name.")
    folder, form = Path(outputs.output), format_of("rows.csv", outputs.format)
    stems = [Path(film).stem for film in marks]
    for stem in stems:
        if stems.count(stem) > 1:
            raise ConfigError(
                f"Two films have the name {stem}, and so would their rows; rename one film."
            )
    ending = FORMATS.resolve(form).endings[0]
    anew = outputs.overwrite or outputs.resume
    prepare_folder(folder, [f"{stem}{ending}" for stem in stems], anew)
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
        masks = None if outputs.masks is None else outputs.masks / stem
        chosen.append(FilmToTrack(name, each, str(folder / f"{stem}{ending}"), masks, count))
    return chosen, failed


def _track(
    film: FilmToTrack,
    frames: FrameOptions,
    outputs: TrackOutputs,
    choice: TrackingChoice,
    bar: FrameProgress,
) -> Run:
    """Track the target of a film into its outputs."""
    source = Film(film.name, start=frames.start, end=frames.end, fps=frames.fps)
    say_rate(source)
    job = Between(source, film.name, [*film.marks.items()], choice)
    run = Run(len(film.marks))
    track_film(job, film.output, replace(outputs, masks=film.masks), run, [], bar=bar)
    return run
