"""Figures of the papers, drawn while `motes track` runs."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

from motes.cli.input_checks import prepare_folder
from motes.cli.moment import Moment, Sink
from motes.core.track import Status
from motes.output.figures import Recorder
from motes.sot.tracker import Tracker

if TYPE_CHECKING:
    from motes.sot.presets import TrackerConfig


class Figures(Sink):
    """The figures of the papers, drawn at the end, also after an interruption."""

    def __init__(self, folder: Path, config: TrackerConfig, *, overwrite: bool) -> None:
        self._recorder = Recorder(config)
        prepare_folder(folder, self._recorder.files, overwrite)
        self._folder = folder
        self._companion = Tracker("mean_shift")
        self._accompanied = False
        self._files: list[Path] = []

    def write(self, moment: Moment) -> None:
        """Record a frame."""
        if moment.info is not None:
            self._recorder.add(moment.frame, moment.info, moment.seconds, self._compared(moment))

    def _compared(self, moment: Moment) -> float | None:
        """Return the time of a mean-shift tracker beside the one that runs, in seconds.

        It starts on the frame in which the target is first tracked, and has no time before.
        """
        if self._accompanied:
            clock = time.perf_counter()
            self._companion.update(moment.frame)
            return time.perf_counter() - clock
        if moment.track is not None and moment.status is Status.TRACKING:
            self._companion.init(moment.frame, moment.track.box)
            self._accompanied = True
        return None

    @property
    def result(self) -> str | None:
        """The files."""
        return f"{len(self._files)} figures in {self._folder}" if self._files else None

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None or issubclass(kind, KeyboardInterrupt):
            self._files = self._recorder.save(self._folder)
