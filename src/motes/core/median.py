"""The median, without the masked arrays of numpy, which its own loads with the first call."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def median(values: NDArray[np.floating[Any]]) -> float:
    """Return the middle one of all values, or the mean of the two in the middle.

    There is one value at least, and none is NaN.
    """
    low, high = (values.size - 1) // 2, values.size // 2
    ordered = np.partition(values, (low, high), axis=None)
    return float(ordered[low] + ordered[high]) / 2
