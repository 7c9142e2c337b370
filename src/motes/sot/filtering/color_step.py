"""The step of a filter that compares colors alone, in one call of compiled code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np

from motes import kernels
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.cues.base import Cue
from motes.cues.color import Color, ColorModel
from motes.sot.filtering.appearance_rule import AppearanceRule
from motes.sot.filtering.likelihood import Gaussian, Likelihood
from motes.sot.filtering.motion import ConstantVelocity, Motion, RandomWalk, SecondOrder, Walking
from motes.sot.filtering.observation import Observation
from motes.sot.filtering.resampling import Multinomial, Resampling, Weights

EVERY_FRAME = Multinomial(threshold=1.0)
WALKS = (RandomWalk, ConstantVelocity, SecondOrder)
SHARES = np.ones(1)
"""One cue has all the weight, by every rule of fusion."""


@dataclass(frozen=True, slots=True)
class ColorStep:
    """Selects, propagates, weighs and estimates as `ParticleFilter` does, to the last bit.

    Part by part, Python takes longer than all the kernels, above all in a program that does much
    else between two frames.
    """

    motion: Walking
    color: Color
    likelihood: tuple[float, float]
    ring: bool

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
        [cue, *more] = cues.values()
        if more or type(cue) is not Color or type(likelihood) is not Gaussian:
            return None
        if not isinstance(motion, Walking) or type(motion) not in WALKS:
            return None
        if resampling != EVERY_FRAME or presence.in_frame:
            return None
        numbers = likelihood.sigma, likelihood.epsilon
        return cls(motion, cue, numbers, presence.contrast > 0)

    def __call__(
        self,
        rng: np.random.Generator,
        frame: Frame,
        states: Floats,
        weights: Weights,
        n: int,
        dt: float,
        first: Ellipse,
        model: ColorModel,
        threshold: float,
    ) -> Observation:
        """Return what n particles see, chosen by weight from states (M, d) of the last frame.

        `dt` seconds have passed; `first` is the target's first region. A particle appears with a
        rho above `threshold`.
        """
        moved, seen = kernels.color_filter.step(
            frame.pixels, states, weights.values, rng.random(n), self.motion.normal(rng, n),
            self.motion.kernel_noise, dt / FRAME_INTERVAL, first[2:4], self.color.target(model),
            self.likelihood, threshold, self.ring,
        )  # fmt: skip
        return _observation(moved, seen)

    def observe(
        self, frame: Frame, states: Floats, model: ColorModel, threshold: float
    ) -> Observation:
        """Return what particles (N, d) see that had equal weights before the frame."""
        target = self.color.target(model)
        seen = kernels.color_filter.observe(
            frame.pixels, states, target, self.likelihood, threshold, self.ring
        )
        return _observation(states, seen)


def _observation(states: Floats, seen: kernels.color_filter.Observation) -> Observation:
    _, logs, values, degenerate, mean = seen[:5]
    weights = Weights(logs, values, degenerate)
    return Observation(states, states[:, :5], weights, SHARES, Ellipse(*mean), *seen[5:])
