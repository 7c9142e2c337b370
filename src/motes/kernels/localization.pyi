import numpy as np
from numpy.typing import NDArray

from motes.kernels.structures import Floats, Pair, PointCues

def weigh(cues: PointCues, points: Floats, logs: Floats) -> None: ...
def draw(
    cues: PointCues,
    normal: Floats,
    offsets: Floats,
    half: Pair,
    narrow: float,
    side: float,
    counts: NDArray[np.intp],
) -> Floats: ...
