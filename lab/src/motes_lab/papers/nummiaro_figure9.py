"""Nummiaro et al., figure 9: the color histogram of a target."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motes.cues.color import Color
from motes.cues.sampling import EveryPixel
from motes.output import charts
from motes_lab.papers.result import Experiment, Result
from motes_lab.papers.sample_regions import View
from motes_lab.report.tables import Cell, Row, Table, percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CUE = Color(space="rgb", bins=(8, 8, 8), kernel="radial", sampling=EveryPixel())  # section III
MAX_ROWS = 12
"""Number of bins in the table; the other bins are summed in its last row."""


def figure9(view: View) -> Experiment:
    """Yield the color histogram of a view's region."""
    assert view.region is not None
    histogram = CUE.histograms(view.frame, np.array([view.region]))[0]
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
    return np.stack(np.unravel_index(np.arange(math.prod(CUE.bins)), CUE.bins), axis=1)


def _draw(histogram: NDArray[np.float64]) -> Figure:
    figure = charts.new_figure(3.2)
    axes = figure.add_subplot()
    charts.style_axes(axes, "Color histogram", "bin, blue fastest; in its own color", "share")
    axes.bar(np.arange(histogram.size), histogram, width=1, color=(_channels() + 0.5) / CUE.bins)
    axes.set(xlim=(0, histogram.size), ylim=(0, None))
    return figure
