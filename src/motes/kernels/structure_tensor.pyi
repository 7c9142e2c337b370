from motes.kernels.structures import Bytes, Floats, Reading, Singles

def structure_tensor(
    picture: Bytes,
    left: int,
    top: int,
    step: int,
    smooth: Singles,
    derivative: Singles,
    window: Singles,
    certainty: Singles,
    bins: Bytes,
    count: int,
) -> None: ...
def histograms(
    certainty: Singles,
    bins: Bytes,
    left: int,
    top: int,
    ellipses: Floats,
    reading: Reading,
    threshold: float,
    shifts: Floats,
    out: Floats,
) -> None: ...
