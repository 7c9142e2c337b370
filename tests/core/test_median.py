"""The median is that of numpy."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motes.core.types import median


@pytest.mark.parametrize("shape", [(1,), (2,), (7,), (5, 4), (54, 96)])
@pytest.mark.parametrize("kind", ["float32", "float64"])
def test_the_median_is_that_of_numpy(shape: tuple[int, ...], kind: str) -> None:
    values: NDArray[Any] = np.random.default_rng(3).random(shape).astype(kind)
    before = values.copy()
    assert median(values) == float(np.median(values))
    np.testing.assert_array_equal(values, before)
