"""The public names of this package."""

from .beetle import Target as Target
from .clips import (
    Clip as Clip,
    Truth as Truth,
    crossing as crossing,
    crowd as crowd,
    demo as demo,
    growing as growing,
    jumping as jumping,
    occluded as occluded,
    rolling as rolling,
    still as still,
    turning as turning,
)
from .pitch import Pitch as Pitch
from .street import Street as Street
