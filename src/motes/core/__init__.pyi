"""The public names of this package."""

from . import interrupts as interrupts
from .addresses import parts_of as parts_of, without_password as without_password
from .callables import explain as explain, import_callable as import_callable, optional as optional
from .config import from_toml as from_toml
from .config_keys import words as words
from .errors import counted as counted
from .files import (
    PARTIAL as PARTIAL,
    leftovers as leftovers,
    read_text as read_text,
    used_alone as used_alone,
    write_whole as write_whole,
    writing as writing,
)
from .frame import FRAME_INTERVAL as FRAME_INTERVAL
from .geometry import (
    as_ellipse as as_ellipse,
    as_region as as_region,
    iou as iou,
    region_within as region_within,
)
from .labels import check_label as check_label, guarded as guarded
from .platforms import blocked_signals as blocked_signals
from .types import Floats as Floats, Singles as Singles
from .worker import (
    Answer as Answer,
    Done as Done,
    Failed as Failed,
    Part as Part,
    Worker as Worker,
    WorkerLine as WorkerLine,
    environment as environment,
    thread_limits as thread_limits,
)
