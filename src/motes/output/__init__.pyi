"""The public names of this package."""

from .painters import TRAIL as TRAIL
from .painters import ScenePainter as ScenePainter
