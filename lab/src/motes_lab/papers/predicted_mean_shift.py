"""Nummiaro et al., section VI: mean shift from the start that a Kalman filter predicts.

It is a tracker for `motes-lab` by the name `motes_lab.papers.predicted_mean_shift:tracker`. After
Comaniciu and Ramesh, Mean shift and optimal prediction for efficient object tracking, ICIP 2000.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from motes import Box, Frame, Track
from motes.core import Bytes, Floats, as_ellipse
from motes.sot import presets

ACCELERATION = 0.5
"""Standard deviation of the velocity's change from frame to frame, in mean half-axes of the first
region. The papers give none; with more of it the prediction follows the last places more."""
MEASUREMENT = 0.2
"""Standard deviation of the error of a place that mean shift finds, in the same unit."""
MOVE = np.array([[1.0, 1.0], [0.0, 1.0]])
"""How a frame changes position and velocity."""
NOISE = np.array([[1 / 4, 1 / 2], [1 / 2, 1.0]]) * ACCELERATION**2
"""What an acceleration of `ACCELERATION` during a frame adds to their covariance."""


class Motion:
    """Constant-velocity Kalman filter for a center; x and y share one covariance.

    Parameters
    ----------
    center
        The first center (2,), in pixels.
    unit
        The mean half-axis of the first region, in pixels.
    """

    def __init__(self, center: Floats, unit: float) -> None:
        self.mean = np.array([center, np.zeros(2)])
        """(2, 2): the position and the velocity, in pixels and pixels a frame."""
        self.covariance = np.diag([0.0, unit**2])
        """(2, 2), of both; the same for x and y."""
        self._unit = unit

    def predict(self) -> Floats:
        """Go on by a frame; return the center (2,) there."""
        self.mean = MOVE @ self.mean
        self.covariance = MOVE @ self.covariance @ MOVE.T + NOISE * self._unit**2
        center: Floats = self.mean[0]
        return center

    def update(self, center: Floats) -> None:
        """Take the center (2,) that was found."""
        variance = self.covariance[0, 0] + (MEASUREMENT * self._unit) ** 2
        gain = self.covariance[:, 0] / variance
        self.mean = self.mean + np.outer(gain, center - self.mean[0])
        self.covariance = self.covariance - np.outer(gain, self.covariance[0])


class PredictedMeanShift:
    """The preset `mean_shift`, which begins each frame where its motion predicts the target."""

    def init(self, image: Bytes, box: Box) -> Track:
        """Start on the object in a box."""
        region = as_ellipse(box)
        self._rng, self._index = np.random.default_rng(0), 0  # it draws no numbers
        self._state, info = presets.MEAN_SHIFT.init(self._rng, Frame(0, 0.0, image), region)
        self._motion = Motion(np.array(region[:2]), float(np.sqrt(region.a * region.b)))
        return info.track

    def update(self, image: Bytes) -> Track:
        """Follow it into the next frame."""
        self._index += 1
        frame = Frame(self._index, float(self._index), image)
        x, y = np.clip(self._motion.predict(), 0, [frame.width - 1, frame.height - 1]).tolist()
        start = replace(self._state, ellipse=self._state.ellipse._replace(x=x, y=y))
        self._state, info = presets.MEAN_SHIFT.step(self._rng, start, frame)
        self._motion.update(np.array(info.track.ellipse[:2]))
        return info.track


def tracker() -> PredictedMeanShift:
    """Return a tracker for one start."""
    return PredictedMeanShift()
