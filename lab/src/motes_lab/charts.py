"""The look of the lab's plots."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# The palette of Okabe and Ito, whose colors color-blind readers can distinguish.
BLUE, VERMILION, GREEN, ORANGE = ("#0072B2", "#D55E00", "#009E73", "#E69F00")
INK = "#333333"


def new_figure(height: float) -> Figure:
    """Return an empty figure, 8 inches wide."""
    # Without pyplot, a figure is an ordinary object and is drawn by the Agg backend.
    from matplotlib.figure import Figure

    return Figure(figsize=(8, height), layout="constrained")


def style_axes(axes: Axes, title: str, x: str, y: str) -> None:
    """Give axes a title and labels; remove the spines that carry no information."""
    axes.set_title(title, fontsize=12, loc="left", color=INK)
    axes.set_xlabel(x, color=INK)
    axes.set_ylabel(y, color=INK)
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis="y", color="#dddddd", linewidth=0.7)
    axes.set_axisbelow(True)


def legend(axes: Axes) -> None:
    """Put the legend above the axes on the right, where it covers no data."""
    axes.legend(
        loc="lower right", bbox_to_anchor=(1, 1), ncols=3, frameon=False, fontsize=9,
        borderaxespad=0.2, columnspacing=1.2,
    )  # fmt: skip
