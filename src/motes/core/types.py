"""Names for the arrays that pass between functions, whose docstrings give shapes; their checks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from motes.core.errors import PluginError

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


def correlation(first: NDArray[np.floating[Any]], second: NDArray[np.floating[Any]]) -> float:
    """Return Pearson's correlation of two arrays of one shape; 0 where one is flat."""
    a, b = first - first.mean(), second - second.mean()
    power = float((a * a).sum()) * float((b * b).sum())
    return float((a * b).sum()) / math.sqrt(power) if power > 0 else 0.0


def check_finite(values: Numbers | float, kind: str, name: object) -> None:
    """Raise a PluginError if a part of a tracker returns NaN or infinity: all after it would be so.

    `kind` and `name` are those of the part, such as a cue and hue.
    """
    if not np.isfinite(values).all():
        raise PluginError(
            f"The {kind} {name!r} returns NaN or infinity; correct it, and see motes.testing."
        )
