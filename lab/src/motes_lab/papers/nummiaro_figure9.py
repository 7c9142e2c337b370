"""Nummiaro et al., figure 9: the color histogram of a target."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motes import Ellipse, Frame, open_source
from motes.cli import numbers_of
from motes.core import region_within
from motes_lab.experiment import Experiment, Result, ResultOptions
from motes_lab.inputs import Region
from motes_lab.papers.ng_delp_table1 import cue_of
from motes_lab.report.tables import Cell, Row, Table, percent
from motes_lab.track_figures import charts

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BINS = (8, 8, 8)
"""Those of the preset nummiaro: section III."""
MAX_ROWS = 12
"""Number of bins in the table; the other bins are summed in its last row."""


def nummiaro_figure9(
    source: str, /, *, init: Region, results: ResultOptions = ResultOptions()
) -> int:
    """Nummiaro et al., figure 9: the color histogram of a target.

    Parameters
    ----------
    source
        A picture, or a video, whose first frame is read.
    """
    box = numbers_of("--init", init, "x,y,width,height")
    with open_source(source) as film:
        frame = next(film)
    region = region_within(box, frame.width, frame.height)
    return results.show("nummiaro-figure9", figure9(frame, region))


def figure9(frame: Frame, region: Ellipse) -> Experiment:
    """Yield the color histogram of a region."""
    cue = cue_of("nummiaro", "color", {"type": "every_pixel"})
    histogram = cue.histograms(frame, np.array([region]))[0]
    order = np.argsort(-histogram, kind="stable")[: min(MAX_ROWS, np.count_nonzero(histogram))]
    rows: list[Row] = []
    for number, channels in zip(order, _channels()[order].tolist(), strict=True):
        ranges = (f"{low * 32} to {low * 32 + 31}" for low in channels)
        rows.append((*map(Cell, ranges), percent(float(histogram[number]))))
    occupied = int(np.count_nonzero(histogram))
    rest = (Cell(f"{occupied - len(order)} others"), Cell(""), Cell(""))
    foot = (*rest, percent(1 - float(histogram[order].sum())))
    title = f"Color histogram of the region: {occupied} of {histogram.size} bins are occupied"
    table = Table(title, ("red", "green", "blue", "share"), rows, (foot,))
    yield Result({"": table}, lambda: _draw(histogram))


def _channels() -> NDArray[np.intp]:
    """Return the bin of each channel for all bins of the histogram, (m, 3)."""
    return np.stack(np.unravel_index(np.arange(math.prod(BINS)), BINS), axis=1)


def _draw(histogram: NDArray[np.float64]) -> Figure:
    figure = charts.new_figure(3.2)
    axes = figure.add_subplot()
    charts.style_axes(axes, "Color histogram", "bin, blue fastest; in its own color", "share")
    axes.bar(np.arange(histogram.size), histogram, width=1, color=(_channels() + 0.5) / BINS)
    axes.set(xlim=(0, histogram.size), ylim=(0, None))
    return figure
