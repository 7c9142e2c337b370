"""What the particles see in a frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np

from motes import kernels
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.cues.base import Cue
from motes.sot.filtering.appearance_rule import AppearanceRule, BackgroundStatistics
from motes.sot.filtering.fusion import Fusion, fuse_distances
from motes.sot.filtering.likelihood import Likelihood
from motes.sot.filtering.motion import Motion
from motes.sot.filtering.resampling import Weights, mean_ellipse


class Observation(msgspec.Struct, frozen=True, eq=False):
    """Particles that a frame was compared with, and the estimate from them."""

    states: Floats
    ellipses: Floats
    """(N, d) and (N, 5), the particles."""
    weights: Weights
    """Their weights after the frame."""
    shares: Mapping[str, float]
    """The weight of each cue; sum 1."""
    estimate: Ellipse
    covariance: Floats
    """The mean ellipse, and the (5, 5) covariance."""
    spread: float
    """Standard deviation of the particles' places, in mean half-axes of the estimate."""
    effective_sample_size: float
    """That of the weights."""
    distance: float
    """The estimate's distance to the target model."""
    around: float
    """The mean rho of the regions beside it; 0 if the appearance rule asks for no contrast."""
    appearing: int
    """Number of particles that fulfill the appearance rule."""
    support: float
    """The sum of their weights."""


@dataclass(frozen=True, slots=True)
class Observer:
    """Weighs particles by a frame, with any motion model and any cues (`ColorStep` has a few)."""

    motion: Motion
    cues: Mapping[str, Cue]
    likelihood: Likelihood
    fusion: Fusion
    presence: AppearanceRule

    def observe(
        self,
        frame: Frame,
        states: Floats,
        prior: Floats,
        models: Mapping[str, Any],
        backgrounds: Mapping[str, BackgroundStatistics],
    ) -> Observation:
        """Return what particles see in a frame, and the estimate of the target.

        Parameters
        ----------
        states, prior
            (N, d) the particles, and (N,) their log-weights before the frame.
        models, backgrounds
            The target model of each cue, and the statistics of its background.
        """
        ellipses = self.motion.ellipses(states)
        distances = self._distances(models, frame, ellipses)
        names = list(self.cues)
        logs = self.likelihood.log(names, distances)
        weights, shares = self.fusion.fuse(names, prior, logs, ellipses)
        estimate, covariance = mean_ellipse(ellipses, weights.values)
        reliability = self.fusion.reliability(names)
        spread = kernels.particles.spread(covariance, estimate[2:4])
        overall = fuse_distances(distances, reliability)
        regions = self.presence.regions(estimate, frame)
        seen = fuse_distances(self._distances(models, frame, regions), reliability)
        distance = float(seen[0])
        around = float((1 - seen[1:] ** 2).mean()) if seen.size > 1 else 0.0
        each = map(self.presence.threshold, backgrounds.values())
        threshold = sum(share * one for share, one in zip(reliability.tolist(), each, strict=True))
        counted = self.presence.counted(overall, ellipses, frame)
        appearing, support = kernels.particles.appearing(counted, weights.values, threshold)
        return Observation(
            states, ellipses, weights, dict(zip(names, shares.tolist(), strict=True)),
            estimate, covariance, spread, weights.effective_sample_size,
            distance, around, appearing, support,
        )  # fmt: skip

    def _distances(self, models: Mapping[str, Any], frame: Frame, ellipses: Floats) -> Floats:
        """Return the distances (J, N) of ellipses (N, 5) by each cue."""
        return np.array(
            [cue.distances(models[name], frame, ellipses) for name, cue in self.cues.items()]
        )
