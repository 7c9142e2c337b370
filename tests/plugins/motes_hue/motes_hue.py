"""A cue of another package: histograms of hue alone, whatever the brightness."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from msgspec import Meta

from motes import Frame
from motes.core import Floats
from motes.cues import HistogramCue, sunflower, visible


class Hue(HistogramCue, frozen=True):
    """Histogram of hue, weighted by saturation."""

    bins: Annotated[int, Meta(ge=2, le=360)] = 24
    """Number of bins around the circle of hues."""
    points: Annotated[int, Meta(ge=8, le=4096)] = 256
    """How many pixels of an ellipse are read."""

    def histograms(self, frame: Frame, ellipses: Floats) -> Floats:
        """Return the histogram of each ellipse (N, 5), shape (N, bins)."""
        rows = np.flatnonzero(visible(frame, ellipses))
        x, y, a, b, theta = ellipses[rows].T[..., None]
        u, v = sunflower(self.points)
        column = np.rint(x + a * u * np.cos(theta) - b * v * np.sin(theta)).astype(np.int64)
        row = np.rint(y + a * u * np.sin(theta) + b * v * np.cos(theta)).astype(np.int64)
        inside = (column >= 0) & (column < frame.width) & (row >= 0) & (row < frame.height)
        red, green, blue = np.moveaxis(
            frame.pixels[np.where(inside, row, 0), np.where(inside, column, 0)].astype(float), 2, 0
        )
        # Hue as an angle in the plane of colors, and how far the color is from gray.
        across, up = red - (green + blue) / 2, np.sqrt(0.75) * (green - blue)
        hue = np.floor((np.arctan2(up, across) / (2 * np.pi) % 1) * self.bins).astype(np.int64)
        weights = (np.hypot(across, up) + 1) * inside
        histograms = np.zeros((len(ellipses), self.bins))
        np.add.at(histograms, (rows[:, None], hue % self.bins), weights)
        sums = histograms.sum(axis=1, keepdims=True)
        out: Floats = np.divide(histograms, sums, out=np.zeros_like(histograms), where=sums > 0)
        return out
