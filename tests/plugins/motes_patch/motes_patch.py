"""An expert of another package: the gray values of the first region, compared point by point."""

from __future__ import annotations

from typing import NamedTuple

import msgspec
import numpy as np

from motes import Config, Ellipse, Frame
from motes.core import Floats
from motes.filtering import Expert


class Values(msgspec.Struct, frozen=True, eq=False):
    """Gray values (N,) at points of the first region, with mean 0 and length 1."""

    values: Floats


class Sight(NamedTuple):
    """A frame, and what its places are compared with."""

    known: Values
    frame: Frame


class Patch(Expert, Config, frozen=True):
    """Correlation of a place's gray values with those of the first region."""

    weight: float = 2.0
    """Log odds for a place that looks the same."""

    def learn(self, frame: Frame, box: Ellipse) -> Values:
        """Return the values in the region."""
        return Values(_values(frame, box))

    def look(self, model: Values, frame: Frame, place: Ellipse) -> Sight:
        """Return the frame: any of its places can be compared."""
        return Sight(model, frame)

    def log_odds(self, sight: Sight, place: Ellipse) -> float:
        """Return by how much the gray values speak for a place."""
        return self.weight * float(sight.known.values @ _values(sight.frame, place))


def _values(frame: Frame, place: Ellipse) -> Floats:
    """Return the normalized gray values at a grid of 12 x 12 points in the box of an ellipse."""
    x, y = np.meshgrid(*(np.linspace(-1, 1, 12) * half for half in place[2:4]))
    column = np.clip(np.rint(place.x + x), 0, frame.width - 1).astype(int)
    row = np.clip(np.rint(place.y + y), 0, frame.height - 1).astype(int)
    gray = frame.pixels[row, column].mean(axis=2).ravel()
    out: Floats = (gray - gray.mean()) / max(float(np.linalg.norm(gray - gray.mean())), 1.0)
    return out
