"""The plot of measured speeds."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from motes.evaluation.adapters.opencv import PEERS
from motes.evaluation.speed.measure import MAIN, OURS, SIZE, Job
from motes.evaluation.speed.report import Growth, named_size
from motes.output import charts

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def figure(seconds: Mapping[Job, list[float]], growths: Sequence[Growth]) -> Figure:
    """Draw trackers and peers on the main target and, below, the growth of their times."""
    drawn = charts.new_figure(4.2 + 3.4 * bool(growths))
    below = [growth.what for growth in growths]
    rows: list[Any] = [["bars"] * max(1, len(below)), below]
    axes = drawn.subplot_mosaic([*filter(None, rows)])
    _bars(axes["bars"], seconds)
    for growth in growths:
        _lines(axes[growth.what], growth)
    return drawn


def _bars(axes: Axes, seconds: Mapping[Job, list[float]]) -> None:
    """Draw the trackers' medians on the main target as bars, the fastest first."""
    title = f"One update, {named_size(SIZE)}, target of {named_size(MAIN)}, one core"
    charts.style_axes(axes, title, "milliseconds", "")
    main = {name: times for (name, target), times in seconds.items() if target == MAIN}
    medians = {name: 1e3 * statistics.median(times) for name, times in main.items()}
    names = sorted(medians, key=medians.__getitem__)
    for label, color, group in (("motes", charts.BLUE, OURS), ("OpenCV", charts.ORANGE, PEERS)):
        places = [place for place, name in enumerate(names) if name in group]
        widths = [medians[names[place]] for place in places]
        bars = axes.barh(places, widths, color=color, label=label)
        axes.bar_label(bars, fmt="{:#.3g}", padding=3, fontsize=9, color=charts.INK)
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    axes.set_xscale("log")
    axes.margins(x=0.08)  # room for the numbers at the bars
    axes.xaxis.set_major_formatter("{x:g}")
    axes.grid(visible=False)
    axes.legend(loc="upper right", frameon=False)


def _lines(axes: Axes, growth: Growth) -> None:
    """Draw time against number on logarithmic axes, with a line of proportional growth."""
    charts.style_axes(axes, growth.title, growth.what, "milliseconds")
    colors = (charts.BLUE, charts.VERMILION)
    for (line, medians), color in zip(growth.medians.items(), colors, strict=False):
        label = f"{line}: power {growth.exponent(line):.2f}"
        axes.plot(
            [*medians], [1e3 * each for each in medians.values()], "o-", color=color, label=label
        )
    most, last = [*medians.items()][-1]
    ends = np.array([min(medians), most])
    axes.plot(
        ends, 1e3 * last / most * ends, "--", color=charts.INK, linewidth=1, label="in proportion"
    )
    axes.loglog()
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter("{x:g}")
    axes.legend(frameon=False, fontsize=9)
