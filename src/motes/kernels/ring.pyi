from motes.kernels.structures import Singles

def correlations(
    large: Singles, small: Singles, hole: tuple[int, int, int, int], out: Singles
) -> None: ...
