"""The outputs of `motes track`, as options, and a request for a run.

Annotations are evaluated here: the parser would look for their names in the module of a subclass.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from motes.cli.options import FLAG, OUTPUT, FrameOptions, OutputOptions

if TYPE_CHECKING:
    from motes.mot.analytics.real_units import RealUnits
    from motes.sot.presets import TrackerConfig


@Parameter(name="*", group=OUTPUT)
@dataclass(frozen=True, kw_only=True)
class TrackOutputs(OutputOptions):
    """The outputs of `motes track`."""

    figures: Annotated[
        Path | None,
        Parameter(help="Folder for the figures of the papers; motes draw makes those of rows."),
    ] = None
    save_histogram: Annotated[
        Path | None,
        Parameter(
            help="Save the target's color histogram in the first frame to this JSON file, for "
            "--histogram with the same preset, and track nothing."
        ),
    ] = None
    resume: Annotated[
        bool,
        FLAG,
        Parameter(
            help="Continue the rows of an interrupted run. Give the same source, options and seed. "
            "The run is repeated up to the missing rows; overlay and figures are made again."
        ),
    ] = False


@dataclass(frozen=True)
class TrackRequest:
    """A film, its outputs, and how it is tracked.

    Attributes
    ----------
    source, frames
        The film and its frames, as they are given.
    output, outputs
        The file of the rows, - for standard output, or None without rows; and all options of
        outputs.
    config, seed, preset
        The tracker, and the name of its preset.
    units
        How pixels become metres; None for pixels.
    """

    source: str
    frames: FrameOptions
    output: str | None
    outputs: TrackOutputs
    config: "TrackerConfig"
    seed: int
    preset: str
    units: "RealUnits | None"
