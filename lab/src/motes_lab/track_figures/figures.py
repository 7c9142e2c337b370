"""The figures of the papers, of what was recorded of a run, and the names of their files."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from motes import Frame, MeanShift, StepInfo, TrackerConfig
from motes.core import Floats
from motes.cues import Orientation
from motes_lab.track_figures import charts
from motes_lab.track_figures.charts import SURFACE_STEPS, RhoSurface, Series

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RHO_SURFACE, TIME, APPEARING = "rho_surface.png", "time_per_frame.png", "appearing.png"
SIZE = "size_and_displacement.png"
FIGURES = (RHO_SURFACE, TIME, APPEARING, SIZE)
"""The files of the figures; `APPEARING` only for trackers with the appearance rule."""
CUE_WEIGHTS, ORIENTATION = "cue_weights.png", "orientation_histograms.png"
"""The files for a tracker with several cues, and for one with the cue `orientation`."""


def surface_of(config: TrackerConfig, frame: Frame, info: StepInfo) -> RhoSurface:
    """Return the surface of figure 3, over all cues: the estimate's ellipse, moved around it."""
    ellipse, n = info.track.ellipse, SURFACE_STEPS
    reach = max(ellipse.box[2:])
    x = np.linspace(max(ellipse.x - reach, 0), min(ellipse.x + reach, frame.width - 1), n)
    y = np.linspace(max(ellipse.y - reach, 0), min(ellipse.y + reach, frame.height - 1), n)
    moved = np.tile(np.array(ellipse), (n, n, 1))
    moved[..., 0], moved[..., 1] = np.meshgrid(x, y)
    rho = np.zeros(n * n)
    for name, cue in config.cues.items():
        distances = cue.distances(info.models[name], frame, moved.reshape(-1, 5))
        rho += info.cue_weights[name] * (1 - distances**2)
    mean = np.array(ellipse[:2])
    return RhoSurface(frame.index, x, y, rho.reshape(n, n), info.ellipses[:, :2], mean)


def orientations_of(
    cue: Orientation, frame: Frame, info: StepInfo
) -> tuple[Floats, Floats, Floats]:
    """Return FOH, ROH and model of figure 1: of the estimate's region, turned with it."""
    spectrum, rotated = (
        replace(cue, form=form).learn(frame, info.track.ellipse).histogram
        for form in ("fourier", "rotated")
    )
    return spectrum, rotated, info.models["orientation"].histogram


def files_of(config: TrackerConfig) -> list[str]:
    """Return the names of the files that the figures of a tracker may have."""
    names = [name for name in FIGURES if config.presence is not None or name != APPEARING]
    names += [CUE_WEIGHTS] * (len(config.cues) > 1) + [ORIENTATION] * ("orientation" in config.cues)
    return names


def figures_of(
    config: TrackerConfig, series: Series, samples: int, kept: tuple[Frame, StepInfo] | None
) -> Iterator[tuple[str, Figure]]:
    """Draw the figures of a run; yield each with the name of its file, which is in `files_of`.

    Figures of a single frame are left out if no frame was tracked, running times if there is only
    one frame, weights of cues that never change, and all if no frame was recorded.

    Parameters
    ----------
    config
        The tracker.
    series
        The numbers of all frames.
    samples
        The number of particles.
    kept
        The frame of the figures that show a single one; None if none was tracked.
    """
    if not series.frame.size:
        return
    if kept is not None:
        yield RHO_SURFACE, charts.rho_surface(surface_of(config, *kept))
    if series.frame.size > 1:
        name = "mean shift" if isinstance(config, MeanShift) else "particle filter"
        yield TIME, charts.time_per_frame(series, name)
    if config.presence is not None:
        yield APPEARING, charts.appearing(series, samples, config.presence.fraction)
    yield SIZE, charts.size_and_displacement(series)
    if np.ptp(series.cue_weights, axis=0).any():
        yield CUE_WEIGHTS, charts.cue_weights(series, list(config.cues))
    cue = config.cues.get("orientation")
    if kept is not None and isinstance(cue, Orientation):
        frame, info = kept
        histograms = orientations_of(cue, frame, info)
        yield ORIENTATION, charts.orientation_histograms(frame, info.track.ellipse, *histograms)
