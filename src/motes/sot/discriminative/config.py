"""The configuration of the default tracker, which all of its steps take."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from motes.core.config import Config, NonNegative, Particles, Positive
from motes.cues.color import Posterior
from motes.cues.correlation_filter import Correlation, ScaleFilter
from motes.sot.discriminative.backdrop import Backdrop
from motes.sot.discriminative.expert import Confined, Evidence, Expert, Experts
from motes.sot.discriminative.redetection import Redetection
from motes.sot.filtering.resampling import KldSampling
from motes.sot.network.network import Network

BIN = 0.25
"""Side of a bin of the particles' places, from which their number follows, in half sides of the
target."""


class DiscriminativeConfig(Config, frozen=True, dict=True):
    """What of the default tracker can be chosen."""

    open_field: ClassVar[str | None] = "extra_experts"

    particles: Particles = 400
    """Number of particles that are spread over a window. Where fewer places are likely, fewer are
    left after the first of three rounds, a quarter at least. As many search for a missed target."""
    correlation: Correlation = Correlation()
    """The near window's correlation filter. The scale filter learns at its rate."""
    posterior: Posterior = Posterior()
    """The near window's color posterior."""
    sigma: Positive = 0.02
    """The weight of a particle is exp(pool / sigma), where the pool joins both cues. With a larger
    value, the estimate is a mean over a larger area."""
    scale: ScaleFilter = ScaleFilter()
    """Cue for the size: the scale filter."""
    redetection: Redetection = Redetection()
    """How a missed target is searched for."""
    border_gain: NonNegative = 0.2
    """Weight of the posterior at the border in the estimate of the size; the scale filter has
    weight 1."""
    evidence: Evidence = Evidence()
    """What the near window says of a place; the experts add to it."""
    confined: Confined = Confined()
    """Expert: a filter that is confined to the target, in a wide window."""
    backdrop: Backdrop = Backdrop()
    """Expert: what was at a place before the target came."""
    network: Network | None = None
    """A trained network that follows the target too; by default there is none."""
    extra_experts: dict[str, Expert] = {}  # noqa: RUF012  (msgspec copies it)
    """Experts of other packages, by name. In files and options they stand among the other keys."""

    @cached_property
    def cues(self) -> dict[str, Correlation | Posterior]:
        """The cues for the place, by name."""
        return {"correlation": self.correlation, "posterior": self.posterior}

    @cached_property
    def experts(self) -> Experts:
        """The experts in use: those with a weight, and all of other packages."""
        own: dict[str, Expert] = {}
        if self.confined.weight:
            own["confined"] = self.confined
        if self.backdrop.weight:
            own["backdrop"] = self.backdrop
        return Experts(own | self.extra_experts)

    @cached_property
    def counts(self) -> NDArray[np.intp]:
        """The number of particles after a round in a window, by how many bins they lie in."""
        budget = KldSampling(min=max(self.particles // 4, 1), max=self.particles)
        return np.array([budget.needed(bins) for bins in range(self.particles + 1)], np.intp)
