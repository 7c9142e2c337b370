"""The public names of this package."""

from .overlay import Draw as Draw
from .painters import TRAIL as TRAIL
from .painters import ScenePainter as ScenePainter
