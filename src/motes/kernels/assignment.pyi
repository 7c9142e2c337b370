import numpy as np
from numpy.typing import NDArray

from motes.kernels.structures import Floats

def least_cost(costs: Floats) -> NDArray[np.intp]: ...
