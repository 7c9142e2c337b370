"""Runs of trackers over films of all dials and levels, scene by scene."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from motes.core.errors import SourceError
from motes.core.types import Floats
from motes_lab.adapters.registry import TrackerSpec
from motes_lab.datasets.sot import Problem, load_dataset
from motes_lab.dials.dial_clips import (
    clip_name,
    dial_clips,
    setting_of,
    write_clip,
)
from motes_lab.dials.dials import DIALS
from motes_lab.dials.scenes import Material
from motes_lab.finished_passes import finished_passes
from motes_lab.report.sections import problems as failed_passes
from motes_lab.saved_scores import SavedScores
from motes_lab.scores import Outcome


@dataclass(frozen=True)
class Grid:
    """The films that are measured.

    Attributes
    ----------
    dials, levels
        The dials, and the levels at which each is set; the first level is 0.
    scenes
        Number of scenes, each with a film for every dial and level.
    """

    dials: tuple[str, ...]
    levels: tuple[float, ...]
    scenes: int


@dataclass(frozen=True)
class Measured:
    """Results of trackers on films.

    Attributes
    ----------
    grid
        The films that are done.
    trackers
        The names of the trackers.
    aucs
        The AUC of each tracker by the name of the film.
    problems
        Failures.
    progress
        What was done last.
    """

    grid: Grid
    trackers: tuple[str, ...]
    aucs: Mapping[str, Mapping[str, float]]
    problems: tuple[Problem, ...] = ()
    progress: str = ""

    def of(self, tracker: str, dial: str, level: float) -> Floats:
        """Return the AUC in each scene, (scenes,); NaN where a run failed."""
        found = self.aucs.get(tracker, {})
        names = (clip_name(dial, level, scene) for scene in range(self.grid.scenes))
        return np.array([found.get(name, np.nan) for name in names])

    def hard(self, tracker: str, dial: str) -> Floats:
        """Return the mean AUC over the levels above 0 in each scene, (scenes,)."""
        levels = [level for level in self.grid.levels if level]
        means: Floats = np.mean([self.of(tracker, dial, level) for level in levels], axis=0)
        return means


def measured(
    trackers: Sequence[TrackerSpec],
    grid: Grid,
    material: Material,
    frames: int,
    workers: int,
    films: Path | None = None,
) -> Iterator[Measured]:
    """Render films and run trackers over them, once each; yield the results after each step.

    Parameters
    ----------
    trackers, grid
        What is measured.
    material
        What the films are made of.
    frames
        Length of a film.
    workers
        Number of processes.
    films
        A folder for the films, which are kept there; None to keep none.

    Raises
    ------
    FormatError
        If a film cannot be written.
    """
    outcomes: list[Outcome] = []
    names = tuple(each.name for each in trackers)
    now = Measured(replace(grid, scenes=0), names, {})
    for scene in range(grid.scenes):
        with TemporaryDirectory(prefix="motes-") as scratch:
            folder, made = films or Path(scratch), set()
            for clip in dial_clips(grid.dials, grid.levels, [scene], material, frames=frames):
                write_clip(clip, folder)
                made.add(clip.name)
                yield replace(now, progress=f"rendered {clip.name}")
            found = [film for film in load_dataset(folder)[0] if film.name in made]
            ended: list[Outcome] = []
            for step in finished_passes(Outcome, trackers, found, 1, workers):
                ended = step.outcomes
                progress = f"scene {scene + 1} of {grid.scenes}, {step.progress}"
                yield replace(now, progress=progress)
            outcomes += ended
        problems = tuple(failed_passes((), outcomes))
        done = replace(grid, scenes=scene + 1)
        now = Measured(done, names, _aucs(outcomes), problems, f"{scene + 1} scenes")
        yield now


def _aucs(outcomes: Iterable[Outcome]) -> dict[str, dict[str, float]]:
    aucs: dict[str, dict[str, float]] = {}
    for outcome in outcomes:
        if (auc := outcome.scores["auc"]) is not None:
            aucs.setdefault(outcome.item.tracker, {})[outcome.item.sequence] = float(auc)
    return aucs


def of_evaluation(scores: SavedScores) -> Measured:
    """Return the results of an evaluation of films that were kept.

    Raises
    ------
    SourceError
        If it is one of other sequences.
    """
    names = {name for values in scores.values.values() for name in values}
    settings = [setting_of(name) for name in names]
    known = [setting for setting in settings if setting is not None]
    levels = tuple(sorted({0.0, *(level for _, level, _ in known)}))
    used = {dial for dial, _, _ in known}
    dials = tuple(dial for dial in DIALS if dial in used)
    if len(known) < len(settings) or not dials:
        raise SourceError(f"{scores.name} is not an evaluation of films with dials, see --films.")
    grid = Grid(dials, levels, 1 + max(scene for _, _, scene in known))
    return Measured(grid, tuple(scores.values), scores.values)
