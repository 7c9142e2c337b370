"""Zhao and Pei, figure 2: a target that turns around, with and without an update of its model."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from motes.core.geometry import iou
from motes.core.types import Floats
from motes.output import charts
from motes.synthetic.clips import Clip
from motes_lab.metrics.sot import enclosing_boxes
from motes_lab.papers.rendered_claims import passes
from motes_lab.papers.result import Experiment, Result, over
from motes_lab.report.tables import Cell, Row, Table, number

if TYPE_CHECKING:
    from matplotlib.figure import Figure


FOLLOWED = 0.5
"""A tracker has followed the turn if its mean IoU at the end is above this."""


def figure2(presets: Sequence[str], clips: Sequence[Clip], seeds: int) -> Experiment:
    """Yield the overlap of trackers with a target that rolls over, frame by frame.

    In the last quarter of the frames only the target's other side is visible; see
    `synthetic.rolling`.
    """
    overlaps: dict[str, list[Floats]] = {}
    for name, found, truth, progress in passes(presets, clips, seeds):
        each = iou(enclosing_boxes(found), enclosing_boxes(truth))
        overlaps.setdefault(name, []).append(each)
        rows = [_row(name, np.array(runs)) for name, runs in overlaps.items()]
        head = ("tracker", "runs", "mean IoU", "in the last quarter", "turns followed")
        note = (
            f"Followed: the mean IoU of the last quarter, when only the other side is seen, is "
            f"above {FOLLOWED}. The paper shows pictures, and has no numbers."
        )
        table = Table("A target that turns around", head, rows, note=note)
        yield Result({"": table}, partial(_draw, overlaps), progress=progress)


def _row(name: str, runs: Floats) -> Row:
    """Return a tracker's row, given its overlaps (runs, frames)."""
    whole, last = runs.mean(axis=1), runs[:, -runs.shape[1] // 4 :].mean(axis=1)
    followed = int(np.count_nonzero(last > FOLLOWED))
    means = (number(over(part), 2) for part in (whole, last))
    turns = Cell(f"{followed} of {len(runs)}", followed)
    return Cell(name), number(len(runs), 0), *means, turns


def _draw(overlaps: dict[str, list[Floats]]) -> Figure:
    figure = charts.new_figure(3.6)
    axes = figure.add_subplot()
    charts.style_axes(axes, "A target that turns around", "frame", "IoU, mean over runs")
    for i, (name, runs) in enumerate(overlaps.items()):
        again, place = divmod(i, len(charts.COLORS))
        dashes = ("-", "--", ":", "-.")[again % 4]
        axes.plot(
            np.mean(runs, axis=0), dashes, color=charts.COLORS[place], linewidth=1.6, label=name
        )
    axes.set(ylim=(0, 1))
    charts.legend(axes)
    return figure
