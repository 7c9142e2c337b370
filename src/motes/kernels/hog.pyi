from motes.kernels.structures import Bytes, Floats, Reading, Singles

BAND: int

def gradients(
    picture: Bytes,
    left: int,
    top: int,
    smooth: Singles,
    derivative: Singles,
    strength: Singles,
    bins: Bytes,
    count: int,
) -> None: ...
def histograms(
    strength: Singles,
    bins: Bytes,
    left: int,
    top: int,
    ellipses: Floats,
    reading: Reading,
    side: int,
    turned: bool,
    out: Floats,
) -> None: ...
def histograms_at(
    picture: Bytes,
    ellipses: Floats,
    lattice: Singles,
    profile: int,
    side: int,
    turned: bool,
    smooth: Singles,
    derivative: Singles,
    out: Floats,
) -> None: ...
