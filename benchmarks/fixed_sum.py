"""`maggio` with its fixed weights in the sum of Maggio et al. (equation 10), not in a product.

motes-lab experiment pairs SEQUENCES maggio benchmarks.fixed_sum:tracker
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace

from motes import Tracker
from motes.core.config import Config
from motes.core.types import Floats
from motes.filtering import Fusion, Weights
from motes.sot.presets import MAGGIO

WEIGHTS = np.array([0.66, 0.34])
"""Of color and of orientation: section 5."""


class FixedSum(Fusion, Config, frozen=True):
    """The sum of the cues' likelihoods with weights that are the same in all frames."""

    def fuse(
        self, names: Sequence[str], prior: Floats, logs: Floats, ellipses: Floats
    ) -> tuple[Weights, Floats]:
        """Return the particles' weights and the cues' shares, as `Fusion.fuse` does."""
        mixed = np.logaddexp.reduce(np.log(WEIGHTS)[:, None] + logs, axis=0)
        return Weights.from_log(prior + mixed), WEIGHTS


def tracker(seed: int = 0) -> Tracker:
    """Return the tracker, for `motes-lab experiment pairs`."""
    return Tracker(replace(MAGGIO, fusion=FixedSum()), seed)
