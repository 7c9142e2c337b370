"""Names for the arrays that pass between functions; docstrings give their shapes."""

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
