"""The smoother: one path from what one or two passes have seen, and from keyframes.

Each coordinate of a region is smoothed alone, by a Kalman filter and the fixed-interval smoother of
Rauch, Tung and Striebel (Maximum likelihood estimates of linear dynamic systems, AIAA Journal
1965). The state is the position p, its velocity v, and the offset d of each pass:

    v(t) = rho v(t-1) + noise of variance q        z(t) = p(t) + d(t) + noise of variance r
    p(t) = p(t-1) + v(t)                           d(t) = phi d(t-1) + noise, of variance s^2 if old

A pass begins without an offset, on its keyframe, and drifts: d is a process of Ornstein and
Uhlenbeck with the standard deviation s and a memory of some frames. A keyframe is an exact
observation of p, so it also shows the offset of a pass that arrives there. Where no pass has seen
the target, nothing is observed: the path is a bridge, and its variance grows from both supports.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.core.types import Flags, Floats

PERSISTENCE = (0.0, 0.5, 0.8, 0.95)
"""The shares rho of a velocity that may stay from frame to frame; the likeliest one is taken."""
NOISE_RATIOS = (0.01, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0)
"""The ratios r / q that may be taken."""
LEAST_DEVIATION = 0.02
"""Least standard deviation of noise and of motion from frame to frame, in the coordinates' units
(hundredths of a side, see `coordinates`): a film at rest is not known better than that."""
RUN = 3
"""Fast steps in a row from which a target has run, and has not jumped."""
NORMAL_MEDIAN = 0.6745
"""The median of the absolute value of a standard normal variable."""
UNKNOWN = 1e4
"""Standard deviation of a position that nothing is known of."""


class Dynamics(NamedTuple):
    """How a target moves, and how noisy it is seen: arrays (k,), a value for each coordinate."""

    persistence: Floats
    """Share of the velocity that stays from frame to frame."""
    acceleration: Floats
    """Variance of the velocity's change in a frame."""
    noise: Floats
    """Variance of an observation."""


class Drift(NamedTuple):
    """How a pass leaves the center of its target: arrays (k,)."""

    deviation: Floats
    """Standard deviation of the offset of an old pass."""
    memory: Floats
    """Number of frames after which an offset has lost 63 % of what it was."""


class Smoothed(NamedTuple):
    """The smoothed path: means and variances, each (n, k)."""

    mean: Floats
    variance: Floats


def fit_motion(seen: Floats, valid: Flags, relative: Floats) -> Dynamics:
    """Return the motion of the greatest likelihood, for each coordinate alone.

    The likelihood is that of the Kalman filter's prediction errors, with the scale of all variances
    at its maximum (Harvey, Forecasting, structural time series models and the Kalman filter, 1989,
    section 3.4). Observations and their relative variances are (n, k); those that are `valid` (n,)
    count.
    """
    rho, ratio = (each.ravel() for each in np.meshgrid(PERSISTENCE, NOISE_RATIOS))
    models, coordinates = len(rho), seen.shape[1]
    rho, ratio = rho[:, None], ratio[:, None]
    p = np.zeros((models, coordinates))
    v, pp, pv, vv = np.zeros_like(p), np.zeros_like(p), np.zeros_like(p), np.zeros_like(p)
    squares, logs, count = np.zeros_like(p), np.zeros_like(p), -1
    for z, here, scale in zip(seen, valid, relative, strict=True):
        if count >= 0:
            v = rho * v
            p = p + v
            vv = rho * rho * vv + 1
            pp, pv = pp + 2 * rho * pv + vv, rho * pv + vv
        if not here:
            continue
        if count < 0:  # the first observation is the start
            p, pp, vv = p + z, pp + ratio * scale, vv + 1
        else:
            error, variance = z - p, pp + ratio * scale
            squares += error * error / variance
            logs += np.log(variance)
            gain_p, gain_v = pp / variance, pv / variance
            p, v = p + gain_p * error, v + gain_v * error
            pp, pv, vv = pp - gain_p * pp, pv - gain_p * pv, vv - gain_v * pv
        count += 1
    q = np.maximum(squares / max(count, 1), LEAST_DEVIATION**2)
    best = np.argmin(max(count, 1) * np.log(q) + logs, axis=0)
    columns = np.arange(coordinates)
    noise = np.maximum(ratio[best, 0] * q[best, columns], LEAST_DEVIATION**2)
    return Dynamics(rho[best, 0], q[best, columns], noise)


def smoothed(
    passes: Floats,
    valid: Flags,
    relative: Floats,
    exact: dict[int, Floats],
    motion: Dynamics,
    drift: Drift | None,
) -> Smoothed:
    """Return the smoothed path of n frames.

    Parameters
    ----------
    passes
        (m, n, k), what each pass has seen.
    valid
        (m, n), whether it counts.
    relative
        (m, n, k), the variance of each observation relative to the others; 0 at a pass's keyframe.
    exact
        Keyframes: positions (k,) by their frame from 0 to n - 1.
    motion
        How the target moves.
    drift
        How passes drift; None if they do not.
    """
    count, frames, k = passes.shape
    offsets = count if drift is not None else 0
    size = 2 + offsets
    transition = np.zeros((k, size, size))
    transition[:, 0, 0] = 1
    transition[:, 0, 1] = transition[:, 1, 1] = motion.persistence
    process = np.zeros((k, size, size))
    process[:, :2, :2] = motion.acceleration[:, None, None]
    start = np.zeros((k, size, size))
    start[:, 0, 0] = UNKNOWN**2
    start[:, 1, 1] = motion.acceleration / (1 - motion.persistence**2)
    if drift is not None:
        phi = np.exp(-1 / drift.memory)
        for i in range(2, size):
            transition[:, i, i] = phi
            process[:, i, i] = drift.deviation**2 * (1 - phi**2)
            start[:, i, i] = drift.deviation**2
    tiny = 1e-6 * LEAST_DEVIATION**2
    rows = [np.eye(size)[0]]
    rows += [rows[0] + (np.eye(size)[2 + i] if offsets else 0) for i in range(count)]

    means, covariances = np.empty((frames, k, size)), np.empty((frames, k, size, size))
    predicted_means, predicted = np.empty_like(means), np.empty_like(covariances)
    mean, covariance = np.zeros((k, size)), start
    known = np.flatnonzero(valid.any(axis=0))
    first = min([*known[:1].tolist(), *exact])
    near = exact.get(first, passes[valid[:, first].argmax(), first])
    mean[:, 0] = near  # the variance there is that of a position that is not known
    for t in range(frames):
        if t:
            mean = np.einsum("kij,kj->ki", transition, mean)
            covariance = transition @ covariance @ transition.transpose(0, 2, 1) + process
            covariance[:, range(size), range(size)] += tiny
        predicted_means[t], predicted[t] = mean, covariance
        given = [(rows[0], exact[t], np.full(k, tiny))] if t in exact else []
        given += [
            (rows[1 + i], passes[i, t], np.maximum(motion.noise * relative[i, t], tiny))
            for i in range(count)
            if valid[i, t]
        ]
        for row, value, variance in given:
            mean, covariance = _updated(mean, covariance, row, value, variance)
        means[t], covariances[t] = mean, covariance
    for t in range(frames - 2, -1, -1):
        gain = np.linalg.solve(predicted[t + 1], transition @ covariances[t]).transpose(0, 2, 1)
        means[t] += np.einsum("kij,kj->ki", gain, means[t + 1] - predicted_means[t + 1])
        covariances[t] += gain @ (covariances[t + 1] - predicted[t + 1]) @ gain.transpose(0, 2, 1)
    return Smoothed(means[:, :, 0], np.maximum(covariances[:, :, 0, 0], 0.0))


def _updated(
    mean: Floats, covariance: Floats, row: Floats, value: Floats, variance: Floats
) -> tuple[Floats, Floats]:
    """Return mean and covariance after an observation of `row` @ state with a variance."""
    cross = covariance @ row
    total = cross @ row + variance
    gain = cross / total[:, None]
    mean = mean + gain * (value - mean @ row)[:, None]
    return mean, covariance - gain[:, :, None] * cross[:, None, :]


def outliers(seen: Floats, valid: Flags, gate: float) -> Flags:
    """Return which observations (n,) are jumps away and back.

    A filter runs through the observations forward and another one backward. Each leaves out what
    lies outside of its gate, and its uncertainty grows until it accepts an observation again
    (Bar-Shalom and Fortmann, Tracking and data association, 1988, section 4.2). What both leave out
    is an outlier. Positions are (n, k); those that are `valid` (n,) count. `gate` is the quantile
    of the normalized squared innovation, of k degrees of freedom.
    """
    where = np.flatnonzero(valid)
    left = np.zeros(len(seen), bool)
    if len(where) < 3:
        return left
    kept = seen[where]
    variance = local_variance(kept, where)
    back = _left_out(kept[::-1], variance[::-1], gate)[::-1]
    left[where] = _left_out(kept, variance, gate) & back
    return left


def local_variance(seen: Floats, times: NDArray[np.int64]) -> Floats:
    """Return the variance (n - 1, k) of the motion from each observation to the next.

    It is that of the whole track, or that of the steps around where the target moves faster: it may
    rest most of the time and run now and then. A jump is one fast step, a run has several. The
    deviation is the median of steps over that of a standard normal variable's absolute value.
    """
    steps = np.abs(np.diff(seen, axis=0)) / np.sqrt(np.diff(times))[:, None]
    padded = np.pad(steps, ((RUN - 1, RUN - 1), (0, 0)), constant_values=np.nan)
    around = np.lib.stride_tricks.sliding_window_view(padded, 2 * RUN - 1, axis=0)
    fastest = np.maximum(np.nanmedian(around, axis=2), np.median(steps, axis=0))
    spread = np.maximum(fastest / NORMAL_MEDIAN, LEAST_DEVIATION)
    return spread**2 * np.diff(times)[:, None]


def _left_out(seen: Floats, variance: Floats, gate: float) -> Flags:
    """Return which observations lie outside of the gate of a random walk, which then comes back.

    Where the walk never comes back, it has gone to another place, and nothing is left out.
    """
    out = np.zeros(len(seen), bool)
    total = np.concatenate([np.zeros((1, seen.shape[1])), np.cumsum(variance, axis=0)])
    last = 0
    for i in range(1, len(seen)):
        spread = total[i] - total[last]
        if float(((seen[i] - seen[last]) ** 2 / spread).sum()) <= gate:  # it has come back
            out[last:i] = ((seen[last:i] - seen[last]) ** 2 / spread).sum(axis=1) > gate
            last = i
    return out
