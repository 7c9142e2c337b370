"""How a target model learns from where the target was found, for any cue that compares histograms.

A strategy is a pure function: from a model's histogram, the first frame's, the one that is seen and
what it remembers, to the new histogram and what it remembers next.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from functools import lru_cache
from typing import Annotated, Any, NamedTuple, TypeAlias

import msgspec
import numpy as np
from msgspec import Meta
from msgspec.structs import replace

from motes.core.config import Config, Count, NonNegative, Share
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.registry import Registry
from motes.core.saved_state import NotNegative
from motes.core.types import Floats
from motes.cues.base import AdaptableCue, Cue


class KalmanMemory(msgspec.Struct, frozen=True, tag="kalman"):
    """What `KalmanBins` remembers of one cue.

    Attributes
    ----------
    squares
        The mean square of the residuals over all bins, in each of the last L frames.
    noise
        Variance of the measurement noise, delta_v²; None until there are L frames.
    variance
        That of the filtering error, q. One number: in equations 3 to 11 nothing tells one bin's
        from another's.
    """

    squares: tuple[NonNegative, ...] = ()
    noise: NonNegative | None = None
    variance: NonNegative = 0.0


class GaussianMemory(msgspec.Struct, frozen=True, eq=False, tag="gaussian"):
    """What `GaussianBins` remembers of one cue: the histograms seen from the first frame on.

    Attributes
    ----------
    frames
        How many.
    mean
        (m,), mu of each bin.
    squares
        (m,), the sum of squared deviations from it.
    """

    frames: int
    mean: NotNegative
    squares: NotNegative


UpdaterState: TypeAlias = Any
"""What a strategy remembers of one cue: a frozen `msgspec.Struct` of its own, or None."""


class UpdateDiagnostics(NamedTuple):
    """The diagnostics of a model update in one frame.

    Attributes
    ----------
    residuals
        (m,), the histogram seen minus the model's.
    gain
        Share of the way that the model has moved: the gain of equation 5, or the rate of equation
        16; 0 if it has not learned.
    accepted
        Share of the bins that passed the strategy's test: all or none with equation 14.
    """

    residuals: Floats
    gain: float
    accepted: float


class UpdateResult(NamedTuple):
    """The next histogram of a model, the memory of its strategy, and diagnostics, if any."""

    histogram: Floats
    memory: UpdaterState = None
    diagnostics: UpdateDiagnostics | None = None


class Adaptation:
    """The interface of all that says how models learn: one strategy, or one for each cue."""

    __slots__ = ()

    @abstractmethod
    def strategy(self, cue: str) -> Strategy:
        """Return the strategy for the cue of a name."""


class Strategy(Adaptation):
    """The interface of a way of learning, which is also a `Config` with a tag."""

    __slots__ = ()

    def strategy(self, cue: str) -> Strategy:
        """Return itself: all cues learn alike."""
        return self

    @property
    def learns(self) -> bool:
        """Whether the model ever changes."""
        return True

    @abstractmethod
    def learn(
        self, memory: UpdaterState, histogram: Floats, first: Floats, seen: Floats
    ) -> UpdateResult:
        """Return what becomes of a model.

        Parameters
        ----------
        memory
            What was remembered last; None in the beginning.
        histogram, first, seen
            (m,) each: the model's, the first frame's and this frame's, in which something is seen.
        """


class ExponentialForgetting(Strategy, Config, frozen=True, tag="forgetting"):
    """The model moves by a fixed share; Nummiaro et al. name such models in sections IV and VIII.

    Attributes
    ----------
    learning_rate
        Share of each frame's estimate that enters the model; 0 keeps the model fixed.
    anchor
        Share of the first frame's model that is kept for good: what enters is taken from it by this
        share.
    """

    learning_rate: Share = 0.0
    anchor: Share = 0.0

    @property
    def learns(self) -> bool:
        """Whether the rate is above 0."""
        return self.learning_rate > 0

    def learn(
        self, memory: UpdaterState, histogram: Floats, first: Floats, seen: Floats
    ) -> UpdateResult:
        """Return the model moved towards what is seen; remembers nothing."""
        entering = self.anchor * first + (1 - self.anchor) * seen
        return UpdateResult((1 - self.learning_rate) * histogram + self.learning_rate * entering)


class KalmanBins(Strategy, Config, frozen=True, tag="kalman"):
    """A Kalman filter for each bin, and a t test that refuses it: Zhao and Pei, equations 3 to 15.

    The first L frames, in which the model stays, give the noise (equation 11); from then on the
    gain follows from the residuals of the last L. Three readings are not the print's:

    - Equation 7 has q^(i-1) for the predicted variance, and (10) may fall below zero, which is no
      variance: it is then 0.
    - The test (12 to 14) asks whether this frame's residuals are larger than those of the last L.
      Its samples are their squares, one for each bin, as those are what (9) is the mean of: signed
      residuals sum to 0, their sizes have a mean that is hardly ever above the root of (9), and the
      test would refuse nothing.
    - s in (12) is the standard deviation of the samples.

    Attributes
    ----------
    frames
        L, of which the paper gives no number.
    alpha
        Significance level: the chance to refuse a frame like any other.
    """

    frames: Count = 10
    alpha: Annotated[float, Meta(ge=1e-6, le=0.5)] = 0.1

    def learn(
        self, memory: UpdaterState, histogram: Floats, first: Floats, seen: Floats
    ) -> UpdateResult:
        """Return the filtered model, or the same one if the test refuses the frame."""
        before = memory if isinstance(memory, KalmanMemory) else KalmanMemory()
        residuals = seen - histogram  # 8
        samples = residuals**2
        mean = float(samples.mean())
        squares = (*before.squares, mean)[-self.frames :]
        usual = sum(squares) / len(squares)  # 9
        noise, variance, drift = before.noise, before.variance, 0.0
        if noise is not None:
            drift = max(0.0, usual - noise - variance)  # 10
        elif len(squares) == self.frames:
            noise = variance = 0.5 * usual  # 11
        else:
            return UpdateResult(
                histogram, KalmanMemory(squares), UpdateDiagnostics(residuals, 0.0, 1.0)
            )
        predicted = variance + drift  # 4
        if self._refuses(samples, mean - usual):  # the model stays (15): nothing was measured
            memory = KalmanMemory(squares, noise, predicted)
            return UpdateResult(histogram, memory, UpdateDiagnostics(residuals, 0.0, 0.0))
        total = predicted + noise
        gain = predicted / total if total > 0 else 0.0  # 5; without any residual there is no noise
        memory = KalmanMemory(squares, noise, (1 - gain) * predicted)  # 7
        return UpdateResult(
            histogram + gain * residuals, memory, UpdateDiagnostics(residuals, gain, 1.0)
        )  # 6

    def _refuses(self, samples: Floats, excess: float) -> bool:
        """Tell whether samples whose mean is so far above the usual one are too large (14)."""
        if excess <= 0:
            return False
        error = float(samples.std(ddof=1)) / math.sqrt(samples.size)
        return excess >= critical(self.alpha, samples.size - 1) * error


class GaussianBins(Strategy, Config, frozen=True, tag="gaussian"):
    """Each bin moves towards the mean of all that was seen: Zhao and Pei, equation 16.

    mu and delta of each bin are taken over all frames so far. The print compares B_i with 3 delta
    where its distance from mu is meant. B_i is the model's bin on both sides: so beta is a rate of
    learning, as the text calls it. Were it the frame's, the model would be nearly replaced by every
    frame. Histograms are scaled to sum to 1 again.

    Attributes
    ----------
    beta
        Share of the way to mu that a bin goes.
    deviations
        A bin that is more than so many delta away from mu becomes mu.
    """

    beta: Share = 0.1
    deviations: NonNegative = 3.0

    def learn(
        self, memory: UpdaterState, histogram: Floats, first: Floats, seen: Floats
    ) -> UpdateResult:
        """Return the model moved towards the mean."""
        if not isinstance(memory, GaussianMemory):
            memory = GaussianMemory(1, first, np.zeros_like(first))
        frames, off = memory.frames + 1, seen - memory.mean
        mean = memory.mean + off / frames
        squares = memory.squares + off * (seen - mean)
        near = np.abs(histogram - mean) <= self.deviations * np.sqrt(squares / frames)
        moved = np.where(near, self.beta * mean + (1 - self.beta) * histogram, mean)
        moved /= moved.sum()
        lesson = UpdateDiagnostics(seen - histogram, self.beta, float(near.mean()))
        return UpdateResult(moved, GaussianMemory(frames, mean, squares), lesson)


class PerCue(Adaptation, Config, frozen=True, tag="per_cue"):
    """A strategy for each cue.

    Attributes
    ----------
    cues
        By name; the model of a cue that is not named stays fixed.
    """

    cues: dict[str, Strategy] = {}  # noqa: RUF012  (msgspec copies it)

    def strategy(self, cue: str) -> Strategy:
        """Return the strategy that is named; else one that keeps the model fixed."""
        return self.cues.get(cue, ExponentialForgetting())


MODEL_UPDATES = Registry[Adaptation](
    "model update",
    "motes.model_updates",
    Adaptation,
    {
        "forgetting": ExponentialForgetting,
        "kalman": KalmanBins,
        "gaussian": GaussianBins,
        "per_cue": PerCue,
    },
)


class ModelUpdate(NamedTuple):
    """The target models after a frame.

    Attributes
    ----------
    models
        The models, by cue.
    memories
        What the updates remember, for each cue whose update remembers something.
    diagnostics
        What the updates report, for each cue whose update reports something.
    """

    models: dict[str, Any]
    memories: dict[str, UpdaterState]
    diagnostics: dict[str, UpdateDiagnostics]


def update_models(
    cues: Mapping[str, Cue],
    strategies: Mapping[str, Strategy],
    models: Mapping[str, Any],
    memories: Mapping[str, UpdaterState],
    frame: Frame,
    estimate: Ellipse,
) -> ModelUpdate:
    """Return the models after a frame in which the target is present at `estimate`."""
    update = ModelUpdate({}, dict(memories), {})
    for name, cue in cues.items():
        model = models[name]
        strategy = strategies.get(name)
        if strategy is not None and strategy.learns and isinstance(cue, AdaptableCue):
            seen = cue.observe(model, frame, estimate)
            if seen.any():
                learned = strategy.learn(memories.get(name), model.histogram, model.anchor, seen)
                model = replace(model, histogram=learned.histogram)
                if learned.memory is not None:
                    update.memories[name] = learned.memory
                if learned.diagnostics is not None:
                    update.diagnostics[name] = learned.diagnostics
        update.models[name] = cue.update_reading(model, frame, estimate)
    return update


@lru_cache(maxsize=64)
def critical(alpha: float, freedom: int) -> float:
    """Return t_alpha(freedom), which Student's t exceeds with probability alpha (equation 13).

    In the angle whose tangent is t / sqrt(freedom), the density is cos^(freedom - 1), which is
    summed up. Right to a share of 1e-6 up to 1,000 degrees of freedom and for alpha from 0.01.
    """
    angle = np.linspace(0, np.pi / 2, 20_001)
    density = np.cos(angle) ** (freedom - 1)
    below = np.concatenate([[0.0], np.cumsum(density[1:] + density[:-1])])
    found = np.interp((1 - 2 * alpha) * below[-1], below, angle)
    return math.sqrt(freedom) * math.tan(float(found))
