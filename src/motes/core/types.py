"""Names for the arrays that pass between functions, whose docstrings give shapes; their median."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
"""Ellipses, histograms, distances, weights and all other numbers in double precision."""
Numbers: TypeAlias = Sequence[float] | NDArray[Any]
"""A region in the forms that callers give it: a sequence or an array of numbers."""
Singles: TypeAlias = NDArray[np.float32]
"""Values that are read from pixels: samples, features, strengths."""
Spectra: TypeAlias = NDArray[np.complex64]
"""Fourier transforms of `Singles`."""
Bytes: TypeAlias = NDArray[np.uint8]
"""Pixels, masks, and numbers of bins."""
Flags: TypeAlias = NDArray[np.bool_]
"""Whether something holds, for each frame, ellipse or pixel."""


def median(values: NDArray[np.floating[Any]]) -> float:
    """Return the middle one of all values, or the mean of the two in the middle.

    There is one value at least, and none is NaN. numpy's own loads masked arrays with the first
    call.
    """
    low, high = (values.size - 1) // 2, values.size // 2
    ordered = np.partition(values, (low, high), axis=None)
    return float(ordered[low] + ordered[high]) / 2
