"""Figures of a target's path, speed and size, with 95 % bands, in a column's width for a paper."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from motes.core.types import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Colors of Okabe and Ito, which color-blind readers can distinguish.
BLUE, VERMILION, INK = "#0072B2", "#D55E00", "#333333"
COLUMN = 3.5
"""Width of a figure in inches: a column of most journals."""
INTERVAL = 1.96
"""Standard deviations on each side of a 95 % band."""
REGIONS = 80
"""Most 95 % regions along a path; more would only cover each other."""
NARROWEST = 0.25
"""Least ratio of the sides of a path's figure; ticks beside a straight path need room."""
ROOM = 0.05
"""Room above the values, as a share of the largest one."""
STYLE = {
    "font.size": 8, "axes.titlesize": 8, "axes.labelsize": 8, "xtick.labelsize": 7,
    "ytick.labelsize": 7, "legend.fontsize": 7, "axes.linewidth": 0.6, "lines.linewidth": 1.0,
    "xtick.major.width": 0.6, "ytick.major.width": 0.6, "pdf.fonttype": 42, "svg.fonttype": "none",
    "axes.spines.top": False, "axes.spines.right": False, "text.color": INK,
    "axes.labelcolor": INK, "xtick.color": INK, "ytick.color": INK, "axes.edgecolor": INK,
}  # fmt: skip


class MotionSeries(NamedTuple):
    """A target's course; each field has shape (frames,), NaN where it is not known."""

    time: Floats
    """In seconds."""
    x: Floats
    y: Floats
    x_std: Floats
    y_std: Floats
    speed: Floats
    speed_std: Floats
    """Place and speed in the units of the ground."""
    a: Floats
    b: Floats
    a_std: Floats
    b_std: Floats
    """Half-axes in pixels."""


def style() -> AbstractContextManager[None]:
    """Return the context in which these figures are made and saved."""
    import matplotlib as mpl

    return mpl.rc_context(STYLE)  # type: ignore[arg-type]


def _figure(height: float) -> tuple[Figure, Axes]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(COLUMN, height), layout="constrained")
    return figure, figure.add_subplot()


def _band(
    axes: Axes, time: Floats, value: Floats, std: Floats, color: str, label: str, line: str = "-"
) -> None:
    low, high = value - INTERVAL * std, value + INTERVAL * std
    axes.fill_between(time, low, high, color=color, alpha=0.25, linewidth=0)
    axes.plot(time, value, line, color=color, label=label)


def _begin_at_zero(axes: Axes) -> None:
    """Show all from 0 on, with room above also where the values hardly change."""
    axes.set_ylim(0, (1 + ROOM) * axes.get_ylim()[1])


def path(series: MotionSeries, unit: str) -> Figure:
    """Draw the path, its start, and the 95 % regions of places along it."""
    from matplotlib.collections import PolyCollection

    figure, axes = _figure(COLUMN * 0.8)
    angles = np.linspace(0, 2 * np.pi, 33)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    known = np.flatnonzero(np.isfinite(series.x))
    sure = np.flatnonzero(np.isfinite(series.x_std + series.y_std))
    chosen = sure[:: max(1, -(-len(sure) // REGIONS))]
    radius = np.sqrt(-2 * np.log(0.05))  # of 95 % of a Gaussian in the plane
    sides = np.stack([series.x_std, series.y_std], axis=1)[chosen, None]
    centers = np.stack([series.x, series.y], axis=1)[chosen, None]
    regions = centers + radius * sides * circle
    axes.add_collection(PolyCollection(list(regions), facecolor=BLUE, alpha=0.15, linewidth=0))
    axes.plot(series.x, series.y, color=BLUE)
    if len(known):
        axes.plot(series.x[known[0]], series.y[known[0]], "o", color=BLUE, markersize=3)
    axes.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})", aspect="equal")
    axes.margins(0.08)
    spans = [high - low for low, high in (axes.get_xlim(), axes.get_ylim())]
    for (low, high), set_limits in (
        (axes.get_xlim(), axes.set_xlim), (axes.get_ylim(), axes.set_ylim),
    ):  # fmt: skip
        room = max(NARROWEST * max(spans) - (high - low), 0) / 2
        set_limits(low - room, high + room)
    axes.invert_yaxis()  # as in the picture
    return figure


def speed(series: MotionSeries, unit: str) -> Figure:
    """Draw the speed over time with its 95 % band."""
    figure, axes = _figure(COLUMN * 0.6)
    _band(axes, series.time, series.speed, series.speed_std, BLUE, "speed")
    axes.set(xlabel="time (s)", ylabel=f"speed ({unit}/s)")
    _begin_at_zero(axes)
    return figure


def size(series: MotionSeries, unit: str) -> Figure:
    """Draw both half-axes over time with their 95 % bands; they are in pixels."""
    del unit
    figure, axes = _figure(COLUMN * 0.6)
    _band(axes, series.time, series.a, series.a_std, BLUE, "a")
    _band(axes, series.time, series.b, series.b_std, VERMILION, "b", "--")  # a may be the same
    axes.set(xlabel="time (s)", ylabel="half-axes (pixels)")
    _begin_at_zero(axes)
    axes.legend(frameon=False, ncols=2)
    return figure


FIGURES: dict[str, Callable[[MotionSeries, str], Figure]] = {
    "path": path,
    "speed": speed,
    "size": size,
}
"""The figures by name."""
