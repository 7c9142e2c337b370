"""The correlation is Pearson's."""

import numpy as np
import pytest

from motes.core.types import correlation


def test_the_correlation_is_that_of_numpy() -> None:
    first, second = np.random.default_rng(3).random((2, 54, 96), np.float32)
    expected = np.corrcoef(first.ravel(), second.ravel())[0, 1]
    assert correlation(first, second) == pytest.approx(expected, abs=1e-6)
    assert correlation(first, 2 - 3 * first) == pytest.approx(-1)
    assert correlation(first, np.full_like(first, 0.5)) == 0  # a flat one tells nothing
