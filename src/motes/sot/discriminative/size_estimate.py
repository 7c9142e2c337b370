"""The size of the target at its place: the scale filter, and the colors at the border."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.cues.color_posterior import borders
from motes.cues.correlation_filter import ScaleFilter, ScaleModel
from motes.sot.discriminative.localization import WindowEstimate
from motes.sot.discriminative.redetection import SYSTEMATIC, limits
from motes.sot.filtering.resampling import Weights

BORDER_SHARPNESS = 50.0
"""The border term is exp(-BORDER_SHARPNESS · squared difference to the border's running mean)."""


@dataclass(frozen=True, slots=True)
class SizeEstimator:
    """Estimates the size; the fields are those of `Discriminative`."""

    scale: ScaleFilter
    border_gain: float
    sigma: float

    def estimate(
        self,
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
        sizes, low, high = self.scale, *limits(look.pose, frame)
        factors = np.clip(sizes.factors, low, high)
        spectra = sizes.spectra(model, frame, look.pose)
        pool = sizes.response(model, spectra).astype(np.float64)
        boxes = np.tile(look.box, (sizes.count, 1))
        boxes[:, 2:] *= factors[:, None]
        errors = borders(look.integral, boxes) - border
        pool += self.border_gain * np.exp(-BORDER_SHARPNESS * (errors**2).sum(axis=1))
        weights = Weights.from_log(pool / self.sigma)
        chosen = factors[SYSTEMATIC.ancestors(rng, weights, len(look.centers))]
        grown = min(max(sizes.between(pool), low), high)
        pose = look.pose._replace(a=grown * look.pose.a, b=grown * look.pose.b)
        return pose, chosen
