"""The public names of this package."""

from .assignment import assign as assign
from .boxes import intersection_over_first as intersection_over_first
from .expected import Expected as Expected
from .look import Look as Look
from .pipeline_config import WatchConfig as WatchConfig
from .pipeline_config import check_code as check_code
from .pipeline_config import named_detector as named_detector
