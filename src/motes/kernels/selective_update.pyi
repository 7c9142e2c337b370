from motes.kernels.structures import Bytes, Floats, HoldLimits

def update(
    picture: Bytes,
    foreground: Bytes,
    known: Bytes,
    time: float,
    limits: HoldLimits,
    since: Floats,
    clean: Bytes,
) -> None: ...
