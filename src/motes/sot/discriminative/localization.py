"""The place of the target in one window: particles over dense responses, in ever finer steps."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np

from motes import kernels
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats, Singles, Spectra
from motes.cues.color_posterior import CORE_FRACTION, PosteriorModel, contrast
from motes.cues.correlation_filter import (
    UPSAMPLING,
    CorrelationModel,
    peak_near,
    sample_response,
)
from motes.cues.search_window import CELL_SIZE, SampleGrid
from motes.sot.discriminative.config import DiscriminativeConfig
from motes.sot.discriminative.prediction import Transition
from motes.sot.discriminative.redetection import SYSTEMATIC
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
    transition: Transition | None = None,
) -> WindowEstimate:
    """Return the weighted mean of particles in the window around `place`.

    Where experts see the target near by, it is at the mean of their places and this one.
    `sights` are what they see in this frame. Without a `transition`, the target may be anywhere
    in the window.
    """
    sights = config.experts.look_again(known.experts, frame, place, sights)
    samples = known.correlation.grid
    half = np.array(samples.half)
    window = samples.sample_window(frame, place)
    spectra = config.correlation.spectra(samples, window)
    plane, first = config.correlation.responses(known.correlation, spectra)
    integral = config.posterior.integral(known.posterior, window)
    share = color_weight(known.contrast)
    core = CORE_FRACTION * samples.half[0], CORE_FRACTION * samples.half[1]

    def weights(points: Floats) -> Weights:
        pool = sample_response(plane, points)
        kernels.bilinear.pool(integral, core, share, points, pool)
        log_weights = pool / config.sigma
        if transition is not None:
            log_weights += transition.log_density(samples.points(place, points))
        return Weights.from_log(log_weights)

    centers = samples.points(place, _drawn(config, rng, samples, plane, weights))
    centers = np.clip(centers, 0, (frame.width - 1, frame.height - 1))
    weighed = weights(samples.offsets(place, centers))
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
    config: DiscriminativeConfig,
    rng: np.random.Generator,
    samples: SampleGrid,
    plane: Singles,
    weights: Callable[[Floats], Weights],
) -> Floats:
    """Return particles (n, 2), in samples off the window's center.

    Half of them are spread over the window, the others around the maximum of the response
    `plane`. Then they are weighted, resampled and moved by less and less noise.
    """
    row, column = divmod(int(np.argmax(plane)), plane.shape[1])
    peak = np.array([column - plane.shape[1] // 2, row - plane.shape[0] // 2])
    half, side = np.array(samples.half), math.sqrt(samples.width * samples.height)
    narrow = config.correlation.sharpness * side
    noise = rng.standard_normal((3, config.particles, 2))
    points: Floats = noise[0]
    points[::2] *= half
    points[1::2] = points[1::2] * narrow + peak * CELL_SIZE / UPSAMPLING
    for layer, spread in ((1, narrow / 2), (2, narrow / 4)):
        weighed = weights(points)
        chosen = points[SYSTEMATIC.ancestors(rng, weighed, len(points))]
        count = config.budget.number(chosen / math.sqrt(half.prod()))
        chosen = points[SYSTEMATIC.ancestors(rng, weighed, count)]
        points = chosen + noise[layer, :count] * spread
    return points


def color_weight(contrast: float) -> float:
    """Return the weight of color, from 0 to 1; it grows with the color contrast."""
    counts = max(contrast, 0.0)
    return counts / (1 + counts)
