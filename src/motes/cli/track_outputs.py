"""The outputs of `motes track` beside the rows: overlay, figures, masks and the live picture."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

from motes.cli.annotated_video import drawn, painted_target
from motes.cli.input_checks import prepare_folder, stem_of
from motes.cli.moment import Moment, Sink
from motes.cli.track_options import TrackRequest
from motes.cli.track_units import MotionFigures, motion_names
from motes.core.track import Status
from motes.sot.tracker import Tracker

if TYPE_CHECKING:
    from motes.sot.presets import TrackerConfig
    from motes.video.film import Film
    from motes.video.sources import Source


def pictures_outputs(
    asked: TrackRequest, film: Source | Film, config: TrackerConfig | None = None
) -> list[Sink]:
    """Return the outputs beside the rows: overlay, figures, masks and the live picture.

    Parameters
    ----------
    asked
        What is to be done.
    film
        The film.
    config
        The tracker, for the figures of the papers.

    Raises
    ------
    ConfigError
        If a name has a wrong ending.
    FormatError
        If a file exists and must not be overwritten, or cannot be made.
    """
    outputs, output = asked.outputs, asked.output
    anew = outputs.overwrite or outputs.resume
    unit = None if asked.units is None else "m"
    opened = drawn(outputs, film, asked.frames.stride, lambda: painted_target(unit), overwrite=anew)
    if names := motion_names(outputs.figures):
        stem = stem_of(asked.source) if output in (None, "-") else str(output)
        path = Path(stem).with_suffix("")
        opened.append(MotionFigures(path, names, unit or "pixels", overwrite=anew))
    elif outputs.figures is not None and config is not None:
        opened.append(Figures(Path(outputs.figures), config, overwrite=anew))
    if outputs.masks is not None:
        from motes.cli.track_masks import masks_output

        masks = masks_output(
            outputs.masks, film, outputs.label, overwrite=anew, resume=outputs.resume
        )
        opened.append(masks)
    return opened


class Figures(Sink):
    """The figures of the papers, drawn at the end, also after an interruption."""

    def __init__(self, folder: Path, config: TrackerConfig, *, overwrite: bool) -> None:
        from motes.output.figures import Recorder

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
