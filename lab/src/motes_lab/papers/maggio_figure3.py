"""Maggio et al., figure 3: the weights of the cues, on a film in which each cue fails in turn."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from motes.core.errors import ConfigError
from motes.core.frame import Frame
from motes.core.types import Floats
from motes.output import charts
from motes.sot.particle_filter import ParticleFilter
from motes.sot.presets import preset
from motes.sot.tracker import Tracker
from motes_lab.metrics.sot import overlap_distances
from motes_lab.papers.failing_cues import FRAMES_OF_PART, PARTS, FilmPart, Shot
from motes_lab.papers.result import Experiment, Result, over
from motes_lab.report.tables import NO_VALUE, Cell, Row, Table, number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FAILURES = tuple(i for i, part in enumerate(PARTS) if part is not FilmPart.CLEAR)
"""The numbers of the parts in which a cue fails; each follows a clear part."""
CUES = ("color", "orientation")


def config_of(name: str) -> ParticleFilter:
    """Return a preset; raise a ConfigError unless it has color and orientation as cues."""
    config = preset(name)
    if not isinstance(config, ParticleFilter) or tuple(config.cues) != CUES:
        raise ConfigError(
            f"Preset {name} does not fuse color and orientation; give maggio or a variant of it "
            f"that begins with maggio:C+O."
        )
    return config


def figure3(presets: Sequence[str], films: Sequence[Iterable[Shot]], seeds: int) -> Experiment:
    """Yield the weight of color in every frame, mean over films and seeds.

    Raises
    ------
    ConfigError
        If a preset does not fuse color and orientation.
    """
    configs = {name: config_of(name) for name in presets}
    weights: dict[str, list[Floats]] = {}
    errors: dict[str, list[float]] = {}
    total, done = len(films) * len(configs) * seeds, 0
    for film in films:
        shots = list(film)
        for name, config in configs.items():
            for seed in range(seeds):
                run, error = _run(Tracker(config, seed), shots)
                weights.setdefault(name, []).append(run)
                errors.setdefault(name, []).append(error)
                done += 1
                means = {each: np.mean(runs, axis=0) for each, runs in weights.items()}
                rows = [_row(each, means[each], errors[each]) for each in means]
                table = Table("The weight of color where a cue fails", HEAD, rows, note=NOTE)
                progress = f"{done} of {total} runs"
                yield Result({"": table}, partial(_draw, means), (), progress, done / total)


HEAD = (
    "tracker",
    "runs",
    *(text for part in FAILURES for text in ("both useful", PARTS[part].value, "frames until")),
    "mean OD",
)
NOTE = (
    "Mean weight of color; that of orientation is the rest. Frames until: from the failure until "
    "the mean over runs is, for 3 frames, on the failure's side of the middle between both means."
)
STEADY = 3


def _run(tracker: Tracker, shots: Sequence[Shot]) -> tuple[Floats, float]:
    """Return the weight of color in each frame (n,), and the mean OD."""
    weights, ellipses = [], []
    for frame, _, target in shots:
        own = Frame(frame.index, frame.time, frame.pixels)
        track = tracker.init(own, target) if frame.index == 0 else tracker.update(own)
        weights.append(tracker.info.cue_weights["color"])
        ellipses.append(track.ellipse)
    truth = np.array([shot.target for shot in shots])
    return np.array(weights), float(overlap_distances(np.array(ellipses), truth).mean())


def _row(name: str, weights: Floats, errors: Sequence[float]) -> Row:
    cells = []
    for part in FAILURES:
        before, during, frames = response(weights, part)
        until = Cell(NO_VALUE) if frames is None else number(frames, 0)
        cells += [number(before, 2), number(during, 2), until]
    return Cell(name), number(len(errors), 0), *cells, number(over(errors))


def response(weights: Floats, part: int) -> tuple[float, float, int | None]:
    """Return the weights' reaction to the failure in a part of the film.

    Parameters
    ----------
    weights
        (n,), the weight of color in each frame.
    part
        The number of the part.

    Returns
    -------
    The mean weight in the part before and in this one; and the number of frames until it is on the
    right side of their middle for `STEADY` frames, None if it moves the wrong way or never settles.
    """
    parts = weights.reshape(len(PARTS), FRAMES_OF_PART)
    before, during = float(parts[part - 1].mean()), float(parts[part].mean())
    sign = -1 if PARTS[part] is FilmPart.BLUE_LIGHT else 1
    if sign * (during - before) <= 0:
        return before, during, None
    beyond = sign * (parts[part] - (before + during) / 2) > 0
    steady = np.lib.stride_tricks.sliding_window_view(beyond, STEADY).all(axis=1)
    return before, during, int(steady.argmax()) if steady.any() else None


def _draw(means: dict[str, Floats]) -> Figure:
    figure = charts.new_figure(3.6)
    axes = figure.add_subplot()
    charts.style_axes(axes, "Where each cue fails", "frame", "weight of color, mean over runs")
    for part in FAILURES:
        start, end = part * FRAMES_OF_PART, (part + 1) * FRAMES_OF_PART
        axes.axvspan(start - 0.5, end - 0.5, color=charts.INK, alpha=0.08, linewidth=0)
        axes.text((start + end) / 2, 0.97, PARTS[part].value, ha="center", va="top", fontsize=9)
    for (name, weights), color in zip(means.items(), charts.COLORS, strict=False):
        axes.plot(weights, color=color, linewidth=1.6, label=name)
    axes.set(ylim=(0, 1))
    charts.legend(axes)
    return figure
