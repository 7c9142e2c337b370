"""The place of the target in one window: particles over dense responses, in ever finer steps."""

from __future__ import annotations

import math
from dataclasses import dataclass

import msgspec
import numpy as np

from motes import kernels
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats, Singles, Spectra
from motes.cues.color_posterior import CORE_FRACTION, Posterior, PosteriorModel, contrast
from motes.cues.correlation_filter import (
    UPSAMPLING,
    Correlation,
    CorrelationModel,
    peak_near,
    sample_response,
)
from motes.cues.search_window import CELL_SIZE
from motes.sot.filtering.resampling import Resampling, Weights
from motes.sot.filtering.sample_size import KldSampling


class TargetModels(msgspec.Struct, frozen=True, eq=False):
    """The models that a localization uses.

    Attributes
    ----------
    correlation, posterior
        The correlation filter, and the color posterior.
    contrast
        Running mean of the color contrast between the target and its surroundings. It sets the
        weight of the color posterior.
    first_contrast
        The contrast in the first frame. It sets the weight of color in the certainty.
    """

    correlation: CorrelationModel
    posterior: PosteriorModel
    contrast: float
    first_contrast: float


@dataclass(frozen=True, slots=True, eq=False)
class WindowEstimate:
    """The place of the target in one window.

    Attributes
    ----------
    window_pose
        The ellipse at the center of the window.
    window, spectra, integral
        The samples of the window; the transform of its features; the integral image of the
        posterior.
    centers, weights
        (N, 2), (N,) the particles.
    pose
        The mean of the particles, with the size and angle of `window_pose`.
    box
        (4,) the pose in samples of the window: x and y from its center, and half sides.
    contrast
        Color contrast between the box and its surroundings.
    certainty
        Certainty that the target is at the pose, 0 to 1; see `Localizer.certainty`.
    response
        Response of the learned filter at the pose.
    """

    window_pose: Ellipse
    window: Singles
    spectra: Spectra
    integral: Floats
    centers: Floats
    weights: Weights
    pose: Ellipse
    box: Floats
    contrast: float
    certainty: float
    response: float


@dataclass(frozen=True, slots=True)
class Localizer:
    """Finds the target's place in a window; the fields are those of `Discriminative`."""

    particles: int
    budget: KldSampling
    correlation: Correlation
    posterior: Posterior
    color_gain: float
    sigma: float
    resampling: Resampling

    def localize(
        self, rng: np.random.Generator, known: TargetModels, frame: Frame, place: Ellipse
    ) -> WindowEstimate:
        """Return the weighted mean of particles in the window around `place`.

        Half of the particles are spread over the window, the others around the maximum of the
        response. Then they are weighted, resampled and moved by less and less noise.
        """
        samples = known.correlation.grid
        half = np.array(samples.half)
        window = samples.sample_window(frame, place)
        spectra = self.correlation.spectra(samples, window)
        plane, first = self.correlation.responses(known.correlation, spectra)
        integral = self.posterior.integral(known.posterior, window)
        share = self.color_weight(known.contrast)
        core = CORE_FRACTION * samples.half[0], CORE_FRACTION * samples.half[1]

        def weights(points: Floats) -> Weights:
            pool = sample_response(plane, points)
            kernels.bilinear.pool(integral, core, share, points, pool)
            return Weights.from_log(pool / self.sigma)

        row, column = divmod(int(np.argmax(plane)), plane.shape[1])
        peak = (
            np.array([column - plane.shape[1] // 2, row - plane.shape[0] // 2])
            * CELL_SIZE
            / UPSAMPLING
        )
        narrow = self.correlation.sharpness * math.sqrt(samples.width * samples.height)
        noise = rng.standard_normal((3, self.particles, 2))
        points = noise[0]
        points[::2] *= half
        points[1::2] = points[1::2] * narrow + peak
        for layer, spread in ((1, narrow / 2), (2, narrow / 4)):
            weighed = weights(points)
            chosen = points[self.resampling.ancestors(rng, weighed, len(points))]
            count = min(self.budget.number(chosen / math.sqrt(half.prod())), self.particles)
            chosen = points[self.resampling.ancestors(rng, weighed, count)]
            points = chosen + noise[layer, :count] * spread
        centers = samples.points(place, points)
        centers = np.clip(centers, 0, (frame.width - 1, frame.height - 1))
        weighed = weights(samples.offsets(place, centers))
        x, y = (weighed.values @ centers).tolist()
        box = np.append(samples.offsets(place, np.array((x, y))), half)
        stands_out = contrast(integral, box)
        alike = min(peak_near(first, box[0], box[1]), 1.0)
        certainty = self.certainty(known, alike, stands_out)
        found = place._replace(x=x, y=y)
        response = float(sample_response(plane, box[None, :2])[0])
        seen, said = (window, spectra, integral), (stands_out, certainty, response)
        return WindowEstimate(place, *seen, centers, weighed, found, box, *said)

    def certainty(self, known: TargetModels, similarity: float, contrast: float) -> float:
        """Return the certainty that the target is at a place, 0 to 1.

        It is similarity^(1 - w) · (contrast / first contrast)^w, a weighted geometric mean. Color
        counts relative to the first frame, and by the weight w that it has there: a target that
        never differed in color from its surroundings is judged by its gradients alone.

        Neither factor adapts to what the tracker follows. The response of the learned filter would
        not do: it also rises while the filter learns a wrong object.

        Parameters
        ----------
        similarity
            Response of the first frame's filter.
        contrast
            Color contrast between the target's box and its surroundings.
        """
        weight = self.color_weight(known.first_contrast)
        relative = min(max(contrast, 0.0) / known.first_contrast, 1.0) if weight else 1.0
        return float(max(similarity, 0.0) ** (1 - weight) * relative**weight)

    def color_weight(self, contrast: float) -> float:
        """Return the weight of color, from 0 to 1; it grows with the color contrast."""
        counts = self.color_gain * max(contrast, 0.0)
        return counts / (1 + counts)
