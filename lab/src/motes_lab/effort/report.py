"""The tables and the figure of the annotator's effort."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from motes.core.types import Floats
from motes.output import charts
from motes_lab.aggregate import Mean
from motes_lab.effort.measure import NAMES, Measured
from motes_lab.papers.result import Experiment, Result
from motes_lab.report.plots import style
from motes_lab.report.tables import Cell, Row, Table, number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INTERPOLATION = "interpolation"
MOST = 30.0
"""Corrections for each 100 frames up to which the figure is drawn."""


def results(steps: Iterable[Measured], rule: str) -> Experiment:
    """Yield tables and figure of the results so far; they grow with each sequence."""
    for now in steps:
        tables = {"means": means(now, rule), "sequences": sequences(now)} if now.efforts else {}
        progress = f"{len(now.efforts)} sequences"
        draw = partial(figure, now) if now.efforts else None
        yield Result(tables, draw, tuple(now.problems), progress, now.share)


def rates(now: Measured, name: str) -> Floats:
    """Return the corrections for each 100 frames of a method, (sequences,)."""
    return np.array([efforts[name].rate for efforts in now.efforts.values()])


def means(now: Measured, rule: str) -> Table:
    """Return a table with a row for each method."""
    reference = rates(now, INTERPOLATION)
    rows: list[Row] = []
    for name in NAMES:
        values = rates(now, name)
        fewer = int((values < reference).sum())
        ratio = float(values.mean() / reference.mean()) if reference.mean() else float("nan")
        rows.append(
            (
                Cell(name),
                number(Mean.over(values), 1),
                number(float(np.median(values)), 1),
                number(ratio, 2),
                Cell(f"{fewer} of {len(values)}", fewer),
            )
        )
    note = (
        f"Corrections for each 100 frames until 95 % of the frames have an IoU of 0.7 or more: "
        f"mean ± standard deviation over {len(reference)} sequences. The next keyframe is "
        + ("the frame that motes check names." if rule == "check" else "the worst frame.")
    )
    head = ("method", "corrections", "median", "ratio to interpolation", "fewer than it")
    return Table("Effort of an annotator", head, rows, note=note)


def sequences(now: Measured) -> Table:
    """Return a table with a row for each sequence."""
    rows = [
        (
            Cell(sequence),
            Cell(str(efforts[NAMES[0]].frames), efforts[NAMES[0]].frames),
            *(number(efforts[name].rate, 1) for name in NAMES),
        )
        for sequence, efforts in now.efforts.items()
    ]
    note = "Corrections for each 100 frames."
    return Table("Effort on each sequence", ("sequence", "frames", *NAMES), rows, note=note)


def figure(now: Measured) -> Figure:
    """Draw the mean IoU of each method against the number of corrections."""
    drawn = charts.new_figure(3.4)
    axes = drawn.subplots()
    charts.style_axes(axes, "", "corrections for each 100 frames", "IoU")
    x = np.linspace(0, MOST, 121)
    for i, name in enumerate(NAMES):
        each = [efforts[name] for efforts in now.efforts.values()]
        lines = [
            np.interp(x, 100 * np.arange(len(one.overlaps)) / one.frames, one.overlaps)
            for one in each
        ]
        axes.plot(x, np.mean(lines, axis=0), color=style(i)[0], label=name)
    axes.set(xlim=(0, MOST), ylim=(0, 1))
    axes.legend(frameon=False, loc="lower right")
    return drawn
