from motes.kernels.structures import (
    Bytes,
    ColorBins,
    ColorTarget,
    Counts,
    Floats,
    PixelGrid,
    Reading,
    Singles,
)

RGB: int
HSV: int
HSV_V: int

def histograms(
    picture: Bytes, ellipses: Floats, reading: Reading, slots: Counts, bins: ColorBins, out: Floats
) -> None: ...
def distances(picture: Bytes, ellipses: Floats, target: ColorTarget, out: Floats) -> None: ...
def mean_shift(
    picture: Bytes,
    ellipse: Floats,
    lattice: Singles,
    grid: PixelGrid,
    slots: Counts,
    ratios: Floats,
    bins: ColorBins,
    center: Floats,
) -> None: ...
def to_bins(colors: Counts, bins: ColorBins) -> None: ...
