"""The size and the turn of the target: what is measured in a frame, and what is reported.

The tracker keeps to steps of size and of turn, so that noise does not add up to a drift. Nothing of
what is reported goes back into the tracker, so the report may follow each measurement without
steps, by an alpha-beta filter: Kalata, The tracking index: a generalized parameter for alpha-beta
and alpha-beta-gamma target trackers, IEEE Transactions on Aerospace and Electronic Systems 1984.

A turn of the target shifts rings of colors around its center, whatever their radius. Their
cross-correlation, of all rings at once in the Fourier domain, has its maximum at the turn (De
Castro and Morandi, Registration of translated and rotated images using finite Fourier transforms,
PAMI 1987, in polar coordinates).
"""

from __future__ import annotations

import math
from typing import NamedTuple, Self

import msgspec
import numpy as np

from motes.core.frame import Frame
from motes.core.geometry import Angled, Ellipse
from motes.core.types import Floats
from motes.cues.color import borders
from motes.cues.correlation_filter import ScaleModel
from motes.cues.fourier import vertex
from motes.sot.discriminative.config import DiscriminativeConfig
from motes.sot.discriminative.localization import WindowEstimate
from motes.sot.discriminative.redetection import SYSTEMATIC, limits
from motes.sot.filtering.resampling import Weights

ALPHA = 0.5
"""Share of a measurement in the reported value."""
BETA = ALPHA**2 / (2 - ALPHA)
"""Share of a measurement's error in the growth, so that the filter is critically damped."""


class Trend(NamedTuple):
    """A reported value and its growth."""

    value: float = 0.0
    """Logarithm of the size relative to the first region's, or the angle since it in radians."""
    growth: float = 0.0
    """Change of the value from one frame to the next."""
    rough: bool = False
    """Whether the value is only that at which a lost target was found. The next measurement then
    replaces it."""

    def predicted(self) -> Self:
        """Return the value in the next frame if nothing is measured there."""
        return self._replace(value=self.value + self.growth)

    def measured(self, value: float) -> Self:
        """Return the value after a frame in which it was measured."""
        if self.rough:
            return type(self)(value)
        error = value - self.predicted().value
        return type(self)(self.predicted().value + ALPHA * error, self.growth + BETA * error)


BORDER_SHARPNESS = 50.0
"""The border term is exp(-BORDER_SHARPNESS · squared difference to the border's running mean)."""


def estimated(
    config: DiscriminativeConfig,
    rng: np.random.Generator,
    model: ScaleModel,
    border: Floats,
    frame: Frame,
    estimate: WindowEstimate,
) -> tuple[Ellipse, Floats]:
    """Return a window's estimate with its size, and particles of the size as factors, (N,).

    Each size is weighted by the scale filter, and by how close the posterior just inside and
    outside of its border is to its running mean `border`, (2,). The size is at the maximum
    between the compared ones.
    """
    sizes, low, high = config.scale, *limits(estimate.pose, frame)
    factors = np.clip(sizes.factors, low, high)
    spectra = sizes.spectra(model, frame, estimate.pose)
    pool = sizes.response(model, spectra).astype(np.float64)
    boxes = np.tile(estimate.box, (sizes.count, 1))
    boxes[:, 2:] *= factors[:, None]
    errors = borders(estimate.integral, boxes) - border
    pool += config.border_gain * np.exp(-BORDER_SHARPNESS * (errors**2).sum(axis=1))
    weights = Weights.from_log(pool / config.sigma)
    chosen = factors[SYSTEMATIC.ancestors(rng, weights, len(estimate.centers))]
    grown = min(max(sizes.between(pool), low), high)
    pose = estimate.pose._replace(a=grown * estimate.pose.a, b=grown * estimate.pose.b)
    return pose, chosen


POINTS = 64
"""Points of a ring."""
RADII = np.linspace(0.25, 1.0, 8)
"""Radii of the rings, in those of the circle with the target's area."""
ALIKE = 0.4
"""Least correlation of rings from which a turn is read."""
REACH = math.pi / 4
"""Largest turn that is looked for beside the predicted one, and beside the window's."""
_STEP = 2 * math.pi / POINTS


class TurnEstimate(msgspec.Struct, frozen=True, eq=False):
    """The turn of a target since its first region."""

    rings: Floats
    """(3 R, POINTS), the rings of the first region. There are none for a box: its angle is not
    asked for."""
    angle: Trend = Trend()
    """The turn; a positive one is from the x axis towards y."""

    @classmethod
    def begin(cls, frame: Frame, region: Ellipse) -> TurnEstimate:
        """Return the estimate at the first region."""
        asked = region.theta != 0 or isinstance(region, Angled)
        return cls(sampled(frame, region) if asked else np.empty((0, POINTS)))

    def followed(
        self, frame: Frame, place: Ellipse, window: float, turned: float, *, seen: bool
    ) -> TurnEstimate:
        """Return the estimate after a frame.

        `window` is the angle of the tracker's window since the first region, and `turned` its
        change in this frame, which the report follows where the rings show no turn.
        """
        if not len(self.rings):
            return TurnEstimate(self.rings, Trend(window))
        found = self._turn(frame, place, window) if seen else None
        if found is None:
            return TurnEstimate(self.rings, Trend(self.angle.value + turned))
        return TurnEstimate(self.rings, self.angle.measured(found))

    def _turn(self, frame: Frame, place: Ellipse, window: float) -> float | None:
        """Return the turn that the rings show; None if they are not alike."""
        rings = sampled(frame, place)
        energy = math.sqrt(float((self.rings**2).sum() * (rings**2).sum()))
        if not energy:
            return None
        spectra = np.conj(np.fft.rfft(self.rings)) * np.fft.rfft(rings)
        alike = np.fft.irfft(spectra.sum(axis=0), POINTS) / energy
        near = [_peak(alike, center) for center in (self.angle.predicted().value, window)]
        best, turn = max(near, key=lambda each: each[0])
        return turn if best > ALIKE else None


def sampled(frame: Frame, ellipse: Ellipse) -> Floats:
    """Return the rings (3 R, POINTS) around an ellipse's center, each less its mean."""
    from scipy import ndimage

    radii = RADII * math.sqrt(ellipse.a * ellipse.b)
    angles = np.arange(POINTS) * _STEP
    at = np.stack(
        [ellipse.y + np.outer(radii, np.sin(angles)), ellipse.x + np.outer(radii, np.cos(angles))]
    )
    rings = np.stack(
        [
            ndimage.map_coordinates(frame.pixels[..., i], at, np.float64, order=1, mode="nearest")
            for i in range(3)
        ]
    )
    rings -= rings.mean(axis=2, keepdims=True)
    rings *= np.sqrt(RADII)[:, None]  # an outer ring stands for more pixels
    return rings.reshape(-1, POINTS)


def _peak(values: Floats, center: float) -> tuple[float, float]:
    """Return the largest of periodic values near an angle, and its angle, by a parabola."""
    reach = int(REACH / _STEP)
    places = round(center / _STEP) + np.arange(-reach, reach + 1)
    place = int(places[values[places % POINTS].argmax()])
    low, best, high = (float(values[(place + i) % POINTS]) for i in (-1, 0, 1))
    shift = min(max(vertex(low, best, high), -0.5), 0.5)  # it may be beside the maximum
    return best, (place + shift) * _STEP
