"""What several experiments read: targets, rendered clips and sequences."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from motes.cli.input_checks import check_counts, first_pixels, numbers_of
from motes.cli.options import RUN, Seeds
from motes.core.errors import ConfigError, SourceError
from motes_lab.cli.experiment_output import Output, show

if TYPE_CHECKING:
    from motes.synthetic.clips import Clip
    from motes_lab.datasets.sot import Problem
    from motes_lab.datasets.sot import Sequence as Film
    from motes_lab.papers.result import Experiment

Clips = Annotated[int, Parameter(group=RUN, help="Number of rendered clips.")]


def region_of(source: str | None, region: str | None) -> Sequence[float] | None:
    """Return the numbers of --init; raise a ConfigError unless it comes with a source."""
    if source is None and region is not None:
        raise ConfigError("--init belongs to a picture or video; name it, or omit --init.")
    if source is not None and region is None:
        raise ConfigError(f"The target in {source} is missing; give --init x,y,width,height.")
    return None if region is None else numbers_of("--init", region, "x,y,width,height")


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class ClipRuns:
    """Runs over rendered clips."""

    seeds: Seeds = 5
    clips: Clips = 3

    def show(
        self,
        run: Callable[[Sequence[str], Sequence[Clip], int], Experiment],
        presets: Sequence[str],
        clip: Callable[..., Clip],
        output: Output,
    ) -> int:
        """Run an experiment on clips, each with its own scenery; return the exit code."""
        check_counts(seeds=self.seeds, clips=self.clips)
        films = [clip(seed=seed) for seed in range(self.clips)]
        return show(run(presets, films, self.seeds), output)


def films_of(dataset: Path, first_pixel: Sequence[str] | None) -> tuple[list[Film], list[Problem]]:
    """Return the sequences of a dataset, and those that cannot be read; raise if none can."""
    from motes_lab.datasets.sot import load_dataset

    films, problems = load_dataset(dataset, first_pixels(first_pixel or []))
    refuse_none(dataset, films, problems)
    return films, problems


def refuse_none(dataset: Path, usable: Sequence[object], problems: Sequence[Problem]) -> None:
    """Raise a SourceError if no sequence can be used."""
    if not usable:
        why = "; ".join(f"{problem.where}: {problem.what}" for problem in problems)
        raise SourceError(f"No sequence of {dataset} can be used. {why}")
