"""The figures of Nummiaro et al. that show how a run went, drawn from numbers kept per frame."""

from __future__ import annotations

from array import array
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.errors import FormatError, LimitError
from motes.frame import Frame
from motes.particle_filter import Info, ParticleFilter
from motes.presets import TrackerConfig
from motes.track import Status

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

FIGURES = (
    "rho_surface.png",
    "time_per_frame.png",
    "appearing.png",
    "size_and_displacement.png",
)
"""The files that `Recorder.save` writes."""

# Okabe and Ito's palette: all readers can tell these apart.
BLUE, VERMILION, ORANGE, INK = "#0072B2", "#D55E00", "#E69F00", "#333333"
MAP = "viridis"
RHO = "\N{GREEK SMALL LETTER RHO}"
DPI = 110
STEPS = 61
"""The surface of figure 3 is computed at so many places in x and in y."""


class Series(NamedTuple):
    """What is kept of every frame; each field has shape (frames,).

    Attributes
    ----------
    frame
        Index.
    x, y, a, b
        Center and half-axes of the estimate, in pixels.
    appearing
        Number of particles that fulfill the appearance rule.
    tracking
        Whether the status was tracking, 1 or 0.
    seconds, shift_seconds
        Running times of the tracker and of mean shift; NaN where there was none.
    """

    frame: Floats
    x: Floats
    y: Floats
    a: Floats
    b: Floats
    appearing: Floats
    tracking: Floats
    seconds: Floats
    shift_seconds: Floats


class Surface(NamedTuple):
    """The Bhattacharyya coefficient where the estimate's ellipse is moved over its surroundings.

    Attributes
    ----------
    frame
        Index of the frame.
    x, y
        (n,) and (m,), centers of the ellipse, in pixels.
    rho
        (m, n).
    samples
        (N, 2), centers of the particles.
    mean
        (2,), center of the estimate.
    """

    frame: int
    x: Floats
    y: Floats
    rho: Floats
    samples: Floats
    mean: Floats

    def height(self, points: Floats) -> Floats:
        """Return rho at the place nearest to each of the points (N, 2), shape (N,)."""
        column = np.abs(self.x - points[:, :1]).argmin(axis=1)
        row = np.abs(self.y - points[:, 1:]).argmin(axis=1)
        nearest: Floats = self.rho[row, column]
        return nearest


class Recorder:
    """Collects what the paper's figures 3, 7, 12 and 14 need, and draws them.

    A frame leaves nine numbers behind. Only for figure 3 one frame is kept whole: the last whose
    number among the tracked frames, from 1, is a power of two. It lies in the second half of these
    and is chosen without knowing how many will come, or how good they are.

    Parameters
    ----------
    config
        Of the tracker that is recorded.

    Raises
    ------
    LimitError
        If matplotlib is not installed.
    """

    def __init__(self, config: TrackerConfig) -> None:
        try:
            import matplotlib  # noqa: F401
        except ImportError:
            raise LimitError(
                "Drawing figures needs matplotlib; install it with: pip install 'motes[report]'."
            ) from None
        self._config = config
        self._numbers = array("d")
        self._tracked = 0
        self._kept: tuple[Frame, Info] | None = None

    def add(self, frame: Frame, info: Info, seconds: float, shift_seconds: float | None) -> None:
        """Take note of a frame.

        Parameters
        ----------
        frame, info
            The frame, and what the tracker said about it.
        seconds
            The tracker's running time.
        shift_seconds
            That of mean shift for the same frame, if it runs beside.
        """
        track, tracking = info.track, info.track.status is Status.TRACKING
        shift = np.nan if shift_seconds is None else shift_seconds
        self._numbers.extend(
            (frame.index, *track.ellipse[:4], info.appearing, tracking, seconds, shift)
        )
        self._tracked += tracking
        if tracking and self._tracked.bit_count() == 1:
            self._kept = frame, info

    @property
    def series(self) -> Series:
        """The numbers kept so far."""
        table = np.array(self._numbers).reshape(-1, len(Series._fields))
        return Series(*table.T)

    def surface(self) -> Surface | None:
        """Return the surface of figure 3 in the frame that was kept; None if none was tracked."""
        if self._kept is None:
            return None
        frame, info = self._kept
        ellipse = info.track.ellipse
        reach = max(ellipse.box[2:])
        x = np.linspace(max(ellipse.x - reach, 0), min(ellipse.x + reach, frame.width - 1), STEPS)
        y = np.linspace(max(ellipse.y - reach, 0), min(ellipse.y + reach, frame.height - 1), STEPS)
        moved = np.tile(np.array(ellipse), (STEPS, STEPS, 1))
        moved[..., 0], moved[..., 1] = np.meshgrid(x, y)
        distances = self._config.cue.distances(info.model, frame, moved.reshape(-1, 5))
        rho = (1 - distances**2).reshape(STEPS, STEPS)
        return Surface(frame.index, x, y, rho, info.ellipses[:, :2], np.array(ellipse[:2]))

    def save(self, folder: Path) -> list[Path]:
        """Draw the figures into a folder, which is made if need be; return the files written.

        They are the `FIGURES`, and replace files of these names. Figure 3 is left out where no
        frame was tracked; figure 7, of the times between two frames, where there are not two; and
        all of them where no frame was recorded.

        Raises
        ------
        FormatError
            If a file cannot be written.
        """
        series, surface = self.series, self.surface()
        if not series.frame.size:
            return []
        figures = (
            _rho_surface(surface) if surface else None,
            _time_per_frame(series, self._name) if series.frame.size > 1 else None,
            _appearing(series, *self._rule),
            _size_and_displacement(series),
        )
        written = []
        for name, figure in zip(FIGURES, figures, strict=True):
            if figure:
                path = folder / name
                try:
                    folder.mkdir(parents=True, exist_ok=True)
                    figure.savefig(path, dpi=DPI)
                except OSError as error:
                    raise FormatError(
                        f"The figure {path} cannot be written: {error.strerror}; choose another "
                        f"folder, or make room there."
                    ) from None
                written.append(path)
        return written

    @property
    def _name(self) -> str:
        return "particle filter" if isinstance(self._config, ParticleFilter) else "mean shift"

    @property
    def _rule(self) -> tuple[int, float]:
        """Number of samples N and fraction f of the appearance rule."""
        samples = self._config.particles if isinstance(self._config, ParticleFilter) else 1
        return samples, self._config.presence.fraction


def _figure(height: float) -> Figure:
    # Without pyplot, a figure is an object like any other and draws with the Agg backend.
    from matplotlib.figure import Figure

    return Figure(figsize=(8, height), layout="constrained")


def _plain(axes: Axes, title: str, x: str, y: str) -> None:
    """Give axes a title and labels, and take away what says nothing."""
    axes.set_title(title, fontsize=12, loc="left", color=INK)
    axes.set_xlabel(x, color=INK)
    axes.set_ylabel(y, color=INK)
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis="y", color="#dddddd", linewidth=0.7)
    axes.set_axisbelow(True)


def _shade(axes: Axes, series: Series) -> None:
    """Shade the frames in which the target was not being tracked."""
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
        label = "_"  # only the first is named in the legend


def _legend(axes: Axes) -> None:
    """Put the legend on top of the axes on the right, where no data is."""
    axes.legend(
        loc="lower right", bbox_to_anchor=(1, 1), ncols=3, frameon=False, fontsize=9,
        borderaxespad=0.2, columnspacing=1.2,
    )  # fmt: skip


def _rho_surface(surface: Surface) -> Figure:
    figure = _figure(4.2)
    title = f"Bhattacharyya coefficient {RHO} around the estimate in frame {surface.frame}"
    figure.suptitle(title, fontsize=12, x=0.01, ha="left", color=INK)
    x, y, rho, mean = surface.x, surface.y, surface.rho, surface.mean[None]
    low, high = (x[0], y[0]), (x[-1], y[-1])
    inside = ((surface.samples >= low) & (surface.samples <= high)).all(axis=1)
    samples = surface.samples[inside]

    # Points are drawn after the surface: matplotlib cannot tell what of them it would hide.
    space: Any = figure.add_subplot(1, 2, 1, projection="3d", computed_zorder=False)
    space.plot_surface(*np.meshgrid(x, y), rho, rstride=1, cstride=1, vmin=0, vmax=1, cmap=MAP)
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
    filled = flat.contourf(x, y, rho, levels=np.linspace(0, 1, 21), cmap=MAP)
    flat.scatter(samples[:, 0], samples[:, 1], color="black", s=9, linewidth=0, label="samples")
    flat.scatter(mean[:, 0], mean[:, 1], color="white", edgecolor="black", s=50, label="mean")
    flat.set(xlabel="x (pixels)", ylabel="y (pixels)", aspect="equal")
    flat.invert_yaxis()
    flat.legend(loc="upper right", fontsize=9, framealpha=0.85)
    figure.colorbar(filled, ax=flat, label=RHO, ticks=[0, 0.5, 1], shrink=0.75)
    return figure


def _time_per_frame(series: Series, name: str) -> Figure:
    from matplotlib.ticker import LogLocator

    figure = _figure(3.2)
    axes = figure.add_subplot()
    _plain(axes, "Running time", "frame", "milliseconds per frame")
    for label, seconds, color in (
        (name, series.seconds[1:], BLUE),
        ("mean shift", series.shift_seconds[1:], VERMILION),
    ):
        if np.isfinite(seconds).any():
            median = float(np.nanmedian(seconds)) * 1000
            label = f"{label}, median {median:.2g} ms"
            axes.plot(series.frame[1:], seconds * 1000, color=color, linewidth=1, label=label)
            axes.axhline(median, color=color, linewidth=1, linestyle="--")
    axes.set_yscale("log", subs=[])
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter("{x:g}")
    _legend(axes)
    return figure


def _appearing(series: Series, samples: int, fraction: float) -> Figure:
    figure = _figure(3.2)
    axes = figure.add_subplot()
    _plain(axes, "Appearance rule", "frame", f"samples that fulfill it, of {samples}")
    _shade(axes, series)
    axes.step(series.frame, series.appearing, where="mid", color=BLUE, linewidth=1.2)
    axes.axhline(
        fraction * samples, color=VERMILION, linewidth=1.2, linestyle="--",
        label=f"threshold f N = {fraction * samples:g}",
    )  # fmt: skip
    axes.set_ylim(0, samples * 1.03)
    _legend(axes)
    return figure


def _size_and_displacement(series: Series) -> Figure:
    figure = _figure(4.8)
    upper, lower = figure.subplots(2, 1, sharex=True)
    _plain(upper, "Size of the region", "", "half-axes (pixels)")
    _plain(lower, "Displacement", "frame", "pixels since the last frame")
    # Where the target is not tracked, the estimate is a guess and says nothing about it.
    tracked = np.where(series.tracking > 0, 1.0, np.nan)
    for axes in (upper, lower):
        _shade(axes, series)
    for label, values, color in (("a", series.a, BLUE), ("b", series.b, VERMILION)):
        upper.plot(series.frame, values * tracked, color=color, linewidth=1.4, label=label)
    upper.set_ylim(bottom=0)
    for label, values, color in (("along x", series.x, BLUE), ("along y", series.y, VERMILION)):
        moved = np.diff(values * tracked, prepend=np.nan)
        lower.plot(series.frame, moved, color=color, linewidth=1, label=label)
    for axes in (upper, lower):
        _legend(axes)
    return figure
