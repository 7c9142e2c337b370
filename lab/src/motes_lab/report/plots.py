"""The plots of a report, as SVG in HTML; they use the page's text colors, light or dark."""

from __future__ import annotations

import io
import re
from typing import TYPE_CHECKING

import numpy as np

from motes.core.types import Floats
from motes_lab.metrics.sot import BINS, Reliability

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# The palette of Okabe and Ito, with gray instead of black, which cannot be seen on a dark page, and
# without yellow, which is too pale on a light page.
COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#808080")
DASHES = ("", "6 3", "2 2", "8 2 2 2")
"""Line styles, which distinguish trackers if there are more trackers than colors."""

_INK, _GRID = "#123456", "#654321"  # are replaced by the colors of the page


def style(i: int) -> tuple[str, str]:
    """Return color and dashes of the line of tracker i, as in SVG; no dashes: a solid line."""
    return COLORS[i % len(COLORS)], DASHES[i // len(COLORS) % len(DASHES)]


def curves(name: str, x: Floats, lines: dict[int, Floats], labels: tuple[str, str]) -> str:
    """Return a plot of shares between 0 and 1, as SVG.

    Parameters
    ----------
    name
        Unique in the page; ids begin with it.
    x
        (n,), the horizontal coordinates.
    lines
        The values (n,) of each tracker, by its number.
    labels
        Labels of the axes.
    """
    figure = _figure(5, 3.6)
    axes = figure.add_subplot()
    _style_axes(axes, *labels)
    for i, y in lines.items():
        color, dashes = style(i)
        pattern = (0, tuple(map(float, dashes.split()))) if dashes else "-"
        axes.plot(x, y, color=color, linewidth=1.8, linestyle=pattern)
    axes.set(xlim=(x[0], x[-1]), ylim=(0, 1.005))
    axes.grid(axis="both", color=_GRID, linewidth=0.7)
    return _svg(figure, name)


def diagram(name: str, i: int, found: Reliability) -> str:
    """Return the reliability diagram of tracker i, with the number of frames in each bin, as SVG.

    Parameters
    ----------
    name
        Unique in the page; ids begin with it.
    i
        The tracker's number, for its color.
    found
        Its reliability.
    """
    color, _ = style(i)
    figure = _figure(3, 3.9)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    _style_axes(upper, "", "share with IoU > 0.5")
    _style_axes(lower, "confidence", "frames")
    middle = (np.arange(BINS) + 0.5) / BINS
    upper.bar(middle, found.accuracy, width=0.9 / BINS, color=color, alpha=0.35)
    upper.plot([0, 1], [0, 1], color=_INK, linewidth=1, linestyle=(0, (4, 3)))
    upper.plot(
        found.confidence, found.accuracy, color=color, linewidth=1.4, marker="o", markersize=4
    )
    upper.set(xlim=(0, 1), ylim=(0, 1), yticks=(0, 0.5, 1))
    lower.bar(middle, found.frames, width=0.9 / BINS, color=color)
    for place, count in zip(middle, found.frames, strict=True):
        lower.annotate(
            _short(int(count)), (place, count), (0, 2), textcoords="offset points",
            ha="center", fontsize=6.5, color=_INK,
        )  # fmt: skip
    lower.set(yticks=(), ylim=(0, max(1, found.frames.max()) * 1.3))
    lower.grid(visible=False)
    return _svg(figure, name)


def _short(count: int) -> str:
    if count < 1000:
        return str(count or "")
    return f"{count / 1000:.1f}k" if count < 9950 else f"{count / 1000:.0f}k"


def _figure(width: float, height: float) -> Figure:
    # Without pyplot, a figure is an ordinary object.
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def _style_axes(axes: Axes, x: str, y: str) -> None:
    axes.set_xlabel(x, color=_INK)
    axes.set_ylabel(y, color=_INK)
    axes.tick_params(color=_INK, labelcolor=_INK, labelsize=9)
    axes.spines[["top", "right"]].set_visible(False)
    axes.spines[["left", "bottom"]].set_color(_INK)
    axes.grid(axis="y", color=_GRID, linewidth=0.7)
    axes.set_axisbelow(True)


def _svg(figure: Figure, name: str) -> str:
    """Return a figure as an SVG element that can be placed with others in one page."""
    import matplotlib

    file = io.StringIO()
    # Text stays text, and ids are not random.
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": "motes"}):
        figure.savefig(file, format="svg", transparent=True, metadata={"Date": None})
    svg = file.getvalue()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"\s*<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", svg, count=1, flags=re.DOTALL)
    svg = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", svg, count=1, flags=re.DOTALL)
    svg = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}-", svg)
    svg = re.sub(r"font: ([\d.]+px)[^;\"]*", r"font-size: \1", svg)
    return svg.replace(_INK, "currentColor").replace(_GRID, "var(--grid)").strip()
