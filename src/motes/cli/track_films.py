"""`motes track` with several films: one after the other, with one bar and one summary."""

from __future__ import annotations

import glob
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import NamedTuple

from motes.cli.correct_run import Work, work_of
from motes.cli.exit_codes import DONE, PARTIAL
from motes.cli.input_checks import check_label, is_pattern_of_films, prepare_folder
from motes.cli.keyframe_options import KeyframeOptions
from motes.cli.messages import counted, log
from motes.cli.options import FrameOptions, OutputOptions
from motes.cli.progress import Progress
from motes.cli.track_keyframes import track_keyframes
from motes.cli.watch_outputs import format_of
from motes.core.errors import ConfigError, MotesError
from motes.correction.correct import stretches
from motes.correction.keyframes import Keyframes, check_keyframes, keyframes_of
from motes.formats.registry import named
from motes.sot.presets import TrackerConfig
from motes.video.film import Film


class Job(NamedTuple):
    """A film of a batch: the film, its keyframes, and its output."""

    film: Film
    keys: Keyframes
    output: str


def films_of(sources: Sequence[str]) -> list[str]:
    """Return the films of names and patterns; a pattern of images is one film.

    Raises
    ------
    ConfigError
        If a film is there twice.
    """
    films: list[str] = []
    for source in sources:
        films += sorted(glob.glob(source)) if is_pattern_of_films(source) else [source]
    for name in films:
        if films.count(name) > 1:
            raise ConfigError(f"{name} is given twice; give each film once.")
    return films


def track_films(
    films: Sequence[str],
    options: KeyframeOptions,
    frames: FrameOptions,
    outputs: OutputOptions,
    config: TrackerConfig,
    seed: int,
) -> int:
    """Track the target of each film between its keyframes, into a folder.

    A film that fails does not end the others: its error is printed, and counted in the summary.

    Returns
    -------
    The exit code.

    Raises
    ------
    ConfigError
        If the folder or the format is wrong, or keyframes are missing or do not fit their film.
    FormatError
        If the keyframes cannot be read, or an output exists or cannot be written.
    """
    assert options.keyframes is not None
    if frames.stride != 1:
        raise ConfigError("--stride is not for keyframes; omit it.")
    keys = {film: keyframes_of(options.keyframes, film) for film in films}
    jobs = _checked(keys, _outputs(films, outputs), frames)
    failed, done = len(films) - len(jobs), 0
    work = sum(work_of(stretches(job.film.frames, job.keys)) for job in jobs)
    code = DONE
    with Progress(Work(work)) as bar:
        for film, marks, output in jobs:
            given = [*marks.items()]
            try:
                code = track_keyframes(
                    film, options, None, given, config, seed, output, outputs, nullcontext(bar)
                )
            except MotesError as error:
                failed += 1
                log(f"{film.name} failed: {error}")
                continue
            if code != DONE:
                break
            done += 1
    log(
        f"{counted(len(films), 'film')}: {done} done, {failed} failed"
        + f", {len(jobs) - done} not reached or interrupted" * (code != DONE)
        + f"; the rows are in {outputs.output}."
    )
    return code if code != DONE else PARTIAL if failed else DONE


def _outputs(films: Sequence[str], outputs: OutputOptions) -> dict[str, str]:
    """Return the output of each film, all of which can be made."""
    if outputs.output is None or outputs.output == "-":
        raise ConfigError("Several videos need a folder for their rows; give one with -o.")
    if outputs.overlay is not None:
        raise ConfigError("--overlay is for one video; omit it.")
    form = format_of("rows.csv", outputs.format)
    ending = named(form).endings[0]
    check_label(outputs.label, f"rows{ending}", form)
    stems = [Path(film).stem for film in films]
    for stem in stems:
        if stems.count(stem) > 1:
            raise ConfigError(f"Two films have the name {stem}, and so had their rows; rename one.")
    names = [f"{stem}{ending}" for stem in stems]
    prepare_folder(Path(outputs.output), names, outputs.overwrite)
    paths = [str(Path(outputs.output) / name) for name in names]
    return dict(zip(films, paths, strict=True))


def _checked(
    keys: Mapping[str, Keyframes], outputs: Mapping[str, str], frames: FrameOptions
) -> list[Job]:
    """Return the films that can be read, before any is tracked; report the others."""
    jobs = []
    for name, marks in keys.items():
        try:
            film = Film(name, start=frames.start, end=frames.end)
        except MotesError as error:
            log(f"{name} failed: {error}")
            continue
        check_keyframes(marks, name, film.frames, film.width, film.height)
        jobs.append(Job(film, marks, outputs[name]))
    return jobs
