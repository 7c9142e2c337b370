import numpy as np
from numpy.typing import NDArray

from motes.kernels.structures import Bytes, Floats

def outline_gradients(
    mask: Bytes, now: Bytes, learned: Bytes, boxes: NDArray[np.int64], out: Floats
) -> None: ...
