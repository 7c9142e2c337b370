"""What several experiments read: targets, rendered clips and sequences."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

from cyclopts import Parameter

from motes.cli.input_checks import check_counts, numbers_of
from motes.cli.options import RUN
from motes.core.errors import ConfigError, SourceError
from motes_lab.cli.dataset_options import Seeds, first_pixels
from motes_lab.cli.experiment_output import Output, show

if TYPE_CHECKING:
    from motes_lab.datasets.mot import MotSequence
    from motes_lab.datasets.sot import Problem
    from motes_lab.datasets.sot import Sequence as Film
    from motes_lab.papers.result import Experiment
    from motes_lab.papers.sample_regions import View

C = TypeVar("C")

Clips = Annotated[int, Parameter(group=RUN, help="Number of rendered clips.")]


def views_of(
    source: str | None, region: str | None, preset: str, seeds: int
) -> Generator[View, None, None]:
    """Return the target of --init in a source, where a tracker follows it; or rendered ones.

    Raises
    ------
    ConfigError
        If only one of source and region is given.
    """
    from motes_lab.papers import sample_regions

    if source is None and region is not None:
        raise ConfigError("--init belongs to a picture or video; name it, or omit --init.")
    if source is None or region is None:
        if source is not None:
            raise ConfigError(f"The target in {source} is missing; give --init x,y,width,height.")
        return sample_regions.rendered(seeds)
    box = numbers_of("--init", region, "x,y,width,height")
    return sample_regions.followed(source, box, preset, seeds)


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class ClipRuns:
    """Runs over rendered clips."""

    seeds: Seeds = 5
    clips: Clips = 3

    def show(
        self,
        run: Callable[[Sequence[str], Sequence[C], int], Experiment],
        presets: Sequence[str],
        clip: Callable[..., C],
        output: Output,
    ) -> int:
        """Run an experiment on clips, each with its own scenery; return the exit code."""
        check_counts(seeds=self.seeds, clips=self.clips)
        films = [clip(seed=seed) for seed in range(self.clips)]
        return show(run(presets, films, self.seeds), output)


def films_of(
    dataset: Path, first_pixel: Sequence[str] | None, patterns: Sequence[str] | None = None
) -> tuple[list[Film], list[Problem]]:
    """Return the sequences of a dataset, and those that cannot be read.

    Raises
    ------
    SourceError
        If none can be read.
    ConfigError
        If patterns are given, and no sequence has a name that fits one.
    """
    from motes_lab.datasets.sot import load_dataset

    films, problems = load_dataset(dataset, first_pixels(first_pixel or []))
    _refuse_none(dataset, films, problems)
    if patterns:
        known = films[0].name
        films = [film for film in films if any(fnmatchcase(film.name, each) for each in patterns)]
        if not films:
            raise ConfigError(
                f"No sequence of {dataset} fits {', '.join(patterns)}; it has {known} and others."
            )
    return films, problems


def crowds_of(dataset: Path) -> tuple[list[MotSequence], list[Problem]]:
    """Return the sequences of many objects, and those that cannot be read; raise if none can."""
    from motes_lab.datasets.mot import load_mot_dataset

    crowds, problems = load_mot_dataset(dataset)
    _refuse_none(dataset, crowds, problems)
    return crowds, problems


def _refuse_none(dataset: Path, usable: Sequence[object], problems: Sequence[Problem]) -> None:
    """Raise a SourceError if no sequence can be used."""
    if not usable:
        why = "; ".join(f"{problem.where}: {problem.what}" for problem in problems)
        raise SourceError(f"No sequence of {dataset} can be used. {why}")
