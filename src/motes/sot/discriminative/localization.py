"""The place, size and turn of the target in one window: particles over dense responses.

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
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, Self

import msgspec
import numpy as np

from motes import kernels
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats, Singles, Spectra
from motes.cues.color import CORE_FRACTION, PosteriorModel, borders, contrast
from motes.cues.correlation_filter import (
    UPSAMPLING,
    CorrelationModel,
    ScaleModel,
    peak_near,
)
from motes.cues.fourier import vertex
from motes.cues.search_window import CELL_SIZE, SampleGrid
from motes.kernels.structures import PointCues
from motes.sot.discriminative.config import BIN, DiscriminativeConfig
from motes.sot.discriminative.expert import SYSTEMATIC, limits
from motes.sot.filtering.resampling import Weights


class TargetModels(msgspec.Struct, frozen=True, eq=False):
    """The models that a localization uses."""

    correlation: CorrelationModel
    posterior: PosteriorModel
    """The correlation filter, and the color posterior."""
    experts: dict[str, Any]
    """The model of each expert, by name."""
    contrast: float
    """Running mean of the color contrast between the target and its surroundings. It sets the
    weight of the color posterior."""


@dataclass(frozen=True, slots=True, eq=False)
class WindowEstimate:
    """The place of the target in one window."""

    window_pose: Ellipse
    """The ellipse at the center of the window."""
    window: Singles
    spectra: Spectra
    integral: Floats
    sights: Mapping[str, Any]
    """The samples of the window; the transform of its features; the integral image of the
    posterior; what the experts see, by name."""
    centers: Floats
    weights: Weights
    """(N, 2), (N,) the particles."""
    pose: Ellipse
    """The mean of the particles' place and of where experts see the target near it; with the size
    and angle of `window_pose`."""
    box: Floats
    """(4,) the pose in samples of the window: x and y from its center, and half sides."""
    contrast: float
    """Color contrast between the box and its surroundings."""
    similarity: float
    """Response of the first frame's filter at the pose."""
    evidence: float
    """Log odds that the target is at the pose: those of `Evidence` and of all experts."""


def localize(
    config: DiscriminativeConfig,
    rng: np.random.Generator,
    known: TargetModels,
    frame: Frame,
    place: Ellipse,
    sights: Mapping[str, Any],
    sigma: float = math.inf,
) -> WindowEstimate:
    """Return the weighted mean of particles in the window around `place`.

    Where experts see the target near by, it is at the mean of their places and this one.
    `sights` are what they see in this frame. The target is expected at `place` with a standard
    deviation of `sigma` pixels; by default it may be anywhere in the window.
    """
    sights = config.experts.look_again(known.experts, frame, place, sights)
    samples = known.correlation.grid
    window = samples.sample_window(frame, place)
    spectra = config.correlation.spectra(samples, window)
    plane, first = config.correlation.responses(known.correlation, spectra)
    integral = config.posterior.integral(known.posterior, window)
    half, step = samples.half, samples.step(place)
    cues = PointCues(
        plane, CELL_SIZE / UPSAMPLING, integral, (CORE_FRACTION * half[0], CORE_FRACTION * half[1]),
        color_weight(known.contrast), config.sigma, (sigma / step[0], sigma / step[1]),
    )  # fmt: skip
    centers = samples.points(place, _drawn(config, rng, samples, cues))
    centers = np.clip(centers, 0, (frame.width - 1, frame.height - 1))
    log_weights = np.empty(len(centers))
    kernels.localization.weigh(cues, samples.offsets(place, centers), log_weights)
    weighed = Weights.from_log(log_weights)
    x, y = (weighed.values @ centers).tolist()
    found = place._replace(x=x, y=y)
    found = config.experts.refined(sights, found)
    centers += np.subtract(found[:2], (x, y))
    box = np.append(samples.offsets(place, np.array(found[:2])), half)
    stands_out = contrast(integral, box)
    similarity = peak_near(first, box[0], box[1])
    evidence = config.evidence.log_odds(similarity, stands_out)
    evidence += config.experts.log_odds(sights, found)
    seen = window, spectra, integral, sights
    judged = stands_out, similarity, evidence
    return WindowEstimate(place, *seen, centers, weighed, found, box, *judged)


def _drawn(
    config: DiscriminativeConfig, rng: np.random.Generator, samples: SampleGrid, cues: PointCues
) -> Floats:
    """Return particles (n, 2), in samples off the window's center.

    Half of them are spread over the window, the others around the maximum of the response. Then
    they are weighted, resampled and moved by less and less noise.
    """
    side = math.sqrt(samples.width * samples.height)
    narrow, bin_side = config.correlation.sharpness * side, BIN * side / 2
    normal, offsets = rng.standard_normal((3, config.particles, 2)), rng.random(4)
    return kernels.localization.draw(
        cues, normal, offsets, samples.half, narrow, bin_side, config.counts
    )


def color_weight(contrast: float) -> float:
    """Return the weight of color, from 0 to 1; it grows with the color contrast."""
    counts = max(contrast, 0.0)
    return counts / (1 + counts)


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
    look: WindowEstimate,
) -> tuple[Ellipse, Floats]:
    """Return a window's estimate with its size, and particles of the size as factors, (N,).

    Each size is weighted by the scale filter, and by how close the posterior just inside and
    outside of its border is to its running mean `border`, (2,). The size is at the maximum
    between the compared ones.
    """
    sizes, low, high = config.scale, *limits(look.pose, frame)
    factors = np.clip(sizes.factors, low, high)
    spectra = sizes.spectra(model, frame, look.pose)
    pool = sizes.response(model, spectra).astype(np.float64)
    boxes = np.tile(look.box, (sizes.count, 1))
    boxes[:, 2:] *= factors[:, None]
    errors = borders(look.integral, boxes) - border
    pool += config.border_gain * np.exp(-BORDER_SHARPNESS * (errors**2).sum(axis=1))
    weights = Weights.from_log(pool / config.sigma)
    chosen = factors[SYSTEMATIC.ancestors(rng, weights, len(look.centers))]
    grown = min(max(sizes.between(pool), low), high)
    pose = look.pose._replace(a=grown * look.pose.a, b=grown * look.pose.b)
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
