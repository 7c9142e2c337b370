"""Model updates: how a target model learns from the region in which the target was found.

They serve every cue that compares histograms. A strategy is a pure function. It takes the
histograms of the model, of the first frame and of this frame, and its memory. It returns the new
histogram of the model and its new memory.
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
    """The memory of `KalmanBins` for one cue.

    Attributes
    ----------
    squares
        The mean square of the residuals over all bins, in each of the last L frames.
    noise
        Variance of the measurement noise, delta_v²; None before there are L frames.
    variance
        Variance of the filtering error, q. It is one number: equations 3 to 11 give all bins
        the same.
    """

    squares: tuple[NonNegative, ...] = ()
    noise: NonNegative | None = None
    variance: NonNegative = 0.0


class GaussianMemory(msgspec.Struct, frozen=True, eq=False, tag="gaussian"):
    """The memory of `GaussianBins` for one cue, from all histograms since the first frame.

    Attributes
    ----------
    frames
        The number of histograms.
    mean
        (m,), mu of each bin.
    squares
        (m,), the sum of squared deviations from the mean.
    """

    frames: int
    mean: NotNegative
    squares: NotNegative


UpdaterState: TypeAlias = Any
"""The memory of a strategy for one cue: a frozen `msgspec.Struct` of its own, or None."""


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
    """The interface of a model update: one strategy for all cues, or one for each."""

    __slots__ = ()

    @abstractmethod
    def strategy(self, cue: str) -> Strategy:
        """Return the strategy for the cue of a name."""


class Strategy(Adaptation):
    """The interface of a rule by which a model learns. It is also a `Config` with a tag."""

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
        """Return the new histogram of a model, and the new memory.

        Parameters
        ----------
        memory
            The memory after the last frame; None in the beginning.
        histogram, first, seen
            (m,) each: the histogram of the model, of the first frame and of this frame. The last
            one is not empty.
        """


class ExponentialForgetting(Strategy, Config, frozen=True, tag="forgetting"):
    """Exponential forgetting: the model moves by a fixed share in each frame.

    Nummiaro et al. name such models in sections IV and VIII.

    Attributes
    ----------
    learning_rate
        Share of the current frame in the updated model. With a larger value the model follows
        changes faster; 0 keeps it fixed.
    anchor
        Share of the first frame's histogram in what the model moves towards; the rest is the
        current frame's. With a larger value the model stays nearer to the first frame's.
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
        """Return the model moved towards this frame's histogram; there is no memory."""
        entering = self.anchor * first + (1 - self.anchor) * seen
        return UpdateResult((1 - self.learning_rate) * histogram + self.learning_rate * entering)


class KalmanBins(Strategy, Config, frozen=True, tag="kalman"):
    """A Kalman filter for each bin, and a t test of frames: Zhao and Pei, equations 3 to 15.

    The first L frames, in which the model stays fixed, give the noise (equation 11). After them the
    gain follows from the residuals of the last L frames. Three details differ from the printed
    equations:

    - Equation 7 has q^(i-1) for the predicted variance. Equation 10 may be negative, which a
      variance cannot be; it is then 0.
    - The test (12 to 14) is whether this frame's residuals are larger than those of the last L
      frames. Its samples are the squared residuals, one for each bin, since (9) is their mean.
      Signed residuals sum to 0, and the mean of their absolute values is hardly ever above the root
      of (9): with either, the test would refuse nothing.
    - s in (12) is the standard deviation of the samples.

    Attributes
    ----------
    frames
        Number L of frames from whose residuals the noise and the gain are estimated. In the first L
        the model stays fixed. A larger value reacts more slowly. The paper gives no number.
    alpha
        Significance level of the t test: the probability that it refuses a usual frame. With a
        larger value more frames are refused.
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
        if self._refuses(samples, mean - usual):  # the model stays (15), as without a measurement
            memory = KalmanMemory(squares, noise, predicted)
            return UpdateResult(histogram, memory, UpdateDiagnostics(residuals, 0.0, 0.0))
        total = predicted + noise
        gain = predicted / total if total > 0 else 0.0  # 5; there may be no noise at all
        memory = KalmanMemory(squares, noise, (1 - gain) * predicted)  # 7
        return UpdateResult(
            histogram + gain * residuals, memory, UpdateDiagnostics(residuals, gain, 1.0)
        )  # 6

    def _refuses(self, samples: Floats, excess: float) -> bool:
        """Return whether samples are too large (14); `excess`: their mean minus the usual one."""
        if excess <= 0:
            return False
        error = float(samples.std(ddof=1)) / math.sqrt(samples.size)
        return excess >= critical(self.alpha, samples.size - 1) * error


class GaussianBins(Strategy, Config, frozen=True, tag="gaussian"):
    """Each bin moves towards its mean over all frames so far: Zhao and Pei, equation 16.

    mu is a bin's mean over all frames so far, delta its standard deviation. The printed equation
    compares B_i with 3 delta; its distance from mu is meant. B_i is the model's bin on both sides,
    so beta is a learning rate, as the text calls it. If B_i were the frame's bin, every frame would
    nearly replace the model. Histograms are scaled to sum to 1 again.

    Attributes
    ----------
    beta
        Share of the way to its mean mu that a bin moves in each frame. With a larger value the
        model follows faster.
    deviations
        A bin that is more than this many standard deviations delta away from its mean mu becomes mu
        at once. With a larger value this is rarer.
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
    """A model update of its own for each cue.

    Attributes
    ----------
    cues
        The model update of one cue: NAME is the cue's name, such as color. The model of a cue that
        is not named stays fixed.
    """

    cues: dict[str, Strategy] = {}  # noqa: RUF012  (msgspec copies it)

    def strategy(self, cue: str) -> Strategy:
        """Return the strategy of the cue with a name; by default one that keeps the model fixed."""
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
        The memory of each cue's update, if it has one.
    diagnostics
        The diagnostics of each cue's update, if it has any.
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

    Over the angle whose tangent is t / sqrt(freedom), the density is cos^(freedom - 1). It is
    integrated numerically. The relative error is at most 1e-6 up to 1,000 degrees of freedom and
    for alpha from 0.01 on.
    """
    angle = np.linspace(0, np.pi / 2, 20_001)
    density = np.cos(angle) ** (freedom - 1)
    below = np.concatenate([[0.0], np.cumsum(density[1:] + density[:-1])])
    found = np.interp((1 - 2 * alpha) * below[-1], below, angle)
    return math.sqrt(freedom) * math.tan(float(found))
