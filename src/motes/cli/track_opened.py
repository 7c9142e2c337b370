"""The outputs that the options of `motes track` ask for, for one target."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from motes.cli.frame_loop import Sink
from motes.cli.input_checks import stem_of
from motes.cli.track_loop import Step
from motes.cli.track_options import TrackOutputs
from motes.cli.track_outputs import AsObjects, Figures, TrackOverlay, TrackRows
from motes.cli.track_units import MotionFigures, motion_names
from motes.cli.watch_outputs import format_of, objects_output, row_form
from motes.output.track_rows import GROUND

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
) -> list[Sink[Step]]:
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
    opened: list[Sink[Step]] = []
    anew = outputs.overwrite or outputs.resume
    if outputs.overlay is not None:
        unit = None if units is None else "m"
        opened.append(TrackOverlay(outputs.overlay, film, stride, overwrite=anew, unit=unit))
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
        from motes.cli.show import show_track

        opened.append(show_track())
    return opened


def rows_output(
    output: str,
    film: Source | Film,
    outputs: TrackOutputs,
    columns: Sequence[str],
    units: RealUnits | None,
    *,
    resume: bool = False,
) -> Sink[Step]:
    """Return the output of rows, or of another format.

    Parameters
    ----------
    output, film, outputs
        As in `pictures_outputs`.
    columns
        The columns of rows, without metres.
    units
        Whether there are metres.
    resume
        Whether an existing file is the beginning of these rows.
    """
    if rows := row_form(format_of(output, outputs.format)):
        return TrackRows(
            output, rows, overwrite=outputs.overwrite, resume=resume,
            columns=columns if units is None else (*columns, *GROUND),
        )  # fmt: skip
    return AsObjects(objects_output(output, film, outputs))
