import numpy as np
from numpy.typing import NDArray

from motes.kernels.structures import Bytes

def divided(patch: Bytes, spike: int, valley: float, narrow: int) -> NDArray[np.int64]: ...
