from motes.kernels.structures import Bytes, Floats, Integers

def misfits(
    picture: Bytes, pixels: Integers, shifts: Integers, most: float, out: Floats
) -> None: ...
