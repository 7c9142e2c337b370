"""The outputs of `motes track` beside the rows: overlay, figures, masks and the live picture."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from motes.cli.annotated_video import AnnotatedVideo, painted_target
from motes.cli.input_checks import stem_of
from motes.cli.moment import Moment, Sink
from motes.cli.track_loop import Companion
from motes.cli.track_options import TrackOutputs
from motes.cli.track_units import MotionFigures, motion_names
from motes.core.errors import FormatError

if TYPE_CHECKING:
    from motes.mot.analytics.real_units import RealUnits
    from motes.sot.presets import TrackerConfig
    from motes.video.film import Film
    from motes.video.sources import Source


def pictures_outputs(
    film: Source | Film,
    source: str,
    output: str | None,
    outputs: TrackOutputs,
    units: RealUnits | None,
    *,
    config: TrackerConfig | None = None,
    stride: int = 1,
) -> list[Sink]:
    """Return the outputs beside the rows: overlay, figures, masks and the live picture.

    Parameters
    ----------
    film, source
        The film, and its name on the command line.
    output
        The file of the rows, or -; None without rows.
    outputs
        The options.
    units
        How pixels become metres, for the figures of the motion; None for pixels.
    config
        The tracker, for the figures of the papers.
    stride
        Every n-th frame of the film is used.

    Raises
    ------
    ConfigError
        If a name has a wrong ending.
    FormatError
        If a file exists and must not be overwritten, or cannot be made.
    """
    opened: list[Sink] = []
    anew = outputs.overwrite or outputs.resume
    if outputs.overlay is not None:
        unit = None if units is None else "m"
        opened.append(
            AnnotatedVideo(outputs.overlay, film, stride, painted_target(unit), overwrite=anew)
        )
    if names := motion_names(outputs.figures):
        stem = Path(stem_of(source) if output in (None, "-") else str(output)).with_suffix("")
        unit = "pixels" if units is None else "m"
        opened.append(MotionFigures(stem, names, unit, overwrite=anew))
    elif outputs.figures is not None and config is not None:
        opened.append(Figures(Path(outputs.figures), config, overwrite=anew))
    if outputs.masks is not None:
        from motes.cli.track_masks import masks_output

        masks = masks_output(
            outputs.masks, film, outputs.label, overwrite=anew, resume=outputs.resume
        )
        opened.append(masks)
    if outputs.show:
        from motes.cli.show import Show

        opened.append(Show(painted_target()))
    return opened


class Figures(Sink):
    """The figures of the papers, drawn at the end, also after an interruption."""

    def __init__(self, folder: Path, config: TrackerConfig, *, overwrite: bool) -> None:
        from motes.output.figures import Recorder

        if folder.exists() and not folder.is_dir():
            raise FormatError(f"{folder} is not a folder; choose another name.")
        place = next(each for each in (folder, *folder.absolute().parents) if each.exists())
        if not os.access(place, os.W_OK):
            raise FormatError(f"{folder} cannot be written: no permission; choose another folder.")
        self._recorder = Recorder(config)
        there = [name for name in self._recorder.files if (folder / name).exists()]
        if there and not overwrite:
            raise FormatError(
                f"{folder / there[0]} exists; choose another folder, or overwrite it (--overwrite)."
            )
        self._folder = folder
        self._companion = Companion()
        self._files: list[Path] = []

    def write(self, moment: Moment) -> None:
        """Record a frame."""
        if moment.info is not None:
            seconds = self._companion.seconds(moment)
            self._recorder.add(moment.frame, moment.info, moment.seconds, seconds)

    @property
    def result(self) -> str | None:
        """The files."""
        return f"{len(self._files)} figures in {self._folder}" if self._files else None

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None or issubclass(kind, KeyboardInterrupt):
            self._files = self._recorder.save(self._folder)
