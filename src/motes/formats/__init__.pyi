"""The public names of this package."""

from . import parquet as parquet
from . import registry as registry
from .mot import read_boxes as read_boxes
from .recording import LABEL as LABEL
from .recording import FilmFacts as FilmFacts
from .recording import Recording as Recording
from .regions import ABSENT as ABSENT
from .regions import MAX_FRAME as MAX_FRAME
from .regions import TruthRegion as TruthRegion
from .regions import read_regions as read_regions
from .registry import Format as Format
from .truth import absences as absences
from .truth import kind_of as kind_of
