from motes.kernels.structures import Bytes

MOST: int

def usual_colors(pictures: Bytes, group: int, out: Bytes) -> None: ...
