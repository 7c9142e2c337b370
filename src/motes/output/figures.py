"""Recording of a run for the figures of the papers, and the files of these figures."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from motes.core.frame import Frame
from motes.core.optional import optional
from motes.core.track import Status
from motes.core.types import Floats
from motes.cues.structure_tensor import Orientation
from motes.output import charts
from motes.output.charts import SURFACE_STEPS, RhoSurface, Series
from motes.sot.mean_shift import MeanShift
from motes.sot.presets import TrackerConfig
from motes.sot.step_info import StepInfo

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


class Recorder:
    """Collects the data for the figures of the papers, and draws them.

    These are figures 3, 7, 12 and 14 of Nummiaro et al.; with weights of cues that change also
    figure 3 of Maggio et al., and with orientation their figure 1. About a dozen numbers are kept
    of each frame. Only one whole frame is kept, for the figures that show a single frame: the last
    one whose number among the tracked frames, counted from 1, is a power of two. It lies in the
    second half of the tracked frames. Neither the length of the run nor the quality of the track is
    needed to choose it.

    Parameters
    ----------
    config
        Configuration of the tracker that is recorded.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    """

    def __init__(self, config: TrackerConfig) -> None:
        optional("matplotlib", "Drawing figures needs matplotlib", "motes[report]")
        self._config = config
        self._numbers = array("d")
        self._tracked = self._samples = 0
        self._kept: tuple[Frame, StepInfo] | None = None

    def add(
        self, frame: Frame, info: StepInfo, seconds: float, mean_shift_seconds: float | None
    ) -> None:
        """Record a frame.

        Parameters
        ----------
        frame, info
            The frame, and the tracker's step information for it.
        seconds
            The tracker's running time.
        mean_shift_seconds
            The running time of mean shift for the same frame; None if it was not run.
        """
        track, tracking = info.track, info.track.status is Status.TRACKING
        shift = np.nan if mean_shift_seconds is None else mean_shift_seconds
        supporting = np.nan if info.n_supporting is None else info.n_supporting
        self._samples = self._samples or len(info.weights)  # a budget may change it later
        self._numbers.extend(
            (frame.index, *track.ellipse[:4], supporting, tracking, seconds, shift)
        )
        self._numbers.extend(info.cue_weights.values())
        self._tracked += tracking
        if tracking and self._tracked.bit_count() == 1:
            self._kept = frame, info

    @property
    def series(self) -> Series:
        """The numbers recorded so far."""
        single = len(Series._fields) - 1
        table = np.array(self._numbers).reshape(-1, single + len(self._config.cues))
        return Series(*[*table.T[:single], table[:, single:]])

    @property
    def files(self) -> tuple[str, ...]:
        """The names of the files that `figures` may be for."""
        cues = self._config.cues
        more = (CUE_WEIGHTS,) * (len(cues) > 1) + (ORIENTATION,) * ("orientation" in cues)
        rule = self._config.presence is not None
        return tuple(name for name in FIGURES if rule or name != APPEARING) + more

    def surface(self) -> RhoSurface | None:
        """Return the surface of figure 3 in the kept frame; None if no frame was tracked."""
        if self._kept is None:
            return None
        return surface_of(self._config, *self._kept)

    def edges(self) -> tuple[Floats, Floats, Floats] | None:
        """Return FOH, ROH and model of figure 1 in the kept frame; None without frame or cue."""
        cue = self._config.cues.get("orientation")
        if self._kept is None or not isinstance(cue, Orientation):
            return None
        frame, info = self._kept
        spectrum, rotated = (
            replace(cue, form=form).learn(frame, info.track.ellipse).histogram
            for form in ("fourier", "rotated")
        )
        return spectrum, rotated, info.models["orientation"].histogram

    def figures(self) -> Iterator[tuple[str, Figure]]:
        """Draw the figures; yield each with the name of its file, which is among `files`.

        Figures of a single frame are left out if no frame was tracked, running times if there is
        only one frame, weights of cues that never change, and all if no frame was recorded.
        """
        series, surface, edges = self.series, self.surface(), self.edges()
        if not series.frame.size:
            return
        if surface is not None:
            yield RHO_SURFACE, charts.rho_surface(surface)
        if series.frame.size > 1:
            yield TIME, charts.time_per_frame(series, self._name)
        if (rule := self._config.presence) is not None:
            yield APPEARING, charts.appearing(series, self._samples, rule.fraction)
        yield SIZE, charts.size_and_displacement(series)
        if np.ptp(series.cue_weights, axis=0).any():
            yield CUE_WEIGHTS, charts.cue_weights(series, list(self._config.cues))
        if self._kept is not None and edges is not None:
            frame, info = self._kept
            yield ORIENTATION, charts.orientation_histograms(frame, info.track.ellipse, *edges)

    @property
    def _name(self) -> str:
        return "mean shift" if isinstance(self._config, MeanShift) else "particle filter"
