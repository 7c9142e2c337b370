"""The sink of `motes track --figures`: it records a run, and draws its figures at the end."""

from __future__ import annotations

import io
import math
import time
from array import array
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Self

import numpy as np

from motes import Frame, Status, StepInfo, Tracker, TrackerConfig
from motes.cli import Moment, Sink, prepared_folder
from motes.core import write_whole, writing
from motes_lab.track_figures.charts import Series
from motes_lab.track_figures.figures import figures_of, files_of

DPI = 110
"""Dots per inch of the figures."""


class TrackFigures(Sink):
    """The figures of the papers, in a folder.

    These are figures 3, 7, 12 and 14 of Nummiaro et al.; with weights of cues that change also
    figure 3 of Maggio et al., and with orientation their figure 1. About a dozen numbers are kept
    of each frame. Only one whole frame is kept, for the figures that show a single frame: the last
    one whose number among the tracked frames, counted from 1, is a power of two. It lies in the
    second half of the tracked frames. Neither the length of the run nor the quality of the track is
    needed to choose it.
    """

    def __init__(self, folder: Path, config: TrackerConfig, *, overwrite: bool) -> None:
        self._folder, self._config = folder, config
        self._prepared = prepared_folder(folder, files_of(config), overwrite)
        self._written = 0
        self._numbers = array("d")
        self._tracked = self._samples = 0
        self._kept: tuple[Frame, StepInfo] | None = None
        self._companion, self._accompanied = Tracker("mean_shift"), False

    def write(self, moment: Moment) -> None:
        """Record a frame."""
        frame, info = moment.frame, moment.info
        if info is None:
            return
        tracking = info.track.status is Status.TRACKING
        supporting = math.nan if info.n_supporting is None else info.n_supporting
        seconds = moment.seconds, self._compared(moment)
        self._samples = self._samples or len(info.weights)  # a budget may change it later
        self._numbers.extend((frame.index, *info.track.ellipse[:4], supporting, tracking, *seconds))
        self._numbers.extend(info.cue_weights.values())
        self._tracked += tracking
        if tracking and self._tracked.bit_count() == 1:
            self._kept = frame, info

    def _compared(self, moment: Moment) -> float:
        """Return the time of a mean-shift tracker beside the one that runs, in seconds.

        It starts on the frame in which the target is first tracked, and has no time, NaN, before.
        """
        if self._accompanied:
            clock = time.perf_counter()
            self._companion.update(moment.frame)
            return time.perf_counter() - clock
        if moment.target.status is Status.TRACKING:
            self._companion.init(moment.frame, moment.target.box)
            self._accompanied = True
        return math.nan

    @property
    def series(self) -> Series:
        """The numbers recorded so far."""
        single = len(Series._fields) - 1
        table = np.array(self._numbers).reshape(-1, single + len(self._config.cues))
        return Series(*[*table.T[:single], table[:, single:]])

    @property
    def result(self) -> str | None:
        """The number of files, and their folder."""
        return f"{self._written} figures in {self._folder}" if self._written else None

    def __enter__(self) -> Self:
        self._prepared.__enter__()
        return self

    def __exit__(self, *exception: Any) -> None:
        """Draw the figures, also of an interrupted run."""
        with ExitStack() as stack:
            stack.push(self._prepared)
            figures = figures_of(self._config, self.series, self._samples, self._kept)
            for name, figure in figures:
                data = io.BytesIO()
                figure.savefig(data, dpi=DPI)
                with writing(self._folder / name):
                    write_whole(self._folder / name, data.getvalue())
                self._written += 1
