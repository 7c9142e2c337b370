from motes.kernels.structures import Bytes, Floats, Pair, Place, Singles

CELL: int

def cut(picture: Bytes, corner: Pair, across: Pair, down: Pair, out: Singles) -> None: ...
def cut_around(picture: Bytes, place: Place, step: Pair, out: Singles) -> None: ...
def gradient_cells(samples: Singles, sectors: Bytes, out: Singles) -> None: ...
def cells_of_sizes(
    picture: Bytes,
    place: Place,
    factors: Floats,
    tapers: Singles,
    rows: int,
    columns: int,
    sectors: Bytes,
    out: Singles,
) -> None: ...
