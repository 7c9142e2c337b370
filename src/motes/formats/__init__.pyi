"""The public names of this package."""

from . import parquet as parquet, registry as registry
from .mot import read_boxes as read_boxes
from .recording import LABEL as LABEL, FilmFacts as FilmFacts, Recording as Recording
from .registry import Format as Format
from .truth import absences as absences, kind_of as kind_of
from .truth_regions import (
    ABSENT as ABSENT,
    MAX_FRAME as MAX_FRAME,
    TruthRegion as TruthRegion,
    read_regions as read_regions,
)
