"""A motion model and a detector of another package."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np
from msgspec import Meta

from motes import Box, Config, Detection, DetectorConfig, Ellipse, Frame
from motes.core import FRAME_INTERVAL, Floats
from motes.filtering import Motion


class Drift(Motion, Config, frozen=True, tag="drift"):
    """The target keeps its size, and drifts as in a stream. State: x, y, a, b, theta."""

    flow: float = 0.0
    """Motion to the right in 1/25 s, in pixels. With a larger value the target drifts faster."""
    noise: float = 0.3
    """Standard deviation of x and y after 1/25 s, as a share of the first region's mean half-axis.
    With a larger value the target drifts less straight."""

    def initial(self, ellipses: Floats) -> Floats:
        """Return the ellipses themselves, (N, 5)."""
        return ellipses.copy()

    def propagate(
        self, rng: np.random.Generator, states: Floats, dt: float, first: Ellipse
    ) -> Floats:
        """Return the states, moved and with noise."""
        steps = dt / FRAME_INTERVAL
        out = states.copy()
        out[:, 0] += steps * self.flow
        spread = self.noise * math.sqrt(first.a * first.b * steps)
        out[:, :2] += spread * rng.standard_normal((len(states), 2))
        out[:, 2:4] = np.maximum(out[:, 2:4], 1.0)
        return out

    def ellipses(self, states: Floats) -> Floats:
        """Return the states themselves."""
        return states


class BrightConfig(DetectorConfig, Config, frozen=True, tag="bright"):
    """Settings of a `BrightDetector`."""

    level: Annotated[float, Meta(ge=0, le=255)] = 150.0
    """Pixels of at least this brightness, 0 to 255, belong to the object."""

    def detector(self) -> BrightDetector:
        """Return a detector with these settings."""
        return BrightDetector(self)


class BrightDetector:
    """Finds one object: the box around all bright pixels."""

    def __init__(self, config: BrightConfig) -> None:
        self._level = config.level

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return the object in a frame, if there is one."""
        rows, columns = np.nonzero(frame.pixels.mean(axis=2) >= self._level)
        if not rows.size:
            return []
        left, top = int(columns.min()), int(rows.min())
        width, height = int(columns.max()) + 1 - left, int(rows.max()) + 1 - top
        return [Detection(Box(left, top, width, height), rows.size / (width * height))]
