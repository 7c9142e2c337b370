from motes.kernels.structures import Box, Bytes, Counts, Floats, Reading, Singles, Window

EPANECHNIKOV: int
RADIAL: int
UNIFORM: int
GAUSSIAN: int
WIDEST: int

def pixels_within(
    window: Window,
    ellipse: Floats,
    reading: Reading,
    offsets: Counts,
    weights: Floats,
) -> int: ...
def colors_at(picture: Bytes, offsets: Counts, colors: Counts) -> None: ...
def values_within(
    plane: Singles, left: int, top: int, ellipse: Floats, reading: Reading
) -> Singles: ...
def bounds(ellipses: Floats) -> Box: ...
