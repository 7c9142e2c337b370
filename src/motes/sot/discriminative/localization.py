"""The place of the target in one window: particles over dense responses, in ever finer steps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np

from motes import kernels
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats, Singles, Spectra
from motes.cues.color import CORE_FRACTION, PosteriorModel, contrast
from motes.cues.correlation_filter import UPSAMPLING, CorrelationModel, peak_near
from motes.cues.search_window import CELL_SIZE, SampleGrid
from motes.kernels.structures import PointCues
from motes.sot.discriminative.config import BIN, DiscriminativeConfig
from motes.sot.discriminative.exclusion import Taken
from motes.sot.discriminative.expert import LARGEST_LOG_ODDS
from motes.sot.filtering.resampling import Weights


class TargetModels(msgspec.Struct, frozen=True, eq=False):
    """The models that a localization uses."""

    correlation: CorrelationModel
    posterior: PosteriorModel
    experts: dict[str, Any]
    """The models of both cues, and of each expert by name."""
    contrast: float
    """Running mean of the color contrast between the target and its surroundings. It sets the
    weight of the color posterior."""
    taken: Taken
    """Places that are other targets'. No evidence counts there."""


@dataclass(frozen=True, slots=True, eq=False)
class WindowEstimate:
    """The place of the target in one window."""

    window_pose: Ellipse
    """The ellipse at the center of the window."""
    window: Singles
    """The samples of the window."""
    spectra: Spectra
    """The transform of its features."""
    integral: Floats
    """The integral image of the posterior, for the border."""
    sights: Mapping[str, Any]
    """What the experts see, by name."""
    centers: Floats
    """(N, 2), the particles."""
    weights: Weights
    """(N,), theirs."""
    pose: Ellipse
    """The mean of the particles, with the size and angle of `window_pose`."""
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
    deviation: float = math.inf,
) -> WindowEstimate:
    """Return the weighted mean of particles in the window around `place`.

    `sights` are what the experts see in this frame. The target is expected at `place` with a
    standard `deviation` in pixels; by default it may be anywhere in the window.
    """
    sights = config.experts.look_again(known.experts, frame, place, sights)
    grid = known.correlation.grid
    window = grid.sample_window(frame, place)
    spectra = config.correlation.spectra(grid, window)
    plane, first = config.correlation.responses(known.correlation, spectra)
    integral, border = config.posterior.integrals(known.posterior, window)
    half, step = grid.half, grid.step(place)
    cues = PointCues(
        plane, CELL_SIZE / UPSAMPLING, integral, (CORE_FRACTION * half[0], CORE_FRACTION * half[1]),
        color_weight(known.contrast), config.sigma, (deviation / step[0], deviation / step[1]),
    )  # fmt: skip
    centers = grid.points(place, _drawn(config, rng, grid, cues))
    centers = np.minimum(np.maximum(centers, 0), (frame.width - 1, frame.height - 1))
    log_weights = np.empty(len(centers))
    kernels.localization.weigh(cues, grid.offsets(place, centers), log_weights)
    weighed = Weights.from_log(log_weights)
    x, y = (weighed.values @ centers).tolist()
    found = place._replace(x=x, y=y)
    box = np.append(grid.offsets(place, np.array(found[:2])), half)
    stands_out = contrast(integral, box)
    similarity = peak_near(first, box[0], box[1])
    evidence = config.evidence.log_odds(similarity, stands_out)
    evidence += config.experts.log_odds(sights, found)
    if known.taken.holds(found):
        evidence = -LARGEST_LOG_ODDS
    return WindowEstimate(
        window_pose=place, window=window, spectra=spectra, integral=border, sights=sights,
        centers=centers, weights=weighed, pose=found, box=box, contrast=stands_out,
        similarity=similarity, evidence=evidence,
    )  # fmt: skip


def _drawn(
    config: DiscriminativeConfig, rng: np.random.Generator, grid: SampleGrid, cues: PointCues
) -> Floats:
    """Return particles (n, 2), in samples off the window's center.

    Half of them are spread over the window, the others around the maximum of the response. Then
    they are weighted, resampled and moved by less and less noise.
    """
    side = math.sqrt(grid.width * grid.height)
    narrow, bin_side = config.correlation.sharpness * side, BIN * side / 2
    normal, offsets = rng.standard_normal((3, config.particles, 2)), rng.random(4)
    return kernels.localization.draw(
        cues, normal, offsets, grid.half, narrow, bin_side, config.counts
    )


def color_weight(standing_out: float) -> float:
    """Return the weight of color, from 0 to 1; it grows with the color contrast."""
    counts = max(standing_out, 0.0)
    return counts / (1 + counts)
