"""The public names of this package."""

from .annotated_video import ScenePainter as ScenePainter, TargetPainter as TargetPainter
from .app import program as program
from .entry import call as call, main as main, run as run
from .exit_codes import DONE as DONE, NOT_FOUND as NOT_FOUND, PARTIAL as PARTIAL
from .frame_loop import Moment as Moment, Sink as Sink, TerminalBar as TerminalBar
from .input_checks import (
    check_counts as check_counts,
    check_not_source as check_not_source,
    default_output as default_output,
    numbers_of as numbers_of,
    prepared_folder as prepared_folder,
)
from .option_groups import (
    FileName as FileName,
    OwnCode as OwnCode,
    Whole as Whole,
    options as options,
)
from .streams import log as log
