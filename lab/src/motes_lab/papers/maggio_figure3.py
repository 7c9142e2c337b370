"""Maggio et al., figure 3, on film: the weight of orientation where its cue is disturbed.

The paper names three disturbances: something that covers a part of the target, blur, and a target
so small that it has little detail.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import numpy as np
from cyclopts import Parameter
from msgspec import Meta
from numpy.typing import NDArray

from motes import Config, ConfigError, ParticleFilter, SourceError, Tracker
from motes.cli import check_counts
from motes.core import Floats
from motes_lab.adapters.registry import motes_config
from motes_lab.datasets.shortened import frames_of, shortened
from motes_lab.datasets.sot import Sequence as Film
from motes_lab.experiment import Experiment, Result, ResultOptions
from motes_lab.inputs import RUN, Seeds, films_of
from motes_lab.metrics.sot import overlap_distances
from motes_lab.metrics.statistics import unpaired_difference
from motes_lab.report.tables import Cell, Row, Table, difference, number

CUES = ("color", "orientation")
MOST = 1000
"""Frames of a film that are read, at most."""
LENGTH = 5
"""Frames of the parts into which a film is cut where nobody has marked any."""
LOST = 0.8
"""Frames with a larger overlap distance do not count: what is there is not the target."""
Part = Annotated[tuple[int, ...], Meta(min_length=2, max_length=2)]
"""First and last frame of a part of a film."""
Parts = Annotated[tuple[Part, ...], Meta(min_length=2)]


class Marks(Config, frozen=True):
    """Parts of a film in which something covers about half of the target, or nothing of it."""

    covered: Parts
    clear: Parts


By = Literal["sharpness", "size"]
NAMES: dict[By, tuple[str, str]] = {"sharpness": ("blurred", "sharp"), "size": ("small", "large")}


def maggio_figure3(
    *presets: str,
    film: Annotated[Path, Parameter(group=RUN, help="A sequence as for motes-lab evaluate.")],
    marks: Annotated[
        Path | None,
        Parameter(
            group=RUN,
            help="A TOML file with parts of the film, covered and clear: first and last frames. "
            "Without it parts are compared by --by.",
        ),
    ] = None,
    by: Annotated[
        By, Parameter(group=RUN, help="What tells the parts of the film from each other.")
    ] = "sharpness",
    seeds: Seeds = 5,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Maggio et al., figure 3: where orientation weighs less.

    Parameters
    ----------
    presets
        Presets or TOML files that fuse color and orientation; by default maggio:printed.
    """
    check_counts(seeds=seeds)
    names = presets or ("maggio:printed",)
    parts = None if marks is None else Marks.load(marks)
    [sequence, *_], problems = films_of(film)
    return results.show("maggio-figure3", figure3(names, sequence, parts, by, seeds), problems)


def config_of(name: str) -> ParticleFilter:
    """Return a configuration; raise a ConfigError unless its cues are color and orientation."""
    config = motes_config(name)
    if not isinstance(config, ParticleFilter) or tuple(config.cues) != CUES:
        raise ConfigError(
            f"Preset {name} does not fuse color and orientation; give maggio, maggio:printed or a "
            f"TOML file."
        )
    return config


class Watched(NamedTuple):
    """What a film has shown: sharpness and size of the target (n,), and weights of orientation.

    Weights are (runs, n) by preset; all are NaN where the target is absent.
    """

    measured: dict[By, Floats]
    weights: dict[str, Floats]


def figure3(
    presets: Sequence[str], film: Film, marks: Marks | None, by: By, seeds: int
) -> Experiment:
    """Yield the weight of orientation in disturbed parts of a film and in others.

    Without marks a film is cut into parts of `LENGTH` frames, and the third of them in which the
    target is least sharp, or smallest, is compared with the third in which it is most so.

    Raises
    ------
    ConfigError
        If a preset does not fuse color and orientation.
    """
    measured, weights = watched(presets, film, seeds)
    if marks is None:
        groups, names = thirds(measured[by]), NAMES[by]
    else:
        groups, names = [marks.covered, marks.clear], ("covered", "clear")
    rows = [_row(film.name, name, runs, groups) for name, runs in weights.items()]
    parts = (f"{name} parts" for name in names)
    head = ("film", "tracker", "runs", *parts, *names, "difference", "95 % interval")
    note = (
        "Mean weight of orientation over parts of the film; that of color is the rest. Frames "
        f"with an OD above {LOST} do not count. The interval is a bootstrap over parts."
    )
    table = Table("The weight of orientation on film", head, rows, note=note)
    yield Result({"": table}, progress="1 of 1 films", share=1.0)


def thirds(values: Floats) -> list[Parts]:
    """Return the parts of a film with the least values and with the greatest, a third each."""
    cuts = np.arange(0, len(values) - LENGTH + 1, LENGTH)
    means = np.array([values[cut : cut + LENGTH].mean() for cut in cuts])
    there = cuts[np.argsort(means)][: np.isfinite(means).sum()].tolist()
    third = len(there) // 3
    return [tuple((cut, cut + LENGTH - 1) for cut in e) for e in (there[:third], there[-third:])]


def watched(presets: Sequence[str], film: Film, seeds: int) -> Watched:
    """Return what a film shows from its first target on; weights are NaN where it is lost, too."""
    view = shortened(film, MOST, 1)
    if view is None:
        raise SourceError(f"{film.name} never shows its target; choose another film.")
    configs = {name: config_of(name) for name in presets}
    trackers = {name: [Tracker(c, seed) for seed in range(seeds)] for name, c in configs.items()}
    weights = {name: np.full((seeds, view.frames), np.nan) for name in presets}
    sharpness = np.full(view.frames, np.nan)
    for frame in frames_of(view):
        index, box = frame.index, view.boxes[frame.index]
        if np.isfinite(box).all():
            sharpness[index] = sharpness_of(frame.pixels, box)
        for name, runs in trackers.items():
            for run, tracker in enumerate(runs):
                track = tracker.update(frame) if index else tracker.init(frame, box.tolist())
                ellipses = np.array([track.ellipse]), view.ellipses[index : index + 1]
                if overlap_distances(*ellipses)[0] <= LOST:
                    weights[name][run, index] = tracker.info.cue_weights["orientation"]
    return Watched({"sharpness": sharpness, "size": view.boxes[:, 2:].prod(axis=1)}, weights)


def sharpness_of(pixels: NDArray[np.uint8], box: Floats) -> float:
    """Return the mean square of the steps between neighboring pixels of a region, in gray."""
    left, top = np.maximum(box[:2], 0).astype(int)
    right, bottom = (box[:2] + box[2:]).astype(int)
    gray = pixels[top:bottom, left:right].mean(axis=2)
    return float((np.diff(gray, axis=0) ** 2).mean() + (np.diff(gray, axis=1) ** 2).mean())


def _row(film: str, name: str, runs: Floats, groups: Sequence[Parts]) -> Row:
    means = []
    for parts in groups:
        values = [runs[:, first : last + 1] for first, last in parts]
        means.append(np.array([v[np.isfinite(v)].mean() for v in values if np.isfinite(v).any()]))
    counts = (number(len(group), 0) for group in means)
    weights = (number(float(group.mean()) if group.size else None, 2) for group in means)
    change = difference(unpaired_difference(means[0], means[1]), 2)
    return Cell(film), Cell(name), number(len(runs), 0), *counts, *weights, *change
