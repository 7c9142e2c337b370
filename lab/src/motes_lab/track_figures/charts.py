"""The figures of the papers that show the course of a run; each function draws one from numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from motes import Ellipse, Frame
from motes.core import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# The palette of Okabe and Ito, whose colors color-blind readers can distinguish.
BLUE, VERMILION, GREEN, ORANGE = COLORS = ("#0072B2", "#D55E00", "#009E73", "#E69F00")
INK = "#333333"
COLOR_MAP = "viridis"
RHO = "\N{GREEK SMALL LETTER RHO}"
SURFACE_STEPS = 61
"""Number of positions in x and in y at which the surface of figure 3 is computed."""


class Series(NamedTuple):
    """The numbers kept of every frame, each of shape (frames,) unless a shape is given."""

    frame: Floats
    """Index."""
    x: Floats
    y: Floats
    a: Floats
    b: Floats
    """Center and half-axes of the estimate, in pixels."""
    n_supporting: Floats
    """Number of particles that fulfill the appearance rule."""
    tracking: Floats
    """1 where the status was `tracking`, else 0."""
    seconds: Floats
    mean_shift_seconds: Floats
    """Running times of the tracker and of mean shift; NaN if mean shift was not run."""
    cue_weights: Floats
    """(frames, J), the weight of each cue."""


class RhoSurface(NamedTuple):
    """The Bhattacharyya coefficient for the estimate's ellipse moved over its surroundings."""

    frame: int
    """Index of the frame."""
    x: Floats
    y: Floats
    """(n,) and (m,), centers of the ellipse, in pixels."""
    rho: Floats
    """(m, n), the coefficients."""
    samples: Floats
    """(N, 2), centers of the particles."""
    mean: Floats
    """(2,), center of the estimate."""

    def height(self, points: Floats) -> Floats:
        """Return rho at the position nearest to each of the points (N, 2), shape (N,)."""
        column = np.abs(self.x - points[:, :1]).argmin(axis=1)
        row = np.abs(self.y - points[:, 1:]).argmin(axis=1)
        nearest: Floats = self.rho[row, column]
        return nearest


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


def _shade_untracked(axes: Axes, series: Series) -> None:
    """Shade the frames in which the target was not tracked."""
    gone = np.concatenate([[0], 1 - series.tracking, [0]])
    starts, ends = np.flatnonzero(np.diff(gone) > 0), np.flatnonzero(np.diff(gone) < 0) - 1
    label = "lost or searching"
    for start, end in zip(starts, ends, strict=True):
        axes.axvspan(
            series.frame[start] - 0.5,
            series.frame[end] + 0.5,
            color=ORANGE,
            alpha=0.25,
            linewidth=0,
            label=label,
        )
        label = "_"  # only the first one is in the legend


def legend(axes: Axes) -> None:
    """Put the legend above the axes on the right, where it covers no data."""
    axes.legend(
        loc="lower right", bbox_to_anchor=(1, 1), ncols=3, frameon=False, fontsize=9,
        borderaxespad=0.2, columnspacing=1.2,
    )  # fmt: skip


def rho_surface(surface: RhoSurface) -> Figure:
    """Draw how similar the surroundings are to the target (Nummiaro et al., figure 3)."""
    figure = new_figure(4.2)
    title = f"Bhattacharyya coefficient {RHO} around the estimate in frame {surface.frame}"
    figure.suptitle(title, fontsize=12, x=0.01, ha="left", color=INK)
    x, y, rho, mean = surface.x, surface.y, surface.rho, surface.mean[None]
    low, high = (x[0], y[0]), (x[-1], y[-1])
    inside = ((surface.samples >= low) & (surface.samples <= high)).all(axis=1)
    samples = surface.samples[inside]

    # Points are drawn after the surface: matplotlib cannot compute which of them it hides.
    space: Any = figure.add_subplot(1, 2, 1, projection="3d", computed_zorder=False)
    space.plot_surface(
        *np.meshgrid(x, y), rho, rstride=1, cstride=1, vmin=0, vmax=1, cmap=COLOR_MAP
    )
    above = 0.02
    space.scatter(*samples.T, surface.height(samples) + above, color="black", s=7, depthshade=False)
    space.scatter(
        *mean.T, surface.height(mean) + above,
        color="white", edgecolor="black", s=45, depthshade=False,
    )  # fmt: skip
    space.set(xlabel="x (pixels)", ylabel="y (pixels)", zlabel=RHO, zlim=(0, 1))
    space.invert_yaxis()  # as on the screen: y grows towards the viewer
    space.view_init(elev=38, azim=-62)
    space.locator_params(nbins=4)
    space.tick_params(labelsize=8)

    flat = figure.add_subplot(1, 2, 2)
    filled = flat.contourf(x, y, rho, levels=np.linspace(0, 1, 21), cmap=COLOR_MAP)
    flat.scatter(samples[:, 0], samples[:, 1], color="black", s=9, linewidth=0, label="samples")
    flat.scatter(mean[:, 0], mean[:, 1], color="white", edgecolor="black", s=50, label="mean")
    flat.set(xlabel="x (pixels)", ylabel="y (pixels)", aspect="equal")
    flat.invert_yaxis()
    flat.legend(loc="upper right", fontsize=9, framealpha=0.85)
    figure.colorbar(filled, ax=flat, label=RHO, ticks=[0, 0.5, 1], shrink=0.75)
    return figure


def time_per_frame(series: Series, name: str) -> Figure:
    """Draw the running times of the named tracker and of mean shift (figure 7)."""
    from matplotlib.ticker import LogLocator

    figure = new_figure(3.2)
    axes = figure.add_subplot()
    style_axes(axes, "Running time", "frame", "milliseconds per frame")
    for label, seconds, color in (
        (name, series.seconds[1:], BLUE),
        ("mean shift", series.mean_shift_seconds[1:], VERMILION),
    ):
        if np.isfinite(seconds).any():
            median = float(np.nanmedian(seconds)) * 1000
            label = f"{label}, median {median:.2g} ms"
            axes.plot(series.frame[1:], seconds * 1000, color=color, linewidth=1, label=label)
            axes.axhline(median, color=color, linewidth=1, linestyle="--")
    axes.set_yscale("log", subs=[])
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter("{x:g}")
    legend(axes)
    return figure


def appearing(series: Series, samples: int, fraction: float) -> Figure:
    """Draw the number of samples that fulfill the appearance rule (figure 12)."""
    figure = new_figure(3.2)
    axes = figure.add_subplot()
    style_axes(axes, "Appearance rule", "frame", f"samples that fulfill it, of {samples}")
    _shade_untracked(axes, series)
    axes.step(series.frame, series.n_supporting, where="mid", color=BLUE, linewidth=1.2)
    axes.axhline(
        fraction * samples, color=VERMILION, linewidth=1.2, linestyle="--",
        label=f"threshold f N = {fraction * samples:g}",
    )  # fmt: skip
    axes.set_ylim(0, samples * 1.03)
    legend(axes)
    return figure


def size_and_displacement(series: Series) -> Figure:
    """Draw the target's size and its displacement between frames (figure 14)."""
    figure = new_figure(4.8)
    upper, lower = figure.subplots(2, 1, sharex=True)
    style_axes(upper, "Size of the region", "", "half-axes (pixels)")
    style_axes(lower, "Displacement", "frame", "pixels since the last frame")
    # Where the target is not tracked, the estimate is only a guess.
    tracked = np.where(series.tracking > 0, 1.0, np.nan)
    for axes in (upper, lower):
        _shade_untracked(axes, series)
    for label, values, color in (("a", series.a, BLUE), ("b", series.b, VERMILION)):
        upper.plot(series.frame, values * tracked, color=color, linewidth=1.4, label=label)
    upper.set_ylim(bottom=0)
    for label, values, color in (("along x", series.x, BLUE), ("along y", series.y, VERMILION)):
        moved = np.diff(values * tracked, prepend=np.nan)
        lower.plot(series.frame, moved, color=color, linewidth=1, label=label)
    for axes in (upper, lower):
        legend(axes)
    return figure


def cue_weights(series: Series, names: Sequence[str]) -> Figure:
    """Draw the weight of each cue over time (Maggio et al., figure 3)."""
    figure = new_figure(3.2)
    axes = figure.add_subplot()
    style_axes(axes, "Weights of the cues", "frame", "weight")
    _shade_untracked(axes, series)
    for name, weights, color in zip(names, series.cue_weights.T, COLORS, strict=False):
        axes.plot(series.frame, weights, color=color, linewidth=1, label=name)
    axes.set_ylim(0, 1.03)
    legend(axes)
    return figure


def orientation_histograms(
    frame: Frame, ellipse: Ellipse, spectrum: Floats, rotated: Floats, model: Floats
) -> Figure:
    """Draw a region and its two orientation histograms (Maggio et al., figure 1).

    Parameters
    ----------
    frame, ellipse
        The frame, and the estimate in it.
    spectrum
        The FOH: magnitudes of the Fourier transform, normalized.
    rotated
        The ROH: orientations relative to the angle of the ellipse.
    model
        The target model, in the form that the tracker compares.
    """
    figure = new_figure(3)
    title = f"Orientation histograms of the estimate in frame {frame.index}"
    figure.suptitle(title, fontsize=12, x=0.01, ha="left", color=INK)
    region, fourier, turned = figure.subplots(1, 3)
    low, sides = np.array(ellipse.box[:2]), np.array(ellipse.box[2:])
    inside = (0, 0), (frame.width - 1, frame.height - 1)
    left, top = np.clip(low - sides / 2, *inside).astype(int).tolist()
    right, bottom = np.clip(low + 1.5 * sides, *inside).astype(int).tolist()
    extent = (left - 0.5, right + 0.5, bottom + 0.5, top - 0.5)
    region.imshow(frame.pixels[top : bottom + 1, left : right + 1], extent=extent)
    region.plot(*np.vstack([(p := ellipse.polygon()), p[:1]]).T, color=ORANGE, linewidth=1.5)
    region.set(xlabel="x (pixels)", ylabel="y (pixels)", xlim=extent[:2], ylim=extent[2:])
    style_axes(fourier, "FOH", "frequency (cycles in 180°)", "share of the magnitudes")
    fourier.bar(np.arange(spectrum.size), spectrum, color=BLUE)
    style_axes(turned, "ROH", "angle to the ellipse (degrees)", "share of the certainty")
    width_of_bin = 180 / rotated.size
    angles = -90 + (np.arange(rotated.size) + 0.5) * width_of_bin
    turned.bar(angles, rotated, width=width_of_bin, color=BLUE)
    turned.set_xticks([-90, -45, 0, 45, 90])
    compared = turned if model.size == rotated.size else fourier
    bins = angles if compared is turned else np.arange(spectrum.size)
    compared.step(bins, model, where="mid", color=VERMILION, linewidth=1.2, label="model")
    compared.legend(frameon=False, fontsize=9)
    return figure
