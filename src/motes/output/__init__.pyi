"""The public names of this package."""

from .painters import ScenePainter as ScenePainter, TargetPainter as TargetPainter
