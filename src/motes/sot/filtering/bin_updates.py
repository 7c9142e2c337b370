"""Model updates after Zhao and Pei, section 2.2: filters for the bins of a target's histogram."""

from __future__ import annotations

import math
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta

from motes.core.config import Config, Count, NonNegative, Share
from motes.core.types import Floats
from motes.sot.filtering.model_update import Strategy, UpdateResult, UpdaterState


class KalmanMemory(msgspec.Struct, frozen=True, tag="kalman"):
    """The memory of `KalmanBins` for one cue."""

    squares: tuple[NonNegative, ...] = ()
    """The mean square of the residuals over all bins, in each of the last L frames."""
    noise: NonNegative | None = None
    """Variance of the measurement noise, delta_v²; None before there are L frames."""
    variance: NonNegative = 0.0
    """Variance of the filtering error, q. It is one number: equations 3 to 11 give all bins the
    same."""


class GaussianMemory(msgspec.Struct, frozen=True, eq=False, tag="gaussian"):
    """The memory of `GaussianBins` for one cue, from all histograms since the first frame."""

    frames: int
    """The number of histograms."""
    mean: Floats
    """(m,), mu of each bin."""
    squares: Floats
    """(m,), the sum of squared deviations from the mean."""


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
    """

    frames: Count = 10
    """Number L of frames from whose residuals the noise and the gain are estimated. In the first L
    the model stays fixed. A larger value reacts more slowly. The paper gives no number."""
    alpha: Annotated[float, Meta(ge=1e-6, le=0.5)] = 0.1
    """Significance level of the t test: the probability that it refuses a usual frame. With a
    larger value more frames are refused."""

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
            return UpdateResult(histogram, KalmanMemory(squares))
        predicted = variance + drift  # 4
        if self._refuses(samples, mean - usual):  # the model stays (15), as without a measurement
            return UpdateResult(histogram, KalmanMemory(squares, noise, predicted))
        total = predicted + noise
        gain = predicted / total if total > 0 else 0.0  # 5; there may be no noise at all
        memory = KalmanMemory(squares, noise, (1 - gain) * predicted)  # 7
        return UpdateResult(histogram + gain * residuals, memory)  # 6

    def _refuses(self, samples: Floats, excess: float) -> bool:
        """Return whether samples are too large (14); `excess`: their mean minus the usual one."""
        if excess <= 0:
            return False
        from scipy.special import stdtrit  # takes a quarter of a second to import

        critical = float(stdtrit(samples.size - 1, 1 - self.alpha))  # t_alpha of equation 13
        error = float(samples.std(ddof=1)) / math.sqrt(samples.size)
        return excess >= critical * error


class GaussianBins(Strategy, Config, frozen=True, tag="gaussian"):
    """Each bin is compared with its mean over all frames so far: Zhao and Pei, equation 16.

    mu is the mean of a bin B_i over all frames from the first to this one, delta its standard
    deviation. The printed equation compares B_i with 3 delta; its distance from mu is meant. As
    printed, B_i is this frame's bin, so nine tenths of the model are this frame's. Histograms are
    scaled to sum to 1 again.
    """

    beta: Share = 0.1
    """Share of the mean mu in the model's next bin; the rest is this frame's bin. With a larger
    value the model follows more slowly."""
    deviations: NonNegative = 3.0
    """A bin of this frame that is more than this many standard deviations delta away from its mean
    mu is refused: the model's next bin is mu. With a larger value this is rarer."""

    def learn(
        self, memory: UpdaterState, histogram: Floats, first: Floats, seen: Floats
    ) -> UpdateResult:
        """Return the model of this frame's bins and their means."""
        if not isinstance(memory, GaussianMemory):
            memory = GaussianMemory(1, first, np.zeros_like(first))
        frames, off = memory.frames + 1, seen - memory.mean
        mean = memory.mean + off / frames
        squares = memory.squares + off * (seen - mean)
        near = np.abs(seen - mean) <= self.deviations * np.sqrt(squares / frames)
        after = np.where(near, self.beta * mean + (1 - self.beta) * seen, mean)
        return UpdateResult(after / after.sum(), GaussianMemory(frames, mean, squares))


class AnchoredKalman(Strategy, Config, frozen=True, tag="anchored_kalman"):
    """A Kalman filter for each bin around the first frame's, and a gate for whole histograms.

    Close to Zhao and Pei, equations 3 to 15, but a wrong region is not learned in the end:

    - A bin returns to its share p_0 in the first frame (equation 3 keeps it):
      p_i = p_0 + persistence (p_{i-1} - p_0) + change of the target.
    - The variance of this change is a fixed multiple of the measurement noise. Equation 10 takes
      any large residual for a change of the target, and learns faster just when it is wrong.
    - Variances are those of the Bhattacharyya distance d. Its square is half the sum of the squared
      differences of the bins' square roots, which all have about the same noise, whatever their
      shares. The mean of d² over the first L frames is the residuals' variance of equation 11; half
      of it is noise, the other half the error of the first frame's model.
    - A whole histogram is refused if d is above `deviations` standard deviations of the innovation,
      sqrt(q + delta_v²). Equation 14 compares with the residuals of the last frames, wrong or not.
      After a refusal the model goes on returning to the first frame's.
    """

    frames: Count = 10
    """Number L of frames from whose distances the noise is estimated. In the first L the model
    stays fixed. With a larger value the model begins to learn later."""
    persistence: Share = 0.97
    """Share of a bin's difference from the first frame's that is left in the next frame. With a
    larger value the model departs farther from the first frame's; 1 is the paper's equation 3."""
    change: NonNegative = 0.01
    """Variance of the target's change in a frame, as a multiple of the measurement noise. With a
    larger value the model follows faster."""
    deviations: NonNegative = 3.0
    """Largest distance between a histogram and the model, in standard deviations, at which the
    model learns from it. With a larger value fewer frames are refused."""

    def learn(
        self, memory: UpdaterState, histogram: Floats, first: Floats, seen: Floats
    ) -> UpdateResult:
        """Return the filtered model, or the predicted one if the histogram is refused."""
        before = memory if isinstance(memory, KalmanMemory) else KalmanMemory()
        noise = before.noise
        if noise is None:
            squares = (*before.squares, _squared_distance(histogram, seen))
            usual = sum(squares) / len(squares)  # 9
            if len(squares) == self.frames:
                noise = max(0.5 * usual, LEAST_NOISE)  # 11
            return UpdateResult(histogram, KalmanMemory(squares, noise, noise or 0.0))
        predicted = first + self.persistence * (histogram - first)  # 3
        variance = self.persistence**2 * before.variance + self.change * noise  # 4
        total = variance + noise
        if _squared_distance(predicted, seen) > self.deviations**2 * total:
            return UpdateResult(predicted, KalmanMemory(before.squares, noise, variance))
        gain = variance / total  # 5
        memory = KalmanMemory(before.squares, noise, (1 - gain) * variance)  # 7
        return UpdateResult(predicted + gain * (seen - predicted), memory)  # 8 and 6


LEAST_NOISE = 0.02**2
"""Least variance of the measurement noise, of a distance.

The distance between readings of half or a quarter of a region's pixels is about 0.02 (Ng and Delp,
table 1)."""


def _squared_distance(model: Floats, seen: Floats) -> float:
    """Return the squared Bhattacharyya distance of two histograms that sum to 1."""
    return 0.5 * float(((np.sqrt(seen) - np.sqrt(model)) ** 2).sum())
