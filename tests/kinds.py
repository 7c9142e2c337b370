"""Trackers of every kind, and which few of them have all parts together."""

from collections.abc import Iterator

from motes import PRESETS, ParticleFilter, TrackerConfig, configure
from motes.cues.color import Color
from motes.sot.filtering.appearance_rule import AppearanceRule
from motes.sot.filtering.likelihood import Gaussian
from motes.sot.filtering.motion import Noise, SecondOrder
from motes.sot.filtering.resampling import Systematic

# Presets, and what no preset uses.
CONFIGS: dict[str, TrackerConfig] = {
    **PRESETS,
    "sum of spectra": configure(
        PRESETS["maggio"],
        {
            "orientation": {"form": "fourier", "scale_selection": False},
            "fusion": {"type": "printed_mixture"},
        },
    ),
    "parts of the pixels": configure(
        PRESETS["ng_delp"],
        {
            "color": {"sampling": {"type": "checkerboard", "share": "half"}},
            "edges": {"sampling": {"type": "checkerboard", "share": "quarter"}},
        },
    ),
    "second order, systematic": ParticleFilter(
        motion=SecondOrder(
            noise=Noise(position=0.3, angle=0.02), velocity=0.3, acceleration=0.1, persistence=0.5
        ),
        color=Color(space="hsv", bins=(8, 8, 4), kernel="epanechnikov"),
        likelihood=Gaussian(sigma=0.1),
        presence=AppearanceRule(margin=0.7),
        resampling=Systematic(threshold=0.5),
    ),
    "random walk, every pixel": configure(
        PRESETS["nummiaro"],
        {
            "motion": {"type": "random_walk", "noise": {"position": 0.4, "size": 0.003}},
            "color": {"sampling": {"type": "every_pixel"}},
        },
    ),
    "half of the pixels": configure(
        PRESETS["nummiaro"], {"color": {"sampling": {"type": "checkerboard"}}}
    ),
    "learned against the surroundings": configure(
        PRESETS["nummiaro"],
        {"correlation": {}, "posterior": {}, "presence": {"max_positions": 500}},
    ),
}
ALGORITHMS = ["default", "nummiaro", "mean_shift"]
"""One of each: for what the tracker does around its algorithm, or any algorithm does alike."""
VARIANTS = [
    "nummiaro:printed",
    "maggio:printed",
    "parts of the pixels",
    "ng_delp:printed",
    "zhao_pei:printed",
]
"""They differ from another kind in the pixels that are read, or in one rule."""
KINDS = [
    "default",
    "mean_shift",
    "maggio",
    "sum of spectra",
    "ng_delp",
    "zhao_pei",
    "maggio:C",
    "ng_delp:edges",
    "second order, systematic",
    "random walk, every pixel",
    "half of the pixels",
    "learned against the surroundings",
    *VARIANTS,
]
"""Together they have each part that any has: for what depends on parts, but not on numbers."""
FILTERS = [name for name in CONFIGS if isinstance(CONFIGS[name], ParticleFilter)]
FILTER_KINDS = ["maggio", "sum of spectra", "ng_delp", "zhao_pei", "maggio:C"]
"""For what any filter can be combined with: they have one cue or two, fused in each way."""


def parts(value: object, where: str = "") -> Iterator[tuple[str, object]]:
    """Yield what a configuration chooses beside its numbers: which part at which place, or none."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from parts(inner, f"{where}.{key}")
    elif value is None or isinstance(value, str | bool):
        yield where, value
