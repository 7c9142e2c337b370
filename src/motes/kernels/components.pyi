import numpy as np
from numpy.typing import NDArray

from motes.kernels.structures import Bytes

def label(mask: Bytes, labels: NDArray[np.int32]) -> NDArray[np.int64]: ...
def fill_holes(outline: Bytes, before: Bytes, mask: Bytes) -> None: ...
