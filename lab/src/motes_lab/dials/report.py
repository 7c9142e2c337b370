"""The tables and the figure of success against each dial."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from motes.core.types import Floats
from motes.output import charts
from motes_lab.adapters.networks import short_name
from motes_lab.aggregate import Mean
from motes_lab.dials.measure import Measured
from motes_lab.metrics.sot import paired_difference
from motes_lab.papers.result import Experiment, Result
from motes_lab.report.plots import style
from motes_lab.report.tables import NO_VALUE, Cell, Row, Table, bars

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = 4
"""Panels beside each other in the figure."""


def results(steps: Iterable[Measured]) -> Experiment:
    """Yield tables and figure of the results so far; they grow with each scene."""
    for now in steps:
        if not now.grid.scenes:
            yield Result({}, progress=now.progress)
            continue
        tables = {"means": means(now), "levels": levels(now)}
        yield Result(tables, partial(figure, now), now.problems, now.progress)


def interval(values: Floats) -> tuple[float, float, float]:
    """Return the mean of values (n,) and its 95 % bootstrap interval; NaN values are left out."""
    known = values[np.isfinite(values)]
    return paired_difference(np.random.default_rng(0), known, np.zeros_like(known))


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
            values = (Mean.over(now.of(name, dial, level)) for name in names)
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
