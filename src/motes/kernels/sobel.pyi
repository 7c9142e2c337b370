from motes.kernels.structures import Bytes, Floats, Reading, Singles

def sobel(
    picture: Bytes, left: int, top: int, threshold: float, count: int, bins: Bytes
) -> None: ...
def histograms(
    bins: Bytes, left: int, top: int, ellipses: Floats, reading: Reading, out: Floats
) -> None: ...
def histograms_at(
    picture: Bytes,
    ellipses: Floats,
    lattice: Singles,
    profile: int,
    threshold: float,
    out: Floats,
) -> None: ...
