from motes.kernels.structures import Bytes, ColorTarget, Floats, NoiseScales, Pair

Observation = tuple[
    Floats,
    Floats,
    Floats,
    bool,
    tuple[float, float, float, float, float],
    Floats,
    float,
    float,
    int,
    float,
]

def step(
    picture: Bytes,
    before: Floats,
    before_weights: Floats,
    positions: Floats,
    normal: Floats,
    noise: NoiseScales,
    steps: float,
    first: Pair,
    target: ColorTarget,
    likelihood: tuple[float, float],
    threshold: float,
    ring: bool,
) -> tuple[Floats, Observation]: ...
def observe(
    picture: Bytes,
    states: Floats,
    target: ColorTarget,
    likelihood: tuple[float, float],
    threshold: float,
    ring: bool,
) -> Observation: ...
