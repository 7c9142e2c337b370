"""The public names of this package."""

from .base import (
    AdaptableCue as AdaptableCue,
    Cue as Cue,
    HistogramCue as HistogramCue,
    bhattacharyya as bhattacharyya,
    visible as visible,
)
from .color import Color as Color, ColorModel as ColorModel
from .sampling import sunflower as sunflower
from .structure_tensor import Orientation as Orientation
