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
        str | None,
        Parameter(
            help="Folder for the figures of the papers. Or path,speed,size, or some of these: "
            "figures of the motion, written beside the rows NAME.csv as NAME.path.pdf and so on."
        ),
    ] = None
    masks: Annotated[
        Path | None,
        Parameter(
            help="Masks of the target: its pixels, where their colors differ from those around "
            "it. A folder for PNG files, or a .json document of COCO."
        ),
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
            "Existing rows are kept; overlay, masks and figures are made again. With "
            "keyframes, only missing frames are tracked; otherwise the run is repeated up to the "
            "missing rows."
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
