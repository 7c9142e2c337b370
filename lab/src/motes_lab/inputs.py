"""The datasets of commands: their options, and the sequences that these name."""

from __future__ import annotations

import fnmatch
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, TypeVar

from cyclopts import Group, Parameter

from motes import ConfigError, SourceError
from motes_lab.datasets.mot import MotSequence, load_mot_dataset
from motes_lab.datasets.sot import Problem, Sequence as Film, load_dataset

S = TypeVar("S", Film, MotSequence)
DATASET = Group("Dataset", sort_key=1)
RUN = Group("Run", sort_key=2)
OUTPUT = Group("Output", sort_key=3)
FLAG = Parameter(negative=(), show_default=False)
"""An option without a value, off by default."""
REPEATED = Parameter(negative=())
"""An option that may be given several times."""
HYPHEN = Parameter(allow_leading_hyphen=True)
"""An option whose value may begin with a hyphen, such as a negative number."""
Overwrite = Annotated[bool, FLAG, Parameter(group=OUTPUT, help="Replace existing files.")]
FirstPixel = Annotated[
    list[str] | None,
    Parameter(
        group=DATASET,
        negative=(),
        help="Coordinate of the first pixel in the ground truth: 0 or 1, or 'GLOB=0' for some "
        "sequences. The default is that of the dataset's layout.",
    ),
]
Only = Annotated[
    list[str] | None,
    REPEATED,
    Parameter(group=DATASET, help="Only these sequences, such as 'seg-*'; may be repeated."),
]
Seeds = Annotated[
    int, Parameter(group=RUN, help="Number of runs of each tracker that uses random numbers.")
]
Region = Annotated[
    str, HYPHEN, Parameter(help="The target in the first frame: a box x,y,width,height.")
]


def first_pixels(texts: Sequence[str] | None) -> dict[str, int]:
    """Return the values of --first-pixel, by the pattern of their sequences.

    Raises
    ------
    ConfigError
        If a text has another form.
    """
    pixels = {}
    for text in texts or ():
        pattern, _, number = text.rpartition("=")
        if number not in ("0", "1"):
            raise ConfigError(f"--first-pixel takes 0, 1 or GLOB=0, as in 'seg-*=0'; got {text!r}.")
        pixels[pattern or "*"] = int(number)
    return pixels


def films_of(
    dataset: Path, first_pixel: Sequence[str] | None = None, patterns: Sequence[str] | None = None
) -> tuple[list[Film], list[Problem]]:
    """Return the sequences of a dataset, and those that cannot be read.

    Raises
    ------
    SourceError
        If none can be read.
    ConfigError
        If no sequence has a name that fits one of the patterns.
    """
    films, problems = chosen(*load_dataset(dataset, first_pixels(first_pixel)), patterns)
    refuse_none(dataset, films, problems)
    return films, problems


def crowds_of(dataset: Path) -> tuple[list[MotSequence], list[Problem]]:
    """Return the sequences of many objects, and those that cannot be read; raise if none can."""
    crowds, problems = load_mot_dataset(dataset)
    refuse_none(dataset, crowds, problems)
    return crowds, problems


def chosen(
    films: Sequence[S], problems: Sequence[Problem], patterns: Sequence[str] | None
) -> tuple[list[S], list[Problem]]:
    """Return the sequences that fit one of the patterns, and their problems; all without patterns.

    Raises
    ------
    ConfigError
        If a pattern fits no sequence.
    """
    named = {film.name for film in films}
    named |= {problem.where.removeprefix("sequence ") for problem in problems}
    fitting = set[str]()
    for pattern in patterns or ["*"]:
        if not (found := fnmatch.filter(named, pattern)):
            raise ConfigError(
                f"--sequence {pattern} fits none of {', '.join(sorted(named)[:9])}"
                + (" …." if len(named) > 9 else ".")
            )
        fitting.update(found)
    return (
        [film for film in films if film.name in fitting],
        [each for each in problems if each.where.removeprefix("sequence ") in fitting],
    )


def lines(problems: Iterable[Problem]) -> str:
    """Return problems as one line."""
    line = "; ".join(f"{problem.where}: {problem.what.rstrip('.')}" for problem in problems)
    return line if line.endswith("?") else f"{line}."


def refuse_none(dataset: Path, usable: Sequence[object], problems: Sequence[Problem]) -> None:
    """Raise a SourceError if no sequence can be used."""
    if not usable:
        raise SourceError(f"No sequence of {dataset} can be used. {lines(problems)}")
