"""Series of a target's histograms, and what a model update learns from them."""

from collections.abc import Iterator

import numpy as np

from motes.core.types import Floats
from motes.sot.filtering.model_update import Strategy, UpdateResult


def histogram(rng: np.random.Generator, bins: int) -> Floats:
    return rng.dirichlet(np.full(bins, 0.5))


def series(seed: int, bins: int, frames: int) -> list[Floats]:
    """Return a target's histograms: noise around one that changes, at times by a leap."""
    rng = np.random.default_rng(seed)
    true, out = histogram(rng, bins), []
    for _ in range(frames):
        true = 0.97 * true + 0.03 * histogram(rng, bins)
        share = rng.choice([0.02, 0.1, 0.9], p=[0.6, 0.3, 0.1])
        out.append((1 - share) * true + share * histogram(rng, bins))
    return out


def lessons(strategy: Strategy, first: Floats, seen: list[Floats]) -> Iterator[UpdateResult]:
    model, memory = first, None
    for each in seen:
        learned = strategy.learn(memory, model, first, each)
        yield learned
        model, memory = learned.histogram, learned.memory
