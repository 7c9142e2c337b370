"""The step of a filter that compares colors alone, in one call of compiled code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Self

import numpy as np

from motes import kernels
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.cues.base import Cue
from motes.cues.color import Color, ColorModel
from motes.kernels.structures import ColorComparison
from motes.sot.filtering.appearance_rule import AppearanceRule, BackgroundStatistics
from motes.sot.filtering.likelihood import Gaussian, Likelihood
from motes.sot.filtering.motion import ConstantVelocity, Motion, RandomWalk, SecondOrder, Walking
from motes.sot.filtering.resampling import Multinomial, Resampling, Weights
from motes.sot.particle_state import Observation

EVERY_FRAME = Multinomial(threshold=1.0)
WALKS = (RandomWalk, ConstantVelocity, SecondOrder)


@dataclass(frozen=True, slots=True, eq=False)
class ColorStep:
    """Selects, propagates, weighs and estimates as `ParticleFilter` does, to the last bit.

    Part by part, Python takes longer than all the kernels, above all in a program that does much
    else between two frames.
    """

    motion: Walking
    color: Color
    likelihood: Gaussian
    presence: AppearanceRule
    shares: Mapping[str, float]
    """The only cue has all the weight, by every rule of fusion."""

    @classmethod
    def of(
        cls,
        resampling: Resampling,
        motion: Motion,
        cues: Mapping[str, Cue],
        likelihood: Likelihood,
        presence: AppearanceRule,
    ) -> Self | None:
        """Return the step of a filter of these parts; None if one of them is another.

        Subclasses are others: their methods may do something else.
        """
        [(name, cue), *more] = cues.items()
        if more or type(cue) is not Color or type(likelihood) is not Gaussian:
            return None
        if not isinstance(motion, Walking) or type(motion) not in WALKS:
            return None
        if resampling != EVERY_FRAME or presence.in_frame:
            return None
        return cls(motion, cue, likelihood, presence, {name: 1.0})

    def __call__(
        self,
        rng: np.random.Generator,
        frame: Frame,
        states: Floats,
        weights: Weights,
        n: int,
        dt: float,
        first: Ellipse,
        models: Mapping[str, Any],
        backgrounds: Mapping[str, BackgroundStatistics],
    ) -> Observation:
        """Return what n particles see, chosen by weight from states (M, d) of the last frame.

        `dt` seconds have passed; `first` is the target's first region. The model of the cue comes
        with the statistics of its background.
        """
        comparison = _comparison(self, *models.values(), *backgrounds.values())
        moved, seen = kernels.color_filter.step(
            frame.pixels, states, weights.values, rng.random(n), self.motion.normal(rng, n),
            self.motion.kernel_noise, dt / FRAME_INTERVAL, first[2:4], comparison,
        )  # fmt: skip
        return self._observation(moved, seen)

    def observe(
        self,
        frame: Frame,
        states: Floats,
        models: Mapping[str, Any],
        backgrounds: Mapping[str, BackgroundStatistics],
    ) -> Observation:
        """Return what particles (N, d) see that had equal weights before the frame."""
        comparison = _comparison(self, *models.values(), *backgrounds.values())
        seen = kernels.color_filter.observe(frame.pixels, states, comparison)
        return self._observation(states, seen)

    def _observation(self, states: Floats, seen: kernels.color_filter.Observation) -> Observation:
        weights, estimate = Weights(*seen[:3]), Ellipse(*seen[3])
        return Observation(states, states[:, :5], weights, self.shares, estimate, *seen[4:])


@lru_cache
def _comparison(
    step: ColorStep, model: ColorModel, background: BackgroundStatistics
) -> ColorComparison:
    """Return what the kernel compares particles with, the same until the model learns."""
    target, likelihood = step.color.target(model), (step.likelihood.sigma, step.likelihood.epsilon)
    threshold, ring = step.presence.threshold(background), step.presence.contrast > 0
    return ColorComparison(target, likelihood, threshold, ring)
