"""The outputs of `motes track`, as options.

Annotations are evaluated here: the parser would look for their names in the module of a subclass.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from motes.cli.options import FLAG, OUTPUT, OutputOptions


@Parameter(name="*", group=OUTPUT)
@dataclass(frozen=True, kw_only=True)
class TrackOutputs(OutputOptions):
    """The outputs of `motes track`."""

    figures: Annotated[
        str | None,
        Parameter(
            help="Folder for the figures of the papers; or the names of figures of the motion, "
            "path,speed,size, which become NAME.path.pdf and so on, beside the rows NAME.csv."
        ),
    ] = None
    masks: Annotated[
        Path | None,
        Parameter(
            help="Pixels of the target, as far as its colors differ from those around it: a folder "
            "for PNG files, or a .json document of COCO."
        ),
    ] = None
    resume: Annotated[
        bool,
        FLAG,
        Parameter(
            help="Continue the rows of an interrupted run. Give the same source, options and seed. "
            "The run is repeated at its usual speed, with keyframes only what is missing: existing "
            "rows are kept, overlay, masks and figures are made anew."
        ),
    ] = False
