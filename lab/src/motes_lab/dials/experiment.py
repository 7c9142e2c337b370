"""The experiment on films that are hard in one respect at a time: success against each dial."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated

import numpy as np
from cyclopts import Parameter

from motes.cli.input_checks import check_counts
from motes.cli.messages import log
from motes.cli.options import FLAG, OUTPUT, REPEATED, RUN
from motes.core.errors import ConfigError, FormatError, SourceError
from motes.core.types import Floats
from motes_lab import charts
from motes_lab.adapters.networks import short_name
from motes_lab.adapters.registry import TrackerSpec, resolve
from motes_lab.datasets.film_cutouts import cut_out
from motes_lab.datasets.sot import Problem, load_dataset
from motes_lab.dials.dial_clips import clip_name, dial_clips, setting_of, write_clip
from motes_lab.dials.dials import DIALS
from motes_lab.dials.scenes import Garden, Material
from motes_lab.experiment import Experiment, Result, ResultOptions
from motes_lab.finished_jobs import finished_jobs
from motes_lab.inputs import FirstPixel, films_of
from motes_lab.metrics.statistics import over, paired_difference
from motes_lab.report.plots import style
from motes_lab.report.sections import problems as failed_passes
from motes_lab.report.tables import NO_VALUE, Cell, Row, Table, bars
from motes_lab.runner import plan
from motes_lab.saved_scores import SavedScores

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TRACKERS = ("default", "nummiaro", "cv2:csrt")
LEVELS, SCENES, FRAMES = (0.0, 0.5, 1.0), 2, 40
FULL_LEVELS, FULL_SCENES, FULL_FRAMES = (0.0, 0.25, 0.5, 0.75, 1.0), 10, 60
MIN_FRAMES = 10
COLUMNS = 4
"""Panels beside each other in the figure."""


def dials(
    dataset: Path | None = None,
    /,
    *,
    first_pixel: FirstPixel = None,
    tracker: Annotated[
        list[str] | None,
        REPEATED,
        Parameter(
            group=RUN,
            help="Tracker to measure, as for motes-lab evaluate; may be repeated. The default is "
            f"{', '.join(TRACKERS)}.",
        ),
    ] = None,
    full: Annotated[
        bool,
        FLAG,
        Parameter(group=RUN, help="Measure five levels, 10 scenes and 60 frames."),
    ] = False,
    scenes: Annotated[
        int | None, Parameter(group=RUN, help="Number of scenes for each dial and level.")
    ] = None,
    frames: Annotated[
        int | None,
        Parameter(group=RUN, help="Length of each film; in a shorter one, changes are faster."),
    ] = None,
    films: Annotated[
        Path | None,
        Parameter(group=OUTPUT, help="Keep the films in this folder, as sequences."),
    ] = None,
    evaluated: Annotated[
        Path | None,
        Parameter(
            help="Folder of a motes-lab evaluate over films that were kept; its results are shown, "
            "and nothing is measured."
        ),
    ] = None,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Hard films: success against motion, light and others.

    Without --full: three levels, 2 scenes and 40 frames.

    Parameters
    ----------
    dataset
        A folder of sequences as for motes-lab evaluate, whose objects are cut out and put before
        frames of other sequences. By default scenes are rendered.
    """
    count = scenes if scenes is not None else FULL_SCENES if full else SCENES
    length = frames if frames is not None else FULL_FRAMES if full else FRAMES
    check_counts(scenes=count, frames=length)
    if length < MIN_FRAMES:
        raise ConfigError(f"--frames is {length}; give {MIN_FRAMES} or more.")
    if evaluated is not None:
        kept = of_evaluation(SavedScores.load(evaluated))
        return results.show("dials", (step for step in [kept.result()]))
    if films is not None and films.is_dir() and any(films.iterdir()) and not results.overwrite:
        raise FormatError(f"The folder {films} is not empty; choose another, or give --overwrite.")
    entries, problems = resolve(tracker or TRACKERS)
    if not entries:
        raise ConfigError("There is no tracker to run. " + problems[0].what)
    material: Material = Garden()
    if dataset is not None:
        sequences, unreadable = films_of(dataset, first_pixel)
        material = cut_out(sequences)
        objects, behind = len(material.objects), len(material.frames)
        log(f"{objects} objects cut out, to be put before {behind} films.")
        problems = [*problems, *unreadable]
    grid = Grid(DIALS, FULL_LEVELS if full else LEVELS, count)
    return results.show("dials", measured(entries, grid, material, length, films), problems)


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
    """

    grid: Grid
    trackers: tuple[str, ...]
    aucs: Mapping[str, Mapping[str, float]]

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

    def result(self) -> Result:
        """Return the tables and the figure."""
        return Result({"means": means(self), "levels": levels(self)}, partial(figure, self))


def measured(
    trackers: Sequence[TrackerSpec],
    grid: Grid,
    material: Material,
    frames: int,
    films: Path | None = None,
) -> Experiment:
    """Render films and run trackers over them, once each; yield the results after each step.

    `films` is a folder in which the films are kept; None to keep none.
    """
    names = tuple(each.name for each in trackers)
    aucs: dict[str, dict[str, float]] = {name: {} for name in names}
    problems: list[Problem] = []
    now = Result({})
    for scene in range(grid.scenes):
        with TemporaryDirectory(prefix="motes-") as scratch:
            folder, made = films or Path(scratch), set()
            for clip in dial_clips(grid.dials, grid.levels, [scene], material, frames=frames):
                write_clip(clip, folder)
                made.add(clip.name)
                yield now._replace(progress=f"rendered {clip.name}")
            found = [film for film in load_dataset(folder)[0] if film.name in made]
            jobs, _ = plan(trackers, found, ["ope"], 1)
            for outcomes, progress, _ in finished_jobs(jobs):
                problems += failed_passes((), outcomes)
                for outcome in outcomes:
                    if (auc := outcome.scores["auc"]) is not None:
                        aucs[outcome.item.tracker][outcome.item.sequence] = float(auc)
                yield now._replace(progress=f"scene {scene + 1} of {grid.scenes}, {progress}")
        done = Measured(replace(grid, scenes=scene + 1), names, aucs)
        now = done.result()._replace(problems=tuple(problems))
        yield now._replace(progress=f"{scene + 1} scenes", share=(scene + 1) / grid.scenes)


def of_evaluation(scores: SavedScores) -> Measured:
    """Return the results of an evaluation of films that were kept.

    Raises
    ------
    SourceError
        If it is one of other sequences.
    """
    settings = [setting_of(name) for name in scores.values.index]
    known = [setting for setting in settings if setting is not None]
    levels = tuple(sorted({0.0, *(level for _, level, _ in known)}))
    used = {dial for dial, _, _ in known}
    dials = tuple(dial for dial in DIALS if dial in used)
    if len(known) < len(settings) or not dials:
        raise SourceError(f"{scores.name} is not an evaluation of films with dials, see --films.")
    grid = Grid(dials, levels, 1 + max(scene for _, _, scene in known))
    aucs = {tracker: values.dropna().to_dict() for tracker, values in scores.values.items()}
    return Measured(grid, tuple(aucs), aucs)


def interval(values: Floats) -> tuple[float, float, float]:
    """Return the mean of values (n,) and its 95 % bootstrap interval; NaN values are left out."""
    known = values[np.isfinite(values)]
    return paired_difference(known, np.zeros_like(known))


def means(now: Measured) -> Table:
    """Return a table with a row for each dial: means over its levels, and differences."""
    first, *others = names = now.trackers
    easy = {name: now.of(name, now.grid.dials[0], 0.0) for name in names}
    rows = [_row("easy", easy, first, others)]
    hard = [{name: now.hard(name, dial) for name in names} for dial in now.grid.dials]
    rows += [
        _row(dial, each, first, others) for dial, each in zip(now.grid.dials, hard, strict=True)
    ]
    whole = {name: np.mean([each[name] for each in hard], axis=0) for name in names}
    above = ", ".join(f"{level:g}" for level in now.grid.levels if level)
    return Table(
        "Success on films with one hardness each",
        (
            "dial",
            *map(short_name, names),
            *(f"{short_name(first)} minus {short_name(other)}" for other in others),
        ),
        rows,
        (_row("mean of the dials", whole, first, others),),
        f"Mean AUC over {now.grid.scenes} scenes with the dial at {above}, and the paired "
        f"difference with its 95 % interval, a bootstrap over scenes.",
    )


def _row(title: str, aucs: dict[str, Floats], first: str, others: Iterable[str]) -> Row:
    cells = bars(float(np.mean(values)) for values in aucs.values())
    return (Cell(title), *cells, *(_difference(aucs[first] - aucs[other]) for other in others))


def _difference(values: Floats) -> Cell:
    mean, low, high = interval(values)
    if math.isnan(mean):
        return Cell(NO_VALUE)
    between = "" if math.isnan(low) else f" ({low:+.3f} to {high:+.3f})"
    return Cell(f"{mean:+.3f}{between}", mean)


def levels(now: Measured) -> Table:
    """Return a table with a row for each dial and level."""
    names = now.trackers
    rows: list[Row] = []
    for dial in now.grid.dials:
        for level in now.grid.levels:
            values = (over(now.of(name, dial, level)) for name in names)
            rows.append((Cell(dial), Cell(f"{level:g}", level), *bars(values)))
    note = f"AUC: mean ± standard deviation over {now.grid.scenes} scenes."
    return Table(
        "Success at each level", ("dial", "level", *map(short_name, names)), rows, note=note
    )


def figure(now: Measured) -> Figure:
    """Draw the AUC of each tracker against each dial, with 95 % intervals over scenes."""
    count = len(now.grid.dials)
    rows = -(-count // COLUMNS)
    drawn = charts.new_figure(0.7 + 1.7 * rows)
    panels = drawn.subplots(rows, min(COLUMNS, count), sharex=True, sharey=True, squeeze=False)
    for panel in panels.flat[count:]:
        panel.set_visible(False)
    for panel, dial in zip(panels.flat, now.grid.dials, strict=False):
        _panel(panel, now, dial)
    for panel in panels[-1]:
        panel.set_xlabel("dial", color=charts.INK)
    for panel in panels[:, 0]:
        panel.set_ylabel("AUC", color=charts.INK)
    handles, labels = panels.flat[0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)
    return drawn


def _panel(axes: Axes, now: Measured, dial: str) -> None:
    charts.style_axes(axes, dial, "", "")
    x = np.array(now.grid.levels)
    for i, tracker in enumerate(now.trackers):
        color, _ = style(i)
        found = [interval(now.of(tracker, dial, level)) for level in now.grid.levels]
        mean, low, high = np.array(found).T
        axes.fill_between(x, low, high, color=color, alpha=0.2, linewidth=0)
        axes.plot(x, mean, "o-", color=color, markersize=3, label=short_name(tracker))
    axes.set(xlim=(-0.03, 1.03), ylim=(0, 1), xticks=[0, 0.5, 1])
