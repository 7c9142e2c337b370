from motes.kernels.structures import Floats

def log_determinants(
    prior: Floats,
    logs: Floats,
    ellipses: Floats,
    floor: float,
    equal: float,
    singular: float,
    out: Floats,
) -> None: ...
