"""The step of a filter that compares colors alone, in one call of compiled code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Self

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
from motes.sot.particle_state import FilterState, Observation

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
    name: str
    shares: Mapping[str, float]
    """The name of the only cue, which has all the weight, by every rule of fusion."""

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
        return cls(motion, cue, likelihood, presence, name, {name: 1.0})

    def step(
        self, rng: np.random.Generator, frame: Frame, state: FilterState, n: int, dt: float
    ) -> Observation:
        """Return what n particles see, chosen by weight from those of a state `dt` seconds ago."""
        moved, seen = kernels.color_filter.step(
            frame.pixels, state.states, state.weights.values, rng.bit_generator.capsule, n,
            self.motion.kernel_noise, dt / FRAME_INTERVAL, state.reference_size[2:4],
            self._comparison(state),
        )  # fmt: skip
        return self._observation(moved, seen)

    def observe(self, frame: Frame, state: FilterState, states: Floats) -> Observation:
        """Return what particles (N, d) see that had equal weights before the frame."""
        seen = kernels.color_filter.observe(frame.pixels, states, self._comparison(state))
        return self._observation(states, seen)

    def _comparison(self, state: FilterState) -> ColorComparison:
        return _comparison(self, state.models[self.name], state.backgrounds[self.name])

    def _observation(self, states: Floats, seen: kernels.color_filter.Observation) -> Observation:
        log, values, degenerate, mean, covariance, spread, size, distance, around, n, support = seen
        return Observation(
            states, states[:, :5], Weights(log, values, degenerate), self.shares,
            Ellipse._make(mean), covariance, spread, size, distance, around, n, support,
        )  # fmt: skip


@lru_cache
def _comparison(
    step: ColorStep, model: ColorModel, background: BackgroundStatistics
) -> ColorComparison:
    """Return what the kernel compares particles with, the same until the model learns."""
    target, likelihood = step.color.target(model), (step.likelihood.sigma, step.likelihood.epsilon)
    threshold, ring = step.presence.threshold(background), step.presence.contrast > 0
    return ColorComparison(target, likelihood, threshold, ring)
