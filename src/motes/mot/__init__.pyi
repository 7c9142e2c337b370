"""The public names of this package."""

from .analytics.real_units import GroundMotion as GroundMotion, RealUnits as RealUnits
from .association import assign as assign
from .expected import Expected as Expected
from .look import Look as Look
from .overlaps import intersection_over_first as intersection_over_first
from .scene_config import WatchConfig as WatchConfig, check_code as check_code
