"""Means over runs, and confidence intervals."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from motes.core import Floats

RESAMPLES, SEED = 10_000, 0


class Mean(NamedTuple):
    """Mean and sample standard deviation over runs; the deviation is NaN for one run."""

    mean: float
    deviation: float = np.nan


def over(values: Iterable[float]) -> Mean:
    """Return mean and deviation of the values that are not NaN; NaN if all are."""
    known = np.array([value for value in values if np.isfinite(value)], np.float64)
    mean = float(known.mean()) if known.size else np.nan
    return Mean(mean, float(known.std(ddof=1)) if known.size > 1 else np.nan)


def wilson_interval(successes: int, total: int) -> tuple[float, float]:
    """Return the 95 % interval of a share, from 0 to 1, after Wilson, J. Am. Stat. Assoc. 1927."""
    from scipy.stats import binomtest  # takes a second to import

    low, high = binomtest(successes, total).proportion_ci(method="wilson")
    return float(low), float(high)


class Difference(NamedTuple):
    """A mean difference and its confidence interval; all NaN without pairs."""

    mean: float
    low: float
    high: float


def paired_difference(values: Floats, others: Floats, level: float = 0.95) -> Difference:
    """Return the mean of values - others, (n,), and its percentile bootstrap interval.

    Pairs are drawn with replacement, n at a time and `RESAMPLES` times. Efron and Tibshirani, An
    introduction to the bootstrap, 1993, chapter 13. One pair gives no interval: NaN.
    """
    return _difference([values - others], level)


def unpaired_difference(values: Floats, others: Floats, level: float = 0.95) -> Difference:
    """Return the mean of values (n,) minus that of others (m,), and its bootstrap interval.

    Both groups are drawn with replacement, each from itself, `RESAMPLES` times. Efron and
    Tibshirani, chapter 8. A group of one gives no interval: NaN.
    """
    return _difference([values, others], level)


def _difference(groups: Sequence[Floats], level: float) -> Difference:
    """Return the mean of a group, or the difference of two means, and its interval.

    Each interval has random numbers of its own: it does not depend on those before it.
    """
    from scipy.stats import bootstrap  # takes a second to import

    def difference(first: Floats, second: Floats | None = None, *, axis: int = -1) -> Floats:
        means: Floats = first.mean(axis)
        return means if second is None else means - second.mean(axis)

    least = min(group.size for group in groups)
    mean = float(difference(*groups)) if least else np.nan
    if least < 2:
        return Difference(mean, np.nan, np.nan)
    batch = RESAMPLES // 10 if len(groups) == 1 else None  # limits the memory for large n
    found = bootstrap(
        groups, difference, n_resamples=RESAMPLES, batch=batch, confidence_level=level,
        method="percentile", rng=np.random.default_rng(SEED),
    )  # fmt: skip
    return Difference(mean, *map(float, found.confidence_interval))
