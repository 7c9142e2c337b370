"""The public names of this package."""

from .painters import ScenePainter as ScenePainter
from .painters import TargetPainter as TargetPainter
