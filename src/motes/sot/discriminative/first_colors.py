"""The colors of the target's first region, as an expert (Nummiaro et al., section III)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motes.core.config import NonNegative
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.cues.color import Color, ColorModel
from motes.sot.discriminative.expert import Expert

NEUTRAL_DISTANCE = 0.4
"""A distance that speaks neither for a place nor against it."""
LARGEST_DISTANCE = 0.6
"""Color histograms farther apart than this are all equally unlike: the light has changed."""


@dataclass(frozen=True, slots=True, eq=False)
class ColorSight:
    """A frame, and the histogram that its places are compared with."""

    model: ColorModel
    frame: Frame


class FirstColors(Color, Expert, frozen=True, dict=True):
    """The Bhattacharyya distance of a place's colors to those of the first region; never learns.

    The other fields are those of the cue `color`.

    Attributes
    ----------
    weight
        Log odds against a place at a distance of 1; see `Evidence`. With 0 the expert is not
        asked.
    """

    weight: NonNegative = 3.75

    def look(self, model: ColorModel, frame: Frame, place: Ellipse, shift: Floats) -> ColorSight:
        """Return the frame with the histogram."""
        return ColorSight(model, frame)

    def log_odds(self, sight: ColorSight, place: Ellipse) -> float:
        """Return by how much the colors speak for a place."""
        [distance] = self.distances(sight.model, sight.frame, np.array([place]))
        return self.weight * (NEUTRAL_DISTANCE - min(float(distance), LARGEST_DISTANCE))
