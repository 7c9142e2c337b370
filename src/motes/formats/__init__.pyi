"""The public names of this package."""

from . import parquet as parquet, registry as registry
from .mot import read_boxes as read_boxes
from .recording import (
    LABEL as LABEL,
    MAX_FRAME as MAX_FRAME,
    FilmFacts as FilmFacts,
    Recording as Recording,
)
from .registry import Format as Format
from .truth import (
    ABSENT as ABSENT,
    TruthRegion as TruthRegion,
    absences as absences,
    kind_of as kind_of,
    read_regions as read_regions,
)
