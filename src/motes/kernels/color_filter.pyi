from motes.kernels.structures import Bytes, ColorComparison, Floats, NoiseScales, Pair

Observation = tuple[
    Floats,
    Floats,
    bool,
    tuple[float, float, float, float, float],
    Floats,
    float,
    float,
    float,
    float,
    int,
    float,
]

def step(
    picture: Bytes,
    before: Floats,
    before_weights: Floats,
    random: object,
    count: int,
    noise: NoiseScales,
    steps: float,
    first: Pair,
    comparison: ColorComparison,
) -> tuple[Floats, Observation]: ...
def observe(picture: Bytes, states: Floats, comparison: ColorComparison) -> Observation: ...
