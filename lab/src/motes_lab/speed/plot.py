"""The plot of measured speeds."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from motes_lab import charts
from motes_lab.adapters.opencv import PEERS
from motes_lab.speed.growth import Growth
from motes_lab.speed.measure import MAIN, OURS, SIZE, Job
from motes_lab.speed.report import named_size

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BARS, EMPTY = "bars", "."
"""Places in the figure that show no growth."""


def figure(seconds: Mapping[Job, list[float]], growths: Sequence[Growth]) -> Figure:
    """Draw trackers and peers on the main target and, below, the growth of times, two in a row."""
    below = [growth.what for growth in growths]
    rows: list[Any] = [[BARS] * 2] if seconds else []
    rows += [[*below[i : i + 2], EMPTY][:2] for i in range(0, len(below), 2)]
    heights = [4.2 if BARS in row else 3.4 for row in rows]
    drawn = charts.new_figure(sum(heights))
    axes = drawn.subplot_mosaic(rows, height_ratios=heights, empty_sentinel=EMPTY)
    if seconds:
        _bars(axes[BARS], seconds)
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
    from matplotlib.ticker import LogLocator, NullLocator

    charts.style_axes(axes, growth.title, growth.what, "milliseconds")
    colors = (charts.BLUE, charts.VERMILION)
    for (line, medians), color in zip(growth.medians.items(), colors, strict=False):
        label = f"{line}: power {growth.powers[line]}"
        axes.plot(
            [*medians], [1e3 * each for each in medians.values()], "o-", color=color, label=label
        )
    # In proportion to the last line's slowest measurement, which is at one of its ends.
    anchor, slowest = [*medians.items()][-1 if growth.proportional > 0 else 0]
    ends = np.array([min(medians), max(medians)])
    straight = 1e3 * slowest * (ends / anchor) ** growth.proportional
    axes.plot(ends, straight, "--", color=charts.INK, linewidth=1, label="in proportion")
    axes.loglog()
    axes.set_xticks([*medians])
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5), numticks=8))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter("{x:g}")
    axes.legend(frameon=False, fontsize=8)
