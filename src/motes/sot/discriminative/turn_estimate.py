"""The reported turn: rings of colors around the center, compared with those of the first region.

A turn of the target shifts its rings, whatever their radius. Their cross-correlation, of all rings
at once in the Fourier domain, has its maximum at the turn (De Castro and Morandi, Registration of
translated and rotated images using finite Fourier transforms, PAMI 1987, in polar coordinates).
"""

from __future__ import annotations

import math

import msgspec
import numpy as np

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.cues.fourier import vertex
from motes.sot.discriminative.trend import Trend

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
    """(3 R, POINTS), the rings of the first region. There are none for an upright region, such as a
    box: its angle is not asked for."""
    angle: Trend = Trend()
    """The turn; a positive one is from the x axis towards y."""

    @classmethod
    def begin(cls, frame: Frame, region: Ellipse) -> TurnEstimate:
        """Return the estimate at the first region."""
        rings = sampled(frame, region) if region.theta else np.empty((0, POINTS))
        return cls(rings)

    def followed(
        self, frame: Frame, place: Ellipse, window: float, turned: float, *, seen: bool
    ) -> TurnEstimate:
        """Return the estimate after a frame.

        Parameters
        ----------
        frame
            The frame.
        place
            The estimate of place and size.
        window, turned
            The angle of the tracker's window since the first region, and its change in this frame.
            The report follows the change where the rings show no turn.
        seen
            Whether the target is tracked.
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
    """Return the rings (3 R, POINTS) around an ellipse's center, each color's mean taken off."""
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
